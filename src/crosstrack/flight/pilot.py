"""What decides for one vehicle in flight: from what it senses to what it is commanded."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from crosstrack.flight.navigation import Navigator
from crosstrack.flight.perception import Perception
from crosstrack.flight.plan import Plan
from crosstrack.protocols import Surroundings
from crosstrack.types import ALONE, Array, Command, Others, Scan, Setpoint, State


class Pilot:
    """Perception, navigation, tracker and avoiders of one vehicle, and what they remember."""

    def __init__(self, plan: Plan, state: State, index: int = 0, count: int = 1) -> None:
        self.plan = plan
        self.perception = Perception(plan, index, count)
        self.navigator = Navigator(plan)
        asked = plan.route.points if plan.replanning is None else plan.replanning.task.waypoints
        self.navigator.take(plan.course, asked, state.time)
        self.tracking: Any = plan.tracker.start(plan.course, state)
        around = self.perception.look(state, (), ALONE)
        self.memories: list[Any] = [avoider.start(plan.course, around, state) for avoider in plan.avoiders]
        self.interventions = 0
        self.replanned: Array | None = None

    def decide(self, state: State, scans: Sequence[Scan], vehicles: Others) -> Command:
        """Return the command for the next period.

        Args:
            state: as estimated
            scans: seen since the last decision
            vehicles: the others that fly

        Raises:
            Unreachable: there is no way to the goal.
        """
        around = self.perception.look(state, scans, vehicles)
        self.renew(state, around)
        command, self.tracking = self.plan.tracker.step(
            self.tracking, self.navigator.course, state, self.plan.scenario.period
        )
        return self.avoided(command, state, around)

    def renew(self, state: State, around: Surroundings) -> None:
        """Go by a new course where the present one is no good any more."""
        self.replanned = None
        course = self.navigator.again(state, around, self.tracking, held=self.interventions > 0)
        if course is None:
            return
        self.tracking = self.plan.tracker.start(course, state)
        self.memories = [
            memory if avoider.guards else avoider.start(course, around, state)
            for avoider, memory in zip(self.plan.avoiders, self.memories, strict=True)
        ]
        self.replanned = course.path(np.linspace(0.0, course.path.length, 200))

    def avoided(self, command: Command, state: State, around: Surroundings) -> Command:
        """Return the command that the chain of avoiders makes of the tracker's."""
        self.interventions = 0
        for k, avoider in enumerate(self.plan.avoiders):
            if not avoider.guards and not isinstance(command, Setpoint):
                continue
            command, self.memories[k] = avoider.step(
                self.memories[k], command, state, around, self.plan.scenario.period
            )
            self.interventions |= self.memories[k].intervening << k
        return command
