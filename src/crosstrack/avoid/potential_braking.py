"""What a vehicle that brakes in time may fly: the approach to an obstacle that its gap allows."""

import math

from crosstrack.compiled import compiled
from crosstrack.types import Array
from crosstrack.vectors import dot

ROUNDS = 12
"""at most, times that all obstacles are gone through: what one takes away may be an approach to another"""

SLACK = 0.02
"""m/s, of approach that is left where there are obstacles all around"""


@compiled
def allowed(gap: float, braking: float, delay: float) -> float:
    """Return the fastest approach v (m/s) from which a vehicle stops within a gap d (m): v T + v²/(2 a) = d.

    Args:
        gap: m, d
        braking: m/s², a
        delay: s, T, flown on before it brakes
    """
    if gap <= 0.0:
        return 0.0
    return braking * (math.sqrt(delay * delay + 2.0 * gap / braking) - delay)


@compiled
def held_back(velocity: Array, gaps: Array, away: Array, approach: Array, braking: float, delay: float) -> Array:
    """Return a velocity (3,) m/s without what approaches an obstacle faster than can be stopped.

    This is the repulsion of Krogh's generalised field where it matters: none for a vehicle that stops in time, and
    along the obstacle nothing is lost.

    Args:
        velocity: (3,) m/s
        gaps: (n,) m, to stop within
        away: (n, 3) unit, from the obstacles
        approach: (n,) m/s, how fast the obstacles come by themselves; below zero where more is allowed
        braking: m/s²
        delay: s
    """
    out = velocity.copy()
    for _turn in range(ROUNDS):
        worst = 0.0
        for i in range(len(gaps)):
            excess = approach[i] - dot(out, away[i]) - allowed(gaps[i], braking, delay)
            if excess > 0.0:
                worst = max(worst, excess)
                for k in range(3):
                    out[k] += excess * away[i, k]
        if worst < 1e-6:
            return out
    # Obstacles all around leave only what approaches none of them.
    share = 1.0
    for i in range(len(gaps)):
        closing = -dot(out, away[i])
        most = allowed(gaps[i], braking, delay) - approach[i]
        if approach[i] <= 0.0 and closing > most + SLACK:
            share = min(share, (most + SLACK) / closing)
    return share * out
