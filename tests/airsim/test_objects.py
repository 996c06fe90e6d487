"""Things of the scene: spawned, moved, scaled, numbered and destroyed, and the world that follows."""

import math
import time
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scenery import at, call, simulated, vector

from crosstrack import frames
from crosstrack.airsim.scene.assets import inside, place
from crosstrack.airsim.scene.blocks import blocks
from crosstrack.airsim.scene.earth import local
from crosstrack.airsim.scene.names import first_number, numbered, pattern
from crosstrack.airsim.scene.poses import matrix
from crosstrack.airsim.scene.scene import MOST_CELLS, MOST_THINGS, Scene
from crosstrack.airsim.scene.thing import named, standing
from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.serve import simulator_of
from crosstrack.airsim.server.settings import Settings
from crosstrack.airsim.structs import GeoPoint, Pose
from crosstrack.types import Array
from crosstrack.world.generate import Forest
from crosstrack.world.grids import Voxels
from crosstrack.world.shapes import Box, Cylinder, Prism, Sphere
from crosstrack.world.world import World


def distance(point: Array, scene: Scene) -> float:
    """Return how far a point (NED) is from things."""
    return float(scene.world.distance(frames.enu_from_ned(point)))


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from(["Cube", "Sphere", "Cylinder", "Cone"]),
    st.sampled_from([0.0, 90.0, 37.0, -120.0]),
    st.sampled_from([0.0, 90.0, -90.0, 25.0]),
    st.sampled_from([0.0, 180.0, 90.0, -40.0]),
    st.sampled_from([(1.0, 1.0, 1.0), (2.0, 2.0, 3.0), (2.0, 0.7, 1.5), (4.0, 3.0, 0.5)]),
)
def test_a_placed_solid_holds_the_points_of_the_asset(
    asset: str, yaw: float, pitch: float, roll: float, scale: tuple[float, float, float]
) -> None:
    """Inside after turning and scaling back, but for a skin: a cell, or what a polygon is off a circle."""
    pose, sides = at(3, -2, -5, yaw, pitch, roll), np.array(scale)
    solid = place(asset, pose, sides)
    made = World((), (solid,)) if isinstance(solid, Voxels) else World((solid,))
    local_points = np.random.default_rng(3).uniform(-0.75, 0.75, (2000, 3))
    held = inside(asset, local_points)
    points = (local_points * sides) @ matrix(pose.orientation).T + pose.position
    gap = made.distance(frames.enu_from_ned(points))
    skin = 2.2 * solid.cell if isinstance(solid, Voxels) else 0.5 * sides.max() * (1 - math.cos(math.pi / 32)) + 1e-9
    assert (gap[held] <= skin).all()
    assert (gap[~held] >= -skin).all()
    assert (gap[held] < 0).mean() > 0.5
    assert (gap[~held] > 0).mean() > 0.8


def test_upright_solids_are_exact() -> None:
    assert isinstance(place("Cube", at(0, 0, 0, yaw=90, roll=180), vector(1, 2, 3)), Box)
    assert isinstance(place("Cube", at(0, 0, 0, pitch=90), vector(1, 2, 3)), Box)
    assert isinstance(place("Cube", at(0, 0, 0, yaw=10), vector(1, 2, 3)), Prism)
    assert isinstance(place("Cylinder", at(0, 0, 0, yaw=10), vector(2, 2, 3)), Cylinder)
    assert isinstance(place("Cylinder", at(0, 0, 0), vector(2, 1, 3)), Prism)
    assert isinstance(place("Sphere", at(0, 0, 0, pitch=33), vector(2, 2, 2)), Sphere)
    box = place("Cube", at(1, 2, -3), vector(2, 4, 6))
    assert isinstance(box, Box)
    np.testing.assert_allclose([box.min, box.max], [(0, 0, 0), (4, 2, 6)], atol=1e-12)


