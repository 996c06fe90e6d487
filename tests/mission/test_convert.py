"""Missions written in AirSim's north-east-down fly the same as in east-north-up."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosstrack import frames
from crosstrack.errors import InputError
from crosstrack.mission import from_document, loads

NED = """
frame: ned
start: {position: [1, 2, -3], yaw: 0.3}
route: [[5, 0, -3], [5, 8, -4]]
wind: {mean: [1, 2, 0.5]}
world:
  ground: 1
  bounds: [[-10, -20, -30], [40, 50, 2]]
  shapes:
    - box: {min: [20, 21, -5], max: [22, 25, -1]}
    - cylinder: {center: [-5, 30], radius: 2, z: [-6, -2]}
    - sphere: {center: [30, -10, -7], radius: 3}
    - prism: {polygon: [[10, 30], [14, 30], [10, 38]], z: [-9, 0]}
"""


def test_everything_that_has_a_place_is_converted() -> None:
    mission = loads(NED)
    scenario = mission.scenario()
    assert scenario.position.tolist() == [2, 1, 3]
    assert scenario.yaw == pytest.approx(math.pi / 2 - 0.3)
    assert scenario.wind.mean == (2, 1, -0.5)
    assert scenario.world.ground == -1
    assert scenario.world.bounds is not None
    assert scenario.world.bounds.tolist() == [[-20, -10, -2], [50, 40, 30]]
    assert mission.points.tolist() == [[2, 1, 3], [0, 5, 3], [8, 5, 4]]


def test_distances_to_obstacles_are_those_of_the_same_place() -> None:
    world = loads(NED).obstacles
    rng = np.random.default_rng(1)
    ned = rng.uniform([-10, -20, -20], [40, 50, 1], size=(500, 3))
    found = world.distance(frames.enu_from_ned(ned))
    low, high = np.array([20, 21, -5]), np.array([22, 25, -1])
    outside = np.maximum(np.maximum(low - ned, ned - high), 0)
    box = np.linalg.norm(outside, axis=1)
    sphere = np.linalg.norm(ned - [30, -10, -7], axis=1) - 3
    near = (found > 0) & ((np.abs(box - found) < 1e-9) | (np.abs(sphere - found) < 1e-9))
    assert near.sum() > 100
    assert (found <= np.minimum(np.where(box > 0, box, np.inf), sphere) + 1e-9).all()


def test_the_document_keeps_the_frame_it_was_written_in() -> None:
    mission = loads(NED)
    document = mission.document()
    assert document["frame"] == "ned"
    assert document["start"]["position"] == [1, 2, -3]
    assert from_document(document) == mission


def test_two_dimensional_points_fly_at_the_start_s_height() -> None:
    mission = loads("frame: ned\nstart: {position: [0, 0, -3]}\nroute: [[5, 1], [5, 8]]\n")
    assert mission.points.tolist() == [[0, 0, 3], [1, 5, 3], [8, 5, 3]]


def test_positive_down_is_below_the_ground() -> None:
    with pytest.raises(InputError, match=r"route\[0\]: \(0, 5, -3\) lies 3 m below the ground"):
        loads("frame: ned\nstart: {position: [0, 0, -3]}\nroute: [[5, 0, 3]]\n")


@given(st.tuples(*[st.floats(-100, 100)] * 2), st.floats(0, 50), st.floats(-6, 6))
def test_an_enu_mission_rewritten_in_ned_is_the_same_scenario(
    plane: tuple[float, float], height: float, yaw: float
) -> None:
    enu = np.array([*plane, height])
    goal = np.array([200.0, 30.0, 20.0])
    one = from_document({"start": {"position": enu.tolist(), "yaw": yaw}, "route": [goal.tolist()]})
    two = from_document(
        {
            "frame": "ned",
            "start": {"position": frames.ned_from_enu(enu).tolist(), "yaw": float(frames.heading_from_yaw(yaw))},
            "route": [frames.ned_from_enu(goal).tolist()],
        }
    )
    np.testing.assert_array_equal(one.points, two.points)
    difference = one.scenario().yaw - two.scenario().yaw
    assert math.cos(difference) == pytest.approx(1)
