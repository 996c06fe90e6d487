"""Policies fly missions: what they see and ask for, which files and sensors they need."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import crosstrack as ct
from crosstrack.errors import InputError
from crosstrack.flight.summary import summary
from crosstrack.learn.arenas import forest
from crosstrack.learn.avoid import Avoid
from crosstrack.learn.randomise import NOMINAL
from crosstrack.learn.single import Single
from crosstrack.mission.load import from_document, loads
from crosstrack.policy.file import load, save, shipped
from crosstrack.policy.flying import Pilot
from crosstrack.types import Outcome, Scan, State

RAYS = {"kind": "lidar", "rings": 1, "columns": 32, "lowest_deg": 0.0, "highest_deg": 0.0, "fov_deg": 180.0}
RAYS |= {"range": 8.0, "rate": 20.0, "noise": 0.0}
HOP = "start: {position: [0, 0, 10]}\nroute: [[15, 0, 10]]\nspeed: 3\n"


def document(seed: int, **more: Any) -> dict[str, Any]:
    """Return a mission through a forest, by a policy."""
    arena = forest(0.08, seed)
    return {
        "start": {"position": list(arena.start)},
        "route": [list(arena.goal)],
        "speed": 3.5,
        "map": "unknown",
        "sensors": [RAYS],
        "avoid": [{"kind": "policy", "file": "avoid-ppo"}],
        "world": dict(arena.world),
        **more,
    }


def test_what_a_policy_does_in_flight_is_what_it_does_where_it_was_trained() -> None:
    policy = load("avoid-ppo")
    options = {name: policy.card.options[name] for name in ("speed", "rays", "fov_deg", "range")}
    env = Single(Avoid(randomise=NOMINAL, noise=0.0, **options), arena=forest(0.08, 7))
    seen, _ = env.reset(seed=0)
    memory, places = policy.start(), [env.core.rows["state"][0, :3].copy()]
    over = False
    while not over:
        action, memory = policy.decide(seen, memory)
        seen, _, terminated, truncated, infos = env.step(action)
        over = terminated or truncated
        places.append(env.core.rows["state"][0, :3].copy())
    assert infos["outcome"] == "arrived"
    flight = ct.fly(from_document(document(7, timing={"rate": 20.0})))
    assert flight.outcome is Outcome.ARRIVED
    count = min(len(places) - 1, int(0.7 * len(places)))
    np.testing.assert_allclose(flight.record.position[:count], places[:count], atol=0.02)


def test_the_safety_layer_behind_a_policy_keeps_it_from_harm() -> None:
    blind = {"avoid": [{"kind": "policy", "file": "avoid-ppo"}, {"kind": "safety"}]}
    lidar = {"kind": "lidar", "rings": 16, "columns": 360, "range": 15.0, "rate": 10.0}
    wall = {"bounds": [[-5, -20, 0], [30, 20, 3]], "shapes": [{"box": {"min": [10, -20, 0], "max": [10.2, 20, 3]}}]}
    said = document(1, **blind) | {"world": wall, "start": {"position": [0, 0, 1.5]}, "route": [[20, 0, 1.5]]}
    said |= {"sensors": [RAYS, lidar], "timing": {"timeout": 15.0}}
    flight = ct.fly(from_document(said))
    assert flight.outcome in {Outcome.STUCK, Outcome.TIMED_OUT, Outcome.LEFT_BOUNDS}
    numbers = summary(flight)
    assert numbers["min_clearance_m"] >= 0.2
    if flight.outcome is not Outcome.LEFT_BOUNDS:
        assert numbers["safety_interventions"] > 0


def test_a_learned_follower_follows() -> None:
    flight = ct.fly(loads(HOP + "tracker: {kind: policy}\n"))
    assert flight.outcome is Outcome.ARRIVED
    assert flight.metrics.cross_track_rms_m < 0.5


def test_a_policy_beside_the_mission_is_kept_in_the_log(tmp_path: Path) -> None:
    save(load("avoid-ppo"), tmp_path / "mine.npz")
    mission = from_document(document(3, avoid=[{"kind": "policy", "file": "mine.npz"}]), tmp_path)
    flight = ct.fly(mission)
    assert set(flight.plan.files) == {"mine.npz"}
    (tmp_path / "mine.npz").unlink()
    again = ct.fly(from_document(flight.plan.document, flight.plan.files))
    np.testing.assert_array_equal(flight.record.position, again.record.position)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"avoid": [{"kind": "policy", "file": "nothing"}]}, "avoid.0..file: nothing: no such policy ships"),
        ({"avoid": [{"kind": "policy", "file": "nothing.npz"}]}, "no such file"),
        ({"avoid": [{"kind": "policy", "file": "follow-ppo"}]}, "task: must be avoid to be flown here, found follow"),
        ({"sensors": [RAYS | {"fov_deg": 90.0}]}, "no sensor has the beams that avoid-ppo was trained with"),
        ({"tracker": {"kind": "policy", "file": "avoid-ppo"}}, "task: must be follow to be flown here, found avoid"),
    ],
)
def test_what_does_not_fit_is_told_before_the_flight(change: dict[str, Any], message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=message):
        from_document(document(1, **change), tmp_path)


def test_a_finer_sensor_stands_for_the_beams() -> None:
    pilot = Pilot("it", load("avoid-ppo"), "avoid")
    rng = np.random.default_rng(0)
    fine = rng.normal(size=(4000, 3)) * [1, 1, 0.02]
    fine[:, 0] = np.abs(fine[:, 0])
    fine /= np.linalg.norm(fine, axis=1, keepdims=True)
    state = State(0.0, np.zeros(3), np.zeros(3), np.array([0.0, 0, 0, 1]), np.zeros(3))
    ranges = np.where(fine[:, 1] > 0, 4.0, np.inf)
    memory = pilot.saw(pilot.start(state), [Scan(0.0, np.zeros(3), fine, ranges, 8.0)])
    left = pilot.beams[:, 1] > 0.05
    np.testing.assert_allclose(memory.ranges[left], 0.5)
    np.testing.assert_allclose(memory.ranges[pilot.beams[:, 1] < -0.05], 1.0)
    behind = -fine[fine[:, 0] > 0.3]
    kept = pilot.saw(memory, [Scan(0.1, np.zeros(3), behind, np.ones(len(behind)), 8.0)])
    assert kept is memory, "a sensor that looks the other way shows nothing"


@pytest.mark.parametrize("name", shipped())
def test_policies_that_ship_say_how_they_came_about(name: str) -> None:
    card = load(name).card
    task, _, algorithm = name.partition("-")
    assert (card.task, card.algorithm) == (task, algorithm)
    assert replace(card).to_json()
    if card.training:
        assert card.training["command"].startswith("crosstrack train")
        assert 0 <= card.measured["success"] <= 1
