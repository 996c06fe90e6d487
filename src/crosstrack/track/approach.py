"""What is asked for where the vehicle cannot do everything: far from the trajectory, or out of thrust."""

import math

from crosstrack.compiled import compiled
from crosstrack.track.attitude import Triple, dot
from crosstrack.types import GRAVITY, Model

BRAKING = 0.5
"""of the acceleration that the limits leave in the weakest direction"""
SIDEWAYS = 0.4
"""of the greatest thrust, that height leaves to sideways motion: 24° of tilt, for 8 % of the lift"""


def braking(model: Model) -> float:
    """Return the acceleration (m/s²) that a vehicle is counted on to brake with in any direction."""
    up, down = model.thrust_max - GRAVITY, GRAVITY - model.thrust_min
    sideways = min(GRAVITY * math.tan(model.tilt_max), math.sqrt(model.thrust_max**2 - GRAVITY**2))
    return BRAKING * min(up, down, sideways)


def limits_of(model: Model) -> Triple:
    """Return the limits of a model: least and most thrust (m/s²), tilt tangent."""
    return model.thrust_min, model.thrust_max, math.tan(model.tilt_max)


@compiled
def eased(error: Triple, reach: float) -> Triple:
    """Return a position error (m), beyond the reach r (m) as long as √(2 r |e| - r²).

    A law that approaches with the speed λ |e| within the reach so brakes by λ² r, and no more, from however far.
    """
    far = math.sqrt(dot(error, error))
    if far <= reach:
        return error
    scale = math.sqrt(2 * reach * far - reach * reach) / far
    return error[0] * scale, error[1] * scale, error[2] * scale


@compiled
def affordable(f: Triple, limits: Triple) -> Triple:
    """Return the thrust vector (m/s²) that limits allow for one asked for: height before sideways, but not all of it.

    Were all thrust left to height, a vehicle short of it would level out, and noise would throw it to and fro.

    Args:
        f: m/s², world
        limits: see `limits_of`
    """
    least, most, tilt = limits
    sideways = math.sqrt(f[0] * f[0] + f[1] * f[1])
    kept = min(sideways, most * min(SIDEWAYS, tilt / math.sqrt(1.0 + tilt * tilt)))
    lift = min(math.sqrt(most * most - kept * kept), max(least, f[2]))
    room = min(lift * tilt, math.sqrt(max(0.0, most * most - lift * lift)))
    scale = room / sideways if sideways > room else 1.0
    return f[0] * scale, f[1] * scale, lift
