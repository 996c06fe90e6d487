"""Whether a quadrotor can do what a trajectory asks of its thrust, tilt and body rates."""

import math
from dataclasses import dataclass

import numpy as np

from crosstrack.protocols import Trajectory
from crosstrack.trajectory.certified.extremes import Extreme, largest_norm
from crosstrack.trajectory.flatness.flat import NOTHING, Flat, flatten
from crosstrack.trajectory.flatness.yaw import EAST, Yaw
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import GRAVITY, Array, Vector

MOST_SAMPLES = 1_000_000
"""of one check; longer trajectories are sampled more coarsely"""


@dataclass(frozen=True)
class Ability:
    """What a quadrotor can do."""

    thrust_min: float = 0.0
    """m/s², least collective thrust over mass"""
    thrust_max: float = math.inf
    """m/s², greatest"""
    tilt: float = math.pi
    """rad, greatest angle between body z and world z"""
    rate: float = math.inf
    """rad/s, greatest body rate about an axis across body z"""
    rate_yaw: float = math.inf
    """rad/s, greatest body rate about body z"""


@dataclass(frozen=True, slots=True)
class Excess:
    """Something that a trajectory asks for and the vehicle cannot do, where it is worst."""

    quantity: str
    """field of `Ability`"""
    time: float
    """s"""
    value: float
    """asked for there"""
    allowed: float

    def __str__(self) -> str:
        return f"{self.quantity} {self.value:.4g} at t = {self.time:.4g} s, allowed is {self.allowed:.4g}"


@dataclass(frozen=True, eq=False)
class Demands:
    """What a trajectory asks for, and what of it is too much."""

    flat: Flat
    """at the times checked"""
    resolution: float
    """s, between the times; what is between them is not looked at"""
    excesses: tuple[Excess, ...]
    """at most one for each quantity"""


def demands(
    trajectory: Trajectory,
    ability: Ability,
    yaw: Yaw = EAST,
    drag: Vector = NOTHING,
    wind: Vector = NOTHING,
    resolution: float = 0.005,
) -> Demands:
    """Check thrust, tilt and body rates at times at most `resolution` (s) apart, see `flatten`.

    Raises:
        InputError: the trajectory has no attitude at some time.
    """
    count = min(MOST_SAMPLES, math.ceil(trajectory.duration / resolution)) + 1
    times = np.linspace(0.0, trajectory.duration, count)
    flat = flatten(trajectory, times, yaw, drag, wind)
    return Demands(flat, float(times[1]), excesses(flat, ability))


def excesses(flat: Flat, ability: Ability) -> tuple[Excess, ...]:
    """Return what is too much for the vehicle, each where it is worst."""
    upper: dict[str, Array] = {
        "thrust_max": flat.thrust,
        "tilt": flat.tilt,
        "rate": np.hypot(flat.rate[:, 0], flat.rate[:, 1]),
        "rate_yaw": np.abs(flat.rate[:, 2]),
    }
    found = []
    least = int(flat.thrust.argmin())
    if flat.thrust[least] < ability.thrust_min:
        found.append(Excess("thrust_min", float(flat.time[least]), float(flat.thrust[least]), ability.thrust_min))
    for name, values in upper.items():
        worst, allowed = int(values.argmax()), float(getattr(ability, name))
        if values[worst] > allowed:
            found.append(Excess(name, float(flat.time[worst]), float(values[worst]), allowed))
    return tuple(found)


def largest_thrust(curve: PiecewisePolynomial) -> Extreme:
    """Enclose the maximum over time of the collective thrust over mass without drag, ‖a + g e_z‖ m/s².

    Certified for every instant, not at samples only, see `crosstrack.trajectory.certified.extremes`.
    """
    acceleration = curve.derivative(2)
    force = acceleration.coefficients.copy()
    force[:, 0, 2] += GRAVITY
    return largest_norm(PiecewisePolynomial(acceleration.durations, force))
