"""Policies are flown through the same worlds as what is beside them, and counted as they ended."""

from collections.abc import Generator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Self

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest

from crosstrack.avoid import policy as avoid
from crosstrack.campaign.ranking import Loss
from crosstrack.campaign.task import Done, Task, attempt
from crosstrack.errors import InputError
from crosstrack.learn import tasks
from crosstrack.learn.evaluation.aimless import Aimless, at_random
from crosstrack.learn.evaluation.evaluate import Evaluation, Setup, evaluate, setup
from crosstrack.learn.evaluation.missions import BESIDE, POLICY, RANDOM, ROUTE, SAFE, WORLDS, Where, mission, rate
from crosstrack.learn.evaluation.score import Score, score, scores
from crosstrack.learn.evaluation.trial import digest, fly, trial_task
from crosstrack.learn.follow import route
from crosstrack.mission.load import from_document
from crosstrack.policy.card import Card, Continuous, Discrete, Layer, Observation
from crosstrack.policy.file import save, to_bytes
from crosstrack.policy.flying import Pilot
from crosstrack.policy.policy import Policy
from crosstrack.show.learned_picture import evaluation_picture, examples
from crosstrack.show.learned_table import HEADINGS, cells
from crosstrack.world.shapes import Cylinder

EMPTY, DENSE = Where("forest", 0.0), Where("forest", 0.4)


def straight(task: str = "avoid", discrete: bool = False) -> Policy:
    """Return a policy that asks for full speed ahead, whatever it sees."""
    made: Any = tasks.find(task)() if not discrete else tasks.find(task)(action="stick")
    slices = tuple(made.seen)
    size = sum(count for _, count in slices)
    action = Discrete(27) if discrete else Continuous(3)
    options = tasks.options(made)
    plain = {name: list(value) if isinstance(value, tuple) else value for name, value in options.items()}
    bias = np.zeros(27 if discrete else 3, np.float32)
    bias[16 if discrete else 0] = 1.0  # held throttle and yaw, one notch ahead
    card = Card(task, plain, Observation(size, slices), action, "ppo", "mlp", (Layer("a", "dense"),), {}, {})
    return Policy(card, {"a.weight": np.zeros((len(bias), size), np.float32), "a.bias": bias})


@pytest.fixture
def file(tmp_path: Path) -> str:
    """Return the file of a policy that flies straight ahead."""
    save(straight(), tmp_path / "straight.npz")
    return str(tmp_path / "straight.npz")


class Here:
    """Do tasks in this process, and count them."""

    def __init__(self) -> None:
        self.done = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        pass

    def run(self, asked: Sequence[Task]) -> Generator[Done, None, None]:
        """Yield what comes of every task."""
        for task in asked:
            self.done += 1
            yield attempt(task)


def result(contestant: str, outcome: str, seed: int = 0, **numbers: Any) -> dict[str, Any]:
    """Return the result of a flight, as far as it is counted."""
    summary = {
        "arrived": outcome == "arrived",
        "mean_speed_mps": 3.0,
        "min_clearance_m": 0.5,
        "flown_length_m": 44.0,
        "path_length_m": 40.0,
        "safety_interventions": 0,
        "cross_track_rms_m": 0.2,
        "decision_time_s": 0.001,
    }
    labels = {"world": "forest-0.1", "seed": seed, "contestant": contestant}
    said = {"avoid": [{"kind": "policy"}, *([{"kind": "safety"}] if contestant == SAFE else [])]}
    return {"labels": labels, "document": said, "outcome": outcome, "summary": summary | numbers, "trace": None}


