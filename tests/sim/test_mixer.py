"""The mixer: what does not fit goes in order of need."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from crosstrack.sim.airframe import AIRFRAMES, Airframe
from crosstrack.sim.autopilot import mix
from crosstrack.sim.fleet import fleet
from crosstrack.types import Air, Array, Limits

frames = st.sampled_from(list(AIRFRAMES.values()))
shares = st.floats(-2, 2)


def row_of(airframe: Airframe) -> Any:
    return fleet(airframe, Air(), Limits(), ground=0.0)[0]


def wrench(airframe: Airframe, thrusts: Array) -> Array:
    """Return thrust and torques of four rotors, by the geometry."""
    x, y, _ = np.array(airframe.rotor_positions).T
    rows = [np.ones(4), y, -x, airframe.torque_ratio * np.array(airframe.spins)]
    return np.array([row @ thrusts for row in rows])


def scales(airframe: Airframe, row: Any) -> Array:
    """Return thrust and torques about as large as the rotors can give."""
    arm = airframe.rotor_positions[2][0]
    span = float(row["thrust_max"] - row["thrust_min"])
    return span * np.array([4, 2 * arm, 2 * arm, 2 * airframe.torque_ratio])


def mixed(airframe: Airframe, asked: Array) -> Array:
    thrust, roll, pitch, yaw = (float(value) for value in asked)
    return np.array(mix(thrust, roll, pitch, yaw, row_of(airframe)), float)


@given(airframe=frames, share=st.tuples(shares, shares, shares, shares))
def test_rotors_stay_within_their_limits(airframe: Airframe, share: tuple[float, ...]) -> None:
    row = row_of(airframe)
    thrusts = mixed(airframe, np.array(share) * scales(airframe, row))
    slack = 1e-12 * float(row["thrust_max"])
    assert thrusts.min() >= float(row["thrust_min"]) - slack
    assert thrusts.max() <= float(row["thrust_max"]) + slack


@given(airframe=frames, seeds=st.tuples(*[st.floats(0, 1)] * 4))
def test_what_fits_is_given_exactly(airframe: Airframe, seeds: tuple[float, ...]) -> None:
    row = row_of(airframe)
    low, high = float(row["thrust_min"]), float(row["thrust_max"])
    thrusts = low + (high - low) * np.array(seeds)
    np.testing.assert_allclose(mixed(airframe, wrench(airframe, thrusts)), thrusts, atol=1e-9 * high)


@given(airframe=frames, share=st.tuples(shares, shares, shares, shares))
def test_roll_and_pitch_come_before_thrust_and_yaw(airframe: Airframe, share: tuple[float, ...]) -> None:
    row = row_of(airframe)
    low, high = float(row["thrust_min"]), float(row["thrust_max"])
    asked = np.array(share) * scales(airframe, row)
    found = wrench(airframe, mixed(airframe, asked))
    # What roll and pitch alone ask of the rotors, and the share of it that fits between idle and full speed.
    alone = airframe.allocation @ np.array([0, asked[1], asked[2], 0])
    fits = min(1.0, (high - low) / max(1e-12, float(np.ptp(alone))))
    tolerance = 1e-9 * float(np.abs(scales(airframe, row)[1]))
    np.testing.assert_allclose(found[1:3], fits * asked[1:3], atol=tolerance)


@given(airframe=frames, share=st.tuples(shares, shares, shares, shares))
def test_thrust_comes_before_yaw(airframe: Airframe, share: tuple[float, ...]) -> None:
    row = row_of(airframe)
    asked = np.array(share) * scales(airframe, row)
    found = wrench(airframe, mixed(airframe, asked))
    without_yaw = wrench(airframe, mixed(airframe, asked * [1, 1, 1, 0]))
    slack = 1e-9 * float(row["thrust_max"])
    np.testing.assert_allclose(found[1:3], without_yaw[1:3], atol=slack)
    assert abs(found[0] - asked[0]) <= abs(without_yaw[0] - asked[0]) + slack
    # Yaw keeps its direction and is never more than asked for.
    assert found[3] * asked[3] >= -1e-12 * asked[3] ** 2 - 1e-18
    assert abs(found[3]) <= abs(asked[3]) + 1e-9 * scales(airframe, row)[3]


@settings(max_examples=40)
@given(airframe=frames, share=st.tuples(shares, shares, shares, shares))
def test_thrust_is_the_nearest_that_any_share_of_the_yaw_allows(airframe: Airframe, share: tuple[float, ...]) -> None:
    row = row_of(airframe)
    asked = np.array(share) * scales(airframe, row)
    found = wrench(airframe, mixed(airframe, asked))
    # Linear program over (thrust, share of yaw, distance), with the roll and pitch that are flown.
    column = airframe.allocation @ np.array([0, found[1], found[2], 0])
    unit = airframe.allocation[:, 0]
    yaw = airframe.allocation[:, 3] * asked[3]
    low, high = float(row["thrust_min"]), float(row["thrust_max"])
    zero = np.zeros(4)
    rows = np.vstack(
        [
            np.column_stack([unit, yaw, zero]),
            -np.column_stack([unit, yaw, zero]),
            [[1, 0, -1], [-1, 0, -1]],
        ]
    )
    limits = np.concatenate([high - column, column - low, [asked[0], -asked[0]]]) + 1e-9 * high
    best = linprog([0, 0, 1], A_ub=rows, b_ub=limits, bounds=[(None, None), (0, 1), (0, None)])
    assert best.success
    assert abs(found[0] - asked[0]) == pytest.approx(best.fun, abs=1e-6 * high)


@given(airframe=frames, share=st.tuples(shares, shares, shares))
def test_thrust_gives_way_no_more_than_roll_and_pitch_need(airframe: Airframe, share: tuple[float, ...]) -> None:
    row = row_of(airframe)
    low, high = float(row["thrust_min"]), float(row["thrust_max"])
    asked = np.array([*share, 0.0]) * scales(airframe, row)
    thrusts = mixed(airframe, asked)
    missing = float(asked[0] - thrusts.sum())
    slack = 1e-9 * high
    if missing > slack:  # thrust was cut: some rotor is at full speed
        assert thrusts.max() == pytest.approx(high, abs=slack)
    elif missing < -slack:  # thrust was raised: some rotor idles
        assert thrusts.min() == pytest.approx(low, abs=slack)
