"""Cascaded PID: position to velocity, velocity to acceleration, acceleration to attitude and thrust."""

import math
from dataclasses import dataclass

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.protocols import Course
from crosstrack.track.approach import affordable, braking, eased, limits_of
from crosstrack.track.attitude import Axes, Triple, axes_for, axes_of, dot, drag_while
from crosstrack.track.clock import Timed, begin, model_of, tick
from crosstrack.track.integral import accumulate
from crosstrack.track.reference import Motion, motion
from crosstrack.types import GRAVITY, Array, AttitudeSetpoint, NonNegative, Positive, State


@dataclass(frozen=True)
class PidMemory(Timed):
    """What the cascade remembers beside the clock."""

    held: Array
    """(9,), the integral (m/s²), the velocity error before (m/s, NaN at first) and its filtered slope (m/s²)"""


@dataclass(frozen=True)
class CascadedPid:
    """Track a trajectory by position, velocity, attitude and thrust, each loop asking the next one in.

    With the trajectory p, the drag D(v, R) of the nominal model and the velocity error e, the loops ask for

        v* = p' + k_p (p - x),    e = v* - v,    a* = p'' + k_v e + k_i ∫ e dt + k_d e',
        f = a* + g e_z - D,    R*: z along f, x at the yaw,    c = f · z_B.

    As the vehicle takes the time τ_R to turn to an attitude and τ_c to reach a thrust, and a command held for the
    period T is T/2 old on average, p'' and the drag along p are those of t + T/2 + τ_R in R* and t + T/2 + τ_c in c.
    The gains follow from the vehicle: with its response time τ, k_v = b / (τ + T/2), k_p = a k_v, k_i = i k_p k_v.
    Position errors beyond a reach count by their root, so that the vehicle can brake from wherever it is. While tilt or
    thrust limit f, the integral stands still along what is missing of it (conditional integration).

    Sources: Åström, Hägglund 2006 (Advanced PID Control), ch. 3, for the loop; Faessler, Franchi, Scaramuzza 2018
    (RA-L 3(2)), eq. 13-20, for feed-forward and drag.
    """

    needs = ("trajectory", "attitude")

    position_gain: Positive = 0.4
    """1, a, position gain over velocity gain"""
    velocity_gain: Positive = 0.8
    """1, b, velocity gain times the time the vehicle takes to respond"""
    integral_gain: NonNegative = 0.4
    """1, i, integral gain over position gain and velocity gain"""
    derivative_gain: NonNegative = 0.0
    """1, k_d, of the slope of the velocity error, filtered over the time the vehicle takes to respond"""

    def start(self, course: Course, state: State) -> PidMemory:
        """Begin the trajectory now.

        Raises:
            InputError: the course has no trajectory, or the vehicle takes no attitudes.
        """
        model_of(course)
        return PidMemory(begin(course, state), np.array([0.0, 0, 0, np.nan, np.nan, np.nan, 0, 0, 0]))

    def step(
        self, memory: PidMemory, course: Course, state: State, duration: float
    ) -> tuple[AttitudeSetpoint, PidMemory]:
        """Return attitude and thrust for the next `duration` (s), and the new memory."""
        clock, model = tick(memory.clock, course, state), model_of(course)
        response = course.envelope.response_time + 0.5 * duration
        damp = self.velocity_gain / response
        stiff = self.position_gain * damp
        out, held = np.empty(5), memory.held.copy()
        cascade(
            clock.reference.rows,
            clock.since(state),
            duration,
            state.position,
            state.velocity,
            state.attitude,
            held,
            (stiff, damp, self.integral_gain * stiff * damp, self.derivative_gain),
            limits_of(model),
            (model.attitude_time, model.thrust_time, response),
            braking(model) / stiff**2,
            model.drag,
            model.drag_quadratic,
            out,
        )
        return AttitudeSetpoint(out[:4], float(out[4])), PidMemory(clock, held)


