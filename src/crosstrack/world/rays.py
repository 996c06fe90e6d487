"""How far a ray goes until it hits one obstacle.

A ray starts at a point and goes along a unit vector. Solids have closed forms. Grids are walked from cell to cell,
which is exact for the union of their occupied cells, in leaps where the distance at a corner says that nothing is near.
"""

import math

from crosstrack.compiled import compiled
from crosstrack.types import Array
from crosstrack.world.table import BOX, CYLINDER, PRISM, RELIEF, SPHERE, Table

Ray = tuple[float, float, float, float, float, float, float, float, float]
"""origin (m), direction, and the inverse of each component of the direction, 0 for 0"""
Triple = tuple[float, float, float]
Corners = tuple[float, float, float, float, float, float]
"""m, lowest and highest corner of a box"""
Span = tuple[float, float]


@compiled
def ray_from(x: float, y: float, z: float, dx: float, dy: float, dz: float) -> Ray:
    """Return the ray from a point along a unit vector."""
    ix, iy = 1.0 / dx if dx != 0.0 else 0.0, 1.0 / dy if dy != 0.0 else 0.0
    return x, y, z, dx, dy, dz, ix, iy, 1.0 / dz if dz != 0.0 else 0.0


@compiled
def slab(origin: float, inverse: float, low: float, high: float) -> Span:
    """Return from where to where along a ray one coordinate is within [low, high]; (inf, -inf) where never.

    Args:
        origin: m, where it starts
        inverse: of how much it changes per metre; 0 where it does not
        low: m
        high: m
    """
    if inverse == 0.0:
        if low <= origin <= high:
            return -math.inf, math.inf
        return math.inf, -math.inf
    one, two = (low - origin) * inverse, (high - origin) * inverse
    return min(one, two), max(one, two)


@compiled
def common(one: Span, two: Span) -> Span:
    """Return what two spans have in common."""
    return max(one[0], two[0]), min(one[1], two[1])


@compiled
def entry(span: Span) -> float:
    """Return where a ray enters a span ahead of its start; inf where it does not."""
    start = max(span[0], 0.0)
    return start if start <= span[1] else math.inf


@compiled
def upright(ray: Ray, axis: Triple, low: float, high: float) -> float:
    """Return where a ray enters an upright cylinder: x and y of its axis, its radius; its heights (m)."""
    px, py = ray[0] - axis[0], ray[1] - axis[1]
    dx, dy, radius = ray[3], ray[4], axis[2]
    a, b, c = dx * dx + dy * dy, px * dx + py * dy, px * px + py * py - radius * radius
    square = b * b - a * c
    if square < 0.0 or (b > 0.0 and c > 0.0):
        return math.inf
    span = slab(ray[2], ray[8], low, high)
    if a == 0.0:
        return entry(span) if c <= 0.0 else math.inf
    root, inverse = math.sqrt(square), 1.0 / a
    return entry(common(span, ((-b - root) * inverse, (-b + root) * inverse)))


@compiled
def ball(ray: Ray, numbers: Array, row: int) -> float:
    """Return where a ray enters a sphere."""
    px, py, pz = ray[0] - numbers[row, 0], ray[1] - numbers[row, 1], ray[2] - numbers[row, 2]
    b, c = px * ray[3] + py * ray[4] + pz * ray[5], px * px + py * py + pz * pz - numbers[row, 3] ** 2
    square = b * b - c
    if square < 0.0 or (b > 0.0 and c > 0.0):
        return math.inf
    root = math.sqrt(square)
    return entry((-b - root, -b + root))


@compiled
def corners_of(boxes: Array, row: int) -> Corners:
    """Return one of several boxes (n, 6 or more) as numbers."""
    low = boxes[row, 0], boxes[row, 1], boxes[row, 2]
    return low + (boxes[row, 3], boxes[row, 4], boxes[row, 5])


@compiled
def box_span(ray: Ray, box: Corners) -> Span:
    """Return the span inside a box."""
    span = common(slab(ray[0], ray[6], box[0], box[3]), slab(ray[1], ray[7], box[1], box[4]))
    return common(span, slab(ray[2], ray[8], box[2], box[5]))


@compiled
def contains(x: float, y: float, corners: Array, first: int, count: int) -> bool:
    """Return whether a plane point is in a polygon, by the parity of the edges to one side."""
    inside = False
    ax, ay = corners[first + count - 1, 0], corners[first + count - 1, 1]
    for i in range(first, first + count):
        bx, by = corners[i, 0], corners[i, 1]
        if (ay > y) != (by > y) and (x - ax < (y - ay) / (by - ay) * (bx - ax)):
            inside = not inside
        ax, ay = bx, by
    return inside


@compiled
def prism(ray: Ray, numbers: Array, row: int, corners: Array) -> float:
    """Return where a ray enters an upright prism: through a side, or, inside the outline, at an end or at its start."""
    x, y, z, dx, dy = ray[:5]
    first, count, low, high = int(numbers[row, 0]), int(numbers[row, 1]), numbers[row, 2], numbers[row, 3]
    span = slab(z, ray[8], low, high)
    best = entry(span)
    if best == math.inf or contains(x + best * dx, y + best * dy, corners, first, count):
        return best
    start, best = best, math.inf
    ax, ay = corners[first + count - 1, 0] - x, corners[first + count - 1, 1] - y
    for i in range(first, first + count):
        bx, by = corners[i, 0] - x, corners[i, 1] - y
        ex, ey = bx - ax, by - ay
        across = dx * ey - dy * ex
        if across != 0.0:
            t, u = (ax * ey - ay * ex) / across, (ax * dy - ay * dx) / across
            if 0.0 <= u <= 1.0 and start <= t <= span[1]:
                best = min(best, t)
        ax, ay = bx, by
    return best


