"""Flatness against the embedded simulator's own equations of motion, finite differences and closed forms."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from crosstrack.errors import InputError
from crosstrack.sim.airframe import RACER
from crosstrack.sim.dynamics import derivative
from crosstrack.sim.fleet import fleet
from crosstrack.trajectory.flatness.ability import Ability, demands, largest_thrust
from crosstrack.trajectory.flatness.flat import flatten
from crosstrack.trajectory.flatness.yaw import Fixed, along_velocity, towards
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import GRAVITY, Air, Array, Limits

component = st.floats(-6, 6).map(lambda x: round(x, 2))
drags = st.tuples(st.floats(0, 0.8), st.floats(0, 0.8), st.floats(0, 0.3))
winds = st.tuples(st.floats(-6, 6), st.floats(-6, 6), st.floats(-2, 2))


def bend(middle: tuple[float, float, float], pace: float = 1.6) -> PiecewisePolynomial:
    points = np.array([[0.0, 0, 5], [5 + middle[0], middle[1], 5 + 0.3 * middle[2]], [12, 2, 6]])
    return minimum(points, np.array([0.0, pace, 2 * pace]), 4)


def parabola(acceleration: tuple[float, float, float]) -> PiecewisePolynomial:
    """Constant acceleration for two seconds, from the origin and a velocity along x."""
    half = 0.5 * np.array(acceleration)
    return PiecewisePolynomial(np.array([2.0]), np.array([[[0.0, 0, 0], [3.0, 0, 0], half]]))


def flown(row: Any, attitude: Array, velocity: Array, rate: Array, wrench: Any, wind: Any) -> Array:
    """Return the derivative of a body as the simulator has it."""
    body: Any = (0.0, 0.0, 100.0, *velocity.tolist(), *attitude.tolist(), *rate.tolist())
    blow: Any = tuple(float(w) for w in wind)
    return np.array(derivative(body, wrench, blow, row))


@settings(max_examples=10)
@given(st.tuples(component, component, component), drags, winds, st.floats(-3, 3))
def test_the_simulator_flies_what_flatness_says(
    middle: tuple[float, float, float],
    drag: tuple[float, float, float],
    wind: tuple[float, float, float],
    yaw: float,
) -> None:
    """Newton and Euler as the embedded airframe has them: thrust and torque give the accelerations of the curve."""
    curve = bend(middle)
    times = np.linspace(0.1, curve.duration - 0.1, 7)
    flat = flatten(curve, times, Fixed(yaw), drag, wind)
    row = fleet(RACER, Air(), Limits(), ground=-1e6)[0]
    rotor_sum = 4 * RACER.rotor_speed_hover
    row["body_drag"], row["rotor_drag"] = 0.0, np.array(drag) * RACER.mass / rotor_sum
    inertia = np.array(RACER.inertia)
    for k, time in enumerate(times):
        rate, angular = flat.rate[k], flat.angular_acceleration[k]
        torque = inertia * angular + np.cross(rate, inertia * rate)
        wrench = (float(RACER.mass * flat.thrust[k]), *torque.tolist(), rotor_sum)
        change = flown(row, flat.attitude[k], curve(time, 1), rate, wrench, wind)
        np.testing.assert_allclose(change[3:6], curve(time, 2), atol=1e-9)
        np.testing.assert_allclose(change[10:13], angular, atol=1e-9 * (1 + np.abs(angular).max()))


@settings(max_examples=15)
@given(st.tuples(component, component, component), drags, winds, st.sampled_from(["fixed", "velocity", "towards"]))
def test_rates_are_derivatives_of_the_attitude(
    middle: tuple[float, float, float], drag: tuple[float, float, float], wind: tuple[float, float, float], look: str
) -> None:
    curve = bend(middle)
    yaw = {
        "fixed": Fixed(0.7),
        "velocity": along_velocity(curve),
        "towards": towards(curve, np.array([4.0, 30.0])),
    }[look]
    h = 1e-5
    middles = np.array([0.4, 0.9, 1.3, 2.1, 2.9])
    times = (middles[:, None] + h * np.array([-1, 0, 1])).ravel()
    flat = flatten(curve, times, yaw, drag, wind)
    turn = Rotation.from_quat(flat.attitude)
    rate = (turn[0::3].inv() * turn[2::3]).as_rotvec() / (2 * h)
    size = 1 + np.abs(flat.angular_acceleration).max()
    np.testing.assert_allclose(flat.rate[1::3], rate, atol=1e-5 * size)
    angular = (flat.rate[2::3] - flat.rate[0::3]) / (2 * h)
    np.testing.assert_allclose(flat.angular_acceleration[1::3], angular, atol=1e-3 * size)
    heading = turn[1::3].apply([1.0, 0, 0])
    off = np.arctan2(heading[:, 1], heading[:, 0]) - yaw(middles)
    np.testing.assert_allclose(np.exp(1j * off), 1, atol=1e-9)


@pytest.mark.parametrize("yaw", [0.0, 1.0, -2.5])
def test_a_level_circle_banks_by_the_centripetal_acceleration(yaw: float) -> None:
    """tan(tilt) = v² / (r g) and thrust g / cos(tilt); looking along the velocity ω = ψ' (0, -sin, cos)(tilt)."""
    radius, pulse = 4.0, 1.2

    class Circle:
        duration = 10.0

        def __call__(self, t: float | Array, order: int = 0) -> Array:
            phase = pulse * np.asarray(t) + order * math.pi / 2 + yaw
            return radius * pulse**order * np.stack([np.cos(phase), np.sin(phase), 0 * phase], axis=-1)

    flat = flatten(Circle(), np.linspace(1, 9, 20), along_velocity(Circle()))
    tilt = math.atan(radius * pulse**2 / GRAVITY)
    np.testing.assert_allclose(flat.tilt, tilt, rtol=1e-9)
    np.testing.assert_allclose(flat.thrust, GRAVITY / math.cos(tilt), rtol=1e-12)
    np.testing.assert_allclose(flat.rate, [[0, -pulse * math.sin(tilt), pulse * math.cos(tilt)]] * 20, atol=1e-9)
    np.testing.assert_allclose(flat.angular_acceleration, 0, atol=1e-8)


