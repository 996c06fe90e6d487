"""What the vehicles of the environments see is what the world says."""

import numpy as np
import pytest

from crosstrack.campaign.avoidance.families import FAMILIES, Arena
from crosstrack.campaign.avoidance.trial import built
from crosstrack.learn.arenas import arenas, pool
from crosstrack.learn.looking import around, look, nearest
from crosstrack.sense.pose import axes

REACH = 8.0
SHAPES = {
    "bounds": [[-20, -20, 0], [20, 20, 3]],
    "shapes": [
        {"sphere": {"center": [4, 1, 1.5], "radius": 0.7}},
        {"box": {"min": [-3, -4, 0.5], "max": [-2, 5, 2.5]}},
        {"cylinder": {"center": [2, -3], "radius": 0.6, "z": [1.0, 1.4]}},
        {"prism": {"polygon": [[0, 4], [2, 4], [1, 6]], "z": [0, 3]}},
    ],
}
MIXED = Arena("mixed", 0, (0.0, 0.0, 1.5), (9.0, 0.0, 1.5), SHAPES)
PLACES = {
    "forest": arenas("forest", 0.2, range(3)),
    "maze": [FAMILIES["maze"]("maze", seed) for seed in (1, 2)],
    "mixed": [MIXED, *arenas("forest", 0.1, range(1))],
}


def turned(rng: np.random.Generator) -> np.ndarray:
    """Return a random attitude, mostly upright."""
    attitude = rng.normal(0, 0.2, 4) + [0, 0, rng.uniform(-1, 1), 1]
    return np.asarray(attitude / np.linalg.norm(attitude))


@pytest.mark.parametrize("name", PLACES)
def test_ranges_and_distances_are_those_of_the_world(name: str) -> None:
    rng = np.random.default_rng(0)
    worlds = [built(arena.world) for arena in PLACES[name]]
    made = pool(PLACES[name], worlds)
    beams = rng.normal(size=(40, 3))
    beams /= np.linalg.norm(beams, axis=1, keepdims=True)
    found, rays = np.empty(made.most, np.int64), np.empty((5, len(beams)))
    hits = 0
    for k in range(60):
        index = k % len(worlds)
        world = worlds[index]
        at = np.array([*rng.uniform(-3, 15, 2), rng.uniform(0.1, 2.9)])
        body = np.concatenate([at, np.zeros(3), turned(rng), np.zeros(3)])
        count = around(made.table, made.first[index], made.first[index + 1], at[0], at[1], REACH, found)
        look(made.table, found, count, body, beams, REACH, 0.0, rays)
        directions = beams @ axes(body[6:10]).T
        with np.errstate(divide="ignore"):
            ground = np.where(directions[:, 2] < 0, -at[2] / directions[:, 2], np.inf)
        expected = np.minimum(np.minimum(world.cast(at, directions, REACH), ground), REACH)
        np.testing.assert_allclose(rays[0], expected, atol=1e-9)
        hits += int((expected < np.minimum(ground, REACH)).sum())
        end = at + rng.normal(0, 0.3, 3)
        reach = 1.0 + float(np.linalg.norm(end - at))
        count = around(made.table, made.first[index], made.first[index + 1], end[0], end[1], reach, found)
        least = nearest(made.table, found, count, at, end[0], end[1], end[2], 1.0)
        assert least == pytest.approx(min(world.swept(at, end), 1.0), abs=2e-6)
    assert hits > 100
