"""Discrete linear-quadratic regulation of position, velocity, attitude and rates about a trajectory."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.protocols import Course
from crosstrack.track.approach import affordable, eased, limits_of
from crosstrack.track.attitude import Axes, Triple, axes_of, capped, dot, seen, world
from crosstrack.track.clock import Clock, Timed, begin, model_of, rate_delay, tick
from crosstrack.track.integral import accumulate
from crosstrack.track.linear import Flying, flying
from crosstrack.track.reference import motion
from crosstrack.track.schedule import Schedule, blended, by_thrust, by_time
from crosstrack.types import Array, Envelope, Model, Positive, RateSetpoint, State


@dataclass(frozen=True)
class LqrMemory(Timed):
    """What the regulator remembers beside the clock."""

    gathered: Array
    """(3,) m s, integral of the position error, world"""
    schedule: Schedule | None
    """the gains; None before the first step, which knows the period"""


@dataclass(frozen=True)
class Lqr:
    """Track a trajectory by discrete linear-quadratic regulation about it.

    The reference flies what the trajectory p needs in still air: axes R_r, thrust c_r, rates ω_r. The state x holds,
    in these axes, the errors of position and velocity, the rotation from the reference to the vehicle, the rate error
    w = ω - Rᵀ R_r ω_r, and the integral of the position error where wanted. With the gain K of the cost
    Σ Σ_i (x_i / X_i)² + Σ_j (u_j / U_j)² over allowed deviations X and U (Bryson's rule),

        u = -K x,    ω = Rᵀ R_r ω_r + (u_1, u_2, u_3),    c = c_r + u_4,

    with ω_r and c_r sent ahead by the times that the vehicle takes to answer. `infinite` takes K of the infinite
    horizon at the thrust c_r; `finite` that of the Riccati recursion backwards along the whole trajectory, which knows
    its rates and its drag. The recursion belongs to the period of the commands, so the first step runs it.

    Far from the trajectory the vehicle must not tumble. Position errors beyond a reach count by their root, so that it
    can brake, and the integral stands still. The part of K x of position, velocity and integral is the one that another
    thrust vector would have; that vector is kept within tilt and thrust limits, and turned to by the shortest way.
    Near the trajectory this is u = -K x itself.

    Sources: Anderson, Moore 1990 (Optimal Control), ch. 2; Bryson, Ho 1975 (Applied Optimal Control), ch. 5; Foehn,
    Scaramuzza 2018 (ICRA, Onboard State Dependent LQR for Agile Quadrotors) for rates as the input.
    """

    needs = ("trajectory", "attitude")

    horizon: Literal["infinite", "finite"] = "infinite"
    """gains by thrust, or by time along the trajectory"""
    integral: bool = True
    """whether the integral of the position error is regulated too"""
    position_error: Positive = 0.2
    """m, allowed deviation on each axis"""
    velocity_error: Positive = 1.5
    """m/s, allowed deviation on each axis"""
    tilt_error: Positive = 0.4
    """rad, allowed deviation of roll and pitch at hover; at other thrusts, of the same sideways acceleration"""
    yaw_error: Positive = 1.0
    """rad, allowed deviation"""
    integral_error: Positive = 0.25
    """m s, allowed deviation on each axis"""
    rate_share: Positive = 0.25
    """1, allowed roll and pitch rates beyond the reference's, in units of `tilt_error` over the time a rate takes"""
    yaw_rate: Positive = 1.0
    """rad/s, allowed yaw rate beyond the reference's"""
    thrust: Positive = 5.0
    """m/s², allowed thrust beyond the reference's"""

    def start(self, course: Course, state: State) -> LqrMemory:
        """Begin the trajectory now.

        Raises:
            InputError: the course has no trajectory, or the vehicle takes no rates.
        """
        model_of(course)
        return LqrMemory(begin(course, state), np.zeros(3), None)

    def step(self, memory: LqrMemory, course: Course, state: State, duration: float) -> tuple[RateSetpoint, LqrMemory]:
        """Return rates and thrust for the next `duration` (s), and the new memory."""
        clock, model = tick(memory.clock, course, state), model_of(course)
        schedule = memory.schedule
        if schedule is None or abs(schedule.period - duration) > 1e-9:
            schedule = self.scheduled(clock, course.envelope, model, duration)
        out, gathered = np.empty(4), memory.gathered.copy()
        regulate(
            clock.reference.rows,
            clock.since(state),
            duration,
            (state.position, state.velocity, state.attitude, state.rate),
            gathered,
            schedule.gains,
            (state.time - clock.began - schedule.begin) / schedule.spacing if schedule.by_time else math.nan,
            (schedule.begin, schedule.spacing, schedule.reach),
            limits_of(model),
            (model.rate_time, model.thrust_time, model.rate_max),
            model.drag,
            model.drag_quadratic,
            out,
        )
        return RateSetpoint(out[:3], float(out[3])), LqrMemory(clock, gathered, schedule)

    def scheduled(self, clock: Clock, envelope: Envelope, model: Model, period: float) -> Schedule:
        """Return the gains for a vehicle commanded every `period` (s)."""
        tilt, yaw = self.tilt_error, self.yaw_error
        allowed = [self.position_error] * 3 + [self.velocity_error] * 3 + [tilt, tilt, yaw] + [math.inf] * 3
        allowed += [self.integral_error] * 3 if self.integral else []
        rate = self.rate_share * tilt / rate_delay(envelope, model)
        q, r = np.array(allowed) ** -2, np.array([rate, rate, self.yaw_rate, self.thrust]) ** -2
        if self.horizon == "finite":
            return by_time(clock.reference, model, q, r, period)
        return by_thrust(model, q, r, period)


@compiled
def regulate(
    rows: Array,
    since: float,
    period: float,
    state: tuple[Array, Array, Array, Array],
    gathered: Array,
    gains: Array,
    row: float,
    table: Triple,
    limits: Triple,
    answers: Triple,
    linear: Array,
    square: Array,
    out: Array,
) -> None:
    """Fill `out` with body rates (rad/s) and thrust (m/s²), and bring the integral up to now.

    Args:
        rows: stretch of the trajectory
        since: s, after its first sample
        period: s, that the command is held for
        state: position, velocity, attitude and rate, see `types.State`
        gathered: (3,) m s, integral of the position error, world
        gains: (rows, 4, n)
        row: of the gains, a fraction; NaN where they go by thrust
        table: m/s², thrust of the first row of the gains, and between two; m, reach of the position error
        limits: see `approach.limits_of`
        answers: s, from a rate and a thrust asked for to those flown; most rate (rad/s)
        linear: (3,) 1/s, drag
        square: (3,) 1/m, drag
        out: (4,)
    """
    position, velocity, attitude, rate = state
    now, axes, flown = motion(rows, since), axes_of(attitude), np.empty((3, 15))
    # In one loop, for `flying` is compiled into wherever it is called.
    for k, delay in enumerate((0.0, 0.5 * period + answers[0], 0.5 * period + answers[1])):
        write(flying(motion(rows, since + delay), limits, linear, square), flown[k])
    ref, force, thrust = axes_in(flown[0]), force_in(flown[0]), thrust_in(flown[0])
    gain = np.empty((4, gains.shape[2]))
    blended(gains, (thrust - table[0]) / table[1] if math.isnan(row) else row, gain)
    behind = (now[0] - position[0], now[1] - position[1], now[2] - position[2])
    slower = (now[3] - velocity[0], now[4] - velocity[1], now[5] - velocity[2])
    pull = asked_for(
        gain, seen(ref, eased(behind, table[2])), seen(ref, slower), seen(ref, (gathered[0], gathered[1], gathered[2]))
    )
    push = world(ref, (pull[0], pull[1], pull[3]))
    asked = (force[0] + push[0], force[1] + push[1], force[2] + push[2])
    f = affordable(asked, limits)
    if dot(behind, behind) <= table[2] * table[2]:
        accumulate(gathered, behind, (asked[0] - f[0], asked[1] - f[1], asked[2] - f[2]), period)
    turn = turn_to(axes, ref, f, pull[2])
    # Rates of the reference are turned as far as the vehicle is from it.
    spin, ahead = seen(axes, world(ref, rate_in(flown[0]))), seen(axes, world(ref, rate_in(flown[1])))
    for k in range(4):
        out[k] = 0.0
        for j in range(3):
            out[k] += gain[k, 6 + j] * turn[j] - gain[k, 9 + j] * (rate[j] - spin[j])
    lift = dot(f, axes[6:9]) + thrust_in(flown[2]) - thrust
    out[3] = min(limits[1], max(limits[0], out[3] + lift))
    out[0], out[1], out[2] = capped((out[0] + ahead[0], out[1] + ahead[1], out[2] + ahead[2]), answers[2])


@compiled
def write(flown: Flying, row: Array) -> None:
    """Write what a reference flies into a row (15,): axes, thrust vector, rates."""
    axes, force, rate = flown
    for i in range(9):
        row[i] = axes[i]
    for i in range(3):
        row[9 + i], row[12 + i] = force[i], rate[i]


@compiled
def axes_in(row: Array) -> Axes:
    """Return the axes of a row."""
    return row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8]


