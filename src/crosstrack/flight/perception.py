"""What a vehicle knows of what is around it: what it was told, and what it has seen since."""

import math
from collections.abc import Sequence

import numpy as np

from crosstrack.flight.observer import NOTHING
from crosstrack.flight.plan import Plan
from crosstrack.protocols import Map, Surroundings
from crosstrack.sense import pose
from crosstrack.sense.local_map import LocalMap
from crosstrack.sense.movers import Movers
from crosstrack.sense.pose import axes, turned_all
from crosstrack.types import ALONE, Array, Others, Scan, State
from crosstrack.world.together import Together


class Perception:
    """The knowledge of one vehicle in flight."""

    def __init__(self, plan: Plan, index: int = 0, count: int = 1) -> None:
        scenario = plan.scenario
        told: Map = scenario.world if plan.told is None else plan.told
        self.index, self.count = index, count
        self.traffic = scenario.traffic if plan.warned else None
        self.local = LocalMap.around(scenario.sensors, told) if scenario.sensors else None
        self.known: Map = told if self.local is None else with_seen(told, self.local)
        self.movers = Movers(told)
        self.tracks = self.movers.start()

    def look(self, state: State, scans: Sequence[Scan], vehicles: Others) -> Surroundings:
        """Take in what was seen from a state, as estimated, and return what is known now."""
        for scan in scans:
            if self.local is not None:
                self.local.add(scan, state)
            if self.traffic is None:
                self.tracks = self.movers.step(self.tracks, scan, state)
        if self.traffic is None:
            moving = self.movers.others(self.tracks, state.time)
        else:
            moving = self.traffic.others(state.time)
        return Surroundings(self.known, joined(vehicles, moving), scans, self.index, self.count)


def with_seen(told: Map, seen: Map) -> Map:
    """Return what was told of the world with what is seen; the latter has ground and bounds of the former."""
    nothing_told = math.isinf(told.distance(np.zeros(3)))
    return seen if nothing_told else Together((told, seen))


def joined(some: Others, more: Others) -> Others:
    """Return all that moves, of two sources."""
    if more is ALONE:
        return some
    return Others(
        np.concatenate([some.position, more.position]),
        np.concatenate([some.velocity, more.velocity]),
        np.concatenate([some.radius, more.radius]),
        np.concatenate([some.avoids, more.avoids]),
    )


def hits(scans: Sequence[Scan], state: State) -> Array:
    """Return where the rays of scans ended, (n, 3) m, world, for a state as estimated."""
    turned, clouds = axes(state.attitude), [NOTHING]
    for scan in scans:
        origin, directions = state.position + turned @ scan.origin, turned_all(turned, scan.directions)
        clouds.append(pose.hits(scan.ranges, directions, origin, -math.inf))
    return np.concatenate(clouds)
