"""The velocity nearest to a preferred one that keeps within half-spaces: a small quadratic program, exactly.

Half-spaces are added one at a time (Seidel, Small-dimensional linear programming and convex hulls made easy, Discrete &
Computational Geometry 6, 1991): while the nearest velocity so far keeps within the next one it stays; otherwise the new
one lies on the boundary of the half-space just added, which leaves the same problem with one dimension less.
"""

import math

from crosstrack.compiled import compiled
from crosstrack.types import Array

TOLERANCE = 1e-9
"""m/s, by which a half-space may be missed"""
PARALLEL = 1e-7
"""sine of the angle between two planes that have no line in common"""
HALVINGS = 12
"""of the range in which the least slack is sought"""

Triple = tuple[float, float, float]
Found = tuple[bool, float, float, float]
"""whether there is a velocity, and the velocity, m/s"""


@compiled
def bound(planes: Array, k: int, slack: float, fixed: int) -> float:
    """Return the bound of a half-space, relaxed by a slack unless it is one of the first `fixed`."""
    return float(planes[k, 3]) if k < fixed else float(planes[k, 3]) - slack


@compiled
def on_line(planes: Array, i: int, j: int, slack: float, fixed: int, target: Triple) -> Found:
    """Return the velocity nearest to the target on planes i and j that keeps within the half-spaces before j."""
    ax, ay, az = planes[i, 0], planes[i, 1], planes[i, 2]
    bx, by, bz = planes[j, 0], planes[j, 1], planes[j, 2]
    dx, dy, dz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    square = dx * dx + dy * dy + dz * dz
    if square < PARALLEL * PARALLEL:
        return False, target[0], target[1], target[2]
    size = math.sqrt(square)
    dx, dy, dz = dx / size, dy / size, dz / size
    miss = bound(planes, i, slack, fixed) - ax * target[0] - ay * target[1] - az * target[2]
    other = bound(planes, j, slack, fixed) - bx * target[0] - by * target[1] - bz * target[2]
    common = ax * bx + ay * by + az * bz
    p, q = (miss - common * other) / square, (other - common * miss) / square
    x = target[0] + p * ax + q * bx
    y = target[1] + p * ay + q * by
    z = target[2] + p * az + q * bz
    low, high = -math.inf, math.inf
    for k in range(j):
        along = planes[k, 0] * dx + planes[k, 1] * dy + planes[k, 2] * dz
        short = bound(planes, k, slack, fixed) - planes[k, 0] * x - planes[k, 1] * y - planes[k, 2] * z
        if abs(along) < PARALLEL:
            if short > TOLERANCE:
                return False, x, y, z
        elif along > 0:
            low = max(low, short / along)
        else:
            high = min(high, short / along)
    if low > high + TOLERANCE:
        return False, x, y, z
    t = min(max(0.0, low), high)
    return True, x + t * dx, y + t * dy, z + t * dz


@compiled
def on_plane(planes: Array, i: int, slack: float, fixed: int, target: Triple) -> Found:
    """Return the velocity nearest to the target on plane i that keeps within the half-spaces before it."""
    ax, ay, az = planes[i, 0], planes[i, 1], planes[i, 2]
    miss = bound(planes, i, slack, fixed) - ax * target[0] - ay * target[1] - az * target[2]
    x, y, z = target[0] + miss * ax, target[1] + miss * ay, target[2] + miss * az
    for j in range(i):
        if planes[j, 0] * x + planes[j, 1] * y + planes[j, 2] * z < bound(planes, j, slack, fixed) - TOLERANCE:
            found, x, y, z = on_line(planes, i, j, slack, fixed, target)
            if not found:
                return False, x, y, z
    return True, x, y, z


@compiled
def nearest(planes: Array, target: Triple, slack: float = 0.0, fixed: int = 0) -> Found:
    """Return the velocity v nearest to the target with n·v >= b for every half-space.

    Args:
        planes: (n, 4) unit normals n and bounds b (m/s), those likely to bind first
        target: m/s
        slack: m/s, by which half-spaces may be missed
        fixed: how many half-spaces, the first, may not be missed
    """
    x, y, z = target
    for i in range(planes.shape[0]):
        if planes[i, 0] * x + planes[i, 1] * y + planes[i, 2] * z < bound(planes, i, slack, fixed) - TOLERANCE:
            found, x, y, z = on_plane(planes, i, slack, fixed, target)
            if not found:
                return False, x, y, z
    return True, x, y, z


@compiled
def least_slack(planes: Array, fixed: int) -> float:
    """Return the least slack (m/s) that leaves a velocity, but for a hundredth of a per cent of the range.

    At rest a vehicle misses no half-space by more than its bound: that much is always enough.
    """
    low, high = 0.0, 0.0
    for k in range(fixed, planes.shape[0]):
        high = max(high, planes[k, 3] + 1e-6)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if nearest(planes, (0.0, 0.0, 0.0), middle, fixed)[0]:
            high = middle
        else:
            low = middle
    return high


@compiled
def safest(planes: Array, target: Triple, fixed: int) -> Triple:
    """Return the velocity nearest to the target among those that miss no half-space by more than they must.

    The first `fixed` are not missed at all as long as there is any velocity that keeps within them.
    """
    found, x, y, z = nearest(planes, target, 0.0, fixed)
    if found:
        return x, y, z
    found, x, y, z = nearest(planes, target, least_slack(planes, fixed), fixed)
    if found:
        return x, y, z
    found, x, y, z = nearest(planes, target, least_slack(planes, 0), 0)
    return (x, y, z) if found else (0.0, 0.0, 0.0)
