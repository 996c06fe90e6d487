"""Tuning: known optima are found, any failure outweighs any error, and real flights get better by what is told."""

import math
from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Self

import pytest
from annotated_types import Ge, Le
from hypothesis import given
from hypothesis import strategies as st

import crosstrack as ct
from crosstrack.campaign.local import Local
from crosstrack.campaign.task import Done, Task, attempt, task
from crosstrack.campaign.tune import Evaluator, tune
from crosstrack.campaign.tune_axes import axes_of
from crosstrack.campaign.tune_cost import Cost, Term, cost_of, parse_cost
from crosstrack.campaign.tune_search import Axis, Trial, search
from crosstrack.campaign.tune_setup import tuning
from crosstrack.errors import InputError
from crosstrack.mission import loads
from crosstrack.types import Finite, NonNegative, Positive

SLALOM = """
name: slalom
start: {position: [0, 0, 4]}
route: [[6, 3, 4], [12, -3, 4]]
speed: 3
tracker: {kind: carrot, lookahead: 8}
"""
TERMS = parse_cost("cross_track_rms_m")
OPTIMUM = {"gain": 0.3, "lookahead": 4.0}


class Here:
    """Does tasks in this process, last one first."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *reason: object) -> None:
        pass

    def run(self, tasks: Sequence[Task]) -> Generator[Done, None, None]:
        yield from map(attempt, reversed(tasks))


def valley(payload: Mapping[str, Any]) -> dict[str, Any]:
    """Stand in for a flight: a tilted quadratic valley of the logarithms; nothing arrives beyond a lookahead of 7."""
    u, v = (math.log(payload[name] / best) for name, best in OPTIMUM.items())
    error = 0.01 + (u + v) ** 2 + 25 * (u - v) ** 2
    arrived = payload["lookahead"] < 7
    summary = {"arrived": arrived, "cross_track_rms_m": error, "final_error_m": 0.0 if arrived else 9.0}
    return {"summary": summary}


def found(axes: Sequence[Axis], generations: int, seed: int = 5) -> tuple[Trial, list[Trial]]:
    """Return the best trial, and all, of a search of the valley through tasks and their runner."""
    evaluate = Evaluator(lambda values: [task(f"{__name__}:valley", values)], TERMS, Here())
    trials = [trial for generation in search(axes, evaluate, generations, seed) for trial in generation]
    assert 0.9 * len(trials) < evaluate.flown <= len(trials)  # what comes twice in a generation is flown once
    assert evaluate.best is not None
    return evaluate.best, trials


AXES = [Axis("gain", 0.02, 50.0, 5.0), Axis("lookahead", 0.5, 10.0, 0.6)]


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_known_optimum_of_a_valley_is_found(seed: int) -> None:
    best, _ = found(AXES, 60, seed)
    assert best.values == pytest.approx(OPTIMUM, rel=0.01)
    assert best.cost.mean == pytest.approx(0.01, abs=1e-4)


def test_one_parameter_is_enough() -> None:
    evaluate = Evaluator(lambda values: [task(f"{__name__}:valley", {"lookahead": 4.0, **values})], TERMS, Here())
    *_, last = search(AXES[:1], evaluate, 40, seed=1)
    assert last[0].values["gain"] == pytest.approx(0.3, rel=0.01)
    assert evaluate.best is not None
    assert evaluate.best.values["gain"] == pytest.approx(0.3, rel=0.01)


def test_a_search_out_of_failures_finds_the_way_and_an_optimum_among_failures_is_not_taken() -> None:
    best, trials = found([AXES[0], Axis("lookahead", 0.5, 40.0, 39.0)], 60)
    assert trials[0].cost.missed == 1
    assert best.values == pytest.approx(OPTIMUM, rel=0.01)
    steep, _ = found([Axis("gain", 3.0, 50.0, 20.0), Axis("lookahead", 0.5, 10.0, 9.0)], 60)
    # within the range the valley's lowest point that arrives lies where the lookahead is 7, on the edge of failure
    assert steep.cost.missed == 0
    assert steep.values["lookahead"] < 7
    assert steep.values["gain"] == pytest.approx(3.0)


def test_the_same_seed_gives_the_same_trials_and_another_gives_others() -> None:
    assert found(AXES, 3)[1] == found(AXES, 3)[1]
    assert found(AXES, 3)[1][1:] != found(AXES, 3, seed=6)[1][1:]


def test_every_value_tried_is_within_its_range_and_short() -> None:
    _, trials = found(AXES, 20)
    for axis in AXES:
        values = [trial.values[axis.name] for trial in trials[1:]]
        assert all(axis.low <= value <= axis.high for value in values)
        assert all(float(f"{value:.4g}") == value for value in values)


@given(st.floats(1e-6, 1e6), st.floats(1.01, 1e6), st.floats(0, 1))
def test_coordinates_of_an_axis_go_back_and_forth(low: float, factor: float, share: float) -> None:
    axis = Axis("gain", low, low * factor, low)
    value = axis.at(share)
    assert axis.low <= value <= axis.high
    assert axis.at(axis.unit(value)) == pytest.approx(value, rel=1e-3)
    assert axis.unit(axis.low) == 0.0
    assert axis.unit(axis.high) == pytest.approx(1.0)
    middle = axis.low * math.sqrt(factor)
    assert axis.unit(middle) == pytest.approx(0.5)
    flat = Axis("offset", -low, low * factor, 0.0)
    assert flat.unit((flat.low + flat.high) / 2) == pytest.approx(0.5)


METRICS = st.sampled_from(["tracking_rms_m", "cross_track_max_m", "rms_jerk_mps3", "time_ratio"])
SUMS = st.lists(st.tuples(st.floats(1e-6, 1e6), METRICS), min_size=1, max_size=5)


@given(SUMS, st.sampled_from(["+", " + ", "  +"]), st.sampled_from(["*", " * "]))
def test_every_sum_of_metrics_is_read_as_it_is_written(terms: Any, plus: str, times: str) -> None:
    text = plus.join(f"{weight!r}{times}{metric}" for weight, metric in terms)
    assert parse_cost(text) == tuple(Term(weight, metric) for weight, metric in terms)


def test_a_weight_may_be_left_out_or_negative_or_a_power_of_ten() -> None:
    assert parse_cost("time_ratio") == (Term(1.0, "time_ratio"),)
    assert parse_cost("-2e-1*min_clearance_m+1e+1*time_ratio") == (
        Term(-0.2, "min_clearance_m"),
        Term(10.0, "time_ratio"),
    )


@pytest.mark.parametrize(
    "text",
    ["", "2", "2*", "time_ratio +", "time_ratio - time_ratio", "time_ratio**2", "no_such", "wall_time_s",
     "(time_ratio)", "0*time_ratio", "inf*time_ratio", "__import__('os')", "time_ratio time_ratio", "1e300*time_ratio"],
)  # fmt: skip
def test_what_is_no_sum_of_metrics_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="cost"):
        parse_cost(text)


@given(st.text(max_size=30))
def test_no_text_breaks_the_parser(text: str) -> None:
    with suppress(InputError):
        assert parse_cost(text)


def summary(arrived: bool = True, error: float | None = 0.1, left: float = 0.0) -> dict[str, Any]:
    return {"arrived": arrived, "cross_track_rms_captured_m": error, "cross_track_rms_m": 0.2, "final_error_m": left}


def test_costs_are_means_over_flights_and_one_failure_outweighs_every_error() -> None:
    terms = parse_cost("2*cross_track_rms_captured_m")
    assert cost_of([summary(error=0.25), summary(error=0.75)], terms) == Cost(0, 0.0, 1.0)
    awful = cost_of([summary(error=1e12)] * 2, terms)
    nearly = cost_of([summary(error=0.0), summary(False, 0.0, left=1.0)], terms)
    far = cost_of([summary(error=0.0), summary(False, 0.0, left=9.0)], terms)
    never = cost_of([summary(error=None), summary(error=0.0)], terms)
    broken = cost_of([summary(), None], terms)
    assert awful < never < nearly < far < broken < cost_of([None, None], terms)


@dataclass(frozen=True)
class Law:
    """A tracker in name only."""

    gain: Positive = 2.0
    share: Annotated[float, Ge(0), Le(1)] = 0.5
    offset: Finite = 1.0
    unused: NonNegative = 0.0
    steps: int = 3


def test_by_default_what_is_positive_is_searched_from_a_fifth_to_five_times() -> None:
    assert axes_of(Law()) == [Axis("gain", 0.4, 10.0, 2.0), Axis("share", 0.1, 1.0, 0.5)]
    assert axes_of(Law(), ["offset=-3:4", "unused=0:2"]) == [
        Axis("offset", -3.0, 4.0, 1.0),
        Axis("unused", 0.0, 2.0, 0.0),
    ]
    assert axes_of(Law(), ["tracker.gain"]) == [Axis("gain", 0.4, 10.0, 2.0)]


def test_everything_wrong_with_parameters_is_said_at_once() -> None:
    wrong = ["gain=0:1", "share=0.5:2", "offset=1:1", "steps=1:2", "lookahed=1:2", "unused", "gain=1:2", "gain=1", "x"]
    with pytest.raises(InputError) as error:
        axes_of(Law(), wrong)
    told = [str(problem) for problem in error.value.problems]
    assert [problem.place for problem in error.value.problems] == [
        "gain", "share", "offset", "steps", "lookahed", "unused", "gain", "x",
    ]  # fmt: skip
    assert "above 0" in told[0]
    assert "from 0 on, up to 1" in told[1]


def test_a_range_is_of_numbers_that_a_mission_may_have() -> None:
    with pytest.raises(InputError, match=r"gain: must be above 0, up to 1e\+09, found 1e-300:1e\+300"):
        axes_of(Law(), ["gain=1e-300:1e300"])
    (widest,) = axes_of(Law(), ["gain=1e-300:1e9"])
    assert widest.at(0.5) == pytest.approx(math.sqrt(1e-300 * 1e9), rel=1e-3)


def test_everything_wrong_with_a_tuning_is_said_at_once() -> None:
    with pytest.raises(InputError) as error:
        tuning(loads(SLALOM), parameters=["lookahead=3:2"], cost="speed", winds=["gale"], budget=3)
    assert [problem.place.split()[0] for problem in error.value.problems] == [
        "--wind", "--parameter", "--cost", "--budget",
    ]  # fmt: skip
    with pytest.raises(InputError, match="unknown tracker"):
        tuning(loads(SLALOM), "carot")
    with pytest.raises(InputError, match=r"--cost: must be \[NUMBER\*\]METRIC \[\+ ...\], found nothing"):
        tuning(loads(SLALOM), cost="")
    with pytest.raises(InputError, match="no planner"):
        tuning(loads(SLALOM), cost="tracking_rms_m")
    with pytest.raises(InputError, match="--seeds"):
        tuning(loads(SLALOM), seeds=0)


def test_the_budget_is_kept() -> None:
    what = tuning(loads(SLALOM + "wind: {gusts: light}"), parameters=["lookahead"], budget=60)
    assert (what.seeds, what.flights) == (3, 3)
    assert what.generations == (60 - 3 - 2 * 3) // (4 * 3)
    assert tuning(loads(SLALOM)).seeds == 1


@pytest.fixture(scope="module")
def workers() -> Iterator[Local]:
    with Local(2) as local:
        yield local


def test_a_detuned_carrot_gets_better_the_same_with_any_number_of_workers(workers: Local, tmp_path: Path) -> None:
    mission = loads(SLALOM + "wind: {mean: [0, 1, 0], gusts: moderate}")
    what = tuning(mission, parameters=["lookahead=0.5:10"], seeds=2, budget=22)
    told: list[int] = []
    best = tune(what, workers, lambda flown, trial: told.append(flown))
    assert best.after.cost.missed == 0
    assert best.after.cost.mean < 0.85 * best.before.cost.mean
    assert told == list(range(1, best.flights + 1))
    assert best.flights <= what.budget
    assert best == tune(what, Here())
    assert best.held_out is not None
    assert {result["labels"]["seed"] for trial in best.held_out for result in trial.results} == {3, 4}
    costs = [ct.fly(replace(best.mission, seed=seed)).metrics.cross_track_rms_captured_m for seed in (1, 2)]
    assert None not in costs
    assert best.after.cost.mean == pytest.approx(sum(filter(None, costs)) / 2, rel=1e-12)
    ct.save(best.mission, tmp_path / "tuned.yaml")
    assert ct.load(tmp_path / "tuned.yaml") == best.mission


def test_present_values_that_are_best_stay(workers: Local) -> None:
    mission = loads(SLALOM.replace("lookahead: 8", "lookahead: 1"))
    kept = tune(tuning(mission, parameters=["lookahead=9:10"], budget=7), workers)
    assert kept.after is kept.before
    assert kept.mission == mission


class Cut(Here):
    """Is interrupted after some flights."""

    def __init__(self, flights: int) -> None:
        self.left = flights

    def run(self, tasks: Sequence[Task]) -> Generator[Done, None, None]:
        for each in tasks:
            if self.left == 0:
                raise KeyboardInterrupt
            self.left -= 1
            yield attempt(each)


def test_an_interrupt_keeps_the_best_so_far() -> None:
    what = tuning(loads(SLALOM), parameters=["lookahead=0.5:10"], budget=30)
    cut = tune(what, Cut(6))
    assert (cut.interrupted, cut.held_out, cut.flights) == (True, None, 6)
    assert cut.after.cost < cut.before.cost
    with pytest.raises(KeyboardInterrupt):
        tune(what, Cut(0))


def test_a_metric_that_a_mission_does_not_have_is_refused() -> None:
    with pytest.raises(InputError, match="min_clearance_m: has no value"):
        tune(tuning(loads(SLALOM), cost="min_clearance_m"), Here())
