"""The search for the parameters that cost least: CMA-ES in whole generations, from a seed."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from cmaes import CMA

from crosstrack.campaign.tune_cost import Cost
from crosstrack.types import Array

DIGITS = 4
"""significant digits of the values tried, so that the best of them can be written down as it was flown"""
SPREAD = 0.2
"""of the range of every parameter, standard deviation of the first generation"""
NARROW = 1e-4
"""of the range of every parameter, the standard deviation at which a search ends: values no longer differ"""

Values = Mapping[str, float]


@dataclass(frozen=True)
class Axis:
    """One parameter of a search."""

    name: str
    low: float
    high: float
    """more than `low`"""
    value: float
    """where the search begins; outside of the range it begins at its nearer end"""

    @property
    def logarithmic(self) -> bool:
        """Whether ratios count: where the whole range is positive."""
        return self.low > 0

    def unit(self, value: float) -> float:
        """Return the coordinate in [0, 1] of a value."""
        scale = math.log if self.logarithmic else float
        low, high = scale(self.low), scale(self.high)
        return (scale(min(max(value, self.low), self.high)) - low) / (high - low)

    def at(self, unit: float) -> float:
        """Return the value of a coordinate in [0, 1], rounded but within the range."""
        if self.logarithmic:
            value = self.low ** (1 - unit) * self.high**unit
        else:
            value = self.low + (self.high - self.low) * unit
        return min(max(float(f"{value:.{DIGITS}g}"), self.low), self.high)


@dataclass(frozen=True)
class Trial:
    """Values tried and what they cost."""

    values: Values
    cost: Cost
    results: tuple[Any, ...] = field(default=(), repr=False)
    """of its flights"""


Evaluate = Callable[[Sequence[Values]], Sequence[Trial]]
"""tries some candidates, and returns the trials in their order"""


def population(axes: Sequence[Axis]) -> int:
    """Return how many candidates a generation has: 4 + 3 ln n (Hansen 2016, arXiv 1604.00772, equation 48)."""
    return 4 + math.floor(3 * math.log(len(axes)))


def search(axes: Sequence[Axis], evaluate: Evaluate, generations: int, seed: int) -> Iterator[Sequence[Trial]]:
    """Yield generation after generation of trials, at most so many; the first is the present values alone.

    The same for the same costs, whoever finds them in whatever order: candidates are drawn from the seed, whole
    generations at a time. Of the costs only their order counts.

    Args:
        axes: the parameters, at least one
        evaluate: tries candidates
        generations: of the search proper
        seed: not negative
    """
    present = {axis.name: axis.value for axis in axes}
    yield evaluate([present])
    begin = np.array([axis.unit(axis.value) for axis in axes])
    state = int(np.random.SeedSequence(seed).generate_state(1)[0])
    bounds = np.tile([0.0, 1.0], (len(axes), 1))
    optimizer = CMA(begin, SPREAD, bounds=bounds, seed=state, population_size=population(axes))
    for _ in range(generations):
        points = [optimizer.ask() for _ in range(optimizer.population_size)]
        generation = evaluate([decoded(axes, point) for point in points])
        yield generation
        costs = sorted({trial.cost for trial in generation})
        optimizer.tell([(point, costs.index(trial.cost)) for point, trial in zip(points, generation, strict=True)])
        if width(points) < NARROW:
            return


def decoded(axes: Sequence[Axis], point: Array) -> Values:
    """Return the values of a point of the unit cube, (n,)."""
    return {axis.name: axis.at(float(unit)) for axis, unit in zip(axes, point, strict=True)}


def width(points: Sequence[Array]) -> float:
    """Return the largest standard deviation of points of the unit cube along an axis."""
    return float(np.std(points, axis=0).max())
