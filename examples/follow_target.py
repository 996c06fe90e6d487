"""Follow a target through a forest: a simulated quadrotor flies behind it and replans five times a second.

Run it as `python examples/follow_target.py [folder]`: it prints what it measured and writes `follow_target.png`.
"""

import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.patches import Circle

from crosstrack.errors import Infeasible
from crosstrack.protocols import Scenario, Session
from crosstrack.show.pictures import sheet, write
from crosstrack.show.style import FOOTPRINT, GRID, PALETTE
from crosstrack.trajectory.limits import MotionLimits
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.trajectory.target import Pursuit, TargetPlan, track_target
from crosstrack.types import Air, Array, Limits, Noise, Setpoint, Wind
from crosstrack.vehicles.quadrotor import Quadrotor
from crosstrack.world.generate import Forest
from crosstrack.world.shapes import Cylinder
from crosstrack.world.world import World

ROUTE = [(4, 4), (12, 5), (15, 11), (9, 15), (16, 17), (24, 15), (22, 8), (28, 4), (35, 7), (33, 14)]
"""m, of the target"""
START = (2.5, 4)
"""m, of the quadrotor"""
SPEED = 1.6
"""m/s, of the target in the mean"""
HEIGHT = 1.5
"""m"""
PERIOD = 0.02
"""s, between two commands"""
SIGHTING = 0.1
"""s, between two sightings of the target"""
REPLAN = 0.2
"""s, between two plans"""
SIGHTING_NOISE = 0.03
"""m, standard deviation on each axis"""
BAND = (1.4, 3.5)
"""m, in which the distance to the target is kept from 5 s on"""
PURSUIT = Pursuit(distance=2.5, clearance=0.35, limits=MotionLimits(speed=4.0, acceleration=5.0))


@dataclass
class Flown:
    """What happened."""

    times: list[float] = field(default_factory=list)
    positions: list[Array] = field(default_factory=list)
    target: list[Array] = field(default_factory=list)
    clearance: list[float] = field(default_factory=list)
    plans: list[TargetPlan] = field(default_factory=list)
    planning: list[float] = field(default_factory=list)
    """s, wall-clock time of every plan"""
    refused: int = 0
    """plans that were infeasible; the one before was flown on"""

    @property
    def distance(self) -> Array:
        """(n,) m, from the vehicle to the target"""
        return np.asarray(np.linalg.norm(np.array(self.positions) - np.array(self.target), axis=1))

    def numbers(self) -> dict[str, float]:
        """Return what was measured."""
        followed = self.distance[np.array(self.times) > 5]
        return {
            "distance to the target, RMS (m)": float(np.sqrt((followed**2).mean())),
            "distance to the target, least (m)": float(followed.min()),
            "distance to the target, largest (m)": float(followed.max()),
            "least clearance (m)": min(self.clearance),
            "time to plan, median (ms)": 1e3 * float(np.median(self.planning)),
            "time to plan, largest (ms)": 1e3 * max(self.planning[1:]),
            "plans": len(self.planning),
            "plans refused": self.refused,
        }


def target_motion() -> PiecewisePolynomial:
    """Return the motion of the target, which nobody tells the vehicle."""
    points = np.column_stack([ROUTE, np.full(len(ROUTE), HEIGHT)])
    legs = np.linalg.norm(np.diff(points, axis=0), axis=1)
    return minimum(points, np.concatenate([[0.0], np.cumsum(legs / SPEED)]), 3)


def forest(motion: PiecewisePolynomial, seed: int) -> World:
    """Return trunks that leave 0.6 m to either side of where the target goes."""
    way = np.concatenate([np.linspace(START, ROUTE[0], 5), motion(np.linspace(0, motion.duration, 200))[:, :2]])
    clear = tuple((float(x), float(y)) for x, y in way)
    return World(shapes=Forest(seed=seed, size=(38, 20, 4), density=0.5, clear=clear, clear_radius=0.6).shapes())


def follow(seed: int = 0, duration: float | None = None) -> tuple[World, Flown]:
    """Fly behind the target for a time (s), or until it stands."""
    motion, rng = target_motion(), np.random.default_rng(seed)
    world, vehicle, flown = forest(motion, seed), Quadrotor(), Flown()
    start = np.array([*START, HEIGHT])
    scenario = Scenario(start, 0.0, world, 2.0, Limits(), Wind(), Air(), Noise(), PERIOD, seed)
    session, ahead = vehicle.launch(scenario), vehicle.envelope(scenario).response_time
    seen: list[tuple[float, Array]] = []
    plan: TargetPlan | None = None
    began = 0.0
    for step in range(round((duration or motion.duration + 2) / PERIOD)):
        now = step * PERIOD
        if step % round(SIGHTING / PERIOD) == 0:
            seen.append((now, motion(now) + rng.normal(scale=SIGHTING_NOISE, size=3)))
        if step % round(REPLAN / PERIOD) == 0 and len(seen) > 4:
            state = np.stack([plan.trajectory(now - began, k) for k in range(3)]) if plan else still(start)
            fresh = planned(seen, now, state, world, flown)
            plan, began = (fresh, now) if fresh else (plan, began)
        fly(session, plan, now - began, start, ahead, flown, world)
        flown.times.append(now + PERIOD)
        flown.target.append(motion(now + PERIOD))
    session.close()
    return world, flown


