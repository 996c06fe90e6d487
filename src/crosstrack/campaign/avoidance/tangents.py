"""Straight lines that touch circles, and whether they are free of obstacles; see `optimum`."""

import math

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.types import Array

TOUCH = 1e-7
"""m, by which a line may enter an obstacle that it touches"""


@compiled
def inside_any(x: float, y: float, circles: Array, rectangles: Array, region: Array) -> bool:
    """Return whether a point is inside an obstacle or outside the region."""
    if x < region[0] - TOUCH or y < region[1] - TOUCH or x > region[2] + TOUCH or y > region[3] + TOUCH:
        return True
    for k in range(len(circles)):
        radius = max(circles[k, 2] - TOUCH, 0.0)
        if (x - circles[k, 0]) ** 2 + (y - circles[k, 1]) ** 2 < radius * radius:
            return True
    for k in range(len(rectangles)):
        if (
            rectangles[k, 0] + TOUCH < x < rectangles[k, 2] - TOUCH
            and rectangles[k, 1] + TOUCH < y < rectangles[k, 3] - TOUCH
        ):
            return True
    return False


@compiled
def enters(px: float, py: float, ux: float, uy: float, low: Array) -> bool:
    """Return whether the segment from p to p + u enters a rectangle."""
    first, last = 0.0, 1.0
    for at, step, bottom, top in ((px, ux, low[0] + TOUCH, low[2] - TOUCH), (py, uy, low[1] + TOUCH, low[3] - TOUCH)):
        if abs(step) < 1e-12:
            if not bottom < at < top:
                return False
            continue
        a, b = (bottom - at) / step, (top - at) / step
        first, last = max(first, min(a, b)), min(last, max(a, b))
    return first < last


@compiled
def crosses(px: float, py: float, qx: float, qy: float, circles: Array, rectangles: Array, region: Array) -> bool:
    """Return whether the segment from p to q enters an obstacle or leaves the region."""
    if min(px, qx) < region[0] - TOUCH or min(py, qy) < region[1] - TOUCH:
        return True
    if max(px, qx) > region[2] + TOUCH or max(py, qy) > region[3] + TOUCH:
        return True
    ux, uy = qx - px, qy - py
    square = ux * ux + uy * uy
    for k in range(len(circles)):
        cx, cy = circles[k, 0] - px, circles[k, 1] - py
        share = min(max((cx * ux + cy * uy) / square, 0.0), 1.0) if square > 0.0 else 0.0
        dx, dy = cx - share * ux, cy - share * uy
        radius = max(circles[k, 2] - TOUCH, 0.0)
        if dx * dx + dy * dy < radius * radius:
            return True
    for k in range(len(rectangles)):  # noqa: SIM110 - compiled
        if enters(px, py, ux, uy, rectangles[k]):
            return True
    return False


@compiled
def free_tangents(circles: Array, obstacles: Array, rectangles: Array, region: Array) -> tuple[Array, int]:
    """Return the free straight lines that touch two circles each.

    A line with the unit normal n touches two circles of radii a and b with the centres p and q at p + a n and at
    q ± b n, where n·(q - p) = a ∓ b.

    Args:
        circles: (n, 3) m: x, y, radius; those of radius 0 are the ends of the way
        obstacles: (k, 3) m, likewise
        rectangles: (m, 4) m
        region: (4,) m

    Returns:
        rows of first circle, second circle, angle of the touching point on the first and on the second (rad), length
        (m), of which so many count.
    """
    rows = np.empty((256, 5))
    count = 0
    for i in range(len(circles)):
        for j in range(i + 1, len(circles)):
            dx, dy = circles[j, 0] - circles[i, 0], circles[j, 1] - circles[i, 1]
            apart = math.sqrt(dx * dx + dy * dy)
            if apart == 0.0:
                continue
            for side in (1.0, -1.0):
                share = (circles[i, 2] - side * circles[j, 2]) / apart
                if abs(share) > 1.0 or (side < 0.0 and circles[j, 2] == 0.0):
                    continue
                across = math.sqrt(1.0 - share * share)
                for turn in (1.0, -1.0):
                    nx = (share * dx - turn * across * dy) / apart
                    ny = (share * dy + turn * across * dx) / apart
                    px, py = circles[i, 0] + circles[i, 2] * nx, circles[i, 1] + circles[i, 2] * ny
                    reach = side * circles[j, 2]
                    qx, qy = circles[j, 0] + reach * nx, circles[j, 1] + reach * ny
                    if crosses(px, py, qx, qy, obstacles, rectangles, region):
                        continue
                    if count == len(rows):
                        longer = np.empty((2 * count, 5))
                        longer[:count] = rows
                        rows = longer
                    rows[count, 0], rows[count, 1] = i, j
                    rows[count, 2], rows[count, 3] = math.atan2(ny, nx), math.atan2(side * ny, side * nx)
                    rows[count, 4] = math.sqrt((qx - px) ** 2 + (qy - py) ** 2)
                    count += 1
    return rows, count


@compiled
def free_arcs(circle: Array, middles: Array, obstacles: Array, rectangles: Array, region: Array) -> Array:
    """Return which arcs of a circle are free, (n,) 1 or 0, from the angles of their middles (n,) rad.

    Between two angles at which the circle meets another boundary, all of an arc is free or none of it.
    """
    free = np.empty(len(middles))
    for k in range(len(middles)):
        x = circle[0] + circle[2] * math.cos(middles[k])
        y = circle[1] + circle[2] * math.sin(middles[k])
        free[k] = 0.0 if inside_any(x, y, obstacles, rectangles, region) else 1.0
    return free
