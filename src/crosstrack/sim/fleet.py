"""Vehicles as rows of one structured array: what each is, where it is, what it is told."""

import math
from typing import Any

import numpy as np

from crosstrack.sim.airframe import SEA_LEVEL_DENSITY, Airframe
from crosstrack.types import GRAVITY, Air, Array, Limits, Mismatch

MOTION, ATTITUDE, RATE = 0, 1, 2
"""Levels of a command: position/velocity/acceleration/yaw/yaw rate, attitude/thrust, rate/thrust."""

ROW = np.dtype(
    [
        # What it is.
        ("mass", float),  # kg
        ("inverse_mass", float),  # 1/kg
        ("known_mass", float),  # kg, that the autopilot takes it to have
        ("known_inverse_mass", float),  # 1/kg
        ("inertia", float, 3),  # kg m², about the body axes
        ("inverse_inertia", float, 3),  # 1/(kg m²)
        ("rotor_x", float, 4),  # m, body
        ("rotor_y", float, 4),  # m, body
        ("spin", float, 4),  # +1 where the drag torque of the rotor turns the body counter-clockwise
        ("thrust", float),  # N/(rad/s)², in the air of the scenario
        ("torque_ratio", float),  # m, drag torque over thrust
        ("motor_time", float),  # s
        ("thrust_min", float),  # N, one rotor at idle
        ("thrust_max", float),  # N, one rotor at full speed
        ("allocation", float, (4, 4)),  # rotor thrusts (N) from thrust (N) and torques (N m)
        ("body_drag", float, 3),  # N/(m/s)², in the air of the scenario
        ("rotor_drag", float, 3),  # N/((rad/s) (m/s)), in the air of the scenario
        ("known_body_drag", float, 3),  # that the autopilot takes it to have
        ("known_rotor_drag", float, 3),
        ("gear", float),  # m, from the centre down to the feet
        ("ground", float),  # m, height of the ground
        ("tilt_tangent", float),  # of the largest tilt that the autopilot asks for
        ("speed_max", float),  # m/s, the most that the autopilot flies
        ("gain_position", float),
        ("gain_velocity", float),
        ("gain_disturbance", float),
        ("gain_attitude", float),
        ("gain_yaw", float),
        ("gain_rate", float),
        ("gain_rate_yaw", float),
        ("max_rate", float),
        ("max_rate_yaw", float),
        # Where it is.
        ("state", float, 17),  # position, velocity, attitude xyzw, rate, rotor speeds, as in `types.State`
        ("expected", float, 3),  # m/s, velocity that thrust and known drag alone would have given
        ("yaw", float),  # rad, held by the autopilot
        ("impact", float),  # m/s, hardest touch of the ground so far
        # What it is told, held from one call of the kernel to the next.
        ("level", np.int64),  # MOTION, ATTITUDE or RATE
        ("command", float, 11),  # the fields of the setpoint of that level in their order, from the left
        ("wind", float, 3),  # m/s
        ("error", float, 6),  # estimate less truth: position (m), velocity (m/s)
    ]
)

EXACT = Mismatch()

Fleet = Any
"""An array of ROW, or one row: compiled code reads the fields of a row as attributes."""


def fleet(
    airframe: Airframe,
    air: Air,
    limits: Limits,
    ground: float,
    count: int = 1,
    mismatch: Mismatch = EXACT,
) -> "np.ndarray[Any, np.dtype[np.void]]":
    """Return `count` vehicles of one airframe, shape (count,), with neither place nor command yet.

    What the autopilot knows of them is the airframe; what they are differs by the mismatch.
    """
    density_ratio = air.density / SEA_LEVEL_DENSITY
    thrust = airframe.thrust_coefficient * density_ratio
    rows = np.zeros(count, ROW)
    mass = mismatch.mass * airframe.mass
    rows["mass"], rows["inverse_mass"] = mass, 1 / mass
    rows["known_mass"], rows["known_inverse_mass"] = airframe.mass, 1 / airframe.mass
    rows["inertia"], rows["inverse_inertia"] = airframe.inertia, 1 / np.asarray(airframe.inertia)
    rows["rotor_x"] = np.asarray(airframe.rotor_positions)[:, 0]
    rows["rotor_y"] = np.asarray(airframe.rotor_positions)[:, 1]
    rows["spin"] = airframe.spins
    rows["thrust"], rows["torque_ratio"] = thrust, airframe.torque_ratio
    rows["motor_time"] = mismatch.motor_time * airframe.motor_time
    rows["thrust_min"] = thrust * airframe.rotor_speed_min**2
    rows["thrust_max"] = thrust * airframe.rotor_speed_max**2
    rows["allocation"] = airframe.allocation
    rows["known_body_drag"] = np.asarray(airframe.body_drag) * air.density
    rows["known_rotor_drag"] = np.asarray(airframe.rotor_drag) * density_ratio
    for name in ("body_drag", "rotor_drag"):
        rows[name] = mismatch.drag * rows[f"known_{name}"]
    rows["gear"], rows["ground"] = airframe.gear, ground
    rows["tilt_tangent"], rows["speed_max"] = math.tan(math.radians(limits.tilt_deg)), limits.speed
    gains = airframe.gains
    rows["gain_position"], rows["gain_velocity"] = gains.position, gains.velocity
    rows["gain_disturbance"] = gains.disturbance
    rows["gain_attitude"], rows["gain_yaw"] = gains.attitude, gains.yaw
    rows["gain_rate"], rows["gain_rate_yaw"] = gains.rate, gains.rate_yaw
    rows["max_rate"], rows["max_rate_yaw"] = gains.max_rate, gains.max_rate_yaw
    rows["command"] = np.nan
    return rows


def place(rows: Fleet, position: Array, yaw: float | Array, spinning: bool = True) -> None:
    """Put vehicles at rest and level at positions (..., 3) m, with rotors at hover speed or at idle."""
    rows["state"] = 0.0
    rows["state"][:, :3] = position
    rows["state"][:, 8], rows["state"][:, 9] = np.sin(np.divide(yaw, 2)), np.cos(np.divide(yaw, 2))
    thrust = rows["mass"] * GRAVITY / 4 if spinning else rows["thrust_min"]
    rows["state"][:, 13:] = np.sqrt(thrust / rows["thrust"])[:, None]
    rows["expected"], rows["yaw"], rows["impact"] = 0.0, yaw, 0.0
