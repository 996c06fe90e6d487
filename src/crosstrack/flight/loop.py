"""The flight loop: sense, plan, track, avoid, command, and judge how it ends; for one vehicle or several together."""

from collections.abc import Sequence
from contextlib import ExitStack

import numpy as np

from crosstrack.flight.drawing import drawing
from crosstrack.flight.flight import Flight
from crosstrack.flight.flying import Flying
from crosstrack.flight.observer import Observer
from crosstrack.flight.pilot import Pilot
from crosstrack.flight.plan import Plan
from crosstrack.flight.separation import separations
from crosstrack.types import ALONE, Outcome


def fly(plan: Plan, observers: Sequence[Observer] = ()) -> Flight:
    """Fly a plan to its end and return what happened; an interrupt (Ctrl-C) ends the flight, not the program.

    Observers see the plan, every sample as it is flown, and the outcome, also when an error ends the flight.
    """
    return fly_together([plan], [observers])[0]


def fly_together(plans: Sequence[Plan], observers: Sequence[Sequence[Observer]] = ()) -> list[Flight]:
    """Fly several vehicles at the same time, each until its own end.

    One that has arrived stays there, and gives way; one whose flight has ended otherwise is taken out.

    Args:
        plans: at least one, all with the same world and period
        observers: of each plan; none by default
    """
    watching = observers or [()] * len(plans)
    vehicles = [Flying(plan, [*watching[k], *drawing(plan)], k, len(plans)) for k, plan in enumerate(plans)]
    with ExitStack() as endings:
        for vehicle in vehicles:
            for observer in vehicle.observers:
                observer.begin(vehicle.plan)
            endings.callback(vehicle.end)
        try:
            together(vehicles)
        except KeyboardInterrupt:
            for vehicle in vehicles:
                vehicle.outcome = vehicle.outcome or Outcome.INTERRUPTED
    return [vehicle.flight() for vehicle in vehicles]


def together(vehicles: Sequence[Flying]) -> None:
    """Fly step by step until the flight of every vehicle has ended."""
    for vehicle in vehicles:
        vehicle.launch()
    apart = gaps = np.full(len(vehicles), np.inf)
    while True:
        for vehicle in vehicles:
            vehicle.sample(apart[vehicle.index], gaps[vehicle.index])
        if all(vehicle.outcome is not None for vehicle in vehicles):
            return
        aloft = [vehicle for vehicle in vehicles if vehicle.aloft]
        for vehicle in aloft:
            vehicle.decide([other for other in aloft if other is not vehicle])
        for vehicle in aloft:
            vehicle.begin()
        for vehicle in aloft:
            vehicle.advance()
        apart, gaps = separations(vehicles)


def warm_up(plan: Plan) -> None:
    """Compile what a flight needs, so that its first step takes no longer than the others."""
    session = plan.vehicle.stand_in.launch(plan.scenario)
    command = Pilot(plan, session.sense()).decide(session.sense(), session.scans(), ALONE)
    session.advance(command, plan.scenario.period)
    plan.scenario.world.swept(np.zeros(3), np.ones(3))
    session.close()
