"""Integration of an error that stands still where the vehicle cannot do more about it."""

from crosstrack.compiled import compiled
from crosstrack.track.attitude import Triple, dot
from crosstrack.types import Array


@compiled
def accumulate(total: Array, error: Triple, missing: Triple, gain: float) -> None:
    """Add gain times an error to its integral, less the part that would ask for more of what is missing.

    Conditional integration (Åström, Hägglund 2006, section 3.5), in the direction that is missing alone.

    Args:
        total: first three entries, the integral
        error: that the vehicle is asked to move along
        missing: m/s², of the force asked for, that limits do not allow
        gain: of the error, times the period
    """
    square, along = dot(missing, missing), dot(error, missing)
    share = along / square if square > 1e-12 and along > 0.0 else 0.0
    for i in range(3):
        total[i] += gain * (error[i] - share * missing[i])