def test_a_thing_comes_moves_grows_and_goes() -> None:
    simulator = simulated()
    scene = simulator.scene
    assert call(simulator, "simSpawnObject", "crate", "Cube", at(10, 0, -2), vector(2, 2, 2), False, False) == "crate"
    assert distance(vector(0, 0, -2), scene) == pytest.approx(9)
    assert call(simulator, "simSetObjectPose", "crate", at(0, 5, -2, yaw=45), True)
    assert distance(vector(0, 0, -2), scene) == pytest.approx(5 - math.sqrt(2))
    assert call(simulator, "simSetObjectScale", "crate", vector(4, 4, 4))
    assert distance(vector(0, 0, -2), scene) == pytest.approx(5 - 2 * math.sqrt(2))
    np.testing.assert_allclose(call(simulator, "simGetObjectScale", "crate"), [4, 4, 4])
    pose = call(simulator, "simGetObjectPose", "crate")
    np.testing.assert_allclose(pose.position, [0, 5, -2])
    assert call(simulator, "simDestroyObject", "crate")
    assert distance(vector(0, 0, -2), scene) == math.inf
    assert not call(simulator, "simDestroyObject", "crate")


def test_what_is_not_there_answers_as_in_airsim() -> None:
    simulator = simulated()
    assert np.isnan(call(simulator, "simGetObjectPose", "none").position).all()
    assert call(simulator, "simGetObjectScale", "none").tolist() == [0, 0, 0]
    assert not call(simulator, "simSetObjectPose", "none", at(0, 0, 0), True)
    assert not call(simulator, "simSetObjectScale", "none", vector(1, 1, 1))
    assert not call(simulator, "simSetSegmentationObjectID", "none", 3, False)
    assert call(simulator, "simGetSegmentationObjectID", "none") == -1
    assert not call(simulator, "simDestroyObject", "Ground")
    assert not call(simulator, "simLoadLevel", "Neighborhood")
    assert not call(simulator, "simSetLightIntensity", "sun", 2.0)
    assert not call(simulator, "simSetObjectMaterial", "Ground", "mud", 0)
    assert call(simulator, "simSwapTextures", "a,b", 1, 0, 0) == []
    assert call(simulator, "simListSceneObjectsByTag", ".*") == []
    assert not call(simulator, "simRunConsoleCommand", "stat fps")
    assert call(simulator, "simFindLookAtRotation", "", "none").tolist() == [0, 0, 0]


def test_unfit_things_are_refused() -> None:
    simulator = simulated()
    good = "a", "Cube", at(0, 0, 0), vector(1, 1, 1), False, False
    bad: list[tuple[int, object]] = [
        (0, ""),
        (0, "x" * 1000),
        (1, "Teapot"),
        (2, Pose(vector(math.nan, 0, 0))),
        (2, Pose(vector(0, 0, 0), np.zeros(4))),
        (2, at(1e9, 0, 0)),
        (3, vector(1, 0, 1)),
        (3, vector(1, math.inf, 1)),
        (3, vector(1, 1e9, 1)),
    ]
    for place_of, value in bad:
        with pytest.raises(Refused):
            call(simulator, "simSpawnObject", *good[:place_of], value, *good[place_of + 1 :])
    with pytest.raises(Refused, match="no objects with name Teapot found in the Registry"):
        call(simulator, "simSpawnObject", "a", "Teapot", *good[2:])
    assert simulator.scene.things == {}


def test_there_is_an_end_to_spawning() -> None:
    simulator = simulated()
    thing = standing("x", 0, Sphere((0, 0, 0), 1))
    simulator.scene.things.update({str(k): thing for k in range(MOST_THINGS)})
    with pytest.raises(Refused, match="no more"):
        call(simulator, "simSpawnObject", "a", "Cube", at(0, 0, 0), vector(1, 1, 1), False, False)


