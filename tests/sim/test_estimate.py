"""The state estimate: delayed truth plus white noise."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from crosstrack.sim import estimate
from crosstrack.types import Noise, State


def turning(time: float) -> State:
    """Fly on a straight line at constant acceleration while turning about z at 2 rad/s."""
    velocity = np.array([3.0, -1.0, 0.5])
    return State(
        time=time,
        position=velocity * time,
        velocity=velocity + np.array([1.0, 2.0, 0.0]) * time,
        attitude=np.array([0, 0, math.sin(time), math.cos(time)]),
        rate=np.array([0, 0, 2.0]),
        acceleration=np.array([1.0, 2.0, 0.0]),
        rotor_speeds=np.full(4, 500.0) + time,
    )


def estimates(noise: Noise, times: NDArray[Any], seed: int = 0) -> list[State]:
    rng = np.random.default_rng(seed)
    memory = estimate.start(noise, turning(times[0]))
    found = []
    for time in times[1:]:
        seen, memory = estimate.step(memory, turning(time), rng)
        found.append(seen)
    return found


def test_without_noise_and_delay_it_is_the_truth_itself() -> None:
    rng = np.random.default_rng(0)
    before = rng.bit_generator.state
    state = turning(1.0)
    memory = estimate.start(Noise(), turning(0.0))
    seen, after = estimate.step(memory, state, rng)
    assert seen is state
    assert after is memory
    assert rng.bit_generator.state == before


@settings(max_examples=30)
@given(delay=st.floats(0.001, 0.5), period=st.floats(0.005, 0.1))
def test_delay_returns_the_truth_that_long_ago(delay: float, period: float) -> None:
    times = np.arange(0, 1.0, period)
    for seen, now in zip(estimates(Noise(delay=delay), times), times[1:], strict=True):
        old = turning(max(0.0, now - delay))
        assert seen.time == now
        np.testing.assert_allclose(seen.position, old.position, atol=1e-12)
        np.testing.assert_allclose(seen.velocity, old.velocity, atol=1e-12)
        np.testing.assert_allclose(seen.rotor_speeds, old.rotor_speeds, atol=1e-9)
        assert np.linalg.norm(seen.attitude) == pytest.approx(1, abs=1e-14)
        # The chord of an arc of angle a errs in angle by less than a³/50 (here a = the half angle turned).
        angle = 2 * math.acos(min(1.0, abs(float(seen.attitude @ old.attitude))))
        assert angle <= 2 * period**3 / 50 + 1e-7


def test_delay_takes_the_short_way_between_attitudes_of_opposite_sign() -> None:
    first, second = turning(0.0), turning(0.02)
    flipped = State(0.02, second.position, second.velocity, -second.attitude, second.rate)
    first = State(0.0, first.position, first.velocity, first.attitude, first.rate)
    memory = estimate.start(Noise(delay=0.01), first)
    seen, _ = estimate.step(memory, flipped, np.random.default_rng(0))
    assert abs(float(seen.attitude @ turning(0.01).attitude)) == pytest.approx(1, abs=1e-12)


def test_delay_remembers_no_more_than_it_needs() -> None:
    memory = estimate.start(Noise(delay=0.1), turning(0.0))
    rng = np.random.default_rng(0)
    for time in np.arange(1, 500) * 0.02:
        _, memory = estimate.step(memory, turning(time), rng)
    assert len(memory.past) <= 8


def test_what_is_not_yet_old_enough_is_the_first_state() -> None:
    first = turning(0.0)
    memory = estimate.start(Noise(delay=0.1), first)
    rng = np.random.default_rng(0)
    for time in (0.0, 0.05, 0.1):  # asked for at once too
        seen, memory = estimate.step(memory, turning(time), rng)
        np.testing.assert_array_equal(seen.position, first.position)
        np.testing.assert_array_equal(seen.attitude, first.attitude)


def test_noise_is_white_with_the_stated_deviation() -> None:
    times = np.arange(0, 4001) * 0.02
    seen = estimates(Noise(position=0.3, velocity=0.05), times)
    truth = [turning(time) for time in times[1:]]
    position = np.array([a.position - b.position for a, b in zip(seen, truth, strict=True)])
    velocity = np.array([a.velocity - b.velocity for a, b in zip(seen, truth, strict=True)])
    errors = np.hstack([position / 0.3, velocity / 0.05])
    # Five standard errors of each statistic over 4000 samples.
    np.testing.assert_allclose(errors.mean(axis=0), 0, atol=5 / math.sqrt(4000))
    np.testing.assert_allclose(errors.var(axis=0), 1, atol=5 * math.sqrt(2 / 4000))
    correlation = np.corrcoef(np.hstack([errors[:-1], errors[1:]]).T)
    np.testing.assert_allclose(correlation, np.eye(12), atol=5 / math.sqrt(4000))
    assert all(np.array_equal(a.attitude, b.attitude) for a, b in zip(seen, truth, strict=True))


def test_same_seed_same_estimate() -> None:
    times = np.arange(0, 50) * 0.02
    noise = Noise(position=0.1, velocity=0.1, delay=0.05)
    first, again = estimates(noise, times, seed=7), estimates(noise, times, seed=7)
    other = estimates(noise, times, seed=8)
    assert all(np.array_equal(a.position, b.position) for a, b in zip(first, again, strict=True))
    assert not np.array_equal(first[0].position, other[0].position)