def test_terminal_velocity_is_flown_level_in_the_wind_alone() -> None:
    """At rest in a wind w, drag d pushes with d w: the tilt leans into it."""
    still = PiecewisePolynomial(np.array([1.0]), np.zeros((1, 1, 3)))
    flat = flatten(still, np.array([0.5]), drag=(0.3, 0.3, 0.3), wind=(4.0, 0, 0))
    up = Rotation.from_quat(flat.attitude).apply([0.0, 0, 1])[0]
    assert math.atan2(-up[0], up[2]) == pytest.approx(math.atan(0.3 * 4 / GRAVITY))
    assert flat.thrust[0] == pytest.approx(math.hypot(0.3 * 4, GRAVITY))


def test_attitudes_do_not_jump_when_the_yaw_goes_round() -> None:
    def spinning(t: float | Array, order: int = 0) -> Array:
        return 3.0 * np.asarray(t, float) if order == 0 else np.full(np.shape(t), 3.0 if order == 1 else 0.0)

    flat = flatten(parabola((1.0, 1, 0)), np.linspace(0, 2, 400), spinning)
    assert np.linalg.norm(np.diff(flat.attitude, axis=0), axis=1).max() < 0.02


@pytest.mark.parametrize(
    ("acceleration", "words"),
    [
        ((0.0, 0.0, -GRAVITY), "free fall: the thrust is 0 m/s²"),
        ((0.0, 5.0, -GRAVITY), "points along the body's y axis"),
    ],
)
def test_a_singular_attitude_names_its_time(acceleration: tuple[float, float, float], words: str) -> None:
    with pytest.raises(InputError, match=f"t = 1.5 s: .*{words}"):
        flatten(parabola(acceleration), np.array([1.5, 1.6]))


def test_what_is_too_much_is_told_where_it_is_worst() -> None:
    curve = bend((0.0, 6.0, 3.0), pace=1.2)
    free = demands(curve, Ability())
    assert free.excesses == ()
    flat, low, most = free.flat, float(free.flat.thrust.min()), float(free.flat.thrust.max())
    found = demands(curve, Ability(thrust_min=low + 1, thrust_max=most - 1, tilt=0.1, rate=0.2, rate_yaw=1e-3)).excesses
    assert [excess.quantity for excess in found] == ["thrust_min", "thrust_max", "tilt", "rate", "rate_yaw"]
    assert found[1].value == most
    assert found[1].time == flat.time[flat.thrust.argmax()]
    assert f"thrust_max {most:.4g} at t = " in str(found[1])


@settings(max_examples=20)
@given(st.tuples(component, component, component))
def test_the_certified_thrust_encloses_the_samples(middle: tuple[float, float, float]) -> None:
    curve = bend(middle)
    most = largest_thrust(curve)
    force = curve(np.linspace(0, curve.duration, 20_001), 2) + [0, 0, GRAVITY]
    sampled = float(np.linalg.norm(force, axis=1).max())
    assert sampled <= most.value <= sampled * (1 + 1e-5)
    assert flatten(curve, np.array([most.time])).thrust[0] == pytest.approx(most.value, rel=1e-7)
