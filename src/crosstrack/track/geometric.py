"""Geometric tracking on SE(3): the thrust vector that the motion needs, and the rates that turn the body to it."""

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.protocols import Course
from crosstrack.track.approach import affordable, braking, eased, limits_of
from crosstrack.track.attitude import (
    Triple,
    axes_for,
    axes_of,
    capped,
    dot,
    drag_while,
    easing_of,
    error_of,
    rate_along,
    seen,
    world,
)
from crosstrack.track.clock import Clock, Timed, begin, model_of, rate_delay, tick
from crosstrack.track.reference import Motion, motion
from crosstrack.types import GRAVITY, Array, Envelope, Model, NonNegative, Positive, RateSetpoint, State
from crosstrack.vectors import limited

YAW_SHARE = 0.4
"""of the attitude gain, that the yaw error is turned with"""
MOMENT = 1e-3
"""s, over which the change of the thrust vector is taken"""
INTEGRATED_ERROR = 0.5
"""m, the most of a position error that is integrated"""
INTEGRAL = 5.0
"""m/s², the most that the integral comes to"""


class Stiffness(Protocol):
    """What a tracker by attitude is tuned with."""

    @property
    def attitude_gain(self) -> float:
        """1, attitude gain times the time the vehicle takes to answer a rate"""

    @property
    def velocity_gain(self) -> float:
        """1/s"""

    @property
    def position_gain(self) -> float:
        """1/s²"""


@dataclass(frozen=True)
class GeometricMemory(Timed):
    """What geometric tracking remembers."""

    push: Array
    """(3,) m/s², acceleration from outside that the integral has found"""


@dataclass(frozen=True)
class Geometric:
    """Track a trajectory on SE(3) with feed-forward of rates, thrust and drag.

    With position and velocity errors from the trajectory p, the rotation R with columns x_B, y_B, z_B, and the drag
    D(v, R) of the nominal model, the thrust vector, attitude, rates and thrust are

        f = k_p (p - x) + k_v (p' - v) + k_i ∫(p - x) + p'' + g e_z - D,    R_d: z along f, x at the yaw,
        ω = Rᵀ R_d ω_d - k_R e_R,    e_R = ½ (R_dᵀ R - Rᵀ R_d)^∨,    c = f · z_B,

    where ω_d keeps R_d along f while it changes by f' = p''' + k_p (p' - v) - D'. As the vehicle takes the time τ to
    answer a rate, and a command held for the period T is T/2 old on average, the changes are fed forward from
    t + T/2 + τ. The attitude gain follows from the vehicle: k_R = a / (τ + T/2). Far off, the approach is no faster
    than the vehicle can brake, and f is what limits leave of it, see `approach`. Of a position error, 0.5 m at most are
    integrated, to 5 m/s² at most.

    Sources: Lee, Leok, McClamroch 2010 (CDC, arXiv 1003.2005), eq. 10-16; Faessler, Franchi, Scaramuzza 2018
    (RA-L 3(2)), eq. 13-20, for drag and rates in place of torques; Goodarzi, Lee, Lee 2013 (ECC, arXiv 1304.6765) for
    the integral.
    """

    needs = ("trajectory", "attitude")

    attitude_gain: Positive = 0.6
    """1, a, attitude gain times the time the vehicle takes to answer a rate"""
    velocity_gain: Positive = 3.5
    """1/s, k_v, acceleration over velocity error"""
    position_gain: Positive = 5.0
    """1/s², k_p, acceleration over position error"""
    integral_gain: NonNegative = 2.5
    """1/s³, k_i, acceleration over the integral of the position error; 0 turns it off"""

    def start(self, course: Course, state: State) -> GeometricMemory:
        """Begin the trajectory now.

        Raises:
            InputError: the course has no trajectory, or the vehicle takes no rates.
        """
        model_of(course)
        return GeometricMemory(begin(course, state), np.zeros(3))

    def step(
        self, memory: GeometricMemory, course: Course, state: State, duration: float
    ) -> tuple[RateSetpoint, GeometricMemory]:
        """Return rates and thrust for the next `duration` (s), and the new memory."""
        clock, model = tick(memory.clock, course, state), model_of(course)
        miss = limited(clock.aim - state.position, INTEGRATED_ERROR)
        push = limited(memory.push - self.integral_gain * duration * miss, INTEGRAL)
        gains = gains_of(self, course.envelope, model, duration)
        return commanded(clock, state, model, duration, push, gains), GeometricMemory(clock, push)


def commanded(
    clock: Clock, state: State, model: Model, duration: float, push: Array, gains: tuple[float, float, float, float]
) -> RateSetpoint:
    """Return rates and thrust for the next `duration` (s).

    Args:
        clock: now
        state: of the vehicle
        model: of the vehicle
        duration: s
        push: (3,) m/s², acceleration by what the nominal model does not know
        gains: see `gains_of`
    """
    out = np.empty(4)
    steer(
        clock.reference.rows,
        clock.since(state),
        duration,
        state.position,
        state.velocity,
        state.attitude,
        push,
        gains,
        limits_of(model),
        (model.rate_time, model.thrust_time, model.rate_max),
        model.drag,
        model.drag_quadratic,
        out,
    )
    return RateSetpoint(out[:3], float(out[3]))