def test_there_is_an_end_to_cubes() -> None:
    simulator = simulated()
    cone = named("cone", 0, "Cone", at(0, 0, 0), vector(1, 1, 1))
    simulator.scene.things.update({str(k): replace(cone, name=str(k)) for k in range(MOST_CELLS // cone.cells)})
    with pytest.raises(Refused, match="cubes"):
        call(simulator, "simSpawnObject", "cone", "Cone", at(0, 0, 0), vector(1, 1, 1), False, False)
    with pytest.raises(Refused, match="cubes"):
        call(simulator, "simSetObjectPose", "0", at(0, 0, 0, yaw=45), True)


def test_names_are_made_new() -> None:
    assert numbered("box", []) == "box"
    assert numbered("box", ["box"]) == "box1"
    assert numbered("box", ["my_box7", "box"]) == "box8"
    assert numbered("ball", ["box"]) == "ball"


def test_names_are_found_by_patterns() -> None:
    simulator = simulated(Box((0, 0, 0), (1, 1, 1)), Cylinder((5, 5), 1, (0, 3)), Box((9, 9, 0), (10, 10, 1)))
    assert call(simulator, "simListSceneObjects", "Box.*") == ["Box_1", "Box_2"]
    assert call(simulator, "simListSceneObjects", "box.*") == []
    assert call(simulator, "simListSceneObjects", "Cyl") == []
    assert set(call(simulator, "simListSceneObjects", ".*")) >= {"Ground", "SkySphere", "Cylinder_1", "SimpleFlight"}
    assert call(simulator, "simSetSegmentationObjectID", "BOX_[\\d]*", 21, True)
    assert call(simulator, "simGetSegmentationObjectID", "box_2") == 21
    assert call(simulator, "simSetSegmentationObjectID", "SimpleFlight", 9, False)
    assert call(simulator, "simGetSegmentationObjectID", "simpleflight") == 9
    with pytest.raises(Refused):
        call(simulator, "simSetSegmentationObjectID", "Ground", 256, False)


@pytest.mark.parametrize(
    "text", ["(a+)+b", "(a|a)*b", "(?:a*)*", "((a)+)+", ".*" * 12, "(", "[", "x" * 300, "a{2}{3}+*"]
)
def test_patterns_that_could_take_long_are_refused(text: str) -> None:
    with pytest.raises(ValueError, match="pattern"):
        pattern(text)


@settings(max_examples=200, deadline=None)
@given(st.text("ab()[]*+?{}|.^$\\1,-", max_size=24))
def test_no_pattern_takes_long(text: str) -> None:
    try:
        made = pattern(text)
    except ValueError:
        return
    began = time.process_time()
    made.fullmatch("a" * 40 + "c")
    assert time.process_time() - began < 1


def test_numbers_come_from_names() -> None:
    """AirSim: 5 and the codes of the small letters, modulo 256; digits and dashes count not."""
    assert first_number("Ground") == (5 + sum(b"ground")) % 256
    assert first_number("Wall_12") == first_number("wall")


def test_a_world_of_things_is_the_world_it_was() -> None:
    shapes = Forest(seed=3).shapes(0.0)
    cloud = Voxels(np.random.default_rng(1).uniform(size=(6, 5, 4)) < 0.3, (30.0, 0.0, 0.0), 0.5)
    world = World((*shapes, Prism(((-9, -9), (-7, -9), (-8, -6)), (0, 3))), (cloud,), ground=-1.0)
    scene = Scene(world)
    points = np.random.default_rng(2).uniform(-40, 40, (500, 3))
    np.testing.assert_array_equal(scene.world.distance(points), world.distance(points))
    assert scene.ground == -1.0
    assert len(scene.things) == len(world.shapes) + 1
    for thing in list(scene.things.values()):
        if thing.asset:
            scene.put(thing.moved(thing.pose))
    np.testing.assert_allclose(scene.world.distance(points), world.distance(points), atol=1e-9)


def test_an_empty_world_has_nothing_to_see() -> None:
    scene = Scene(World())
    ranges, numbers = scene.eye.cast(vector(0, 0, -5), np.array([[1.0, 0, 0], [0, 0, 1.0]]), 100.0)
    assert ranges.tolist() == [math.inf, 5.0]
    assert numbers[1] == first_number("Ground")


def test_our_own_world_leaves_the_start_free() -> None:
    scene = Scene()
    assert distance(vector(0, 0, 0), scene) > 5
    kinds = {type(thing.solid) for thing in blocks()}
    assert kinds == {Box, Cylinder, Sphere, Prism, Voxels}
    assert len({thing.name for thing in blocks()}) == len(blocks())


def test_extents_of_the_world() -> None:
    simulator = simulated(Box((-10, -20, 0), (30, 5, 8)), Sphere((0, 50, 10), 5.0), Box((0, -900, 0), (1, 900, 1)))
    low, high = call(simulator, "simGetWorldExtents")
    corners = [local(one.latitude, one.longitude, one.altitude, simulator.origin) for one in (low, high)]
    np.testing.assert_allclose(corners, [[-20, -10, 0], [55, 30, -15]], atol=0.3)  # a sphere against an ellipsoid


def test_meshes_come_in_centimetres() -> None:
    simulator = simulated(Box((1, 2, 3), (2, 4, 6)))
    mesh = call(simulator, "simGetMeshPositionVertexBuffers")[0]
    vertices = mesh.vertices.reshape(-1, 3)
    np.testing.assert_allclose([vertices.min(axis=0), vertices.max(axis=0)], [[200, 100, 300], [400, 200, 600]])
    np.testing.assert_allclose(mesh.position, [300, 150, 450])
    a, b, c = (vertices[mesh.indices.reshape(-1, 3)[:, k]] - vertices.mean(axis=0) for k in range(3))
    volume = abs(np.einsum("ij,ij->i", a, np.cross(b, c)).sum()) / 6
    assert volume == pytest.approx(100 * 200 * 300)
    assert mesh.name == "box_1"


def test_lines_of_sight() -> None:
    simulator = simulated(Box((-5, 10, 0), (5, 11, 10)))

    def geo(north: float, east: float, up: float) -> GeoPoint:
        place_of = frames.geodetic_from_local([east, north, up], simulator.origin)
        return GeoPoint(*place_of)

    assert not call(simulator, "simTestLineOfSightBetweenPoints", geo(0, 0, 5), geo(20, 0, 5))
    assert call(simulator, "simTestLineOfSightBetweenPoints", geo(0, 0, 5), geo(20, 0, 20))
    assert call(simulator, "simTestLineOfSightBetweenPoints", geo(0, 0, 5), geo(20, 20, 5))
    assert not call(simulator, "simTestLineOfSightBetweenPoints", geo(0, 20, 5), geo(20, 20, -5))
    assert call(simulator, "simTestLineOfSightToPoint", geo(9, 0, 1), "")
    assert not call(simulator, "simTestLineOfSightToPoint", geo(12, 0, 1), "")


def test_looking_at_a_thing() -> None:
    simulator = simulated(Sphere((10, 10, 10), 1.0))
    look = call(simulator, "simFindLookAtRotation", "", "Sphere_1")
    np.testing.assert_allclose(look, [math.degrees(math.atan2(10, math.hypot(10, 10))), 0, 45], atol=1e-9)


def test_vehicles_are_added() -> None:
    simulator = simulator_of(Settings(), World(), lockstep=True)
    assert call(simulator, "simAddVehicle", "Two", "SimpleFlight", at(4, 5, -1), "")
    assert call(simulator, "listVehicles") == ["SimpleFlight", "Two"]
    np.testing.assert_allclose(call(simulator, "simGetObjectPose", "Two").position, [4, 5, -1], atol=1e-6)
    assert call(simulator, "getImuData", "", "Two").time_stamp == simulator.now
    assert len(call(simulator, "simGetImage", "0", 0, "Two", False)) > 100
    assert not call(simulator, "simAddVehicle", "Three", "PhysXCar", at(0, 0, 0), "")
    for name in ("Two", "", "x" * 500):
        with pytest.raises(Refused):
            call(simulator, "simAddVehicle", name, "SimpleFlight", at(0, 0, 0), "")


def test_wind() -> None:
    simulator = simulated()
    call(simulator, "simSetWind", vector(4, 0, -1))
    assert simulator.wind.tolist() == [4, 0, -1]
    for wind in (vector(math.nan, 0, 0), vector(0, 1e5, 0)):
        with pytest.raises(Refused):
            call(simulator, "simSetWind", wind)


def test_weather_and_time_are_taken_note_of() -> None:
    simulator = simulated()
    before = call(simulator, "simGetImage", "0", 0, "", False)
    call(simulator, "simEnableWeather", True)
    call(simulator, "simSetWeatherParameter", 7, 0.5)
    call(simulator, "simSetTimeOfDay", True, "2018-02-12 15:20:00", True, 10.0, 1.0, True)
    call(simulator, "simPrintLogMessage", "hello", "there", 255)
    assert call(simulator, "simGetImage", "0", 0, "", False) == before
    with pytest.raises(Refused):
        call(simulator, "simSetWeatherParameter", 9, 0.5)
    assert call(simulator, "getSettingsString") == "{}"
