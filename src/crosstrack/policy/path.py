"""What a policy that follows a path sees of it, in the frame of its heading."""

import numpy as np
from numpy.typing import NDArray

from crosstrack.compiled import compiled
from crosstrack.policy.motion import heading
from crosstrack.types import Array

AHEAD = (0.0, 1.0, 2.0, 4.0, 7.0, 11.0)
"""m, along the path from the closest point, of the points seen"""
AIM = 3
"""which of them is shown as the one chased"""
NEAR, FAR = 1.0, 10.0
"""m, the unit of the closest point, and of the others"""
LAYOUT = (("error", 3), ("ahead", 3 * (len(AHEAD) - 1)))
"""Name and size of each part, in order."""
SIZE = sum(size for _, size in LAYOUT)


@compiled
def write_points(out: NDArray[np.float32], at: int, body: Array, points: Array) -> None:
    """Write where points (n, 3) m are from a body: the first in units of NEAR, the others in units of FAR.

    Args:
        out: changed from `out[at]` on
        at: first index
        body: (13,) position (m), velocity (m/s), attitude xyzw, body rate (rad/s)
        points: (n, 3) m
    """
    c, s = heading(body)
    for k in range(len(points)):
        per = 1.0 / NEAR if k == 0 else 1.0 / FAR
        dx, dy, dz = points[k, 0] - body[0], points[k, 1] - body[1], points[k, 2] - body[2]
        i = at + 3 * k
        out[i], out[i + 1], out[i + 2] = per * (c * dx + s * dy), per * (c * dy - s * dx), per * dz
