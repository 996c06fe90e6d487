"""Signed distance of single shapes against independent oracles."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from crosstrack.types import Array
from crosstrack.world.mesh import Mesh
from crosstrack.world.shapes import Box, Cylinder, Prism, Shape, Sphere
from crosstrack.world.world import World

ELL = Prism(((0, 0), (4, 0), (4, 1), (1, 1), (1, 3), (0, 3)), (-1, 2))
STAR = Prism(
    tuple((r * math.cos(a), r * math.sin(a)) for a, r in zip(np.arange(10) * math.pi / 5, [3, 1] * 5, strict=True)),
    (0, 1.5),
)
SHAPES: dict[str, Shape] = {
    "box": Box((-1, -2, 0), (2, 1, 4)),
    "cylinder": Cylinder((1, -1), 1.5, (-1, 2)),
    "sphere": Sphere((0.5, 1, -1), 2.0),
    "triangle": Prism(((0, 0), (3, 1), (1, 2)), (0, 2)),
    "clockwise": Prism(((0, 0), (0, 3), (1, 3), (1, 1), (4, 1), (4, 0)), (-1, 2)),
    "ell": ELL,
    "star": STAR,
}
each = pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES.keys())


def scatter(count: int, seed: int = 0) -> Array:
    return np.random.default_rng(seed).uniform(-6, 7, size=(count, 3))


def distance(shape: Shape, points: Array) -> Array:
    return World((shape,)).distance(points)


def to_triangle(p: Array, a: Array, b: Array, c: Array) -> float:
    """Least distance to a triangle: its plane where the foot lies in it, else its edges."""
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal)
    foot = p - normal * (normal @ (p - a))
    ins = [normal @ np.cross(v - u, foot - u) >= 0 for u, v in ((a, b), (b, c), (c, a))]
    if all(ins):
        return float(abs(normal @ (p - a)))
    lengths = []
    for u, v in ((a, b), (b, c), (c, a)):
        along = np.clip((p - u) @ (v - u) / ((v - u) @ (v - u)), 0, 1)
        lengths.append(float(np.linalg.norm(p - u - along * (v - u))))
    return min(lengths)


def winding(p: Array, mesh: Mesh) -> float:
    """Number of times a surface encloses a point, by the solid angles of its triangles (Van Oosterom 1983)."""
    total = 0.0
    for a, b, c in mesh.vertices[mesh.triangles] - p:
        la, lb, lc = (float(np.linalg.norm(v)) for v in (a, b, c))
        above = float(a @ np.cross(b, c))
        below = la * lb * lc + float(a @ b) * lc + float(b @ c) * la + float(c @ a) * lb
        total += 2 * math.atan2(above, below)
    return total / (4 * math.pi)


@pytest.mark.parametrize("name", ["box", "triangle", "clockwise", "ell", "star"])
def test_flat_faced_shapes_agree_with_the_distance_to_their_faces(name: str) -> None:
    mesh = SHAPES[name].mesh()
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    points = np.random.default_rng(4).uniform(low - 1.5, high + 1.5, size=(150, 3))
    faces = mesh.vertices[mesh.triangles]
    size = np.array([min(to_triangle(p, *face) for face in faces) for p in points])
    sign = np.where([winding(p, mesh) > 0.5 for p in points], -1, 1)
    assert (sign < 0).any()
    np.testing.assert_allclose(distance(SHAPES[name], points), sign * size, atol=1e-12)


def test_cylinder_agrees_with_samples_of_its_profile() -> None:
    cylinder = Cylinder((1, -1), 1.5, (-1, 2))
    points = scatter(2000)
    radial = np.hypot(points[:, 0] - 1, points[:, 1] + 1)
    step = np.linspace(0, 1, 20001)
    cap = np.stack([1.5 * step, np.zeros_like(step)], axis=1)
    profile = np.concatenate([cap + [0, -1], cap + [0, 2], np.stack([np.full_like(step, 1.5), 3 * step - 1], axis=1)])
    size, _ = cKDTree(profile).query(np.stack([radial, points[:, 2]], axis=1))
    inside = (radial < 1.5) & (np.abs(points[:, 2] - 0.5) < 1.5)
    assert inside.any()
    np.testing.assert_allclose(distance(cylinder, points), np.where(inside, -size, size), atol=1e-4)


def test_distances_known_by_hand() -> None:
    box, cylinder, sphere = SHAPES["box"], SHAPES["cylinder"], SHAPES["sphere"]
    np.testing.assert_allclose(distance(box, np.array([[0.5, -0.5, 2], [5, -0.5, 8], [2, 0, 1]])), [-1.5, 5, 0])
    np.testing.assert_allclose(distance(cylinder, np.array([[1, -1, 0.5], [1, 3.5, 6], [1, -1, 5]])), [-1.5, 5, 3])
    np.testing.assert_allclose(distance(sphere, np.array([[0.5, 1, -1], [0.5, 1, 4]])), [-2, 3])


@each
def test_gradient_is_a_unit_vector_and_the_slope(shape: Shape) -> None:
    world, points, step = World((shape,)), scatter(4000, 1), 1e-6
    gradient = world.gradient(points)
    np.testing.assert_allclose(np.linalg.norm(gradient, axis=1), 1, atol=1e-12)
    ahead = np.stack([world.distance(points + step * axis) for axis in np.eye(3)], axis=1)
    behind = np.stack([world.distance(points - step * axis) for axis in np.eye(3)], axis=1)
    smooth = (np.abs(ahead + behind - 2 * world.distance(points)[:, None]) < 1e-9).all(axis=1)
    assert smooth.mean() > 0.99
    np.testing.assert_allclose(gradient[smooth], ((ahead - behind) / (2 * step))[smooth], atol=1e-5)


@each
def test_following_the_gradient_back_reaches_the_surface(shape: Shape) -> None:
    world, points = World((shape,)), scatter(1000, 2)
    far = world.distance(points)
    foot = points - far[:, None] * world.gradient(points)
    outside = far > 0
    np.testing.assert_allclose(world.distance(foot[outside]), 0, atol=1e-12)


coordinate = st.floats(-8, 8)
point = st.tuples(coordinate, coordinate, coordinate)


@each
@settings(max_examples=60)
@given(a=point, b=point)
def test_distance_is_1_lipschitz(shape: Shape, a: tuple[float, float, float], b: tuple[float, float, float]) -> None:
    one, two = distance(shape, np.array([a, b]))
    assert abs(one - two) <= math.dist(a, b) + 1e-12


@each
def test_gradient_is_finite_at_centres_edges_and_corners(shape: Shape) -> None:
    mesh = shape.mesh()
    corners = mesh.vertices[mesh.triangles]
    middle = np.mean([mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)], axis=0)
    special = np.concatenate([mesh.vertices, corners.mean(axis=1), corners[:, :2].mean(axis=1), [middle]])
    gradient = World((shape,)).gradient(special)
    np.testing.assert_allclose(np.linalg.norm(gradient, axis=1), 1, atol=1e-9)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Box((0, 0, 0), (1, -1, 0)), ["y from 0 to -1", "z from 0 to 0"]),
        (lambda: Cylinder((0, 0), 1, (3, 3)), ["[3, 3]", "below"]),
        (lambda: Prism(((0, 0), (1, 0), (1, 1)), (2, 1)), ["[2, 1]"]),
        (lambda: Prism(((0, 0), (1, 0)), (0, 1)), ["at least 3", "found 2"]),
        (lambda: Prism(((0, 0), (1, 1), (0, 1), (1, 0)), (0, 1)), ["edges 0 and 2"]),
        (lambda: Prism(((0, 0), (1, 0), (1, 0), (0, 1)), (0, 1)), ["point 2 repeats"]),
        (lambda: Prism(((0, 0), (2, 0), (1, 0), (1, 1)), (0, 1)), ["doubles back", "point 1"]),
        (lambda: Prism(((0, 0), (4, 0), (4, 2), (2, 0), (0, 2)), (0, 1)), ["edges 0 and", "touch"]),
    ],
)
def test_impossible_shapes_are_refused(make: object, words: list[str]) -> None:
    assert callable(make)
    with pytest.raises(ValueError) as caught:  # noqa: PT011 - the words are checked below
        make()
    assert all(word in str(caught.value) for word in words)
