"""Gusts against the closed forms of the Dryden spectra."""

import math
from itertools import pairwise
from typing import Any, Literal, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import integrate, linalg

from crosstrack.sim import turbulence
from crosstrack.types import Array, Wind

Level = Literal["none", "light", "moderate", "severe"]
FEET = 0.3048
EAST = np.array([1.0, 0.0, 0.0])


class Given:
    """Stands in for a random generator: gives the numbers it is told to."""

    def __init__(self, numbers: Array) -> None:
        self.numbers = numbers

    def standard_normal(self, count: int) -> Array:
        assert self.numbers.shape == (count,)
        return self.numbers


def advance(filters: Array, noise: Array, velocity: Array, height: float, duration: float) -> Array:
    memory = turbulence.Turbulence(np.zeros(3), 1.0, filters)
    rng = cast(np.random.Generator, Given(noise))
    return turbulence.step(memory, velocity, height, duration, rng)[1].filters


def transition(velocity: Array, height: float, duration: float) -> tuple[Array, Array]:
    """Return the matrices of a step: filters' = phi filters + noise_gain n."""
    zero, unit = np.zeros(5), np.eye(5)
    phi = np.array([advance(row, zero, velocity, height, duration) for row in unit]).T
    gain = np.array([advance(zero, row, velocity, height, duration) for row in unit]).T
    return phi, gain


def dryden(height: float, w20: float) -> tuple[float, float, float, float]:
    """Return sigma_u, sigma_w (m/s), L_u, L_w (m) of the standard, height in metres."""
    feet = min(1000.0, max(10.0, height / FEET))
    sigma_w = 0.1 * w20
    base = 0.177 + 0.000823 * feet
    return sigma_w / base**0.4, sigma_w, feet / base**1.2 * FEET, feet * FEET


steps = {
    "heading": st.floats(-math.pi, math.pi),
    "climb": st.floats(-5, 5),
    "speed": st.floats(0.01, 30),
    "height": st.floats(0, 500),
    "duration": st.floats(1e-4, 1000),
}


@given(**steps)
def test_step_keeps_the_field_stationary(
    heading: float, climb: float, speed: float, height: float, duration: float
) -> None:
    velocity = np.array([speed * math.cos(heading), speed * math.sin(heading), climb])
    phi, gain = transition(velocity, height, duration)
    np.testing.assert_allclose(phi @ phi.T + gain @ gain.T, np.eye(5), atol=1e-12)


@given(**steps)
def test_two_steps_are_one_step_of_their_length(
    heading: float, climb: float, speed: float, height: float, duration: float
) -> None:
    velocity = np.array([speed * math.cos(heading), speed * math.sin(heading), climb])
    phi, gain = transition(velocity, height, duration)
    phi_whole, gain_whole = transition(velocity, height, 3 * duration)
    thrice = phi @ phi @ phi
    spread = gain @ gain.T
    np.testing.assert_allclose(phi_whole, thrice, atol=1e-12)
    twice = spread + phi @ spread @ phi.T
    np.testing.assert_allclose(gain_whole @ gain_whole.T, spread + phi @ twice @ phi.T, atol=1e-12)


@pytest.mark.parametrize("distance", [0.01, 1.0, 30.0, 400.0])
def test_step_is_the_matrix_exponential_of_the_filter(distance: float) -> None:
    # Lateral filter in controllable form: input n, states (p, p'), (1 + L d/dr)² p = n, gust = p + √3 L p'.
    height = 60.0
    _, _, length, _ = dryden(height, 1.0)
    drift = np.array([[0, 1], [-1, -2]])
    covariance = linalg.solve_continuous_lyapunov(drift, -np.diag([0, 1.0]))
    output = np.array([1, math.sqrt(3)])
    later = output @ linalg.expm(drift * distance / length) @ covariance @ output
    phi, _ = transition(EAST, height, distance)
    assert phi[1, 1] == pytest.approx(later / (output @ covariance @ output), abs=1e-13)


def correlation(height: float, distance: float) -> tuple[float, float, float]:
    phi, _ = transition(EAST, height, distance)
    return phi[0, 0], phi[1, 1], phi[2, 2]


@pytest.mark.parametrize("height", [15.0, 60.0, 250.0])
def test_correlation_is_the_transform_of_the_spectrum(height: float) -> None:
    _, _, along, vertical = dryden(height, 1.0)

    def longitudinal(x: float) -> float:
        return 2 / math.pi / (1 + x * x)

    def transverse(x: float) -> float:
        return (1 + 3 * x * x) / (1 + x * x) ** 2 / math.pi

    for distance in (0.3, 10.0, 150.0):
        found = correlation(height, distance)
        for value, spectrum, length in zip(
            found, (longitudinal, transverse, transverse), (along, along, vertical), strict=True
        ):
            # Cosine transform over the wave number, x = Ω L from 0 to infinity.
            expected, _ = integrate.quad(spectrum, 0, np.inf, weight="cos", wvar=distance / length, limlst=200)
            assert value == pytest.approx(expected, abs=1e-6)


def test_correlation_lengths_are_those_of_the_standard() -> None:
    # The integral of the correlation is π/2 times the spectrum at zero: L along and L/2 across the airspeed.
    height = 30.0
    _, _, along, vertical = dryden(height, 1.0)
    distances = np.linspace(1e-9, 30 * along, 3001)
    curves = np.array([correlation(height, distance) for distance in distances])
    areas = integrate.simpson(curves, x=distances, axis=0)
    np.testing.assert_allclose(areas, [along, along / 2, vertical / 2], rtol=1e-4)


