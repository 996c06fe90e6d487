"""The rigid body against MuJoCo, closed forms and conservation laws."""

import math
from typing import Any

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from crosstrack.sim.airframe import AIRFRAMES, CRAZYFLIE, GENERIC, RACER, Airframe
from crosstrack.sim.dynamics import step
from crosstrack.sim.fleet import fleet
from crosstrack.sim.kernel import STEP
from crosstrack.types import GRAVITY, Air, Array, Limits

every = pytest.mark.parametrize("airframe", AIRFRAMES.values(), ids=AIRFRAMES)
STILL = (0.0, 0.0, 0.0)
OFF = (0.0, 0.0, 0.0, 0.0)


def row_of(airframe: Airframe, air: Air | None = None, drag: bool = True) -> Any:
    """Return the row of a vehicle over ground far below."""
    rows = fleet(airframe, air or Air(), Limits(), ground=-1e6)
    if not drag:
        rows["body_drag"], rows["rotor_drag"] = 0, 0
    return rows[0]


def coast(
    body: Array,
    rotors: tuple[float, ...],
    row: Any,
    duration: float,
    h: float,
    targets: tuple[float, ...] | None = None,
    wind: tuple[float, ...] = STILL,
) -> tuple[Array, Array]:
    """Return body (13,) and rotor speeds (4,) after a time; rotors stay as they are unless given targets."""
    half_lag = math.exp(-0.5 * h / row["motor_time"])
    now: Any = tuple(float(value) for value in body)
    spinning: Any = rotors
    asked: Any = targets or rotors
    for _ in range(round(duration / h)):
        now, spinning = step(now, spinning, asked, wind, row, h, half_lag)  # type: ignore[arg-type]
    return np.array(now), np.array(spinning)


def tumbling(speed: float = 1.0) -> Array:
    """Return a body on the move, tilted, turning about every axis."""
    attitude = Rotation.from_euler("xyz", [0.3, -0.2, 0.7]).as_quat()
    rate = np.array([2.0, -1.5, 1.0]) * speed
    return np.concatenate([[1.0, -2.0, 5.0], [3.0, -1.0, 2.0], attitude, rate])


def apart(a: Array, b: Array) -> float:
    """Return the angle (rad) between two attitudes."""
    return float((Rotation.from_quat(a[6:10]).inv() * Rotation.from_quat(b[6:10])).magnitude())


def uneven(airframe: Airframe) -> tuple[float, ...]:
    """Return rotor speeds near hover that push and turn about every axis."""
    return tuple(airframe.rotor_speed_hover * np.array([1.02, 0.99, 1.005, 1.01]))


