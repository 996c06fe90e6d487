"""From a mission to its flight."""

from collections.abc import Sequence

from crosstrack.flight import loop
from crosstrack.flight.flight import Flight
from crosstrack.flight.observer import Observer
from crosstrack.flight.plan import Plan
from crosstrack.mission.mission import Mission


def fly(mission: Mission | Plan, observers: Sequence[Observer] = ()) -> Flight:
    """Fly a mission to its end and return the flight; `observers` watch it while it is flown.

    Raises:
        InputError: everything that is wrong with the mission.

    Example:
        >>> import crosstrack as ct
        >>> mission = ct.from_document({"start": {"position": [0, 0, 10]}, "route": [[5, 0, 10]]})
        >>> ct.fly(mission).outcome.name
        'ARRIVED'
    """
    return loop.fly(mission.build() if isinstance(mission, Mission) else mission, observers)


def fly_together(mission: Mission) -> list[Flight]:
    """Fly the `vehicles` of a mission at the same time and return their flights, in their order.

    Raises:
        InputError: everything that is wrong with the mission.
        Infeasible: no trajectory keeps within what is asked of one of them.
    """
    return loop.fly_together(mission.plans())
