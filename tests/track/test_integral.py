"""Conditional integration, in the direction that is missing alone."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from crosstrack.track.integral import accumulate


@given(st.lists(st.floats(-9, 9), min_size=6, max_size=6), st.floats(0.001, 1))
def test_the_integral_never_asks_for_more_of_what_is_missing(values: list[float], gain: float) -> None:
    error, missing = np.array(values[:3]), np.array(values[3:])
    total = np.zeros(3)
    accumulate(total, tuple(error), tuple(missing), gain)
    tiny = 1e-9 * (1 + np.linalg.norm(error)) * (1 + np.linalg.norm(missing))
    assert total @ missing <= tiny or missing @ missing <= 1e-12
    # What it leaves out is along what is missing alone, and nothing where that is none.
    assert np.linalg.norm(np.cross(total - gain * error, missing)) <= tiny
    free = np.zeros(3)
    accumulate(free, tuple(error), (0.0, 0.0, 0.0), gain)
    np.testing.assert_array_equal(free, gain * error)
