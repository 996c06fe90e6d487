"""Predictive control: its model, its bounds, what it flies between them, and how closely."""

import math
from dataclasses import replace
from typing import Any

import flights
import numpy as np
import pytest
from flights import lag, rms
from scipy.integrate import solve_ivp

from crosstrack.errors import InputError
from crosstrack.flight.loop import fly
from crosstrack.flight.plan import Plan
from crosstrack.track import condensed
from crosstrack.track.attitude import drag_of, easing_of
from crosstrack.track.geometric import Geometric
from crosstrack.track.mpc import Mpc, MpcMemory, planned
from crosstrack.track.mpc_design import STEP, STEPS, Design, deviations, thrust_rows
from crosstrack.track.mpc_preview import deviation, preview
from crosstrack.track.reference import reference
from crosstrack.trajectory.flatness.flat import flatten
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import GRAVITY, Array, Limits, Mismatch, Model, Outcome, State, Wind
from crosstrack.vehicles.quadrotor import Quadrotor

LIMITS = Limits(speed=20.0, acceleration=20.0, tilt_deg=70.0)
LOOP = np.array([[0.0, 0, 10], [8, 5, 12], [16, 0, 10], [8, -5, 9], [0, 0, 10]])
LEVEL = np.array([0.0, 0.0, 0.0, 1.0])


def loop(speed: float, points: Array = LOOP) -> PiecewisePolynomial:
    """Minimum snap through points with a top speed (m/s)."""
    knots = np.array([0.0, 1.5, 2.5, 3.5, 5.0]) if len(points) == 5 else np.array([0.0, 1.0])
    curve = minimum(points, knots, 4)
    top = float(np.linalg.norm(curve(np.linspace(0, curve.duration, 1000), 1), axis=1).max())
    return minimum(points, knots * top / speed, 4)


def plan_along(curve: Any, tracker: Any = None, **options: Any) -> Plan:
    """Plan to fly a trajectory on a racer."""
    options = {"vehicle": Quadrotor(airframe="racer"), "limits": LIMITS, **options}
    return flights.plan_along(curve, tracker or Mpc(), **options)


def model_of(plan: Plan) -> Model:
    model = plan.course.envelope.model
    assert model is not None
    return model


def started(plan: Plan, **changes: Any) -> tuple[State, MpcMemory]:
    """Return a state at rest at the start of a plan, hovering, and the memory to begin with there."""
    spinning = np.full(4, math.sqrt(GRAVITY / model_of(plan).thrust_factor / 4))
    state = State(0.0, plan.scenario.position, np.zeros(3), LEVEL, np.zeros(3), np.zeros(3), spinning)
    memory: MpcMemory = plan.tracker.start(plan.course, state)
    return replace(state, **changes), memory


def bounded(plan: Plan, off: Array, since: float = 0.0, push: Array | None = None) -> tuple[Design, Array, Array]:
    """Return the program, the inputs (20, 3) it finds for a deviation, and the forces (20, 3) of the trajectory."""
    _, memory = started(plan)
    model, rows, push = model_of(plan), memory.clock.reference.rows, np.zeros(3) if push is None else push
    found = planned(memory.design, model, rows, since, push, off, memory.active)
    assert found.found
    forces, velocities = np.empty((STEPS, 3)), np.empty((5, 3))
    preview(rows, since, STEP, 4, push, model.drag, model.drag_quadratic, forces, velocities)
    return memory.design, found.inputs.reshape(STEPS, 3), forces


def test_deviations_evolve_as_their_differential_equation() -> None:
    gain, lag, step = 9.0, 0.07, 0.05
    a, b = deviations(gain, lag, step)
    start, held = np.array([0.3, -0.2, 1.0, 4.0]), 2.5

    def change(_: float, x: Array) -> list[float]:
        return [x[1], x[2], x[3], (gain * (held - x[2]) - x[3]) / lag]

    end = solve_ivp(change, (0, step), start, rtol=1e-11, atol=1e-12).y[:, -1]
    np.testing.assert_allclose(a @ start + b[:, 0] * held, end, rtol=1e-8)