@compiled
def force_in(row: Array) -> Triple:
    """Return the thrust vector (m/s², world) of a row."""
    return row[9], row[10], row[11]


@compiled
def thrust_in(row: Array) -> float:
    """Return the thrust (m/s²) of a row."""
    return math.sqrt(row[9] * row[9] + row[10] * row[10] + row[11] * row[11])


@compiled
def rate_in(row: Array) -> Triple:
    """Return the rates (rad/s, in its own axes) of a row."""
    return row[12], row[13], row[14]


@compiled
def asked_for(gain: Array, position: Triple, velocity: Triple, total: Triple) -> tuple[float, float, float, float]:
    """Return what outer errors ask for: force along x and y (m/s²), rotation about z (rad), and thrust (m/s²)."""
    pull = (0.0, 0.0, 0.0, 0.0)
    for j in range(3):
        pull = summed(pull, gain[:, j], position[j])
        pull = summed(pull, gain[:, 3 + j], velocity[j])
        if gain.shape[1] > 12:
            pull = summed(pull, gain[:, 12 + j], total[j])
    return pull


@compiled
def summed(pull: tuple[float, float, float, float], column: Array, error: float) -> tuple[float, float, float, float]:
    """Return the sum of a vector and a column of the gains times an error."""
    return (
        pull[0] + column[0] * error,
        pull[1] + column[1] * error,
        pull[2] + column[2] * error,
        pull[3] + column[3] * error,
    )


@compiled
def turn_to(axes: Axes, ref: Axes, force: Triple, yaw: float) -> Triple:
    """Return the rotation (rad, body) that brings z onto a force, and x to `yaw` from that of the reference.

    Of an angle θ it is 2 sin(θ/2): never less the farther it is.
    """
    size = 1.0 / math.sqrt(dot(force, force))
    nx, ny, nz = seen(axes, force)
    far = size / math.sqrt(max(1e-6, 0.5 + 0.5 * nz * size))
    x, y, z = axes[0:3], axes[3:6], axes[6:9]
    u, v, w = ref[0:3], ref[3:6], ref[6:9]
    half = math.sqrt(max(1e-6, 0.25 * (1.0 + dot(x, u) + dot(y, v) + dot(z, w))))
    return -ny * far, nx * far, yaw - 0.5 * (dot(v, x) - dot(u, y)) / half
