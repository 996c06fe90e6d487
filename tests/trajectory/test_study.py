import numpy as np
import pytest

from crosstrack.errors import InputError
from crosstrack.trajectory.weights.study import distance, study

WAYPOINTS = np.array([[0, 0], [1, 2], [2, -1], [4, 8], [5, 2]], float)
TIMES = np.array([0, 0.5400960100096803, 1.3039071123489652, 3.5307800095935304, 5])
"""of the tutorial"""


def test_the_numbers_are_those_of_60_digit_arithmetic() -> None:
    (row,) = study(WAYPOINTS, TIMES, 3, weights=[0]).rows
    assert row.cost == pytest.approx(16781.837218115343, rel=1e-9)
    assert row.guide_error == pytest.approx(1.4070074895582492 + 23.030260595473166, rel=1e-9)
    assert row.max_deviation == pytest.approx(2.6390693436866917, abs=1e-4)
    assert row.max_speed == pytest.approx(11.08560542567465, abs=1e-4)
    assert row.max_acceleration == pytest.approx(28.73624360077076, abs=1e-3)


@pytest.mark.parametrize("derivative", [2, 3, 4])
def test_more_weight_is_rougher_and_nearer_in_the_mean(derivative: int) -> None:
    rows = study(WAYPOINTS, TIMES, derivative, weights=np.geomspace(1, 1e8, 12).tolist()).rows
    assert (np.diff([row.cost for row in rows]) > 0).all()
    assert (np.diff([row.guide_error for row in rows]) < 0).all()
    sums = [row.cost + row.weight * row.guide_error for row in rows]
    assert (np.diff(sums) > 0).all()


def test_the_mean_deviation_is_the_mean_over_time() -> None:
    (row,) = study(WAYPOINTS, TIMES, 3, weights=[1e3]).rows
    t = (np.arange(40000) + 0.5) / 40000 * TIMES[-1]
    squares = distance(row.curve(t), WAYPOINTS) ** 2
    assert row.rms_deviation == pytest.approx(np.sqrt(squares.mean()), rel=1e-3)
    assert squares.max() <= row.max_deviation**2


def test_weights_are_taken_in_order_and_need_not_be_none() -> None:
    assert [row.weight for row in study(WAYPOINTS, TIMES, weights=[10, 0]).rows] == [0, 10]
    with pytest.raises(InputError, match="weights: must be numbers of 0 or more"):
        study(WAYPOINTS, TIMES, weights=[])
    with pytest.raises(InputError, match="weights: must be numbers of 0 or more"):
        study(WAYPOINTS, TIMES, weights=[-1])


def test_a_corridor_is_kept_to_and_saves_effort() -> None:
    free = study(WAYPOINTS, TIMES, weights=[0, 1e3], corridor=0.3)
    met = study(WAYPOINTS, TIMES, weights=[0, 1e3])
    for loose, tight in zip(free.rows, met.rows, strict=True):
        assert np.abs(loose.curve(TIMES) - WAYPOINTS).max() <= 0.3 + 1e-9
        assert loose.cost + loose.weight * loose.guide_error < tight.cost + tight.weight * tight.guide_error