def test_a_vehicle_that_flies_the_trajectory_has_no_deviation() -> None:
    """Attitude, thrust and rates from the inverse of the dynamics; of the jerk, what drag turns with it is left out."""
    curve = loop(8.0)
    rows = reference(curve, 0.0).rows
    times = np.linspace(0.3, 5.0, 9)  # as far as the stretch goes
    drag = np.array([0.5, 0.5, 0.0])
    flat = flatten(curve, times, drag=(0.5, 0.5, 0.0))
    for k, t in enumerate(times):
        out = np.empty(12)
        # The inverse takes the drag of rotors for that at hover, whatever the thrust.
        square, linear = np.zeros(3), drag / math.sqrt(flat.thrust[k] / GRAVITY)
        given = (flat.attitude[k], float(flat.thrust[k]), linear, square, flat.rate[k])
        deviation(rows, float(t), curve(t), curve(t, 1), *given, curve(t, 2), out)
        np.testing.assert_allclose(out[:9], 0, atol=1e-6)
        assert np.linalg.norm(out[9:]) < np.linalg.norm(flat.rate[k]) * 0.5 * np.linalg.norm(curve(t, 1))


def test_drag_eases_as_its_derivative() -> None:
    rng = np.random.default_rng(2)
    frame = np.linalg.qr(rng.normal(size=(3, 3)))[0].ravel()
    air, change, linear, square = rng.normal(size=3) * 5, rng.normal(size=3), rng.random(3), rng.random(3)
    axes: Any = tuple(frame)
    h = 1e-5
    later, sooner = (drag_of(axes, tuple(air + side * h * change), 1.3, linear, square) for side in (1, -1))
    eased = easing_of(axes, tuple(air), tuple(change), 1.3, linear, square)
    np.testing.assert_allclose(eased, (np.array(later) - sooner) / (2 * h), rtol=1e-6)


def test_on_the_trajectory_it_asks_for_what_the_geometric_law_asks_for() -> None:
    curve = loop(6.0)
    plan = plan_along(curve, vehicle=Quadrotor())
    t, model = 1.7, model_of(plan)
    assert not model.drag.any()  # so that the inverse of the dynamics needs no drag of rotors
    nominal = replace(model, drag_quadratic=np.zeros(3))
    plan = replace(plan, course=replace(plan.course, envelope=replace(plan.course.envelope, model=nominal)))
    flat = flatten(curve, np.array([t]))
    speeds = np.full(4, math.sqrt(float(flat.thrust[0]) / model.thrust_factor / 4))
    state, memory = started(plan)
    there = State(t, curve(t), curve(t, 1), flat.attitude[0], flat.rate[0], curve(t, 2), speeds)
    memory = replace(memory, known=curve(t, 2))
    command, _ = Mpc().step(memory, plan.course, there, 0.02)
    law = Geometric(integral_gain=0.0)
    wanted, _ = law.step(law.start(plan.course, state), plan.course, there, 0.02)
    np.testing.assert_allclose(command.rate, wanted.rate, atol=1e-6)
    assert command.thrust == pytest.approx(wanted.thrust, abs=1e-6)


def test_the_polyhedron_holds_what_thrust_and_tilt_allow_and_little_more() -> None:
    model = model_of(plan_along(loop(5.0)))
    rows, least, most = thrust_rows(model)
    rng = np.random.default_rng(3)
    forces = rng.uniform(-1, 1, (20000, 3)) * 1.2 * model.thrust_max
    sideways, lift = np.hypot(forces[:, 0], forces[:, 1]), forces[:, 2]
    inside = np.all((forces @ rows.T >= least) & (forces @ rows.T <= most), axis=1)
    size = np.linalg.norm(forces, axis=1)
    allowed = (lift >= model.thrust_min) & (sideways <= lift * math.tan(model.tilt_max)) & (size <= model.thrust_max)
    assert inside[allowed].all()
    corner = 1 / math.cos(math.pi / 8)
    assert (sideways[inside] <= lift[inside] * math.tan(model.tilt_max) * corner + 1e-9).all()
    assert (size[inside] <= model.thrust_max * corner / math.cos(model.tilt_max / 2) + 1e-9).all()
    assert 500 < allowed.sum() < inside.sum() < 1.5 * allowed.sum()


@pytest.mark.parametrize("seed", range(8))
def test_every_force_of_the_plan_is_one_it_may_ask_for(seed: int) -> None:
    rng = np.random.default_rng(seed)
    plan = plan_along(loop(10.0), limits=replace(LIMITS, tilt_deg=40.0))
    off = rng.normal(size=12) * np.repeat([3.0, 3.0, 2.0, 5.0], 3)
    push = rng.normal(size=3)
    design, inputs, forces = bounded(plan, off, float(rng.uniform(0, 3)), push)
    asked = (forces + inputs) @ design.forces.T
    assert (asked <= design.most + 1e-4).all()
    assert (asked >= design.least - 1e-4).all()
    free = -np.linalg.solve(design.condensed.hessian, design.condensed.coupling @ off).reshape(STEPS, 3)
    assert ((forces + free) @ design.forces.T > design.most + 1.0).any()  # the bounds mattered


