"""The messages of a log that come now and then: what the sensors saw, and courses planned again."""

import numpy as np

from crosstrack.flight.cdr import Builder, constant
from crosstrack.flight.flight import Replan
from crosstrack.flight.topics import WORLD, nanoseconds, stamp
from crosstrack.types import Array

SEEN, REPLANNED = "/seen", "/replanned"
KINDS = {SEEN: "sensor_msgs/PointCloud2", REPLANNED: "nav_msgs/Path"}
FLOAT32 = 7
"""sensor_msgs/PointField: FLOAT32"""
MOST_POINTS = 10_000_000
"""of one message"""


def cloud(count: int) -> Builder:
    """Lay out sensor_msgs/PointCloud2 of `count` points."""
    message = Builder()
    stamp(message, WORLD)
    message.put("<u4", 1, count, 3)
    for offset, axis in zip((0, 4, 8), "xyz", strict=True):
        message.text(axis)
        message.put("<u4", offset)
        message.put("u1", FLOAT32)
        message.put("<u4", 1)
    message.put("u1", 0)
    message.put("<u4", 12, 12 * count, 12 * count)
    message.slot("points", "<f4", count, 3)
    message.put("u1", 1)
    return message


def path(count: int) -> Builder:
    """Lay out nav_msgs/Path of `count` points."""
    message = Builder()
    stamp(message, WORLD)
    message.put("<u4", count)
    for index in range(count):
        message.put("<i4", 0)
        message.put("<u4", 0)
        message.text(WORLD)
        message.slot(f"{index}", "<f8", 3)
        message.put("<f8", 0.0, 0.0, 0.0, 1.0)
    return message


LAYOUTS = {SEEN: cloud, REPLANNED: path}


def encoded(topic: str, time: float, points: Array) -> bytes:
    """Return the message of a topic about points (n, 3) m at a time (s)."""
    layout = LAYOUTS[topic](len(points))
    buffer = bytearray(layout.data)
    message = np.frombuffer(buffer, dtype=layout.dtype())
    stamp = int(nanoseconds(np.array([time]))[0])
    message["sec"], message["nanosec"] = stamp // 10**9, stamp % 10**9
    if topic == SEEN:
        message["points"] = points
    else:
        for index, point in enumerate(points):
            message[f"{index}"] = point
    return bytes(buffer)


def decoded(topic: str, data: bytes) -> tuple[float, Array]:
    """Return the time (s) and the points (n, 3) m of a message.

    Raises:
        ValueError: it is not laid out as it should be.
    """
    begins = Builder()
    stamp(begins, WORLD)
    begins.put("<u4", *([1, 0] if topic == SEEN else [0]))
    at = len(begins.data) - 4
    count = int.from_bytes(data[at : at + 4], "little")
    if count > MOST_POINTS or 12 * count > len(data):
        raise ValueError(f"topic {topic}: a message of {len(data)} bytes announces {count} points")
    layout = LAYOUTS[topic](count)
    dtype = layout.dtype()
    fixed = constant(dtype)
    raw = np.frombuffer(data, np.uint8)
    if len(raw) != dtype.itemsize or (raw[fixed] != np.frombuffer(bytes(layout.data), np.uint8)[fixed]).any():
        raise ValueError(f"topic {topic}: a message is not laid out as {KINDS[topic]}")
    message = raw.view(dtype)[0]
    time = float(message["sec"]) + float(message["nanosec"]) * 1e-9
    if topic == SEEN:
        return time, np.array(message["points"], dtype=float).reshape(-1, 3)
    return time, np.array([message[f"{index}"] for index in range(count)]).reshape(-1, 3)


def replan(data: bytes) -> Replan:
    """Return the course of a message."""
    return Replan(*decoded(REPLANNED, data))
