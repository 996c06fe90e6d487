import sys
from itertools import pairwise

import numpy as np
import pytest

from crosstrack.errors import InputError
from crosstrack.search.sampled import PLANNERS, Sampling, sampled_way
from crosstrack.search.taut import length
from crosstrack.world.shapes import Box
from crosstrack.world.world import World

WALL = World((Box((4.9, -3.0, 0.0), (5.1, 3.0, 3.0)),))
START, GOAL = np.array([1.0, 0.0, 1.5]), np.array([9.0, 0.0, 1.5])
LAYER = np.array([[-np.inf, -np.inf, 0.25], [np.inf, np.inf, 2.75]])


def test_without_the_library_the_message_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ompl", None)
    with pytest.raises(InputError, match=r"search: rrt_star needs the package ompl: pip install 'crosstrack\[plan\]'"):
        sampled_way(WALL, START, GOAL, 0.25, LAYER, "rrt_star", 1000)


@pytest.mark.parametrize("planner", PLANNERS)
def test_a_way_around_a_wall_is_found(planner: Sampling) -> None:
    pytest.importorskip("ompl")
    way = sampled_way(WALL, START, GOAL, 0.25, LAYER, planner, 5000)
    np.testing.assert_array_equal(way[[0, -1]], [START, GOAL])
    assert min(WALL.swept(a, b) for a, b in pairwise(way)) >= 0.249
    assert length(way) < 1.1 * 2 * np.hypot(4.0, 3.25)
