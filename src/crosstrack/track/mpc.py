"""Linear model predictive control of the deviation from a trajectory, over the law that turns forces into rates."""

import math
from dataclasses import dataclass, replace

import numpy as np

from crosstrack.protocols import Course
from crosstrack.track.clock import model_of, tick
from crosstrack.track.condensed import Flags, Solution
from crosstrack.track.geometric import commanded
from crosstrack.track.incremental import Incremental, IncrementalMemory, felt, measured
from crosstrack.track.mpc_design import CHECKED, HELD, STEP, STEPS, Design, design
from crosstrack.track.mpc_preview import bounds_of, deviation, preview
from crosstrack.types import Array, Model, Positive, RateSetpoint, State


@dataclass(frozen=True)
class MpcMemory(IncrementalMemory):
    """What predictive control remembers."""

    design: Design
    """the program, built once"""
    active: Flags
    """(rows,) flags of the bounds that held the last plan"""
    missed: int
    """steps so far that the solver gave up, and the input without bounds was flown instead"""


@dataclass(frozen=True)
class Mpc:
    """Track a trajectory by the best plan for the next second that thrust, tilt and speed allow.

    The deviation x = (δp, δv, δa, δj) from the trajectory evolves as x_{k+1} = A x_k + B u_k, where u is acceleration
    asked for on top of that of the trajectory and reaches the vehicle through its attitude and rate loops, see
    `mpc_design.deviations`. Every step solves, for 20 steps of 50 ms, from what is measured,

        min Σ |δp_k|²/e_p² + |δv_k|²/e_v² + |u_k|²  +  x_Nᵀ P x_N,    P from the Riccati equation,
        while  p''_k + u_k + g e_z - D_k - d  stays within thrust bounds and tilt, and |p'_k + δv_k| within the speed,

    with the drag D of the nominal model along the trajectory p ahead, and d, what the model does not know, taken to
    stay (as `incremental` finds it). Cone, sphere and speed are polyhedra of eight sides. Excess speed costs, so there
    is always a plan. The first input u_0 adds to the force of `geometric`, which asks for thrust and rates. Between
    bounds this is the LQR of infinite horizon. Should the solver give up, that law is flown, and `missed` counts it.

    Sources: Mayne, Rawlings, Rao, Scokaert 2000 (Automatica 36(6)), section 3, for the terminal cost; Bemporad, Morari,
    Dua, Pistikopoulos 2002 (Automatica 38(1)), eq. 4-7, for the condensed program; Pannocchia, Rawlings 2003 (AIChE J.
    49(2)) for d; the deviation from a flat reference is ours.
    """

    needs = ("trajectory", "attitude")

    position_error: Positive = 0.07
    """m, e_p, as dear as an input of 1 m/s²"""
    velocity_error: Positive = 0.5
    """m/s, e_v, as dear as an input of 1 m/s²"""
    attitude_gain: Positive = 0.6
    """1, attitude gain times the time the vehicle takes to answer a rate"""
    bandwidth: Positive = 20.0
    """1/s, of the low-pass filter of what the model does not know"""

    def start(self, course: Course, state: State) -> MpcMemory:
        """Build the program, and begin the trajectory now.

        Raises:
            InputError: the course has no trajectory, the vehicle takes no rates or does not measure what is needed, or
                the weights have no answer.
        """
        seen = Incremental().start(course, state)
        made = self.designed(course, HELD)
        return MpcMemory(seen.clock, seen.push, seen.known, made, made.program.flags, 0)

    def designed(self, course: Course, held: float) -> Design:
        """Return the program for commands that are held for a time (s)."""
        weights = self.attitude_gain, self.position_error, self.velocity_error
        return design(course.envelope, model_of(course), held, *weights)

    def step(self, memory: MpcMemory, course: Course, state: State, duration: float) -> tuple[RateSetpoint, MpcMemory]:
        """Return rates and thrust for the next `duration` (s), and the new memory."""
        if duration > memory.design.held:  # asked more seldom than at 50 Hz: made anew, once
            made = self.designed(course, duration)
            memory = replace(memory, design=made, active=made.program.flags)
        clock, model, made = tick(memory.clock, course, state), model_of(course), memory.design
        rows, since = clock.reference.rows, clock.since(state)
        push, known = felt(memory, state, model, self.bandwidth, duration)
        off = np.empty(12)
        deviation(rows, since, state.position, *measured(state, model), state.rate, known + push, off)
        plan = planned(made, model, rows, since, push, off, memory.active)
        more = plan.inputs[:3] if plan.found else -made.gains @ off
        asked = commanded(clock, state, model, duration, push - more, (0.0, 0.0, made.gain, math.inf))
        missed = memory.missed + (not plan.found)
        return asked, MpcMemory(clock, push, known, made, plan.active, missed)


def planned(made: Design, model: Model, rows: Array, since: float, push: Array, off: Array, active: Flags) -> Solution:
    """Return the best inputs over the horizon.

    Args:
        made: the program
        model: of the vehicle
        rows: stretch of the trajectory
        since: s, after its first sample
        push: (3,) m/s², acceleration by what the nominal model does not know
        off: (12,) deviation from the trajectory
        active: flags of the bounds that held the last plan
    """
    forces, velocities = np.empty((STEPS, 3)), np.empty((STEPS // CHECKED, 3))
    preview(rows, since, STEP, CHECKED, push, model.drag, model.drag_quadratic, forces, velocities)
    return made.program.solve(made.condensed.coupling @ off, *bounds_of(made, off, forces, velocities), active)
