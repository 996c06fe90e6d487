"""Trajectories of others must lead from the route's start to its end, at rest."""

import numpy as np
import pytest

from crosstrack.errors import InputError
from crosstrack.plan.from_file import FromFile
from crosstrack.protocols import Planner, PlanningTask
from crosstrack.trajectory.files.csv_file import to_csv
from crosstrack.trajectory.files.json_file import to_json
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.types import Envelope
from crosstrack.world.world import World

ROUTE = np.array([[0, 0, 5], [4, 1, 5], [4, 6, 7.0]])
CURVE = minimum(ROUTE, [0, 2, 5], 4)


def plan(curve: PiecewisePolynomial, name: str = "a.json") -> object:
    data = (to_csv if name.endswith("csv") else to_json)(curve).encode()
    envelope = Envelope(speed=12, speed_vertical=4, acceleration=7, acceleration_vertical=2, response_time=0.2)
    return FromFile(name).plan(PlanningTask(ROUTE, 5.0, 0.3, envelope, World(), 0.2, {name: data}))


@pytest.mark.parametrize("name", ["a.json", "b.csv"])
def test_what_fits_is_returned_as_it_is(name: str) -> None:
    made = plan(CURVE, name)
    assert isinstance(made, PiecewisePolynomial)
    assert made.coefficients.tobytes() == CURVE.coefficients.tobytes()
    assert FromFile(name).names == (name,)
    planner: Planner = FromFile(name)
    assert planner.allowed(0.3) is None


def test_ends_elsewhere_and_on_the_move_are_told_together() -> None:
    away = PiecewisePolynomial(CURVE.durations, CURVE.coefficients + np.eye(8)[0][:, None] * [0, 0.5, 0])
    moving = minimum(ROUTE, [0, 2, 5], 4, end=[[1.0, 0, 0]])
    allowed = "at most the mission's tolerance, 0.3 m, is allowed"
    with pytest.raises(InputError) as caught:
        plan(away)
    assert [str(problem) for problem in caught.value.problems] == [
        f"start: is at (0, 0.5, 5), 0.5 m from the route's, (0, 0, 5); {allowed}",
        f"end: is at (4, 6.5, 7), 0.5 m from the route's, (4, 6, 7); {allowed}",
    ]
    with pytest.raises(InputError, match="end: moves at 1 m/s; the vehicle is at rest there"):
        plan(moving)