@compiled
def cascade(
    rows: Array,
    since: float,
    period: float,
    position: Array,
    velocity: Array,
    attitude: Array,
    held: Array,
    gains: tuple[float, float, float, float],
    limits: Triple,
    times: Triple,
    reach: float,
    linear: Array,
    square: Array,
    out: Array,
) -> None:
    """Fill `out` with an attitude (xyzw) and a thrust (m/s²), and bring `held` up to now.

    Args:
        rows: stretch of the trajectory
        since: s, after its first sample
        period: s, that the command is held for
        position: (3,) m
        velocity: (3,) m/s
        attitude: (4,) xyzw
        held: (9,) see `PidMemory.held`
        gains: of position (1/s), velocity (1/s), the integral (1/s²) and the derivative (1)
        limits: see `approach.limits_of`
        times: s, from an attitude, a thrust and an acceleration asked for to those flown
        reach: m, position error that is met in proportion
        linear: (3,) 1/s, drag
        square: (3,) 1/m, drag
        out: (5,)
    """
    stiff, damp, gather, brake = gains
    turning, pulling, response = times
    now = motion(rows, since)
    axes = axes_of(attitude)
    then = motion(rows, since + 0.5 * period + turning)
    soon = motion(rows, since + 0.5 * period + pulling)
    smooth = period / (period + response)
    behind = eased((now[0] - position[0], now[1] - position[1], now[2] - position[2]), reach)
    miss = (
        now[3] + stiff * behind[0] - velocity[0],
        now[4] + stiff * behind[1] - velocity[1],
        now[5] + stiff * behind[2] - velocity[2],
    )
    if not math.isnan(held[3]):
        for i in range(3):
            held[6 + i] += smooth * ((miss[i] - held[3 + i]) / period - held[6 + i])
    for i in range(3):
        held[3 + i] = miss[i]
    back = (
        damp * miss[0] + held[0] + brake * held[6],
        damp * miss[1] + held[1] + brake * held[7],
        damp * miss[2] + held[2] + brake * held[8],
    )
    asked = force_at(then, now, velocity, back, axes, linear, square)
    f = affordable(asked, limits)
    accumulate(held, miss, (asked[0] - f[0], asked[1] - f[1], asked[2] - f[2]), gather * period)
    quaternion_into(axes_for(f, then[15]), out)
    lift = force_at(soon, now, velocity, back, axes, linear, square)
    out[4] = min(limits[1], max(limits[0], dot(lift, axes[6:9])))


@compiled
def force_at(
    then: Motion, now: Motion, velocity: Array, back: Triple, axes: Axes, linear: Array, square: Array
) -> Triple:
    """Return the thrust vector (m/s²) of a later motion, were the velocity error kept and the feedback `back`."""
    air = (velocity[0] + then[3] - now[3], velocity[1] + then[4] - now[4], velocity[2] + then[5] - now[5])
    need = (then[6] + back[0], then[7] + back[1], then[8] + back[2] + GRAVITY)
    drag = drag_while(axes, air, need, linear, square)
    return need[0] - drag[0], need[1] - drag[1], need[2] - drag[2]


@compiled
def quaternion_into(axes: Axes, out: Array) -> None:
    """Write the attitude (xyzw) of body axes, from its largest component (Shepperd 1978)."""
    xx, xy, xz, yx, yy, yz, zx, zy, zz = axes
    if zz >= 0.0:
        if xx + yy >= 0.0:
            q = (yz - zy, zx - xz, xy - yx, 1.0 + xx + yy + zz)
        else:
            q = (zx + xz, zy + yz, 1.0 - xx - yy + zz, xy - yx)
    elif xx >= yy:
        q = (1.0 + xx - yy - zz, xy + yx, zx + xz, yz - zy)
    else:
        q = (xy + yx, 1.0 - xx + yy - zz, yz + zy, zx - xz)
    inverse = 1.0 / math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    for i in range(4):
        out[i] = q[i] * inverse