@pytest.mark.parametrize("discrete", [False, True])
def test_a_policy_at_random_is_even_and_follows_from_its_seed(discrete: bool) -> None:
    known = straight(discrete=discrete)
    seen = np.zeros(known.card.observation.size, np.float32)

    def drawn(seed: int) -> np.ndarray[Any, Any]:
        aimless = Aimless(known.card, known.arrays, seed)
        memory, found = aimless.start(), []
        for _ in range(3000):
            action, memory = aimless.decide(seen, memory)
            found.append(np.atleast_1d(action))
        return np.array(found)

    once = drawn(7)
    assert np.array_equal(once, drawn(7))
    assert not np.array_equal(once, drawn(8))
    if discrete:
        counts = np.bincount(once[:, 0], minlength=27)
        assert len(counts) == 27
        assert abs(counts - 3000 / 27).max() < 5 * np.sqrt(3000 / 27)
    else:
        assert once.shape == (3000, 3)
        assert abs(once).max() <= 1
        assert abs(once.mean(axis=0)).max() < 5 * np.sqrt(1 / 3 / 3000)  # of a uniform distribution on [-1, 1]
        assert abs(once.var(axis=0) - 1 / 3).max() < 0.03


def test_only_the_network_is_replaced_by_chance(file: str) -> None:
    one = avoid.Policy("straight.npz").given({"straight.npz": Path(file).read_bytes()})
    other = at_random(one, 3)
    assert isinstance(other.pilot.policy, Aimless)
    assert other.pilot.policy.seed == 3
    assert (other.ahead, other.pilot.period) == (one.ahead, one.pilot.period)
    assert not isinstance(one.pilot.policy, Aimless)


@given(st.floats(0.02, 0.99))
def test_commands_come_with_every_decision(period: float) -> None:
    commands = rate(period)
    assert commands >= 50 - 1e-6
    assert commands * period == pytest.approx(round(commands * period), abs=1e-9)
    assert commands - 1 / period < 50


@pytest.mark.parametrize("where", [Where("forest", 0.2), *(Where(family) for family in WORLDS if family != "forest")])
def test_all_contestants_fly_the_same_world(where: Where) -> None:
    known = straight()
    files = {"p.npz": to_bytes(known)}
    said = [mission("p.npz", known.card, where, 5, name) for name in (POLICY, *BESIDE["avoid"])]
    missions = [from_document(one, files) for one in said]  # each is sound
    first = missions[0]
    for other in missions:
        assert (other.start, other.world, other.vehicle) == (first.start, first.world, first.vehicle)
        assert other.points[-1].tolist() == first.points[-1].tolist()
    way = first.points[-1] - first.points[0]
    assert np.array([np.cos(first.start.yaw), np.sin(first.start.yaw)]) == pytest.approx(way[:2] / np.hypot(*way[:2]))
    assert [one.map for one in missions] == ["unknown"] * len(missions)
    assert [one.replan for one in missions if one.planner is None] == ["never"] * 4
    assert Pilot("p", known, "avoid").options["sensor"]["kind"] == said[0]["sensors"][-1]["kind"]


def test_wind_on_routes_blows_from_all_sides_at_one_speed() -> None:
    known = straight("follow")
    said = [mission("p.npz", known.card, Where(ROUTE), seed, "carrot") for seed in range(64)]
    winds = np.array([one["wind"]["mean"] for one in said])
    assert np.linalg.norm(winds, axis=1) == pytest.approx(np.full(64, 3.0))
    quarters = np.floor(np.arctan2(winds[:, 1], winds[:, 0]) / (np.pi / 2)).astype(int)
    assert np.bincount(quarters - quarters.min(), minlength=4).min() >= 6


def test_straight_ahead_arrives_where_nothing_stands(file: str) -> None:
    found = fly(trial_task(file, digest(straight()), EMPTY, 1, POLICY).payload)
    assert found["outcome"] == "arrived"
    assert found["summary"]["flown_length_m"] == pytest.approx(40, abs=0.5)
    assert 3.0 < found["summary"]["mean_speed_mps"] < found["summary"]["max_speed_mps"] < 4.2  # 4 m/s are asked for
    assert found["trace"]["position"][-1] == pytest.approx([42, 10, 1.5], abs=0.25)


