"""What the log says of every sample: topics, their messages, and the columns of the record that fill them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from crosstrack.flight.cdr import Builder
from crosstrack.flight.record import Record
from crosstrack.types import Array

WORLD = "world"
"""frame, ENU"""
BODY = "vehicle"
"""frame, FLU"""


@dataclass(frozen=True)
class Topic:
    """One message for every sample."""

    name: str
    kind: str
    """ROS type, as package/Type"""
    layout: Callable[[int], Builder]
    """from the number of rotors to the message; its slots are columns, `sec` and `nanosec`"""
    columns: tuple[str, ...]
    """the columns of the record that are read back from it"""


def header(frame: str = WORLD) -> Builder:
    """Begin a message that starts with a std_msgs/Header."""
    message = Builder()
    stamp(message, frame)
    return message


def stamp(message: Builder, frame: str) -> None:
    """Append a std_msgs/Header."""
    message.slot("sec", "<i4")
    message.slot("nanosec", "<u4")
    message.text(frame)


def number(column: str) -> Callable[[int], Builder]:
    """Lay out std_msgs/Float64."""

    def layout(_: int) -> Builder:
        message = Builder()
        message.slot(column, "<f8")
        return message

    return layout


def vector(column: str, zeros: int = 0, size: int = 3, frame: str = WORLD) -> Callable[[int], Builder]:
    """Lay out a header, numbers, and zeros behind them (PointStamped, TwistStamped, QuaternionStamped, ...)."""

    def layout(_: int) -> Builder:
        message = header(frame)
        message.slot(column, "<f8", size)
        message.array(np.zeros(zeros))
        return message

    return layout


def odometry(_: int, body: str = BODY) -> Builder:
    """Lay out nav_msgs/Odometry: pose in the world, twist in the body, covariances not given (zero)."""
    message = header()
    message.text(body)
    message.slot("position", "<f8", 3)
    message.slot("attitude", "<f8", 4)
    message.array(np.zeros(36))
    message.slot("body_velocity", "<f8", 3)
    message.slot("rate", "<f8", 3)
    message.array(np.zeros(36))
    return message


def transform(_: int, body: str = BODY) -> Builder:
    """Lay out tf2_msgs/TFMessage with one transform, body to world."""
    message = Builder()
    message.put("<u4", 1)
    stamp(message, WORLD)
    message.text(body)
    message.slot("position", "<f8", 3)
    message.slot("attitude", "<f8", 4)
    return message


def rotors(count: int) -> Builder:
    """Lay out sensor_msgs/JointState with the speed of every rotor."""
    message = header(BODY)
    message.put("<u4", count)
    for index in range(count):
        message.text(f"rotor_{index + 1}")
    message.put("<u4", 0)
    message.put("<u4", count)
    message.slot("rotor_speeds", "<f8", count)
    message.put("<u4", 0)
    return message


TOPICS = (
    Topic("/time", "std_msgs/Float64", number("time"), ("time",)),
    Topic("/tf", "tf2_msgs/TFMessage", transform, ()),
    Topic("/vehicle/odometry", "nav_msgs/Odometry", odometry, ("position", "attitude", "rate")),
    Topic("/vehicle/velocity", "geometry_msgs/Vector3Stamped", vector("velocity"), ("velocity",)),
    Topic("/vehicle/rotors", "sensor_msgs/JointState", rotors, ("rotor_speeds",)),
    Topic("/vehicle/estimate", "geometry_msgs/PointStamped", vector("estimate"), ("estimate",)),
    Topic("/command/velocity", "geometry_msgs/TwistStamped", vector("command_velocity", 3), ("command_velocity",)),
    Topic(
        "/command/acceleration",
        "geometry_msgs/AccelStamped",
        vector("command_acceleration", 3),
        ("command_acceleration",),
    ),
    Topic(
        "/command/attitude",
        "geometry_msgs/QuaternionStamped",
        vector("command_attitude", size=4),
        ("command_attitude",),
    ),
    Topic("/command/rate", "geometry_msgs/Vector3Stamped", vector("command_rate", frame=BODY), ("command_rate",)),
    Topic("/command/thrust", "std_msgs/Float64", number("command_thrust"), ("command_thrust",)),
    Topic("/tracker/aim", "geometry_msgs/PointStamped", vector("aim"), ("aim",)),
    Topic("/tracker/progress", "std_msgs/Float64", number("progress"), ("progress",)),
    Topic("/wind", "geometry_msgs/Vector3Stamped", vector("wind"), ("wind",)),
    Topic("/clearance", "std_msgs/Float64", number("clearance"), ("clearance",)),
    Topic("/separation", "std_msgs/Float64", number("separation"), ("separation",)),
    Topic("/avoiders/interventions", "std_msgs/Float64", number("interventions"), ("interventions",)),
)
"""in the order in which they are written for every sample"""


def nanoseconds(time: Array) -> np.ndarray[tuple[int], np.dtype[np.uint64]]:
    """Return times (n,) s as whole nanoseconds, (n,)."""
    return np.rint(time * 1e9).astype(np.uint64)


def columns(record: Record) -> Mapping[str, np.ndarray[tuple[int, ...], np.dtype[np.generic]]]:
    """Return what the slots of all topics are filled with, a row for every sample."""
    stamps = nanoseconds(record.time)
    return vars(record) | {
        "sec": (stamps // 10**9).astype(np.int32),
        "nanosec": (stamps % 10**9).astype(np.uint32),
        "body_velocity": into_body(record.attitude, record.velocity),
    }


def into_body(attitude: Array, vectors: Array) -> Array:
    """Turn vectors (n, 3) from the world into the body by attitudes (n, 4) xyzw: v' = v + 2 u × (u × v - w v)."""
    axis, scalar = attitude[:, :3], attitude[:, 3:]
    return vectors + 2.0 * np.cross(axis, np.cross(axis, vectors) - scalar * vectors)