def test_it_looks_ahead() -> None:
    """A turn that tilt forbids, half a second ahead, is begun now though nothing is wrong yet."""
    curve = loop(8.0)
    easy, tight = (plan_along(curve, limits=replace(LIMITS, tilt_deg=tilt)) for tilt in (70.0, 35.0))
    times = np.arange(0.2, 2.0, 0.1)
    for plan, moves in ((easy, False), (tight, True)):
        most = max(float(np.abs(bounded(plan, np.zeros(12), float(t))[1][0]).max()) for t in times)
        assert (most > 0.3) == moves


def test_catching_up_it_keeps_to_the_speed_limit() -> None:
    curve = minimum(np.array([[0.0, 0, 10], [60, 0, 10]]), np.array([0.0, 11.0]), 4)
    fastest = []
    for limit in (12.5, 20.0):
        plan = plan_along(curve, limits=replace(LIMITS, speed=limit))
        behind = replace(plan.scenario, position=curve(0.0) - [15.0, 0, 0])
        flight = fly(replace(plan, scenario=behind))
        assert flight.outcome is Outcome.ARRIVED
        fastest.append(float(np.linalg.norm(flight.record.velocity, axis=1).max()))
    assert fastest[0] < 12.9
    assert fastest[1] > 13.5


def test_no_offset_stays_in_steady_wind_with_another_mass() -> None:
    here = PiecewisePolynomial(np.array([6.0]), np.array([[[0.0, 0, 10], [0.5, 0, 0]]]))
    plan = plan_along(here, wind=Wind(mean=(4.0, -3.0, 0.0)), mismatch=Mismatch(mass=1.15, drag=1.2))
    record = fly(plan).record
    late = (record.time > 4.5) & (record.time < 5.9)
    miss = np.linalg.norm(record.position - here(record.time), axis=1)
    assert miss[record.time < 2.0].max() > 0.02
    assert miss[late].max() < 0.002


def test_weights_without_an_answer_are_said() -> None:
    plan = plan_along(loop(5.0))
    state, _ = started(plan)
    with pytest.raises(InputError, match="too far apart"):
        Mpc(position_error=1e-30).start(plan.course, state)


def test_where_the_solver_gives_up_it_flies_the_law_without_bounds(monkeypatch: pytest.MonkeyPatch) -> None:
    curve = loop(6.0)
    plan = plan_along(curve)
    state, memory = started(plan, position=curve(0.0) + [0.05, 0.02, -0.03])
    solved, after = Mpc().step(memory, plan.course, state, 0.02)
    assert after.missed == 0
    monkeypatch.setattr(condensed, "ITERATIONS", 0)
    _, poor = started(plan)
    missed, after = Mpc().step(poor, plan.course, state, 0.02)
    assert after.missed == 1
    np.testing.assert_allclose(missed.rate, solved.rate, atol=1e-6)  # no bound was near
    assert missed.thrust == pytest.approx(solved.thrust, abs=1e-6)
    assert fly(plan).outcome is Outcome.ARRIVED


@pytest.mark.parametrize(
    ("rate", "mismatch", "wind", "bound"),
    [
        (50.0, Mismatch(), Wind(), 0.035),
        (100.0, Mismatch(), Wind(), 0.035),
        (20.0, Mismatch(motor_time=1.5), Wind(), 0.06),
        (50.0, Mismatch(mass=1.1, drag=1.2), Wind(mean=(2.0, 3.0, 0.0), gusts="moderate"), 0.09),
    ],
)
def test_two_g_at_13_metres_a_second(rate: float, mismatch: Mismatch, wind: Wind, bound: float) -> None:
    eight = [[10, 6, 12], [20, 0, 10], [30, -6, 8], [40, 0, 10], [30, 6, 12], [20, 0, 10], [10, -6, 8]]
    points = np.array([[0, 0, 10], *eight, [0, 0, 10]]) * [1.4, 1.4, 1.0]
    knots = np.concatenate([[0.0], np.cumsum([1.6, 1, 1, 1, 1, 1, 1, 1.6])])
    curve = minimum(points, knots, 4)
    top = float(np.linalg.norm(curve(np.linspace(0, curve.duration, 1000), 1), axis=1).max())
    curve = minimum(points, knots * top / 13, 4)
    hardest = np.linalg.norm(curve(np.linspace(0, curve.duration, 1000), 2) + [0, 0, GRAVITY], axis=1).max()
    assert 1.8 * GRAVITY < hardest < 2.2 * GRAVITY
    flight = fly(plan_along(curve, mismatch=mismatch, wind=wind, rate=rate))
    assert flight.outcome is Outcome.ARRIVED
    assert rms(lag(flight, curve)) < bound
