"""The arenas of the avoidance benchmark."""

import json

import numpy as np
import pytest

from crosstrack.campaign.avoidance.contestants import CONTESTANTS, document
from crosstrack.campaign.avoidance.families import FAMILIES, arenas, families
from crosstrack.campaign.avoidance.plane import plane
from crosstrack.campaign.avoidance.trial import built
from crosstrack.errors import InputError
from crosstrack.world.shapes import Box, Cylinder


@pytest.mark.parametrize("family", FAMILIES)
def test_a_seed_always_gives_the_same_arena_and_another_seed_another(family: str) -> None:
    one, two = arenas(family, 2, 7)
    assert one == FAMILIES[family](family, 7)
    assert built(one.world).shapes == built(FAMILIES[family](family, 7).world).shapes
    assert built(one.world).shapes != built(two.world).shapes
    assert json.loads(json.dumps(one.world)) == one.world


@pytest.mark.parametrize("family", FAMILIES)
def test_start_and_goal_are_free_and_obstacles_fill_the_height(family: str) -> None:
    for arena in arenas(family, 5, 0):
        world = built(arena.world)
        space = plane(world, 0.25)
        assert len(space.circles)
        bounds = world.bounds
        assert bounds is not None
        for place in (arena.start, arena.goal):
            assert (bounds[0] + 0.25 < place).all()
            assert (place < bounds[1] - 0.25).all()
        assert world.distance(np.array(arena.start)) >= 0.25
        assert (world.distance(np.array(arena.goal)) >= 0.25) or family == "closed"


@pytest.mark.parametrize("density", [0.1, 0.2, 0.3, 0.4])
def test_forests_have_their_density_and_radii(density: float) -> None:
    arena = FAMILIES[f"forest-{density}"](f"forest-{density}", 3)
    trunks = [shape for shape in built(arena.world).shapes if isinstance(shape, Cylinder)]
    felled = 2 * np.pi * 2.0**2 * density  # within 2 m of start and goal at most
    assert density * 800 - 3 * felled <= len(trunks) <= density * 800
    assert all(0.2 <= trunk.radius <= 0.5 for trunk in trunks)
    assert built(arena.world).distance(np.array([arena.start, arena.goal])).min() >= 1.5


@pytest.mark.parametrize("seed", range(12))
def test_goals_beside_walls_are_that_near_to_two(seed: int) -> None:
    arena = FAMILIES["beside"]("beside", seed)
    walls = [shape for shape in built(arena.world).shapes if isinstance(shape, Box)]
    goal = np.array(arena.goal)[:2]
    near = [np.linalg.norm(goal - np.clip(goal, wall.min[:2], wall.max[:2])) for wall in walls]
    assert len(near) == 2
    assert 0.3 <= min(near) <= max(near) <= 0.6


def test_the_straight_way_out_of_a_trap_is_blocked() -> None:
    for arena in arenas("trap", 20, 0):
        assert built(arena.world).swept(np.array(arena.start), np.array(arena.goal)) < 0


def test_words_name_families_or_groups_of_them() -> None:
    assert families([]) == list(FAMILIES)
    assert families(["gap", "discs"]) == ["discs-20", "discs-30", "gap"]
    assert families(["forest-0.4"]) == ["forest-0.4"]
    with pytest.raises(InputError, match="woods: there is no such family"):
        families(["woods"])


@pytest.mark.parametrize("name", CONTESTANTS)
def test_missions_ask_for_the_goal_and_give_four_times_the_time(name: str) -> None:
    arena, contestant = FAMILIES["maze"]("maze", 1), CONTESTANTS[name]
    said = document(arena, contestant, 30.0)
    assert said["name"] == f"maze-1-{name}"
    assert (said.get("goal") or said["route"][-1]) == list(arena.goal)
    assert ("goal" in said) == ("planner" in said) == contestant.plans
    assert said["timing"]["timeout"] == pytest.approx(4 * 30.0 / contestant.speed + 10, abs=0.05)
