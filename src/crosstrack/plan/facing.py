"""Where a vehicle looks along a planned trajectory."""

from typing import Literal

from crosstrack.protocols import Trajectory
from crosstrack.trajectory.flatness.yaw import Faced, along_velocity
from crosstrack.trajectory.polynomial import PiecewisePolynomial

Look = Literal["fixed", "velocity"]
"""as it does at the start, or where it flies"""


def facing(curve: PiecewisePolynomial, look: Look) -> Trajectory:
    """Return a trajectory with its yaw; one that keeps the yaw of the start says nothing of it."""
    return Faced(curve, along_velocity(curve)) if look == "velocity" else curve
