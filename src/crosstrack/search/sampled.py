"""Ways by the sampling planners of the Open Motion Planning Library, which is an extra.

Source: Şucan, Moll, Kavraki 2012, The Open Motion Planning Library (IEEE Robotics and Automation Magazine).
"""

from typing import Any, Literal

import numpy as np

from crosstrack.errors import InputError, Problem, Unreachable
from crosstrack.protocols import Map
from crosstrack.search.departure import departure
from crosstrack.search.repair import ROUNDING
from crosstrack.search.taut import taut
from crosstrack.types import Array

Sampling = Literal["rrt_connect", "rrt_star", "informed_rrt_star", "bit_star"]
PLANNERS: dict[Sampling, str] = {
    "rrt_connect": "RRTConnect",
    "rrt_star": "RRTstar",
    "informed_rrt_star": "InformedRRTstar",
    "bit_star": "BITstar",
}
PAD = 6.0
"""m, that samples reach beyond the two points where space is open"""


def sampled_way(
    world: Map, start: Array, goal: Array, clearance: float, box: Array, planner: Sampling, most: int
) -> Array:
    """Return a way from start to goal, (n, 3) m, pulled taut: the best that a planner finds with so many checks.

    Legs are checked along their whole length. More checks make a way shorter, but for rrt_connect, which stops at its
    first; none proves that there is no way. The library draws from one sequence of numbers for the whole process, so
    only the first way of a process is always the same.

    Args:
        world: what is in the way
        start: (3,) m
        goal: (3,) m
        clearance: m, to keep from obstacles
        box: (2, 3) m, lowest and highest corner of the space that may be flown; may be infinite
        planner: which
        most: points and legs that are checked

    Raises:
        InputError: the library is not installed.
        Unreachable: an end has no room, or no way was found.
    """
    ompl = library(planner)
    out = departure(world, start, clearance, box, "start")
    into = departure(world, goal, clearance, box, "goal")[::-1]
    first, last = out[-1], into[0]
    part = np.array([np.minimum(first, last) - PAD, np.maximum(first, last) + PAD]).clip(*box)
    way = asked(ompl, world, np.array([first, last]), clearance - ROUNDING, part, planner, most)
    if way is None:
        message = f"{planner} found no way with a clearance of {clearance:.3g} m in {most} checks"
        raise Unreachable("search", [Problem("goal", message)])
    way = np.concatenate([out[:-1], taut(world, way, clearance - ROUNDING), into[1:]])
    return np.asarray(way[np.concatenate([[True], (np.diff(way, axis=0) != 0.0).any(axis=1)])])


def library(planner: str) -> tuple[Any, Any]:
    """Return the library.

    Raises:
        InputError: it is not installed.
    """
    try:
        from ompl import base, geometric, util  # noqa: PLC0415 - an extra
    except ImportError:
        message = f"{planner} needs the package ompl: pip install 'crosstrack[plan]'"
        raise InputError("planner", [Problem("search", message)]) from None
    if util.getLogLevel() != util.LOG_NONE:  # the first time in this process: later seeds are refused, with a message
        util.setLogLevel(util.LOG_NONE)
        util.RNG.setSeed(1)
    return base, geometric


def asked(
    ompl: tuple[Any, Any], world: Map, ends: Array, clearance: float, box: Array, planner: Sampling, most: int
) -> Array | None:
    """Return the way between two ends (2, 3) m that a planner finds, (n, 3) m; None where it finds none."""
    base, geometric = ompl
    space = base.RealVectorStateSpace(3)
    limits = base.RealVectorBounds(3)
    for axis in range(3):
        limits.setLow(axis, float(min(box[0, axis], ends[:, axis].min())))
        limits.setHigh(axis, float(max(box[1, axis], ends[:, axis].max())))
    space.setBounds(limits)
    information = base.SpaceInformation(space)
    checks = 0

    parent: Any = base.MotionValidator

    def clear(state: Any) -> bool:
        nonlocal checks
        checks += 1
        return bool(world.distance(place(state)) >= clearance)

    class Swept(parent):  # type: ignore[misc]  # a class of the extra, which has no types
        def checkMotion(self, one: Any, two: Any) -> bool:  # noqa: N802 - the library's name
            nonlocal checks
            checks += 1
            return world.swept(place(one), place(two)) >= clearance

    validator = Swept(information)
    information.setStateValidityChecker(clear)
    information.setMotionValidator(validator)
    information.setup()
    states = [space.allocState(), space.allocState()]
    for state, end in zip(states, ends, strict=True):
        for axis in range(3):
            state[axis] = float(end[axis])
    problem = base.ProblemDefinition(information)
    problem.setStartAndGoalStates(*states)
    problem.setOptimizationObjective(base.PathLengthOptimizationObjective(information))
    searcher = getattr(geometric, PLANNERS[planner])(information)
    searcher.setProblemDefinition(problem)
    searcher.setup()
    searcher.solve(base.PlannerTerminationCondition(lambda: checks >= most))
    if not problem.hasExactSolution():
        return None
    path = problem.getSolutionPath()
    return np.array([place(path.getState(i)) for i in range(path.getStateCount())])


def place(state: Any) -> Array:
    """Return the point (3,) m of a state."""
    return np.array([state[0], state[1], state[2]])