@compiled
def boundary(x: float, d: float, i: int, low: float, size: float) -> float:
    """Return where a ray leaves cell `i` along one axis."""
    if d > 0.0:
        return (low + (i + 1) * size - x) / d
    if d < 0.0:
        return (low + i * size - x) / d
    return math.inf


@compiled
def cell_at(x: float, low: float, size: float, count: int) -> int:
    """Return the cell of a coordinate, of a grid with so many corners."""
    return int(min(max(math.floor((x - low) / size), 0.0), count - 2.0))


@compiled
def relief(table: Table, row: int, ray: Ray, far: float) -> float:
    """Return where a ray enters a wall of a plane grid; inf where not within `far` (m)."""
    x, y, dx, dy = ray[0], ray[1], ray[3], ray[4]
    numbers, values = table.numbers, table.values
    first, nx, ny, size = int(numbers[row, 0]), int(numbers[row, 1]), int(numbers[row, 2]), numbers[row, 3]
    lx, ly = numbers[row, 4], numbers[row, 5]
    span = box_span(ray, corners_of(table.boxes, row))
    t, end = entry(span), min(span[1], far)
    flat = math.sqrt(dx * dx + dy * dy)
    i = j = -1
    tx = ty = 0.0
    while t <= end:
        if i < 0:
            i, j = cell_at(x + t * dx, lx, size, nx), cell_at(y + t * dy, ly, size, ny)
            tx, ty = boundary(x, dx, i, lx, size), boundary(y, dy, j, ly, size)
        at = first + i * ny + j
        if table.occupied[at]:
            return t
        free = values[at] - 1.5 * size
        if free > size:
            t += free / flat if flat > 0.0 else math.inf
            i = -1
            continue
        t = max(t, min(tx, ty))
        if tx <= ty:
            i += 1 if dx > 0.0 else -1
            tx = boundary(x, dx, i, lx, size)
        else:
            j += 1 if dy > 0.0 else -1
            ty = boundary(y, dy, j, ly, size)
        if i < 0 or j < 0 or i > nx - 2 or j > ny - 2:
            return math.inf
    return math.inf


@compiled
def voxels(table: Table, row: int, ray: Ray, far: float) -> float:
    """Return where a ray enters an occupied cube of a grid in space; inf where not within `far` (m)."""
    x, y, z, dx, dy, dz = ray[:6]
    numbers, values = table.numbers, table.values
    first, nx, ny, nz = int(numbers[row, 0]), int(numbers[row, 1]), int(numbers[row, 2]), int(numbers[row, 3])
    size, lx, ly, lz = numbers[row, 4], numbers[row, 5], numbers[row, 6], numbers[row, 7]
    span = box_span(ray, corners_of(table.boxes, row))
    t, end = entry(span), min(span[1], far)
    i = j = k = -1
    tx = ty = tz = 0.0
    while t <= end:
        if i < 0:
            i, j = cell_at(x + t * dx, lx, size, nx), cell_at(y + t * dy, ly, size, ny)
            k = cell_at(z + t * dz, lz, size, nz)
            tx, ty = boundary(x, dx, i, lx, size), boundary(y, dy, j, ly, size)
            tz = boundary(z, dz, k, lz, size)
        at = first + (i * ny + j) * nz + k
        if table.occupied[at]:
            return t
        free = values[at] - 1.75 * size
        if free > size:
            t += free
            i = -1
            continue
        t = max(t, min(tx, ty, tz))
        if tx <= ty and tx <= tz:
            i += 1 if dx > 0.0 else -1
            tx = boundary(x, dx, i, lx, size)
        elif ty <= tz:
            j += 1 if dy > 0.0 else -1
            ty = boundary(y, dy, j, ly, size)
        else:
            k += 1 if dz > 0.0 else -1
            tz = boundary(z, dz, k, lz, size)
        if i < 0 or j < 0 or k < 0 or i > nx - 2 or j > ny - 2 or k > nz - 2:
            return math.inf
    return math.inf


@compiled
def hit(table: Table, i: int, ray: Ray, far: float) -> float:
    """Return how far (m) a ray goes until it hits obstacle `i`; inf or more than `far` where not within `far` (m)."""
    kind = table.kinds[i]
    if kind == CYLINDER:
        n = table.numbers
        return upright(ray, (n[i, 0], n[i, 1], n[i, 2]), n[i, 3], n[i, 4])
    if kind == BOX:
        return entry(box_span(ray, corners_of(table.numbers, i)))
    if kind == SPHERE:
        return ball(ray, table.numbers, i)
    if kind == PRISM:
        return prism(ray, table.numbers, i, table.corners)
    if kind == RELIEF:
        return relief(table, i, ray, far)
    return voxels(table, i, ray, far)
