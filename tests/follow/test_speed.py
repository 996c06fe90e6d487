"""Speed profiles: bounds held everywhere, times in closed form, and no faster profile exists."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosstrack.follow.speed import SETTLING, SpeedProfile, profile


def straight(length: float, limit: float, acceleration: float) -> SpeedProfile:
    return profile(np.array([length]), np.array([limit]), np.array([np.inf, np.inf]), np.array([acceleration]))


def test_a_straight_leg_is_a_trapezoid() -> None:
    speed = straight(100.0, 5.0, 2.0)
    settle = 2.0 / SETTLING**2
    top = SETTLING * settle
    # From 0 to 5 and from 5 down to the settling speed at 2 m/s², cruise between.
    ramps = 5**2 / 4 + (5**2 - top**2) / 4
    cruise = (100 - settle - ramps) / 5
    assert speed(50.0) == pytest.approx(5.0)
    arrival = 5 / 2 + cruise + (5 - top) / 2
    s = np.linspace(0, 100 - settle, 200001)
    pace = 1 / speed((s[1:] + s[:-1]) / 2)
    assert float(np.sum(pace * np.diff(s))) == pytest.approx(arrival, rel=1e-3)
    assert float(speed(0.0)) == 0
    assert float(speed(100.0)) == pytest.approx(0, abs=1e-6)


def test_duration_is_the_integral_of_the_pace() -> None:
    speed = straight(30.0, 8.0, 3.0)
    s = np.linspace(0, 30, 2_000_001)
    middle = (s[1:] + s[:-1]) / 2
    assert speed.duration == pytest.approx(float(np.sum(np.diff(s) / speed(middle))), rel=1e-3)


pieces = st.lists(
    st.tuples(st.floats(0.05, 20), st.floats(0.2, 15), st.floats(0.5, 10), st.floats(0.2, 10)), min_size=1, max_size=12
)


@given(pieces)
def test_bounds_hold_and_none_is_faster(rows: list[tuple[float, float, float, float]]) -> None:
    lengths, limits, accelerations, inner = (np.array(column) for column in zip(*rows, strict=True))
    corners = np.concatenate([inner, [np.inf]])
    speed = profile(lengths, limits, corners, accelerations)
    knots = np.concatenate([[0], np.cumsum(lengths)])
    s = np.linspace(0, knots[-1], 20001)
    which = np.clip(np.searchsorted(knots, s, side="right") - 1, 0, len(lengths) - 1)
    v = speed(s)
    assert (v <= limits[which] * (1 + 1e-9) + 1e-9).all()
    left = knots[-1] - s
    distance = min(0.5 * knots[-1], accelerations[-1] / SETTLING**2)
    near = (left >= 0.1 * distance) & (left <= distance)
    assert (v[near] <= SETTLING * left[near] * 1.07 + 1e-6).all()
    assert (np.abs(speed(s, 1)) <= accelerations.max() * (1 + 1e-6)).all()
    # Brute force: the greatest speed on a grid that brakes and accelerates within bounds is nowhere beaten.
    grid = np.minimum(limits[which], np.inf) ** 2
    for k, bound in zip(np.searchsorted(s, knots), corners, strict=True):
        grid[min(k, len(s) - 1)] = min(grid[min(k, len(s) - 1)], bound**2)
    grid[0] = grid[-1] = 0
    step = s[1] - s[0]
    for i in range(1, len(s)):
        grid[i] = min(grid[i], grid[i - 1] + 2 * accelerations[which[i - 1]] * step)
    for i in range(len(s) - 2, -1, -1):
        grid[i] = min(grid[i], grid[i + 1] + 2 * accelerations[which[i]] * step)
    slack = 4 * accelerations.max() * step
    assert (v**2 <= grid + slack + 1e-6).all()
    settled = left > accelerations[-1] / SETTLING**2 + (limits.max() / SETTLING)
    assert (v[settled] ** 2 >= grid[settled] - 2 * accelerations.max() * (1 + step) - 1e-6).all()
