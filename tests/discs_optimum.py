"""The shortest way in the plane around discs, exactly: Dijkstra's search over common tangents and arcs of the rims."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from crosstrack.types import Array

TOUCH = 1e-9


def clear_segments(a: Array, b: Array, centres: Array, radii: Array) -> Array:
    """Return which segments (n,) meet the inside of no disc."""
    step = b - a
    square = np.maximum((step**2).sum(axis=1), 1e-18)
    free = np.ones(len(a), bool)
    for centre, radius in zip(centres, radii, strict=True):
        share = np.clip(((centre - a) * step).sum(axis=1) / square, 0, 1)
        near = a + share[:, None] * step - centre
        free &= (near**2).sum(axis=1) >= (radius - TOUCH) ** 2
    return free


def tangents(centres: Array, radii: Array, most: float) -> tuple[Array, Array, Array, Array]:
    """Return the common tangents of pairs of circles no farther apart than `most`: circle, circle, point, point."""
    i, j = np.triu_indices(len(radii), 1)
    far = np.linalg.norm(centres[j] - centres[i], axis=1)
    near = far < most
    i, j, far = i[near], j[near], far[near]
    along = (centres[j] - centres[i]) / far[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    found = []
    for side_i in (1.0, -1.0):
        for side_j in (1.0, -1.0):
            cosine = (side_i * radii[i] - side_j * radii[j]) / far
            fine = np.abs(cosine) < 1
            c = cosine[fine][:, None]
            normal = c * along[fine] + np.sqrt(1 - c**2) * across[fine]
            a = centres[i[fine]] + side_i * radii[i[fine], None] * normal
            b = centres[j[fine]] + side_j * radii[j[fine], None] * normal
            found.append((i[fine], j[fine], a, b))
    return tuple(np.concatenate(parts) for parts in zip(*found, strict=True))  # type: ignore[return-value]


def shortest(start: Array, goal: Array, centres: Array, radii: Array, most: float = np.inf) -> float:
    """Return the length of the shortest way (m) that meets the inside of no disc; inf without one."""
    start, goal = start[:2], goal[:2]
    far = float(np.linalg.norm(goal - start))
    if clear_segments(start[None], goal[None], centres, radii)[0]:
        return far
    i, j, a, b = tangents(np.concatenate([centres, [start, goal]]), np.concatenate([radii, [0.0, 0.0]]), most)
    free = clear_segments(a, b, centres, radii)
    i, j, a, b = i[free], j[free], a[free], b[free]
    ends = np.concatenate([a, b])
    circle = np.concatenate([i, j])
    rows, columns, costs = [np.arange(len(a))], [np.arange(len(a)) + len(a)], [np.linalg.norm(b - a, axis=1)]
    for k in range(len(radii)):
        mine = np.flatnonzero(circle == k)
        if len(mine) < 2:
            continue
        angle = np.arctan2(*(ends[mine] - centres[k]).T[::-1])
        order = np.argsort(angle)
        mine, angle = mine[order], angle[order]
        turn = np.diff(np.append(angle, angle[0] + 2 * np.pi))
        open_ = free_arcs(k, angle, turn, centres, radii)
        rows.append(mine[open_])
        columns.append(np.roll(mine, -1)[open_])
        costs.append(np.maximum(radii[k] * turn[open_], 1e-12))
    count = len(ends)
    for k, node in ((len(radii), count), (len(radii) + 1, count + 1)):
        mine = np.flatnonzero(circle == k)
        rows.append(mine)
        columns.append(np.full(len(mine), node))
        costs.append(np.full(len(mine), 1e-12))
    graph = coo_matrix(
        (np.concatenate(costs), (np.concatenate(rows), np.concatenate(columns))), shape=(count + 2, count + 2)
    )
    return float(dijkstra(graph.tocsr(), directed=False, indices=count)[count + 1])


def free_arcs(k: int, angle: Array, turn: Array, centres: Array, radii: Array) -> Array:
    """Return which arcs of rim `k`, from an angle over a turn, are inside no other disc."""
    away = centres - centres[k]
    far = np.linalg.norm(away, axis=1)
    meets = (far < radii + radii[k]) & (np.arange(len(radii)) != k)
    free = np.ones(len(angle), bool)
    for m in np.flatnonzero(meets):
        cosine = (far[m] ** 2 + radii[k] ** 2 - radii[m] ** 2) / (2 * far[m] * radii[k])
        if cosine <= -1:
            return np.zeros(len(angle), bool)
        if cosine >= 1:
            continue
        half = np.arccos(cosine)
        middle = np.arctan2(away[m, 1], away[m, 0])
        begin = (angle - (middle - half)) % (2 * np.pi)
        inside = (begin > 1e-7) & (begin < 2 * half - 1e-7)
        reaches = (begin >= 2 * half - 1e-7) & (begin + turn > 2 * np.pi + 1e-7)
        spans = (begin <= 1e-7) & (turn > 1e-7)
        free &= ~(inside | reaches | spans)
    return free
