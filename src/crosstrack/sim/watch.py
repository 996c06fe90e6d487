"""The sensors of a simulated vehicle: each looks when it is due."""

import numpy as np

from crosstrack.protocols import Map, Scenario
from crosstrack.types import Scan, State
from crosstrack.world.together import Together

EARLY = 1e-9
"""s, by which a sensor may be early: rounding"""


class Watch:
    """The sensors of one flight."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        self.random = np.random.default_rng((scenario.seed, 1))  # apart from the weather, which does not depend on it
        self.due = [0.0 for _ in scenario.sensors]
        self.seen: list[Scan] = []

    def step(self, state: State) -> None:
        """Look from a true state with every sensor that is due."""
        for k, sensor in enumerate(self.scenario.sensors):
            if state.time >= self.due[k] - EARLY:
                self.due[k] += 1 / sensor.rate
                self.seen.append(sensor.look(self.world(state.time), state, self.random))

    def world(self, time: float) -> Map:
        """Return all obstacles as they stand at a time (s)."""
        traffic, world = self.scenario.traffic, self.scenario.world
        return world if traffic is None else Together((world, traffic.at(time)))

    def take(self) -> list[Scan]:
        """Return what was seen since this was last asked."""
        seen, self.seen = self.seen, []
        return seen
