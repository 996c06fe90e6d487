"""Incremental tracking: what accelerometer and rotors say of outside forces is met at once."""

import math
from dataclasses import dataclass

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.errors import InputError, Problem
from crosstrack.protocols import Course
from crosstrack.track.attitude import axes_of, drag_of
from crosstrack.track.clock import Timed, begin, model_of, tick
from crosstrack.track.geometric import commanded, gains_of
from crosstrack.types import GRAVITY, Array, Model, Positive, RateSetpoint, State


@dataclass(frozen=True)
class IncrementalMemory(Timed):
    """What incremental tracking remembers."""

    push: Array
    """(3,) m/s², acceleration by what the nominal model does not know"""
    known: Array
    """(3,) m/s², by thrust, gravity and nominal drag in the last step"""


@dataclass(frozen=True)
class Incremental:
    """Track a trajectory as `geometric` does, and correct the thrust by what the last one left unexplained.

    With the acceleration a measured, the thrust of the rotors as they turn, k ΣΩ² z_B, and the drag D of the nominal
    model, the outside acceleration d and the thrust vector are

        d = H(a - (k ΣΩ² z_B + D - g e_z)),    f = k_p (p - x) + k_v (p' - v) + p'' + g e_z - D - d,

    where H is a low-pass filter of first order. That is the increment f = f_now + (a_wanted - a) of Tal and Karaman,
    with the forces that the model knows left out of the filter. Wind, a payload and wrong drag need no integral.

    Source: Tal, Karaman 2021 (IEEE TCST 29(3), arXiv 1809.04048), eq. 16-20; rates in place of angular accelerations.
    """

    needs = ("trajectory", "attitude")

    attitude_gain: Positive = 0.6
    """1, attitude gain times the time the vehicle takes to answer a rate"""
    velocity_gain: Positive = 3.5
    """1/s, k_v, acceleration over velocity error"""
    position_gain: Positive = 5.0
    """1/s², k_p, acceleration over position error"""
    bandwidth: Positive = 10.0
    """1/s, of the low-pass filter"""

    def start(self, course: Course, state: State) -> IncrementalMemory:
        """Begin the trajectory now.

        Raises:
            InputError: the course has no trajectory, or the vehicle takes no rates or does not measure what is needed.
        """
        model_of(course)
        if not np.isfinite(state.acceleration).all() or not state.rotor_speeds.size:
            message = "does not measure acceleration and rotor speeds, which this tracker corrects by"
            raise InputError("vehicle", [Problem("kind", message)])
        return IncrementalMemory(begin(course, state), np.zeros(3), state.acceleration)

    def step(
        self, memory: IncrementalMemory, course: Course, state: State, duration: float
    ) -> tuple[RateSetpoint, IncrementalMemory]:
        """Return rates and thrust for the next `duration` (s), and the new memory."""
        clock, model = tick(memory.clock, course, state), model_of(course)
        push, known = felt(memory, state, model, self.bandwidth, duration)
        gains = gains_of(self, course.envelope, model, duration)
        return commanded(clock, state, model, duration, push, gains), IncrementalMemory(clock, push, known)


def felt(
    memory: IncrementalMemory, state: State, model: Model, bandwidth: float, duration: float
) -> tuple[Array, Array]:
    """Return the outside acceleration (3,) m/s², filtered with a bandwidth (1/s), and the known one (3,) m/s²."""
    push, known, share = np.empty(3), np.empty(3), 1 - math.exp(-bandwidth * duration)
    unexplained(memory.push, memory.known, state.acceleration, share, *measured(state, model), push, known)
    return push, known


def measured(state: State, model: Model) -> tuple[Array, Array, float, Array, Array]:
    """Return what the forces follow from: velocity, attitude, thrust over mass (m/s²) and the drag of the model."""
    thrust = model.thrust_factor * float(state.rotor_speeds @ state.rotor_speeds)
    return state.velocity, state.attitude, thrust, model.drag, model.drag_quadratic


@compiled
def unexplained(
    before: Array,
    known_before: Array,
    acceleration: Array,
    share: float,
    velocity: Array,
    attitude: Array,
    thrust: float,
    linear: Array,
    square: Array,
    push: Array,
    known: Array,
) -> None:
    """Fill `push` with the outside acceleration, filtered, and `known` with the known one, (3,) m/s² each.

    The acceleration is the mean since the last step; so is the mean of what is known then and now.
    """
    axes = axes_of(attitude)
    effort = math.sqrt(thrust / GRAVITY)
    drag = drag_of(axes, (velocity[0], velocity[1], velocity[2]), effort, linear, square)
    for k in range(3):
        known[k] = thrust * axes[6 + k] + drag[k]
        if k == 2:
            known[k] -= GRAVITY
        miss = acceleration[k] - 0.5 * (known[k] + known_before[k])
        push[k] = before[k] + share * (miss - before[k])
