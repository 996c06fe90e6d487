"""The terms of an artificial potential field, in 2-D and 3-D: attraction, repulsion, and what weighs them.

A force is the negative gradient of its potential. Obstacles are points: the nearest of each, at a gap d.
"""

import math
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge

from crosstrack.compiled import compiled
from crosstrack.types import Array, NonNegative, Positive
from crosstrack.vectors import norm

LEAST_GAP = 1e-3
"""m, nearer than which the repulsion grows no more"""

Factor = Literal["none", "obstacle", "vehicle"]
FACTORS: dict[Factor, int] = {"none": 0, "obstacle": 1, "vehicle": 2}
Numbers = tuple[float, float, float, float, int, float, float]
"""ξ, its conic distance, η, Q, which factor, its exponent and its far distance, for compiled code"""


@dataclass(frozen=True)
class Terms:
    """The law of a potential field; by default that of Khatib 1986.

    With the offset r from the vehicle to the goal, the attraction is

        U = ½ ξ |r|²,  F = ξ r      up to |r| = c,      U = ξ c (|r| - c/2),  F = ξ c r/|r|      beyond,

    and the repulsion of an obstacle at the gap d ≤ Q, in the direction n away from it,

        U = ½ η (1/d - 1/Q)² w,      F = η (1/d - 1/Q) w/d² n - ½ η (1/d - 1/Q)² ∇w,

    where w is 1, or |goal - obstacle|^n, which makes it grow with the attraction far from the goal, or |r|^n, which
    makes the goal the lowest point even beside an obstacle.

    Sources: Khatib 1986 (IJRR 5(1), equations 10 to 12); Ge and Cui 2000 (IEEE Trans. Robotics and Automation 16(5),
    equations 8 to 12), |r|^n; Li 2020 (ICAICE), K_v, K_d and K_e.
    """

    attraction: Positive = 0.5
    """1/s², ξ"""
    conic: Positive | None = None
    """m, c, beyond which the attraction grows no more; none for never"""
    repulsion: NonNegative = 20.0
    """m⁴/s² where there is no factor, η"""
    influence: Positive = 20.0
    """m, Q, the gap from which obstacles count"""
    factor: Factor = "none"
    """what w is a power of: `obstacle`, of the distance from the goal to the obstacle; `vehicle`, to the vehicle"""
    exponent: Annotated[float, Ge(1)] = 2.0
    """1, n"""
    far: Positive | None = None
    """m, the distance from which w grows no more; none for never"""
    approach: bool = False
    """whether the attraction is multiplied by K_v, which grows as the approach to the goal slows down"""
    near_goal: NonNegative = 0.0
    """1, by how much K_d raises the attraction near the goal; 3 in the article, 0 turns it off"""
    near_goal_at: NonNegative = 0.5
    """m, distance to the goal at which K_d is greatest"""
    boost: Annotated[float, Ge(1)] = 1.0
    """1, K_e, a constant factor of the attraction"""

    @property
    def numbers(self) -> Numbers:
        """What compiled code takes."""
        conic, far = self.conic or math.inf, self.far or math.inf
        return (
            self.attraction,
            conic,
            self.repulsion,
            self.influence,
            FACTORS[self.factor],
            self.exponent,
            far,
        )

    def strengthened(self, remaining: float, step: float, closing: float) -> float:
        """Return the factor K_v K_d K_e of the attraction.

        Args:
            remaining: m, to the goal
            step: m/s, the speed of a vehicle that nothing repels, above zero
            closing: m/s, how fast the goal comes nearer, at least -`step`
        """
        factor = self.boost * (1.0 + self.near_goal * bell(remaining, self.near_goal_at))
        return factor * slowness(step, closing) if self.approach else factor


def slowness(step: float, closing: float) -> float:
    """Return K_v = 3 l / (2 l + V_ra): 1 when approaching at the full speed l, 1.5 at rest, 3 when receding at l.

    V_ra is positive when approaching, and not beyond ±l, since nothing moves faster; so the denominator is at least l.

    Args:
        step: m/s, l
        closing: m/s, V_ra
    """
    return 3.0 * step / (2.0 * step + min(step, max(-step, closing)))


def bell(remaining: float, at: float) -> float:
    """Return exp(-(d - d₀)²/2), the bump of K_d at the distance d₀ (m) from the goal."""
    return math.exp(-0.5 * (remaining - at) ** 2)


@compiled
def attraction(way: Array, gain: float, conic: float) -> tuple[float, Array]:
    """Return potential (m²/s²) and force (3,) m/s² of the goal, `way` (3,) m from the vehicle."""
    remaining = norm(way)
    if remaining <= conic:
        return 0.5 * gain * remaining * remaining, gain * way
    return gain * conic * (remaining - 0.5 * conic), gain * conic / remaining * way


@compiled
def weight(way: Array, gap: float, away: Array, factor: int, exponent: float, far: float) -> tuple[float, float]:
    """Return the factor w of a repulsion, and how fast (1/m) it grows with the distance from goal to vehicle.

    Args:
        way: (3,) m, from the vehicle to the goal
        gap: m, to the obstacle
        away: (3,) unit, from the obstacle to the vehicle
        factor: 0 none, 1 of the distance from the goal to the obstacle, 2 to the vehicle
        exponent: n
        far: m, where the distance grows no more
    """
    if factor == 0:
        return 1.0, 0.0
    if factor == 1:
        return min(far, norm(way + gap * away)) ** exponent, 0.0
    remaining = norm(way)
    if remaining >= far:
        return far**exponent, 0.0
    return remaining**exponent, exponent * remaining ** (exponent - 1.0)


@compiled
def repulsion(way: Array, gap: float, away: Array, numbers: Numbers) -> tuple[float, Array]:
    """Return potential and force (3,) of one obstacle.

    Args:
        way: (3,) m, from the vehicle to the goal
        gap: m, to the obstacle
        away: (3,) unit, from the obstacle to the vehicle
        numbers: of the terms
    """
    _, _, gain, influence, factor, exponent, far = numbers
    force = np.zeros(3)
    if gap >= influence:
        return 0.0, force
    d = max(gap, LEAST_GAP)
    excess = 1.0 / d - 1.0 / influence
    w, growth = weight(way, gap, away, factor, exponent, far)
    remaining = norm(way)
    pull = 0.5 * gain * excess * excess * growth / remaining if remaining > 0.0 else 0.0
    push = gain * excess * w / (d * d)
    for k in range(3):
        force[k] = push * away[k] + pull * way[k]
    return 0.5 * gain * excess * excess * w, force


@compiled
def repulsions(way: Array, gaps: Array, away: Array, numbers: Numbers) -> Array:
    """Return potential and force (n, 4) of obstacles with gaps (n,) m in directions (n, 3) away from them."""
    out = np.empty((len(gaps), 4))
    for i in range(len(gaps)):
        out[i, 0], force = repulsion(way, gaps[i], away[i], numbers)
        for k in range(3):
            out[i, 1 + k] = force[k]
    return out