def still(position: Array) -> Array:
    """Return the state (3, 3) of a vehicle at rest."""
    return np.stack([position, np.zeros(3), np.zeros(3)])


def planned(seen: list[tuple[float, Array]], now: float, state: Array, world: World, flown: Flown) -> TargetPlan | None:
    """Return a fresh plan, or None where there is none: the one flown so far ends at rest in free space."""
    times, positions = np.array([t for t, _ in seen]), np.array([p for _, p in seen])
    clock = time.perf_counter()
    try:
        plan = track_target(times, positions, now, state, world, PURSUIT)
    except Infeasible:
        flown.refused += 1
        plan = None
    flown.planning.append(time.perf_counter() - clock)
    if plan is not None:
        flown.plans.append(plan)
    return plan


def fly(
    session: Session, plan: TargetPlan | None, t: float, start: Array, ahead: float, flown: Flown, world: World
) -> None:
    """Fly one period of a plan by feed-forward, and note how near an obstacle was."""
    command = Setpoint(position=start, velocity=np.zeros(3), acceleration=np.zeros(3), yaw=0.0)
    if plan is not None:
        curve, at = plan.trajectory, min(t + PERIOD / 2, plan.trajectory.duration)
        moves = float(t + PERIOD / 2 < curve.duration)
        acceleration = moves * curve(min(at + ahead, curve.duration), 2)
        command = Setpoint(position=curve(at), velocity=moves * curve(at, 1), acceleration=acceleration, yaw=0.0)
    before = session.truth().position
    session.advance(command, PERIOD)
    flown.positions.append(session.truth().position)
    flown.clearance.append(world.swept(before, session.truth().position))


def picture(world: World, flown: Flown, path: Path) -> None:
    """Draw the way of both from above, and distance and clearance over time."""
    figure = sheet(13, 6.5)
    grid = figure.add_gridspec(2, 2, width_ratios=[1.7, 1])
    axes: Any = figure.add_subplot(grid[:, 0])
    for trunk in world.shapes:
        if isinstance(trunk, Cylinder):
            axes.add_patch(Circle(trunk.center, trunk.radius, color=FOOTPRINT))
    axes.plot(*np.array(flown.positions)[:, :2].T, color=PALETTE[0], linewidth=2.2, label="flown")
    for plan in flown.plans[::10]:
        curve = plan.trajectory(np.linspace(0, plan.trajectory.duration, 60))
        label = "plans, every tenth" if plan is flown.plans[0] else None
        axes.plot(*curve[:, :2].T, color=PALETTE[2], linewidth=1.2, label=label)
    axes.plot(*np.array(flown.target)[:, :2].T, "--", color=PALETTE[1], linewidth=1.2, label="target")
    axes.set(xlabel="x (m)", ylabel="y (m)")
    axes.set_aspect("equal")
    axes.legend(loc="upper left", frameon=False)
    distance: Any = figure.add_subplot(grid[0, 1])
    distance.axhspan(*BAND, color=GRID, label="band")
    distance.legend(loc="lower right", frameon=False)
    over_time(distance, flown.times, flown.distance, "distance to the target (m)")
    over_time(figure.add_subplot(grid[1, 1]), flown.times, flown.clearance, "clearance (m)")
    write(figure, path)


def over_time(axes: Any, times: list[float], values: Any, label: str) -> None:
    """Draw one quantity over time."""
    axes.plot(times, values, color=PALETTE[0], linewidth=1.2)
    axes.set(xlabel="time (s)", ylabel=label)
    axes.margins(x=0)
    axes.set_ylim(bottom=0)
    axes.grid(color=GRID)


def main() -> None:
    """Fly, print and draw."""
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "runs")
    folder.mkdir(parents=True, exist_ok=True)
    world, flown = follow()
    for name, value in flown.numbers().items():
        print(f"{name:36} {value:8.3f}")
    picture(world, flown, folder / "follow_target.png")


if __name__ == "__main__":
    main()