@pytest.mark.parametrize(("gusts", "knots"), [("light", 15), ("moderate", 30), ("severe", 45)])
@pytest.mark.parametrize("height", [1.0, 20.0, 150.0, 304.8, 900.0])
def test_gusts_have_the_variance_of_the_standard(gusts: Level, knots: float, height: float) -> None:
    memory = turbulence.start(Wind(gusts=gusts), np.random.default_rng(1))
    unit = turbulence.Turbulence(memory.mean, memory.intensity, np.ones(5))
    gust, _ = turbulence.step(unit, EAST, height, 0.0, np.random.default_rng(1))
    sigma_u, sigma_w, _, _ = dryden(height, knots * 0.514444)
    np.testing.assert_allclose(gust, [sigma_u, sigma_u, sigma_w], rtol=1e-5)


def flown(count: int, duration: float, velocity: Array, seed: int) -> Array:
    rng = np.random.default_rng(seed)
    memory = turbulence.start(Wind(mean=(2.0, 0.0, 0.0), gusts="severe"), rng)
    found = np.empty((count, 3))
    for i in range(count):
        found[i], memory = turbulence.step(memory, velocity, 20.0, duration, rng)
    return found


def test_a_long_flight_has_the_spectrum_of_the_standard() -> None:
    # Southwards through air that moves east: u points along the airspeed, v across.
    velocity = np.array([2.0, -12.0, 0.0])
    airspeed, period, count = 12.0, 0.5, 40_000
    gusts = flown(count, period, velocity, seed=5)
    sigma_u, sigma_w, along, vertical = dryden(20.0, 45 * 0.514444)
    lag = int(along / airspeed / period) // 2
    distance = lag * period * airspeed
    covariance = (gusts[:-lag].T @ gusts[lag:]) / (count - lag)
    a, b = distance / along, distance / vertical
    expected = np.diag(
        [
            sigma_u**2 * math.exp(-a) * (1 - a / 2),  # across: east
            sigma_u**2 * math.exp(-a),  # along: south
            sigma_w**2 * math.exp(-b) * (1 - b / 2),
        ]
    )
    # About 40000 · 6 m / L independent samples: five standard errors.
    independent = count * period * airspeed / (2 * along)
    np.testing.assert_allclose(covariance, expected, atol=5 * sigma_u**2 / math.sqrt(independent))
    np.testing.assert_allclose(
        gusts.var(axis=0),
        [sigma_u**2, sigma_u**2, sigma_w**2],
        atol=5 * sigma_u**2 * math.sqrt(2 / independent),
    )


def test_drifting_with_the_wind_sees_a_frozen_field() -> None:
    rng = np.random.default_rng(2)
    memory = turbulence.start(Wind(mean=(3.0, -4.0, 0.0), gusts="moderate"), rng)
    first, memory = turbulence.step(memory, np.array([3.0, -4.0, 0.0]), 30.0, 0.02, rng)
    for _ in range(100):
        gust, memory = turbulence.step(memory, np.array([3.0, -4.0, 0.0]), 30.0, 1.0, rng)
        np.testing.assert_array_equal(gust, first)
    assert np.abs(first).max() > 0


@given(turn=st.floats(-math.pi, math.pi))
def test_turning_makes_no_jump(turn: float) -> None:
    rng = np.random.default_rng(4)
    memory = turbulence.start(Wind(gusts="severe"), rng)
    before, memory = turbulence.step(memory, np.array([8.0, 0.0, 0.0]), 30.0, 0.02, rng)
    after, _ = turbulence.step(memory, 8 * np.array([math.cos(turn), math.sin(turn), 0.0]), 30.0, 1e-12, rng)
    np.testing.assert_allclose(after, before, atol=1e-4)


def test_hovering_in_wind_and_flying_in_still_air_see_the_same_gusts() -> None:
    hovering = turbulence.start(Wind(mean=(-6.0, 0.0, 0.0), gusts="light"), np.random.default_rng(9))
    flying = turbulence.start(Wind(gusts="light"), np.random.default_rng(9))
    one, other = np.random.default_rng(10), np.random.default_rng(10)
    for _ in range(20):
        a, hovering = turbulence.step(hovering, np.zeros(3), 12.0, 0.02, one)
        b, flying = turbulence.step(flying, np.array([6.0, 0.0, 0.0]), 12.0, 0.02, other)
        np.testing.assert_allclose(a, b, rtol=1e-12)


def test_no_gusts_draw_nothing() -> None:
    rng = np.random.default_rng(0)
    memory = turbulence.start(Wind(mean=(5.0, 0.0, 0.0)), rng)
    before: Any = rng.bit_generator.state
    for height, after in pairwise((1.0, 50.0, 900.0)):
        gust, memory = turbulence.step(memory, EAST * after, height, 0.02, rng)
        np.testing.assert_array_equal(gust, 0)
    assert rng.bit_generator.state == before


def test_same_seed_same_gusts() -> None:
    first, again, other = (flown(50, 0.02, EAST * 9, seed) for seed in (3, 3, 4))
    np.testing.assert_array_equal(first, again)
    assert not np.array_equal(first, other)
