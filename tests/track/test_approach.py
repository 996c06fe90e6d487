"""What is asked for where the vehicle cannot do everything: the approach from far off, and what limits leave."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crosstrack.track.approach import SIDEWAYS, affordable, eased


@given(st.floats(0.01, 100), st.floats(0.2, 5), st.floats(0.1, 3))
def test_an_eased_error_is_approached_with_a_braking_that_is_never_more(far: float, gain: float, reach: float) -> None:
    """Along e' = -gain · eased(e) the deceleration is gain² reach beyond the reach, and less within."""
    step = 1e-5 * far
    speed = [gain * eased((0.0, d, 0.0), reach)[1] for d in (far - step, far, far + step)]
    slope = (speed[2] - speed[0]) / (2 * step)
    assert slope * speed[1] <= gain**2 * reach * (1 + 1e-3)
    if far > 1.01 * reach:
        assert slope * speed[1] == pytest.approx(gain**2 * reach, rel=1e-3)
    elif far < 0.99 * reach:
        assert speed[1] == pytest.approx(gain * far)


@given(st.lists(st.floats(-60, 60), min_size=3, max_size=3), st.floats(0.1, 3))
def test_height_comes_first_but_leaves_something_to_sideways_motion(values: list[float], tilt: float) -> None:
    least, most = 3.0, 16.0
    f = np.array(values)
    g = np.array(affordable((f[0], f[1], f[2]), (least, most, tilt)))
    sideways, wanted = float(np.hypot(*g[:2])), float(np.hypot(*f[:2]))
    assert np.linalg.norm(g) <= most * (1 + 1e-9)
    assert sideways <= g[2] * tilt * (1 + 1e-9)
    assert g[2] >= least
    assert abs(g[0] * f[1] - g[1] * f[0]) <= 1e-9 * (1 + wanted**2)  # in the direction asked for
    if wanted <= f[2] * tilt and np.linalg.norm(f) <= most and f[2] >= least:
        np.testing.assert_allclose(g, f, rtol=1e-9, atol=1e-12)
    if f[2] >= most:
        kept = most * min(SIDEWAYS, math.sin(math.atan(tilt)))
        assert sideways == pytest.approx(min(wanted, kept), rel=1e-9, abs=1e-6)
