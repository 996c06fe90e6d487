"""Time of a step of every registered tracker, measured around each call inside a flight.

Run as `python -m benchmarks.tracker_step [NAME ...]`. Each flies the same planned course of a racer at 12 m/s and up to
2 g, in gusts, heavier and draggier than it is taken to be. Processor time of the thread is what the step costs; the
clock on the wall also counts what else the machine does meanwhile.
"""

import sys
import time
from collections.abc import Collection
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from crosstrack import registry
from crosstrack.flight.loop import fly, warm_up
from crosstrack.mission.load import loads
from crosstrack.protocols import Course, Need
from crosstrack.types import Command, State

MISSION = """
start: {position: [0, 0, 10]}
route: [[10, 6, 12], [20, 0, 10], [30, -6, 8], [40, 0, 10], [30, 6, 12], [20, 0, 10], [10, -6, 8], [0, 0, 10]]
speed: 12
tolerance: 3
vehicle: {kind: quadrotor, airframe: racer}
planner: {kind: minimum_snap}
limits: {speed: 20, acceleration: 20, tilt_deg: 75}
wind: {mean: [2, 3, 0], gusts: moderate}
mismatch: {mass: 1.1, drag: 1.2}
timing: {rate: 100, timeout: 60}
"""
ROUNDS = 3
"""flights of each, by turns"""


@dataclass(frozen=True)
class Timed:
    """A tracker that notes how long its own takes."""

    inner: Any
    worked: list[int] = field(default_factory=list)
    """ns of processor time, a step each"""
    passed: list[int] = field(default_factory=list)
    """ns on the wall, a step each"""

    @property
    def needs(self) -> Collection[Need]:
        """What the inner one needs."""
        needs: Collection[Need] = self.inner.needs
        return needs

    def start(self, course: Course, state: State) -> Any:
        """Begin as the inner one does."""
        return self.inner.start(course, state)

    def step(self, memory: Any, course: Course, state: State, duration: float) -> tuple[Command, Any]:
        """Step as the inner one does."""
        passed, worked = time.perf_counter_ns(), time.thread_time_ns()
        answer: tuple[Command, Any] = self.inner.step(memory, course, state, duration)
        self.worked.append(time.thread_time_ns() - worked)
        self.passed.append(time.perf_counter_ns() - passed)
        return answer


def main() -> None:
    names = sys.argv[1:] or registry.names("tracker")
    plan = loads(MISSION).build()
    laws = {name: Timed(registry.find("tracker", name)()) for name in names}
    outcomes = {}
    for law in laws.values():
        warm_up(replace(plan, tracker=law.inner))
    for _ in range(ROUNDS):
        for name, law in laws.items():
            outcomes[name] = fly(replace(plan, tracker=law)).outcome
    table = Table("tracker", "steps", "median µs", "99 % µs", "most µs", "wall 99 %", "flight")
    for name, law in laws.items():
        worked, passed = np.array(law.worked) / 1e3, np.array(law.passed) / 1e3
        times = (np.median(worked), np.percentile(worked, 99), worked.max(), np.percentile(passed, 99))
        table.add_row(name, str(len(worked)), *(f"{value:.0f}" for value in times), outcomes[name].name.lower())
    Console().print(table)


if __name__ == "__main__":
    main()
