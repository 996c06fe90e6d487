"""The shortest of all ways that keep a clearance, exactly: what lengths are measured against.

Among circles the shortest way is straight lines that touch them and arcs along them. All such lines that are free, and
the free arcs between their ends, are a graph, in which Dijkstra's algorithm finds it: the tangent visibility graph
(Liu and Arimoto 1992, "Path planning using a tangent graph for mobile robots among polygonal and curved obstacles").
It shares nothing with the planners that it judges.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import dijkstra

from crosstrack.campaign.avoidance.plane import Plane, plane
from crosstrack.campaign.avoidance.tangents import free_arcs, free_tangents, inside_any
from crosstrack.types import Array
from crosstrack.world.world import World

Indices = NDArray[np.intp]
FULL = 2 * np.pi
STEP = np.radians(5)
"""between two points of an arc that is drawn"""


@dataclass(frozen=True)
class Optimum:
    """A shortest way."""

    length: float
    """m"""
    points: Array
    """(n, 2) m along it; its arcs are cut into pieces of 5 degrees at most"""


@dataclass(frozen=True)
class Graph:
    """Where free tangents touch circles, and what joins these points."""

    circle: Indices
    """(nodes,) which circle a point lies on"""
    angle: Array
    """(nodes,) rad, where on it"""
    edges: Indices
    """(edges, 2) nodes"""
    lengths: Array
    """(edges,) m"""
    sweeps: Array
    """(edges,) rad, how far an edge turns from its first to its second node; 0 where it is straight"""


def optimum(world: World, start: Array, goal: Array, clearance: float) -> Optimum | None:
    """Return the shortest way in the plane from start to goal that keeps a clearance; None where there is none.

    Args:
        world: upright cylinders and boxes, as high as its bounds
        start: (2,) or (3,) m
        goal: likewise
        clearance: m, above 0, to obstacles, and to the bounds

    Raises:
        ValueError: there is more in the world.
    """
    space = plane(world, clearance)
    ends = np.array([(*start[:2], 0.0), (*goal[:2], 0.0)])
    if any(inside_any(end[0], end[1], space.circles, space.rectangles, space.region) for end in ends):
        return None
    circles = np.concatenate([ends, space.circles])
    graph = tangent_graph(circles, space)
    nodes = shortest(graph)
    if nodes is None:
        return None
    return drawn(graph, circles, nodes)


def tangent_graph(circles: Array, space: Plane) -> Graph:
    """Return the graph of free tangents and arcs; node 0 is the start, node 1 the goal, as circles are."""
    rows, count = free_tangents(circles, space.circles, space.rectangles, space.region)
    rows = rows[:count]
    ends = rows[:, :2].astype(np.intp).ravel()  # first and second of every line in turn
    angles = rows[:, 2:4].ravel() % FULL
    node = np.where(ends < 2, ends, 2 + np.arange(2 * count))
    circle, angle = np.concatenate([[0, 1], ends]), np.concatenate([[0.0, 0.0], angles])
    edges, lengths, sweeps = [node.reshape(-1, 2)], [rows[:, 4]], [np.zeros(count)]
    for k in range(2, len(circles)):
        mine = 2 + np.flatnonzero(ends == k)
        if len(mine) > 1:
            pairs, turns = arcs(circles[k], mine[np.argsort(angle[mine])], angle, space)
            edges.append(pairs)
            lengths.append(turns * circles[k, 2])
            sweeps.append(turns)
    return Graph(circle, angle, np.concatenate(edges), np.concatenate(lengths), np.concatenate(sweeps))


def arcs(circle: Array, nodes: Indices, angle: Array, space: Plane) -> tuple[Indices, Array]:
    """Return the free arcs between neighbours on a circle: pairs of nodes, and by how much they turn (rad).

    Args:
        circle: (3,) m
        nodes: (n,) on it, in order of their angles
        angle: (all nodes,) rad in [0, 2π)
        space: the obstacles
    """
    meets = meetings(circle, space)
    cuts = np.unique(np.concatenate([angle[nodes], meets]))
    widths = np.diff(cuts, append=cuts[0] + FULL)
    free = free_arcs(circle, cuts + widths / 2, space.circles, space.rectangles, space.region) > 0
    free |= widths < 1e-9
    blocked = np.concatenate([[0], np.cumsum(~free)])
    first = np.searchsorted(cuts, angle[nodes])
    second = np.roll(first, -1)
    between = np.where(second > first, blocked[second] - blocked[first], blocked[-1] - blocked[first] + blocked[second])
    turn = (np.roll(angle[nodes], -1) - angle[nodes]) % FULL
    same = second == first
    kept = (between == 0) | same
    kept[-1] &= not (same[-1] and len(set(first)) == 1)  # all at one point: the way round is none
    turn[same] = 0.0
    return np.column_stack([nodes, np.roll(nodes, -1)])[kept], turn[kept]


def meetings(circle: Array, space: Plane) -> Array:
    """Return the angles (rad in [0, 2π)) at which a circle meets others, sides of rectangles, and the region."""
    x, y, radius = circle
    offset = space.circles[:, :2] - circle[:2]
    apart = np.linalg.norm(offset, axis=1)
    near = (apart > 0) & (apart < radius + space.circles[:, 2]) & (apart > abs(radius - space.circles[:, 2]))
    cosine = (radius**2 + apart[near] ** 2 - space.circles[near, 2] ** 2) / (2 * radius * apart[near])
    towards, half = np.arctan2(offset[near, 1], offset[near, 0]), np.arccos(np.clip(cosine, -1, 1))
    sides = np.concatenate([space.rectangles, space.region[None]])
    across = ((sides[:, [0, 2]] - x) / radius).ravel()
    along = ((sides[:, [1, 3]] - y) / radius).ravel()
    vertical = np.arccos(across[np.abs(across) < 1])
    level = np.arcsin(along[np.abs(along) < 1])
    return np.concatenate([towards - half, towards + half, vertical, -vertical, level, np.pi - level]) % FULL


def shortest(graph: Graph) -> list[int] | None:
    """Return the nodes of the shortest way from node 0 to node 1; None where there is none."""
    size, (first, second) = len(graph.circle), graph.edges.T
    order = np.lexsort((graph.lengths, second, first))  # of two edges between the same nodes the shorter
    first, second, lengths = first[order], second[order], graph.lengths[order]
    fresh = np.ones(len(order), dtype=bool)
    fresh[1:] = (first[1:] != first[:-1]) | (second[1:] != second[:-1])
    weights = np.maximum(lengths[fresh], 1e-12)  # a zero would be no edge
    matrix = csr_matrix((weights, (first[fresh], second[fresh])), shape=(size, size))
    _, before = dijkstra(matrix, directed=False, indices=0, return_predecessors=True)
    if before[1] < 0:
        return None
    nodes = [1]
    while nodes[-1] != 0:
        nodes.append(int(before[nodes[-1]]))
    return nodes[::-1]


def drawn(graph: Graph, circles: Array, nodes: list[int]) -> Optimum:
    """Return the way through some nodes."""
    known: dict[tuple[int, int], tuple[float, float]] = {}
    for (a, b), length, sweep in zip(graph.edges.tolist(), graph.lengths, graph.sweeps, strict=True):
        for pair, turn in (((a, b), sweep), ((b, a), -sweep)):
            if pair not in known or length < known[pair][0]:
                known[pair] = (float(length), float(turn))
    points, total = [circles[0, :2]], 0.0
    for a, b in pairwise(nodes):
        length, sweep = known[a, b]
        total += length
        if length == 0.0:
            continue
        pieces = max(1, int(np.ceil(abs(sweep) / STEP)))
        x, y, radius = circles[int(graph.circle[b])]
        for share in np.arange(1, pieces + 1) / pieces:
            at = graph.angle[b] - sweep * (1 - share)
            points.append(np.array([x + radius * np.cos(at), y + radius * np.sin(at)]))
    return Optimum(total, np.array(points))
