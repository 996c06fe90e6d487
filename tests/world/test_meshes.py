"""Surfaces for drawing: closed, normals outward, of the right volume."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosstrack.types import Array
from crosstrack.world.grids import Voxels
from crosstrack.world.mesh import Mesh
from crosstrack.world.polygon import area, counter_clockwise, fault, triangles
from crosstrack.world.shapes import Box, Cylinder, Prism, Shape, Sphere
from crosstrack.world.world import World

COMB = ((0, 0), (7, 0), (7, 3), (6, 3), (6, 1), (5, 1), (5, 3), (4, 3), (4, 1), (2, 1), (2, 3), (0, 3), (0, 2), (0, 1))
SHAPES: list[tuple[Shape, float, float]] = [
    (Box((-1, -2, 0), (2, 1, 4)), 36, 1e-12),
    (Prism(COMB, (0, 2)), 2 * (7 + 2 * (2 + 1 + 1)), 1e-12),
    (Prism(COMB[::-1], (0, 2)), 2 * (7 + 2 * (2 + 1 + 1)), 1e-12),
    (Cylinder((1, 1), 2, (0, 3)), 12 * np.pi, 0.01),
    (Sphere((1, 2, 3), 2), 32 / 3 * np.pi, 0.03),
]


def volume(mesh: Mesh) -> float:
    """By the divergence theorem: positive when the normals point outward."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


@pytest.mark.parametrize(("shape", "size", "tolerance"), SHAPES)
def test_shape_meshes_are_closed_and_enclose_the_volume(shape: Shape, size: float, tolerance: float) -> None:
    mesh = shape.mesh()
    edges = Counter((a, b) for face in mesh.triangles.tolist() for a, b in zip(face, face[1:] + face[:1], strict=True))
    assert set(edges.values()) == {1}
    assert all((b, a) in edges for a, b in edges)
    assert volume(mesh) == pytest.approx(size, rel=tolerance)
    np.testing.assert_allclose(World((shape,)).distance(mesh.vertices), 0, atol=1e-12)


def test_voxel_surface_encloses_the_voxels_and_lies_on_them() -> None:
    occupied = np.random.default_rng(3).uniform(size=(7, 5, 4)) < 0.5
    mesh = Voxels(occupied, (1.0, -2.0, 3.0), 0.5).mesh()
    assert volume(mesh) == pytest.approx(occupied.sum() * 0.125)
    padded = np.pad(occupied, 1).astype(int)
    exposed = 0.25 * sum(np.abs(np.diff(padded, axis=axis)).sum() for axis in range(3))
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    assert np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2 == pytest.approx(exposed)


def test_a_full_block_of_voxels_is_drawn_as_a_box() -> None:
    assert len(Voxels(np.ones((9, 8, 7), dtype=bool), (0, 0, 0), 1.0).mesh().triangles) == 12


def test_world_draws_one_surface_for_each_kind() -> None:
    boxes = tuple(Box((i, 0, 0), (i + 0.5, 1, 1)) for i in range(3))
    drawn = World((*boxes, Sphere((0, 0, 5), 1)), (Voxels(np.ones((1, 1, 1), dtype=bool), (9, 9, 9), 1.0),)).meshes()
    assert [name for name, _, _ in drawn] == ["box", "sphere", "voxels"]
    _, vertices, faces = drawn[0]
    assert volume(Mesh(vertices, faces)) == pytest.approx(1.5)


def star(radii: list[float]) -> Array:
    angle = 2 * np.pi * np.arange(len(radii)) / len(radii)
    return np.stack([np.cos(angle) * radii, np.sin(angle) * radii], axis=1)


@settings(max_examples=80)
@given(st.lists(st.floats(0.05, 5), min_size=4, max_size=30), st.booleans())
def test_ears_tile_any_star_shaped_polygon(radii: list[float], back: bool) -> None:
    corners = star(radii)[::-1] if back else star(radii)
    assert fault(corners) == ""
    corners = counter_clockwise(corners)
    parts = [area(corners[part]) for part in triangles(corners)]
    assert len(parts) == len(radii) - 2
    assert min(parts) > -1e-12
    assert sum(parts) == pytest.approx(area(corners))