def mujoco_flight(airframe: Airframe, body: Array, rotors: tuple[float, ...], duration: float, h: float) -> Array:
    """Fly the same vehicle in MuJoCo: a free body, a motor at each rotor, no air."""
    ratio = airframe.torque_ratio
    sites = "".join(
        f'<site name="r{i}" pos="{x!r} {y!r} {z!r}"/>' for i, (x, y, z) in enumerate(airframe.rotor_positions)
    )
    motors = "".join(f'<motor site="r{i}" gear="0 0 1 0 0 {ratio * spin!r}"/>' for i, spin in enumerate(airframe.spins))
    inertia = " ".join(repr(value) for value in airframe.inertia)
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco>
          <compiler boundmass="0" boundinertia="0"/>
          <option timestep="{h!r}" integrator="RK4" gravity="0 0 {-GRAVITY!r}"/>
          <worldbody><body><freejoint/>
            <inertial pos="0 0 0" mass="{airframe.mass!r}" diaginertia="{inertia}"/>{sites}
          </body></worldbody>
          <actuator>{motors}</actuator>
        </mujoco>"""
    )
    data = mujoco.MjData(model)
    data.qpos[:3], data.qpos[3:] = body[:3], body[[9, 6, 7, 8]]
    data.qvel[:3], data.qvel[3:] = body[3:6], body[10:]
    data.ctrl[:] = airframe.thrust_coefficient * np.square(rotors)
    mujoco.mj_step(model, data, nstep=round(duration / h))
    return np.concatenate([data.qpos[:3], data.qvel[:3], data.qpos[[4, 5, 6, 3]], data.qvel[3:]])


SEA_LEVEL = Air(temperature=288.15, pressure=1.225 * 287.053 * 288.15)
"""Air in which the coefficients of the airframes hold exactly."""


@every
def test_free_flight_is_that_of_mujoco(airframe: Airframe) -> None:
    body, rotors = tumbling(), uneven(airframe)
    row = row_of(airframe, SEA_LEVEL, drag=False)
    oracle = mujoco_flight(airframe, body, rotors, 1.0, 1e-4)
    moved, turned = float(np.linalg.norm(oracle[:3] - body[:3])), apart(oracle, body)
    for h, tolerance in ((1e-3, 1e-6), (STEP, 1e-4)):
        found, _ = coast(body, rotors, row, 1.0, h)
        assert float(np.linalg.norm(found[:3] - oracle[:3])) < tolerance * moved
        assert apart(found, oracle) < tolerance * min(1.0, turned)
        np.testing.assert_allclose(found[3:6], oracle[3:6], atol=10 * tolerance)
        np.testing.assert_allclose(found[10:], oracle[10:], atol=10 * tolerance)


def observed_orders(airframe: Airframe) -> Array:
    """Return the orders of convergence of position and attitude to MuJoCo, steps of 20, 10 and 5 ms."""
    body, rotors = tumbling(3.0), uneven(airframe)
    row = row_of(airframe, SEA_LEVEL, drag=False)
    oracle = mujoco_flight(airframe, body, rotors, 1.0, 1e-4)
    errors = []
    for h in (0.02, 0.01, 0.005):
        found, _ = coast(body, rotors, row, 1.0, h)
        errors.append([np.linalg.norm(found[:3] - oracle[:3]), apart(found, oracle)])
    return np.asarray(np.log2(np.array(errors)[:-1] / np.array(errors)[1:]))


@every
def test_convergence_is_of_fourth_order(airframe: Airframe) -> None:
    np.testing.assert_allclose(observed_orders(airframe), 4, atol=0.1)


@every
def test_energy_is_kept_without_rotors_and_air(airframe: Airframe) -> None:
    row = row_of(airframe, drag=False)

    def energy(body: Array) -> float:
        spin = 0.5 * float(np.array(airframe.inertia) @ body[10:] ** 2)
        return airframe.mass * (0.5 * float(body[3:6] @ body[3:6]) + GRAVITY * float(body[2])) + spin

    start = tumbling(3.0)
    end, _ = coast(start, OFF, row, 2.0, STEP)
    assert energy(end) == pytest.approx(energy(start), rel=1e-8)
    spin = np.array(airframe.inertia)
    assert spin @ end[10:] ** 2 == pytest.approx(spin @ start[10:] ** 2, rel=1e-6)


@every
def test_angular_momentum_is_kept_in_the_world(airframe: Airframe) -> None:
    row = row_of(airframe)

    def momentum(body: Array) -> Array:
        world = Rotation.from_quat(body[6:10]).apply(np.array(airframe.inertia) * body[10:])
        return np.asarray(world)

    start = tumbling(3.0)
    end, _ = coast(start, OFF, row, 2.0, STEP)
    before = momentum(start)
    assert apart(end, start) > 0.5
    np.testing.assert_allclose(momentum(end), before, atol=1e-6 * float(np.linalg.norm(before)))


def test_spin_about_the_middle_axis_flips_over() -> None:
    # Racer: Ixx is between Iyy and Izz, so a spin about x is unstable (Dzhanibekov), about z stable.
    body = tumbling(0.0)
    body[10:] = 20.0, 1e-3, 0.0
    row = row_of(RACER, drag=False)
    rates = []
    for _ in range(60):
        body, _ = coast(body, OFF, row, 0.05, STEP)
        rates.append(body[10])
    assert min(rates) < -19
    body[10:] = 0.0, 1e-3, 20.0
    body, _ = coast(body, OFF, row, 3.0, STEP)
    assert body[12] == pytest.approx(20, rel=1e-6)


@every
def test_fall_is_that_of_gravity_alone_without_drag(airframe: Airframe) -> None:
    body = tumbling()
    end, _ = coast(body, OFF, row_of(airframe, drag=False), 1.0, STEP)
    fall = np.array([0, 0, -GRAVITY])
    np.testing.assert_allclose(end[:3], body[:3] + body[3:6] + 0.5 * fall, rtol=1e-12)
    np.testing.assert_allclose(end[3:6], body[3:6] + fall, rtol=1e-12)


def level(speed: tuple[float, float, float] = STILL) -> Array:
    return np.array([0, 0, 0, *speed, 0, 0, 0, 1.0, 0, 0, 0])


@pytest.mark.parametrize("pressure", [60000.0, 101325.0])
def test_fall_through_air_nears_its_terminal_velocity(pressure: float) -> None:
    air = Air(pressure=pressure)
    drag = GENERIC.body_drag[2] * air.pressure / (287.053 * air.temperature)
    terminal = math.sqrt(GENERIC.mass * GRAVITY / drag)
    row = row_of(GENERIC, air)
    for duration in (0.5, 2.0, 15.0):
        end, _ = coast(level(), OFF, row, duration, STEP)
        # m dv/dt = m g - k ρ v²: v = v∞ tanh(g t / v∞), z = -v∞²/g log cosh(g t / v∞)
        x = GRAVITY * duration / terminal
        assert end[5] == pytest.approx(-terminal * math.tanh(x), rel=1e-8)
        assert end[2] == pytest.approx(-(terminal**2) / GRAVITY * math.log(math.cosh(x)), rel=1e-8)


def test_air_that_moves_carries_the_body_along() -> None:
    wind = (4.0, -3.0, 0.0)
    row = row_of(GENERIC)
    still, _ = coast(level(), OFF, row, 1.0, STEP)
    blown, _ = coast(level(wind), OFF, row, 1.0, STEP, wind=wind)
    np.testing.assert_allclose(blown[3:6] - wind, still[3:6], atol=1e-12)
    pushed, _ = coast(level(), OFF, row, 1.0, STEP, wind=wind)
    assert pushed[3] > 0
    assert pushed[4] < 0


@pytest.mark.parametrize("airframe", [CRAZYFLIE, RACER], ids=["crazyflie", "racer"])
def test_rotor_drag_slows_level_flight_exponentially(airframe: Airframe) -> None:
    row = row_of(airframe, SEA_LEVEL)
    row["body_drag"] = 0
    speed = airframe.rotor_speed_hover
    end, _ = coast(level((2.0, -1.0, 0.0)), (speed,) * 4, row, 1.0, STEP)
    x, y, _ = airframe.rotor_drag
    total = 4 * speed / airframe.mass
    np.testing.assert_allclose(end[3:6], [2 * math.exp(-x * total), -math.exp(-y * total), 0], atol=1e-9)


@every
def test_rotors_relax_to_their_targets_and_lift_as_they_do(airframe: Airframe) -> None:
    row = row_of(airframe, SEA_LEVEL, drag=False)
    low, high, lag = 0.7 * airframe.rotor_speed_hover, 1.2 * airframe.rotor_speed_hover, airframe.motor_time
    duration = 0.1
    end, rotors = coast(level(), (low,) * 4, row, duration, STEP, targets=(high,) * 4)
    change, left = low - high, math.exp(-duration / lag)
    np.testing.assert_allclose(rotors, high + change * left, rtol=1e-12)
    # ∫ (high + change e^-t/τ)² dt
    impulse = high**2 * duration + 2 * high * change * lag * (1 - left) + 0.5 * change**2 * lag * (1 - left**2)
    lift = 4 * airframe.thrust_coefficient * impulse / airframe.mass
    assert end[5] + GRAVITY * duration == pytest.approx(lift, rel=2e-4 * (STEP / lag) ** 4 + 1e-6)


@pytest.mark.parametrize(("temperature", "pressure"), [(288.15, 101325.0), (310.0, 95000.0), (255.0, 54000.0)])
def test_thinner_air_lifts_less(temperature: float, pressure: float) -> None:
    row = row_of(RACER, Air(temperature, pressure), drag=False)
    speed = 1.1 * RACER.rotor_speed_hover
    end, _ = coast(level(), (speed,) * 4, row, 0.5, STEP)
    density = pressure / (287.053 * temperature)
    acceleration = 4 * RACER.thrust_coefficient * density / 1.225 * speed**2 / RACER.mass - GRAVITY
    assert end[5] == pytest.approx(0.5 * acceleration, rel=1e-9)


vectors = st.tuples(*[st.floats(-5, 5)] * 3).map(np.array)
bodies = st.tuples(vectors, vectors, vectors, vectors).map(
    lambda v: np.concatenate([v[0], v[1], Rotation.from_rotvec(v[2] / 3).as_quat(), v[3]])
)


@settings(max_examples=25)
@given(body=bodies, yaw=st.floats(-math.pi, math.pi), wind=vectors)
def test_north_is_like_east(body: Array, yaw: float, wind: Array) -> None:
    turn = Rotation.from_rotvec([0, 0, yaw])
    turned = np.concatenate(
        [
            turn.apply(body[:3]),
            turn.apply(body[3:6]),
            (turn * Rotation.from_quat(body[6:10])).as_quat(),
            body[10:],
        ]
    )
    row, rotors = row_of(RACER), uneven(RACER)
    one, _ = coast(body, rotors, row, 0.2, STEP, wind=tuple(wind))
    other, _ = coast(turned, rotors, row, 0.2, STEP, wind=tuple(turn.apply(wind)))
    np.testing.assert_allclose(other[:3], turn.apply(one[:3]), atol=1e-10)
    np.testing.assert_allclose(other[3:6], turn.apply(one[3:6]), atol=1e-10)
    np.testing.assert_allclose(other[10:], one[10:], atol=1e-10)
    attitude = (turn * Rotation.from_quat(one[6:10])).as_quat()
    assert abs(float(other[6:10] @ attitude)) == pytest.approx(1, abs=1e-12)


@settings(max_examples=25)
@given(body=bodies)
def test_flight_without_air_runs_backwards(body: Array) -> None:
    # Thrusts and torques are even in time: turn velocity and rate about, and the same law leads back.
    row, rotors = row_of(GENERIC, drag=False), uneven(GENERIC)
    there, _ = coast(body, rotors, row, 0.5, STEP)
    there[3:6] *= -1
    there[10:] *= -1
    back, _ = coast(there, rotors, row, 0.5, STEP)
    np.testing.assert_allclose(back[:3], body[:3], atol=1e-6)
    np.testing.assert_allclose(back[3:6], -body[3:6], atol=1e-6)
    np.testing.assert_allclose(back[10:], -body[10:], atol=1e-6)
    assert apart(back, body) < 1e-6


@settings(max_examples=25)
@given(body=bodies)
def test_attitude_stays_a_unit_quaternion(body: Array) -> None:
    end, _ = coast(body, uneven(CRAZYFLIE), row_of(CRAZYFLIE), 0.2, STEP)
    assert float(np.linalg.norm(end[6:10])) == pytest.approx(1, abs=1e-14)


@settings(max_examples=25)
@given(body=bodies)
def test_drag_only_takes_energy(body: Array) -> None:
    row = row_of(GENERIC)
    before = 0.5 * float(body[3:6] @ body[3:6]) + GRAVITY * float(body[2])
    end, _ = coast(body, OFF, row, 0.1, STEP)
    after = 0.5 * float(end[3:6] @ end[3:6]) + GRAVITY * float(end[2])
    assert after <= before + 1e-9
