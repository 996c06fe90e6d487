"""Tuning: the parameters of a tracker with which a mission is flown at the least cost."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from crosstrack.campaign.complete import complete
from crosstrack.campaign.runner import Runner
from crosstrack.campaign.task import Done, Task
from crosstrack.campaign.tune_cost import Term, cost_of
from crosstrack.campaign.tune_search import Trial, Values, search
from crosstrack.campaign.tune_setup import Tuning
from crosstrack.errors import InputError, Problem
from crosstrack.mission.mission import Mission

Watch = Callable[[int, Trial | None], None]
"""is told after every flight how many have been flown, and the best trial so far"""


@dataclass(frozen=True)
class Tuned:
    """What a tuning found."""

    tuning: Tuning
    before: Trial
    """the present values"""
    after: Trial
    """the best found; never worse than `before`"""
    held_out: tuple[Trial, Trial] | None
    """both on seeds that were not tuned on; None where it was interrupted first"""
    flights: int
    """flown"""
    interrupted: bool
    errors: tuple[str, ...] = ()
    """of flights that broke; they count as missed"""

    @property
    def mission(self) -> Mission:
        """The mission with the values found."""
        tracker: Any = self.tuning.mission.tracker
        return replace(self.tuning.mission, tracker=replace(tracker, **self.after.values))

    @property
    def results(self) -> list[Any]:
        """The flights before and after, on all seeds."""
        shown = [self.before, self.after] if self.after is not self.before else [self.before]
        return [result for trial in (*shown, *(self.held_out or ())[: len(shown)]) for result in trial.results]


@dataclass
class Evaluator:
    """Tries candidates: flies all their flights side by side and takes what they cost."""

    tasks: Callable[[Values], Sequence[Task]]
    """of a candidate; their values have a `summary`"""
    terms: Sequence[Term]
    runner: Runner
    watch: Watch | None = None
    flown: int = field(default=0, init=False)
    best: Trial | None = field(default=None, init=False)
    """of those tried"""
    errors: list[str] = field(default_factory=list, init=False)
    """of flights that broke"""

    def __call__(self, candidates: Sequence[Values]) -> list[Trial]:
        """Return the trials of candidates, in their order."""
        tasks = [self.tasks(values) for values in candidates]
        done = iter(complete([task for each in tasks for task in each], self.runner, watch=self.note))
        found = [self.trial(values, [next(done) for _ in each]) for values, each in zip(candidates, tasks, strict=True)]
        self.best = min([*([self.best] if self.best else []), *found], key=lambda trial: trial.cost)
        return found

    def note(self, done: Done) -> None:
        """Count a flight."""
        self.flown += 1
        if done.error is not None:
            self.errors.append(done.error)
        if self.watch:
            self.watch(self.flown, self.best)

    def trial(self, values: Values, flights: Sequence[Done]) -> Trial:
        """Return a candidate with what came of its flights."""
        results = tuple(done.value for done in flights if done.value is not None)
        summaries = [None if done.value is None else done.value["summary"] for done in flights]
        return Trial(values, cost_of(summaries or [None], self.terms), results)


def tune(what: Tuning, runner: Runner, watch: Watch | None = None) -> Tuned:
    """Search for the values that cost least, and measure them on seeds that were held out.

    The present values are tried first, and stay unless others are better. Ctrl-C ends the search; what is best by then
    is returned.

    Args:
        what: to tune
        runner: flies
        watch: is told of the progress

    Raises:
        InputError: no flight with the present values is flown, or none has a metric of the cost.
        KeyboardInterrupt: Ctrl-C before the present values are measured.
    """
    evaluate = Evaluator(what.tasks, what.terms, runner, watch)
    generations = search(what.axes, evaluate, what.generations, what.mission.seed)
    before = next(generations)[0]
    sensible(before, what, evaluate.errors)
    held_out, interrupted = None, False
    best = before
    try:
        for _ in generations:
            best = evaluate.best or best
        evaluate.tasks = lambda values: what.tasks(values, what.seeds)
        evaluate.best = best
        pair = evaluate([best.values] if best is before else [before.values, best.values])
        held_out = pair[0], pair[-1]
    except KeyboardInterrupt:
        interrupted = True
    return Tuned(what, before, best, held_out, evaluate.flown, interrupted, tuple(evaluate.errors))


def sensible(before: Trial, what: Tuning, errors: Sequence[str]) -> None:
    """Check that the present values can be flown, and have every metric of the cost.

    Raises:
        InputError: they do not.
    """
    if not before.results:
        raise InputError(
            what.mission.name, [Problem("", f"no flight came back: {errors[0]}" if errors else "no flight")]
        )
    summaries = [result["summary"] for result in before.results]
    lacking = [
        term.metric
        for term in what.terms
        if "captured" not in term.metric
        and any(summary["arrived"] for summary in summaries)
        and all(summary[term.metric] is None for summary in summaries if summary["arrived"])
    ]
    if lacking:
        raise InputError("--cost", [Problem(name, "has no value in this mission") for name in lacking])
