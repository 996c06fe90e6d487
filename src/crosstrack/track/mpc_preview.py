"""What the bounds of a predictive tracker hang on at a step: the deviation now, and the trajectory ahead."""

import math

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.track.attitude import axes_for, axes_of, dot, drag_while, easing_of
from crosstrack.track.mpc_design import Design
from crosstrack.track.reference import motion
from crosstrack.types import GRAVITY, Array


def bounds_of(made: Design, off: Array, forces: Array, velocities: Array) -> tuple[Array, Array]:
    """Return the lower and upper bounds of the program's rows: what is left beside the trajectory.

    Args:
        made: the program
        off: (12,) deviation
        forces: (steps, 3) m/s², that the trajectory needs
        velocities: (checked, 3) m/s, of the trajectory
    """
    around = forces @ made.forces.T
    speeds = (velocities + made.coasting @ off) @ made.headings.T
    lower = np.concatenate([(made.least - around).ravel(), (-made.fastest - speeds).ravel()])
    upper = np.concatenate([(made.most - around).ravel(), (made.fastest - speeds).ravel()])
    return lower, upper


@compiled
def deviation(
    rows: Array,
    since: float,
    position: Array,
    velocity: Array,
    attitude: Array,
    thrust: float,
    linear: Array,
    square: Array,
    rate: Array,
    acceleration: Array,
    out: Array,
) -> None:
    """Fill `out` (12,) with the deviations of position, velocity, acceleration and jerk from the trajectory.

    Of the jerk, the part by which the body turns: thrust alone has no rate to be felt.
    """
    now = motion(rows, since)
    axes = axes_of(attitude)
    x, y, z = axes[0:3], axes[3:6], axes[6:9]
    effort = math.sqrt(thrust / GRAVITY)
    easing = easing_of(axes, (now[3], now[4], now[5]), (now[6], now[7], now[8]), effort, linear, square)
    due = (now[9] - easing[0], now[10] - easing[1], now[11] - easing[2])
    along = dot(due, z)
    for k in range(3):
        out[k] = position[k] - now[k]
        out[3 + k] = velocity[k] - now[3 + k]
        out[6 + k] = acceleration[k] - now[6 + k]
        out[9 + k] = thrust * (rate[1] * x[k] - rate[0] * y[k]) - (due[k] - along * z[k])


@compiled
def preview(
    rows: Array,
    since: float,
    step: float,
    checked: int,
    push: Array,
    linear: Array,
    square: Array,
    forces: Array,
    velocities: Array,
) -> None:
    """Fill in what flying the trajectory needs over the horizon.

    Args:
        rows: stretch of the trajectory
        since: s, after its first sample
        step: s, of the prediction
        checked: steps between those whose speed is bounded
        push: (3,) m/s², acceleration by what the nominal model does not know
        linear: (3,) 1/s, drag
        square: (3,) 1/m, drag
        forces: (steps, 3) m/s², thrust vectors at the beginning of every step
        velocities: (steps // checked, 3) m/s, at the end of every so many steps
    """
    for k in range(forces.shape[0]):
        then = motion(rows, since + k * step)
        need = (then[6] - push[0], then[7] - push[1], then[8] + GRAVITY - push[2])
        drag = drag_while(axes_for(need, then[15]), (then[3], then[4], then[5]), need, linear, square)
        for i in range(3):
            forces[k, i] = need[i] - drag[i]
    for k in range(velocities.shape[0]):
        then = motion(rows, since + (k + 1) * checked * step)
        for i in range(3):
            velocities[k, i] = then[3 + i]
