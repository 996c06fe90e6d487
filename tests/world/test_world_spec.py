"""The world as a mission writes it, and shapes made into voxels."""

from io import BytesIO
from typing import Any

import numpy as np
import pytest
from PIL import Image
from pydantic import TypeAdapter, ValidationError

from crosstrack.errors import InputError
from crosstrack.protocols import Map
from crosstrack.world.build import ShapeSpec, WorldSpec
from crosstrack.world.generate import Forest
from crosstrack.world.rasterise import rasterise
from crosstrack.world.shapes import Box, Cylinder, Prism, Sphere
from crosstrack.world.world import World

SHAPES: list[dict[str, Any]] = [
    {"cylinder": {"center": [1, 2], "radius": 0.5, "z": [0, 3]}},
    {"box": {"min": [0, 0, 0], "max": [1, 1, 1]}},
    {"sphere": {"center": [5, 5, 5], "radius": 1}},
    {"prism": {"polygon": [[0, 0], [1, 0], [0, 1]], "z": [0, 2]}},
]


def read(document: dict[str, Any]) -> WorldSpec:
    return TypeAdapter(WorldSpec).validate_python(document)


def files() -> dict[str, bytes]:
    pixels = np.full((20, 20), 255, dtype=np.uint8)
    pixels[:, 10] = 0
    image, cloud = BytesIO(), BytesIO()
    Image.fromarray(pixels).save(image, "PNG")
    np.savez(cloud, points=np.array([[50.0, 50.0, 5.0]]))
    return {"map.png": image.getvalue(), "scan.npz": cloud.getvalue()}


def test_the_mission_form_of_every_shape() -> None:
    assert [spec.shape for spec in read({"shapes": SHAPES}).shapes] == [
        Cylinder((1, 2), 0.5, (0, 3)),
        Box((0, 0, 0), (1, 1, 1)),
        Sphere((5, 5, 5), 1),
        Prism(((0, 0), (1, 0), (0, 1)), (0, 2)),
    ]


def test_all_sources_stand_in_one_world() -> None:
    spec = WorldSpec(
        bounds=((-60, -60, 0), (90, 90, 60)),
        ground=0.5,
        shapes=read({"shapes": SHAPES}).shapes,
        image=read({"image": {"file": "map.png"}}).image,
        cloud=read({"cloud": {"file": "scan.npz", "voxel": 0.5}}).cloud,
        generate=Forest(seed=7, size=(40, 20, 3), density=0.2, origin=(-40, -40)),
    )
    assert spec.files() == ["map.png", "scan.npz"]
    world: Map = spec.build(files())
    assert world.ground == 0.5
    np.testing.assert_array_equal(world.bounds, [[-60, -60, 0], [90, 90, 60]])
    assert world.distance(np.array([5.0, 5, 5])) == -1
    assert world.distance(np.array([1.05, 1.5, 1])) <= 0
    assert world.distance(np.array([50.0, 50, 9.5])) == pytest.approx(4.0)
    assert isinstance(world, World)
    assert len(world.shapes) == 4 + 160


def test_an_empty_world() -> None:
    world = read({}).build({})
    assert world.bounds is None
    assert world.ground == 0
    assert world.distance(np.zeros(3)) == np.inf


def test_every_error_has_its_place() -> None:
    broken = {
        "bounds": [[0, 0, 0], [1, 1]],
        "shapes": [
            {"cylinder": {"center": [1, 2], "radius": -1, "z": [0, 3]}},
            {"box": {"min": [0, 0, 2], "max": [1, 1, 1]}},
            {},
            {"sphere": {"center": [0, 0, float("nan")], "radius": 1}},
        ],
        "cloud": {"file": "a.ply", "voxel": 0},
    }
    with pytest.raises(ValidationError) as caught:
        read(broken)
    places = {".".join(str(part) for part in error["loc"]) for error in caught.value.errors()}
    assert {"bounds.1.2", "shapes.0.cylinder.radius", "shapes.1.box", "shapes.2", "cloud.voxel"} <= places
    assert any(place.startswith("shapes.3.sphere.center.2") for place in places)


def test_bounds_and_shape_names_are_checked() -> None:
    with pytest.raises(ValueError, match="z from 5 to 5"):
        WorldSpec(bounds=((0, 0, 5), (1, 1, 5)))
    with pytest.raises(ValueError, match="found box and sphere"):
        ShapeSpec(box=Box((0, 0, 0), (1, 1, 1)), sphere=Sphere((0, 0, 0), 1))
    with pytest.raises(ValueError, match="found none"):
        ShapeSpec()


def test_rasterised_shapes_are_covered_and_not_by_much() -> None:
    shapes = (Sphere((1, 1, 1), 0.8), Box((2, 0.5, 0), (2.001, 1.5, 2)), Cylinder((3.2, 1), 0.3, (0.2, 1.8)))
    world, cell = World(shapes), 0.1
    voxels = rasterise(world, (0, 0, 0), (4, 2, 2), cell)
    grid = World(grids=(voxels,))
    points = np.random.default_rng(0).uniform([0, 0, 0], [4, 2, 2], size=(20_000, 3))
    exact, found = world.distance(points), grid.distance(points)
    assert (exact <= 0).any()
    assert (found[exact <= 0] <= 0).all()
    outside = exact > 0
    assert (found[outside] <= exact[outside] + grid.optimism).all()
    assert (found[outside] >= exact[outside] - np.sqrt(3) * cell - np.sqrt(3) / 2 * cell).all()


def test_rasterising_too_finely_or_nothing_is_refused() -> None:
    with pytest.raises(InputError, match="at most 16000000"):
        rasterise(World(), (0, 0, 0), (100, 100, 100), 0.01)
    with pytest.raises(InputError, match="above low"):
        rasterise(World(), (0, 0, 0), (1, 0, 1), 0.1)
