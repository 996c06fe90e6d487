"""What is assumed above and below the view of a sensor."""

import numpy as np
import pytest

from crosstrack.sense.depth_camera import DepthCamera
from crosstrack.sense.lidar import Lidar
from crosstrack.sense.local_map import LocalMap
from crosstrack.types import Array, State
from crosstrack.world.shapes import Box, Cylinder, Shape
from crosstrack.world.world import World

LOW = Lidar(lowest_deg=-15.0, highest_deg=15.0, noise=0.0, dropouts=0.0)
CAMERA = DepthCamera(fov_deg=60.0, noise=0.0, dropouts=0.0)
TRUNK = Cylinder((1.0, 0.0), 0.3, (0.0, 4.0))


def at(height: float) -> State:
    return State(0.0, np.array([0.0, 0.0, height]), np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(3))


def seen(sensor: Lidar | DepthCamera, shape: Shape, *heights: float) -> LocalMap:
    """Return the map after one look from each height above the origin."""
    local = LocalMap.around([sensor], World())
    for height in heights:
        local.add(sensor.look(World((shape,)), at(height), np.random.default_rng(0)), at(height))
    return local


def beside(height: float) -> Array:
    return np.array([0.45, 0.0, height])


@pytest.mark.parametrize("sensor", [LOW, CAMERA])
@pytest.mark.parametrize("aside", [-0.45, 0.45])
def test_a_trunk_seen_to_the_edge_of_the_view_goes_on(sensor: Lidar | DepthCamera, aside: float) -> None:
    edge = 1.5 + np.sign(aside) * 0.7 * np.tan(np.radians(20.0))
    local = seen(sensor, TRUNK, 1.5)
    here = local.distance(beside(1.5 + aside))
    assert abs(aside) > abs(edge - 1.5) + 0.1
    assert 0.24 < here < 0.28


def test_it_goes_on_for_half_a_metre_and_not_for_ever() -> None:
    local = seen(LOW, TRUNK, 1.5)
    assert local.distance(beside(3.0)) > 0.7


def test_what_is_farther_than_two_metres_does_not_go_on() -> None:
    local = seen(LOW, Cylinder((3.0, 0.0), 0.3, (0.0, 9.0)), 3.0)
    highest = local.points[:, 2].max()
    assert highest < 3.0 + 3.0 * np.tan(np.radians(15.0)) + 0.05


def test_it_ends_where_a_ray_passes_over_it() -> None:
    wall = Box((0.7, -2.0, 0.0), (0.9, 2.0, 1.72))
    before = seen(LOW, wall, 1.5)
    after = seen(LOW, wall, 1.5, 1.6, 1.8, 2.0)
    place = np.array([0.7, 0.0, 2.05])
    assert before.distance(place) < 0.1
    assert after.distance(place) == pytest.approx(0.33, abs=0.05)


def test_nothing_goes_on_into_the_ground() -> None:
    local = seen(LOW, TRUNK, 0.5)
    assert local.points[:, 2].min() > 0.0
