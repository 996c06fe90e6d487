"""Distances at the points of a lattice, as far as a reach: every obstacle is stamped where it is near."""

import math

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.protocols import Field
from crosstrack.types import Array
from crosstrack.world.lattice import relief
from crosstrack.world.nearest import sample
from crosstrack.world.solids import disc, polygon, rectangle
from crosstrack.world.table import BOX, CYLINDER, PRISM, RELIEF, Table


def stamped(table: Table | None, low: Array, cell: float, counts: tuple[int, int, int], reach: float) -> Field:
    """Return the distance to the nearest obstacle at the points of a lattice, (counts) m, at most `reach`.

    Args:
        table: of obstacles; None without any
        low: (3,) m, the first point
        cell: m, between two points along each axis
        counts: of points along each axis
        reach: m, above zero
    """
    values = np.full(counts, reach, dtype=np.float32)
    if table is not None:
        stamp(table, np.ascontiguousarray(low, dtype=float), cell, reach, values)
    return values


@compiled
def stamp(table: Table, low: Array, cell: float, reach: float, values: Field) -> None:
    """Lower the values of a lattice to the distances of all obstacles."""
    for i in range(table.kinds.size):
        box = table.boxes[i]
        i0, i1 = span(box[0] - reach, box[3] + reach, low[0], cell, values.shape[0])
        j0, j1 = span(box[1] - reach, box[4] + reach, low[1], cell, values.shape[1])
        k0, k1 = span(box[2] - reach, box[5] + reach, low[2], cell, values.shape[2])
        if i0 >= i1 or j0 >= j1 or k0 >= k1:
            continue
        if table.kinds[i] in (BOX, CYLINDER, PRISM, RELIEF):
            stamp_upright(table, i, low, cell, reach, values[i0:i1, j0:j1, k0:k1], i0, j0, k0)
        else:
            stamp_any(table, i, low, cell, values[i0:i1, j0:j1, k0:k1], i0, j0, k0)


@compiled
def span(lowest: float, highest: float, low: float, cell: float, count: int) -> tuple[int, int]:
    """Return the first and one past the last point of a lattice axis within an interval."""
    first = min(max(math.ceil((lowest - low) / cell), 0.0), float(count))
    last = min(max(math.floor((highest - low) / cell) + 1.0, 0.0), float(count))
    return int(first), int(last)


@compiled
def stamp_upright(
    table: Table, i: int, low: Array, cell: float, reach: float, values: Field, i0: int, j0: int, k0: int
) -> None:
    """Stamp an obstacle that is a plane outline times an interval of heights: its plane distance serves a column."""
    n, kind = table.numbers[i], table.kinds[i]
    bottom, top = (n[2], n[5]) if kind == BOX else (n[6], n[7]) if kind == RELIEF else (n[3], n[4])
    if kind == PRISM:
        bottom, top = n[2], n[3]
    for a in range(values.shape[0]):
        x = low[0] + (i0 + a) * cell
        for b in range(values.shape[1]):
            y = low[1] + (j0 + b) * cell
            if kind == CYLINDER:
                d = disc(x, y, n[0], n[1], n[2])[0]
            elif kind == BOX:
                d = rectangle(x, y, n[0], n[1], n[3], n[4])[0]
            elif kind == PRISM:
                d = polygon(x, y, table.corners, int(n[0]), int(n[1]))[0]
            else:
                d = relief(x, y, n, table.boxes[i], table.values)[0]
            if d >= reach:
                continue
            for c in range(values.shape[2]):
                z = low[2] + (k0 + c) * cell
                dz = max(bottom - z, z - top)
                far = math.sqrt(d * d + dz * dz) if d > 0.0 and dz > 0.0 else max(d, dz)
                values[a, b, c] = min(values[a, b, c], np.float32(far))


@compiled
def stamp_any(table: Table, i: int, low: Array, cell: float, values: Field, i0: int, j0: int, k0: int) -> None:
    """Stamp an obstacle point by point."""
    for a in range(values.shape[0]):
        x = low[0] + (i0 + a) * cell
        for b in range(values.shape[1]):
            y = low[1] + (j0 + b) * cell
            for c in range(values.shape[2]):
                far = sample(table, i, x, y, low[2] + (k0 + c) * cell)[0]
                values[a, b, c] = min(values[a, b, c], np.float32(far))