def test_straight_ahead_collides_where_a_trunk_stands(file: str) -> None:
    found = fly(trial_task(file, digest(straight()), DENSE, 1, POLICY).payload)
    assert found["outcome"] == "collided"
    end = np.array(found["trace"]["position"][-1])[:2]
    stands = from_document(found["document"], {"straight.npz": Path(file).read_bytes()}).obstacles.shapes
    trunks = [one for one in stands if isinstance(one, Cylinder)]
    gaps = [np.hypot(*(end - np.array(trunk.center))) - trunk.radius for trunk in trunks]
    assert min(gaps) == pytest.approx(found["summary"]["min_clearance_m"], abs=2e-3)
    assert min(gaps) < 0.2


def test_errors_on_a_route_are_those_to_its_rounded_course() -> None:
    known = straight("follow")
    payload = trial_task("follow-ppo", "", Where(ROUTE), 2, "carrot").payload
    with pytest.raises(InputError, match="has changed since the evaluation began"):
        fly(payload)
    found = from_document(mission("p.npz", known.card, Where(ROUTE), 2, "carrot")).build()
    corners = route(2)
    near = found.course.path(np.linspace(0, found.course.path.length, 2000))
    gaps = np.linalg.norm(near[:, None] - corners[1:-1], axis=2).min(axis=0)
    assert (gaps <= 1.0).all()
    assert gaps.max() > 0.3


def test_what_is_done_is_not_flown_again_and_another_policy_is(file: str, tmp_path: Path) -> None:
    here = Here()
    asked: Any = {"maps": 2, "densities": [0.0], "beside": [], "store": tmp_path / "kept.jsonl"}
    once = evaluate(file, runner=here, **asked)
    again = evaluate(file, runner=here, **asked)
    assert here.done == 2
    assert once.document() == again.document()
    assert once.scores[0].arrived == 2
    other = straight()
    save(Policy(replace(other.card, algorithm="a2c"), other.arrays), file)
    evaluate(file, runner=here, **asked)
    assert here.done == 4


def test_flights_at_random_repeat(file: str) -> None:
    payload = trial_task(file, digest(straight()), EMPTY, 4, RANDOM).payload
    once, again = fly(payload), fly(payload)
    assert once["trace"] == again["trace"]
    assert once["outcome"] != "arrived"


def test_every_end_is_counted_once() -> None:
    ends = ["arrived", "arrived", "collided", "left_bounds", "timed_out", "stuck", "lost_control"]
    flights = [result(POLICY, end, k, mean_speed_mps=2.0 + k) for k, end in enumerate(ends)]
    found = score("forest-0.1", POLICY, flights, lost=1)
    assert (found.flights, found.arrived, found.collided, found.left_bounds) == (8, 2, 1, 1)
    assert (found.late, found.otherwise, found.lost) == (2, 1, 1)
    sure = binomtest(2, 8).proportion_ci(method="wilson")
    assert found.interval == pytest.approx((sure.low, sure.high), abs=1e-6)
    assert found.mean_speed == pytest.approx(2.5)  # of those that arrived
    assert found.length is not None
    assert found.length.median == pytest.approx(1.1)
    assert found.interventions is None
    assert found.cross_track is None  # nothing is followed


def test_interventions_are_those_of_a_safety_layer() -> None:
    flights = [result(SAFE, "arrived", k, safety_interventions=k) for k in range(4)]
    assert score("forest-0.1", SAFE, flights).interventions == pytest.approx(1.5)


@given(st.lists(st.floats(0, 10), min_size=1, max_size=30))
def test_ninety_percent_of_errors_are_below(errors: list[float]) -> None:
    flights = [result("carrot", "arrived", cross_track_rms_m=error) | {"document": {}} for error in errors]
    found = score(ROUTE, "carrot", flights)
    assert found.cross_track is not None
    assert found.cross_track.median == pytest.approx(np.median(errors))
    assert found.cross_track_90 == pytest.approx(np.quantile(errors, 0.9))


def test_scores_come_in_order_and_know_lost_flights() -> None:
    flights = [result(name, "arrived", seed) for seed in range(2) for name in (POLICY, SAFE)]
    lost = Loss({"world": "maze", "seed": 0, "contestant": POLICY}, "no")
    found = scores(flights, [lost])
    assert [(one.world, one.contestant, one.flights, one.lost) for one in found] == [
        ("forest-0.1", POLICY, 2, 0),
        ("forest-0.1", SAFE, 2, 0),
        ("maze", POLICY, 1, 1),
    ]


