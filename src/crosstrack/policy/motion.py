"""What a policy sees of its own motion, in the frame of its heading: level, x ahead, y to the left, z up."""

import math

import numpy as np
from numpy.typing import NDArray

from crosstrack.compiled import compiled
from crosstrack.types import Array

LAYOUT = (
    ("way", 2),
    ("nearness", 1),
    ("height", 1),
    ("velocity", 3),
    ("tilt", 2),
    ("rate", 3),
    ("asked", 4),
    ("speed", 1),
)
"""Name and size of each part, in order; see `write`."""
SIZE = sum(size for _, size in LAYOUT)
NEAR = 5.0
"""m, at which the nearness of a goal is a half"""
HEIGHT = 2.0
"""m, the unit of heights"""
RATE = 5.0
"""rad/s, the unit of body rates"""
SPEED = 5.0
"""m/s, the unit of speeds allowed"""


@compiled
def heading(body: Array) -> tuple[float, float]:
    """Return the unit vector (cosine, sine) of the yaw of a body: its x axis in the plane."""
    x, y, z, w = body[6], body[7], body[8], body[9]
    ahead, left = 1 - 2 * (y * y + z * z), 2 * (x * y + w * z)
    size = math.sqrt(ahead * ahead + left * left)
    if size < 1e-9:
        return 1.0, 0.0
    return ahead / size, left / size


@compiled
def write(out: NDArray[np.float32], at: int, body: Array, goal: Array, asked: Array, speed: float) -> None:
    """Write what is seen of the motion from `out[at]` on.

    way: unit vector to the goal in the plane; nearness: 5 m/(5 m + distance in the plane); height of the goal above
    the vehicle over 2 m; velocity over the speed allowed; tilt: level part of body z; rate over 5 rad/s; asked: what
    the last action asked for, see `action`, with the heading asked for less the heading; speed allowed over 5 m/s.

    Args:
        out: (n,)
        at: first index
        body: (13,) position (m), velocity (m/s), attitude xyzw, body rate (rad/s)
        goal: (3,) m
        asked: (4,) see `crosstrack.policy.action`
        speed: m/s, allowed
    """
    c, s = heading(body)
    dx, dy = goal[0] - body[0], goal[1] - body[1]
    far = math.sqrt(dx * dx + dy * dy)
    inverse = 1.0 / far if far > 1e-9 else 0.0
    out[at], out[at + 1] = (c * dx + s * dy) * inverse, (c * dy - s * dx) * inverse
    out[at + 2], out[at + 3] = NEAR / (NEAR + far), (goal[2] - body[2]) / HEIGHT
    per = 1.0 / speed
    out[at + 4] = (c * body[3] + s * body[4]) * per
    out[at + 5], out[at + 6] = (c * body[4] - s * body[3]) * per, body[5] * per
    x, y, z, w = body[6], body[7], body[8], body[9]
    tx, ty = 2 * (x * z + w * y), 2 * (y * z - w * x)
    out[at + 7], out[at + 8] = c * tx + s * ty, c * ty - s * tx
    for k in range(3):
        out[at + 9 + k], out[at + 12 + k] = body[10 + k] / RATE, asked[k]
    turn = asked[3] - math.atan2(s, c)
    out[at + 15] = turn - 2 * math.pi * math.floor(turn / (2 * math.pi) + 0.5)
    out[at + 16] = speed / SPEED