def gains_of(law: Stiffness, envelope: Envelope, model: Model, duration: float) -> tuple[float, float, float, float]:
    """Return the gains of a law for a vehicle that is asked every `duration` s, and the error met in proportion.

    Returns:
        of position (1/s²), velocity (1/s) and attitude (1/s), the last for the time that a rate takes to be flown and,
        where the estimate is late, to be seen; the position error (m) from which on the vehicle is short of braking
    """
    approach = law.position_gain / law.velocity_gain
    gain = law.attitude_gain / (rate_delay(envelope, model) + 0.5 * duration)
    return law.position_gain, law.velocity_gain, gain, braking(model) / approach**2


@compiled
def steer(
    rows: Array,
    since: float,
    period: float,
    position: Array,
    velocity: Array,
    attitude: Array,
    push: Array,
    gains: tuple[float, float, float, float],
    limits: Triple,
    answers: Triple,
    linear: Array,
    square: Array,
    out: Array,
) -> None:
    """Fill `out` with body rates (rad/s) and thrust (m/s²).

    Args:
        rows: stretch of the trajectory
        since: s, after its first sample
        period: s, that the command is held for
        position: (3,) m
        velocity: (3,) m/s
        attitude: (4,) xyzw
        push: (3,) m/s², acceleration by what the nominal model does not know
        gains: of position (1/s²), velocity (1/s) and attitude (1/s), and the position error met in proportion (m)
        limits: see `approach.limits_of`
        answers: s, from a rate and a thrust asked for to those flown; most rate (rad/s)
        linear: (3,) 1/s, drag
        square: (3,) 1/m, drag
        out: (4,)
    """
    stiff, damp, tight, reach = gains
    now, axes = motion(rows, since), axes_of(attitude)
    miss = (now[3] - velocity[0], now[4] - velocity[1], now[5] - velocity[2])
    behind = eased((now[0] - position[0], now[1] - position[1], now[2] - position[2]), reach)
    back = (
        stiff * behind[0] + damp * miss[0] - push[0],
        stiff * behind[1] + damp * miss[1] - push[1],
        stiff * behind[2] + damp * miss[2] - push[2] + GRAVITY,
    )
    drag = drag_while(axes, (velocity[0], velocity[1], velocity[2]), force_of(now, back), linear, square)
    back = (back[0] - drag[0], back[1] - drag[1], back[2] - drag[2])
    wanted = axes_for(affordable(force_of(now, back), limits), now[15])
    error = error_of(axes, wanted)
    # What turns the thrust vector, by when the rates asked for now are flown.
    then = motion(rows, since + 0.5 * period + answers[0])
    rate = rate_at(then, back, (stiff * miss[0], stiff * miss[1], stiff * miss[2]), limits, linear, square)
    # Rᵀ R_d ω_d: the feed-forward as seen from the body as it is.
    spin = seen(axes, world(wanted, rate))
    out[0], out[1], out[2] = capped(
        (spin[0] - tight * error[0], spin[1] - tight * error[1], spin[2] - YAW_SHARE * tight * error[2]), answers[2]
    )
    soon = motion(rows, since + 0.5 * period + answers[1])
    out[3] = min(limits[1], max(limits[0], dot(affordable(force_of(soon, back), limits), axes[6:9])))


@compiled
def force_of(then: Motion, back: Triple) -> Triple:
    """Return the thrust vector (m/s²) of a motion with the feedback `back` (m/s²), weight and drag among it."""
    return then[6] + back[0], then[7] + back[1], then[8] + back[2]


@compiled
def rate_at(then: Motion, back: Triple, change: Triple, limits: Triple, linear: Array, square: Array) -> Triple:
    """Return the body rates (rad/s) of a motion with a feedback (m/s²) that changes (m/s³), where limits cut both."""
    due = force_of(then, back)
    f = affordable(due, limits)
    axes = axes_for(f, then[15])
    easing = easing_of(axes, then[3:6], then[6:9], math.sqrt(dot(f, axes[6:9]) / GRAVITY), linear, square)
    later = affordable(
        (
            due[0] + MOMENT * (then[9] + change[0] - easing[0]),
            due[1] + MOMENT * (then[10] + change[1] - easing[1]),
            due[2] + MOMENT * (then[11] + change[2] - easing[2]),
        ),
        limits,
    )
    turned = ((later[0] - f[0]) / MOMENT, (later[1] - f[1]) / MOMENT, (later[2] - f[2]) / MOMENT)
    return rate_along(axes, f, turned, then[15], then[16])
