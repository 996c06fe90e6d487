"""What a predictive tracker knows before it flies: how deviations evolve, what they cost, what bounds the inputs."""

import math
from dataclasses import dataclass

import numpy as np

from crosstrack.track.clock import rate_delay
from crosstrack.track.condensed import Condensed, Program, condense
from crosstrack.track.riccati import discretised, stationary
from crosstrack.types import Array, Envelope, Model

STEPS = 20
"""N, steps of the prediction"""
STEP = 0.05
"""s, of the prediction, longer than the period between commands: so the horizon is a second"""
HELD = 0.02
"""s, the period between commands that is allowed for before it is known"""
SIDES = 8
"""of the cone that stands for the tilt limit"""
CHECKED = 4
"""steps between those whose speed is bounded"""
EXCESS_PRICE = 1e6
"""(m/s²)² per (m/s)², cost of flying faster than the limit"""
AXES = np.eye(3)


@dataclass(frozen=True, eq=False)
class Design:
    """The program of a predictive tracker, less what changes from step to step."""

    held: float
    """s, the longest period between commands that it is made for"""
    gain: float
    """1/s, attitude error to rate"""
    condensed: Condensed
    """deviations δ = (p, v, a, j), axis by axis in each, and inputs, see `deviations`"""
    forces: Array
    """(rows, 3), rows times the force of one step"""
    least: Array
    """(rows,) m/s², their lower bounds"""
    most: Array
    """(rows,) m/s², their upper bounds"""
    headings: Array
    """(directions, 3), directions in which speed is bounded, either way"""
    fastest: Array
    """(directions,) m/s"""
    program: Program
    """rows of forces for every step, then those of speeds for every step checked"""
    coasting: Array
    """(checked, 3, 12) m/s, the velocity without inputs at every step checked is coasting @ δ"""
    gains: Array
    """(3, 12) the first input without bounds is -gains @ δ"""


def deviations(gain: float, lag: float, step: float) -> tuple[Array, Array]:
    """Return how the deviation of one axis from the trajectory evolves in a step, exactly, while the input is held.

    With the deviations p, v, a, j of position, velocity, acceleration, jerk, and an acceleration u asked for on top of
    that of the trajectory, the attitude loop asks for the jerk k (u - a), which is flown with the lag τ:

        p' = v,    v' = a,    a' = j,    τ j' = k (u - a) - j.

    Args:
        gain: 1/s, k
        lag: s, τ
        step: s

    Returns:
        (4, 4) A and (4, 1) B
    """
    rates = np.eye(4, k=1)
    rates[3, 2:] = -gain / lag, -1 / lag
    return discretised(rates, np.array([[0.0], [0.0], [0.0], [gain / lag]]), step)


def design(
    envelope: Envelope, model: Model, held: float, attitude_gain: float, position: float, velocity: float
) -> Design:
    """Build the program for a vehicle.

    Args:
        envelope: for the response and the speed limits
        model: for the response, thrust and tilt
        held: s, the period between commands
        attitude_gain: 1, attitude gain times the time the vehicle takes to answer a rate
        position: m, position error as dear as 1 m/s² of input
        velocity: m/s, velocity error as dear as 1 m/s² of input

    Raises:
        InputError: the errors are so far from one another that there is no answer in floating point.
    """
    lag = rate_delay(envelope, model) + 0.5 * held
    gain = attitude_gain / lag
    dynamics, inputs = deviations(gain, lag, STEP)
    weight, effort = np.diag([position**-2, velocity**-2, 0.0, 0.0]), np.eye(1)
    _, final = stationary(dynamics, inputs, weight, effort)
    a, b, q, r, p = (np.asarray(np.kron(part, AXES), np.float64) for part in (dynamics, inputs, weight, effort, final))
    condensed = condense(a, b, q, r, p, STEPS)
    forces, least, most = thrust_rows(model)
    headings, fastest = speed_rows(envelope)
    checked = range(CHECKED - 1, STEPS, CHECKED)
    speeds = [headings @ condensed.forced[k, 3:6] for k in checked]
    rows = np.vstack([np.kron(np.eye(STEPS), forces), *speeds])
    program = Program(condensed.hessian, rows, np.arange(len(rows)) >= STEPS * len(forces), EXCESS_PRICE)
    coasting = condensed.free[CHECKED - 1 :: CHECKED, 3:6]
    gains = np.asarray(np.linalg.solve(condensed.hessian, condensed.coupling)[:3], np.float64)
    return Design(held, gain, condensed, forces, least, most, headings, fastest, program, coasting, gains)


def around(sides: int) -> Array:
    """Return unit vectors all around in the plane, (sides, 2)."""
    angles = 2 * math.pi * np.arange(sides) / sides
    return np.column_stack([np.cos(angles), np.sin(angles)])


def thrust_rows(model: Model) -> tuple[Array, Array, Array]:
    """Return rows and bounds of a thrust vector f (m/s²): a polyhedron around what thrust and tilt θ allow.

    Lift f_z within the thrust bounds; n·f_xy <= f_z tan θ; n·f_xy sin θ + f_z cos θ <= greatest thrust, for the normals
    n of a polygon.
    """
    normals, flat = around(SIDES), np.zeros((SIDES, 1))
    tilt = np.column_stack([normals, flat - math.tan(model.tilt_max)])
    reach = np.column_stack([normals * math.sin(model.tilt_max), flat + math.cos(model.tilt_max)])
    rows = np.vstack([[[0.0, 0.0, 1.0]], tilt, reach])
    least = np.concatenate([[model.thrust_min], np.full(2 * SIDES, -np.inf)])
    most = np.concatenate([[model.thrust_max], np.zeros(SIDES), np.full(SIDES, model.thrust_max)])
    return rows, least, most


def speed_rows(envelope: Envelope) -> tuple[Array, Array]:
    """Return directions, and the speed (m/s) that a velocity may have along them either way."""
    half = around(SIDES)[: SIDES // 2]
    headings = np.vstack([np.column_stack([half, np.zeros(len(half))]), [[0.0, 0.0, 1.0]]])
    return headings, np.append(np.full(len(half), envelope.speed), envelope.speed_vertical)
