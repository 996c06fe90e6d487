"""What flying a reference takes, against differences along a trajectory."""

from typing import Any

import numpy as np
import pytest
from flights import tour

from crosstrack.track.linear import flying
from crosstrack.track.reference import motion, reference


@pytest.mark.parametrize(("drag", "bound"), [(0.0, 1e-4), (0.02, 0.02), (0.06, 0.08)])
def test_the_rates_of_a_reference_are_those_its_axes_turn_at(drag: float, bound: float) -> None:
    """With drag of the body, whose change with the speed turns the thrust vector; that with the attitude is left."""
    curve, none, square = tour(8.0), np.zeros(3), np.full(3, drag)
    stretch, limits, h = reference(curve, 0.0, 2.0), (0.1, 90.0, 50.0), 1e-4

    def flown(since: float) -> tuple[Any, Any, Any]:
        return flying(motion(stretch.rows, since), limits, none, square)

    for since in np.linspace(0.5, 4.0, 15):
        axes, before, after = (np.array(flown(since + s)[0]).reshape(3, 3).T for s in (0, -h, h))
        swing = axes.T @ (after - before) / (2 * h)
        wanted = [swing[2, 1], swing[0, 2], swing[1, 0]]
        np.testing.assert_allclose(flown(since)[2], wanted, atol=bound)
