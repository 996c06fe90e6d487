"""How a position error is met where it is so large that the vehicle could not brake in time."""

import math

from crosstrack.compiled import compiled
from crosstrack.track.attitude import Triple, dot
from crosstrack.types import GRAVITY, Model

BRAKING = 0.5
"""of the acceleration that the limits leave in the weakest direction"""


def braking(model: Model) -> float:
    """Return the acceleration (m/s²) that a vehicle is counted on to brake with in any direction."""
    up, down = model.thrust_max - GRAVITY, GRAVITY - model.thrust_min
    sideways = min(GRAVITY * math.tan(model.tilt_max), math.sqrt(model.thrust_max**2 - GRAVITY**2))
    return BRAKING * min(up, down, sideways)


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
