"""A flight, made without a simulator, that meets all that an avoider may meet."""

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from crosstrack.flight.flight import Flight, Replan
from crosstrack.world.moving import Moving, MovingObstacles
from crosstrack.world.shapes import Box, Cylinder, Shape, Sphere
from crosstrack.world.world import World

MAPPED: tuple[Shape, ...] = (Cylinder((5, 5), 1, (0, 12)), Cylinder((15, 5), 1, (0, 12)))
ABSENT: tuple[Shape, ...] = (Box((9, 9, 0), (11, 11, 12)),)
MOVERS = (
    Moving(Sphere((20, -4, 10), 0.5), (0, 1, 0)),
    Moving(Cylinder((14, 20), 0.4, (8, 11)), (-1, 0.5, 0), turns=4),
)


@dataclass(frozen=True)
class Potential:
    """Stands for an avoider."""

    guards: bool = False


@dataclass(frozen=True)
class Safety:
    """Stands for one that is there for safety alone."""

    guards: bool = True


def meeting(flight: Flight, told: World | None = None) -> Flight:
    """Return a flight among obstacles, some not on the map, some moving, with interventions, one replan and scans."""
    count = len(flight.record.time)
    mask = np.zeros(count)
    mask[100:300] += 1
    mask[200:210] += 2
    course = np.column_stack([np.linspace(20, 0, 50), np.full(50, 21.0), np.full(50, 10.0)])
    stand_in: Any = SimpleNamespace(world=World((*MAPPED, *ABSENT)), traffic=MovingObstacles(MOVERS))
    around = np.linspace(0, 2 * np.pi, 400)
    trunk = np.column_stack([5 + np.cos(around), 5 + np.sin(around), np.linspace(0, 12, 400)])
    avoiders: Any = (Potential(), Safety())
    plan = replace(flight.plan, scenario=stand_in, told=World(MAPPED) if told is None else told, avoiders=avoiders)
    return replace(
        flight,
        plan=plan,
        record=replace(flight.record, interventions=mask),
        replans=(Replan(8.0, course),),
        seen=np.concatenate([trunk, [[3.0, 3.0, 0.02]], [[500.0, 0.0, 5.0]]]),
    )