def test_the_table_says_what_there_is() -> None:
    row: Score = score("forest-0.1", SAFE, [result(SAFE, "arrived"), result(SAFE, "stuck", 1)])
    said = dict(zip(HEADINGS, cells(row), strict=True))
    assert said["success"] == "1 of 2"
    assert said["otherwise"] == "1 late or stuck"
    assert said["clearance, m"] == "0.500 (0.500)"
    assert said["interventions"] == "0.00"
    assert said["cross-track RMS, m"] == ""
    nothing = dict(zip(HEADINGS, cells(score("maze", POLICY, [], 2)), strict=True))
    assert [word for word, text in nothing.items() if text] == [
        "world",
        "flown by",
        "success",
        "95 % interval",
        "otherwise",
    ]


def test_examples_begin_with_what_the_policy_failed_at() -> None:
    ends = {0: "arrived", 1: "collided", 2: "arrived", 3: "stuck"}
    flights = [result(POLICY, end, seed) for seed, end in ends.items()]
    flights += [result(SAFE, "collided", seed) for seed in ends]
    assert [tile[0]["labels"]["seed"] for tile in examples(flights)] == [1, 3, 0, 2]
    assert all(len(tile) == 2 for tile in examples(flights))


def test_the_picture_shows_flights_in_worlds_and_in_the_open(file: str, tmp_path: Path) -> None:
    flown = fly(trial_task(file, digest(straight()), EMPTY, 0, POLICY).payload)
    evaluation_picture([flown], tmp_path / "a.png")
    known = straight("follow")
    said = mission("p.npz", known.card, Where(ROUTE), 0, "carrot")
    open_air = {"labels": {"world": ROUTE, "seed": 0, "contestant": "carrot"}, "document": said, "outcome": "stuck"}
    evaluation_picture([open_air | {"trace": {"position": [[0, 0, 0], [5, 0, 0]]}}], tmp_path / "b.png")
    assert (tmp_path / "a.png").read_bytes()[:4] == (tmp_path / "b.png").read_bytes()[:4] == b"\x89PNG"
    assert (tmp_path / "a.png").read_bytes() != (tmp_path / "b.png").read_bytes()


def test_a_policy_to_hover_is_refused_in_one_sentence(tmp_path: Path) -> None:
    known = straight()
    save(Policy(replace(known.card, task="hover"), known.arrays), tmp_path / "h.npz")
    with pytest.raises(InputError) as caught:
        setup(str(tmp_path / "h.npz"))
    message = "is a policy to hover, and missions are flown by policies to avoid or follow"
    assert [one.message for one in caught.value.problems] == [message]


def test_everything_wrong_is_said_at_once(file: str) -> None:
    with pytest.raises(InputError) as caught:
        setup(file, maps=0, seed=-1, densities=[2.0, float("nan")], families=["wood"], beside=["fish", "carrot"])
    places = [one.place for one in caught.value.problems]
    assert places == ["maps", "seed", "family", "density", "density", "density", "beside: fish", "beside: carrot"]


@pytest.mark.parametrize(("maps", "seed", "right"), [(10, 999_990, True), (10, 999_991, False), (1, 10**6, False)])
def test_worlds_that_are_trained_in_are_not_flown(file: str, maps: int, seed: int, right: bool) -> None:
    if right:
        assert setup(file, maps=maps, seed=seed).seeds.stop == 10**6
        return
    with pytest.raises(InputError, match="worlds of later seeds are trained in"):
        setup(file, maps=maps, seed=seed)


def test_forests_of_all_densities_then_other_families(file: str) -> None:
    found: Setup = setup(file, maps=3, densities=[0.1, 0.2], families=["maze", "forest"], beside=["none"])
    assert [where.name for where in found.worlds] == ["forest-0.1", "forest-0.2", "maze"]
    assert found.contestants == (POLICY,)
    assert len({task.key for task in found.tasks()}) == 9
    assert Evaluation(found, ()).document()["scores"] == []
