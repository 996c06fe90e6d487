"""Certificates of whole trajectories, against optima solved with 60 digits."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from curves import random_curve

from crosstrack.errors import InputError
from crosstrack.trajectory.certified.certificate import certify
from crosstrack.trajectory.constrained.corridor import Tube, subdivide
from crosstrack.trajectory.minimum_derivative import minimum
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.world.grids import Voxels
from crosstrack.world.shapes import Box
from crosstrack.world.world import World

OPTIMA: list[dict[str, Any]] = json.loads(
    (Path(__file__).parents[1] / "data" / "certified_optima.json").read_text(encoding="utf-8")
)["cases"]


@pytest.mark.parametrize("case", OPTIMA, ids=lambda case: str(case["name"]))
def test_optima_have_their_known_peaks(case: dict[str, Any]) -> None:
    curve = PiecewisePolynomial(np.array(case["durations"]), np.stack([case["x"], case["y"]], axis=-1))
    found = certify(curve, route=np.array(case["route"], float))
    assert set(found.peaks) == {"speed", "acceleration", "jerk", "snap"}
    for name in ("speed", "acceleration", "jerk"):
        sampled = case[name]
        assert sampled * (1 - 1e-12) <= found.peaks[name].value <= sampled * (1 + 1e-5)
    assert found.deviation is not None
    assert case["deviation"] <= found.deviation.value <= case["deviation"] + 1e-4
    assert found.derivative == 3
    assert found.effort == pytest.approx(case["effort"], rel=1e-9)
    guided = "lambda" in case["name"]
    assert max(found.jumps[: 3 if guided else 5]) < 1e-9
    assert found.duration == pytest.approx(sum(case["durations"]))


def test_a_corridor_of_a_millimetre_is_certified_too() -> None:
    route = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])
    curve = minimum(*subdivide(route, [0.0, 5.0, 10.0, 15.0], 1.0), 4, corridor=Tube(0.001))
    found = certify(curve, route=route).deviation
    assert found is not None
    assert 0.0009 < found.attained <= found.value <= 0.001


def test_jumps_are_relative_to_the_derivative() -> None:
    # x = t, then 1 + 3 u: continuous, and the velocity jumps by 2 where it is 3 at most
    curve = PiecewisePolynomial(np.ones(2), np.array([[[0.0], [1.0]], [[1.0], [3.0]]]))
    assert certify(curve).jumps == pytest.approx((0.0, 2 / 3))


def test_horizontal_and_vertical_are_told_apart() -> None:
    curve = PiecewisePolynomial(np.array([2.0]), np.array([[[0.0, 0, 0], [3.0, 4.0, -12.0]]]))
    peaks = certify(curve).peaks
    found = [peaks[name].value for name in ("speed", "speed_horizontal", "speed_vertical", "acceleration")]
    assert found == pytest.approx([13.0, 5.0, 12.0, 0.0])


def test_findings_hold_or_not_as_certified() -> None:
    world = World((Box((-5, 2, 0), (50, 3, 10)),))
    curve = PiecewisePolynomial(np.array([2.0]), np.array([[[0.0, 0, 5], [4.0, 0, 0], [1.0, 0, 0]]]))
    found = certify(curve, route=np.array([[0.0, 0, 5], [10.0, 0, 5]]), world=world, tolerance=1e-3)
    limits = {"speed": 7.9, "acceleration": 2.1, "deviation": 2.1, "clearance": 1.99, "speed_vertical": 0.0}
    findings = {one.quantity: one for one in found.findings(limits)}
    assert list(findings) == list(limits)
    assert {name: one.holds for name, one in findings.items()} == {
        "speed": False, "acceleration": True, "deviation": True, "clearance": True, "speed_vertical": True
    }  # fmt: skip
    assert findings["speed"].value == pytest.approx(8.0)
    assert findings["speed"].time == pytest.approx(2.0)
    assert not found.findings({"clearance": 2.0001})[0].holds
    with pytest.raises(InputError, match=r"speeed.*acceleration"):
        found.findings({"speeed": 1.0})


def test_the_document_is_json_and_says_what_is_certified() -> None:
    curve = random_curve(1, pieces=3, spread=1.0)
    blank = certify(curve, world=World()).document()
    assert blank["quantities"]["clearance"]["at_least"] is None
    found = certify(curve, route=curve.coefficients[:, 0], world=World((Box((0, 0, 0), (1, 1, 1)),)))
    document = json.loads(json.dumps(found.document(), allow_nan=False))
    quantities = document["quantities"]
    assert quantities["speed"]["at_most"] == found.peaks["speed"].value
    assert quantities["speed"]["unit"] == "m/s"
    assert quantities["deviation"]["attained"] <= quantities["deviation"]["at_most"]
    assert quantities["clearance"]["at_least"] <= quantities["clearance"]["attained"]
    assert document["effort"] == {"derivative": 4, "value": curve.cost(4)}
    assert len(document["jumps_relative"]) == 8


def test_optimistic_maps_are_taken_as_they_are() -> None:
    grid = Voxels(np.ones((2, 2, 2), bool), (0.0, 4.0, 4.0), 1.0)
    curve = PiecewisePolynomial(np.ones(1), np.array([[[0.0, 0, 5], [1.0, 0, 0]]]))
    clearance = certify(curve, world=World(grids=(grid,)), tolerance=1e-3).clearance
    assert clearance is not None
    assert clearance.value == pytest.approx(4.0 - grid.optimism, abs=2e-3)


@pytest.mark.parametrize(
    ("options", "place"),
    [
        ({"route": np.zeros((3, 2))}, "route"),
        ({"route": np.zeros((0, 3))}, "route"),
        ({"route": np.zeros(3)}, "route"),
        ({"route": np.full((2, 3), np.nan)}, "route"),
    ],
)
def test_wrong_routes_are_refused(options: dict[str, Any], place: str) -> None:
    with pytest.raises(InputError) as caught:
        certify(random_curve(1), **options)
    assert [problem.place for problem in caught.value.problems] == [place]


def test_everything_wrong_is_told_at_once() -> None:
    bad = PiecewisePolynomial(np.array([1.0, -1.0]), np.array([[[0.0], [1.0]], [[np.nan], [1.0]]]))
    with pytest.raises(InputError) as caught:
        certify(bad, route=np.zeros((2, 3)), world=World())
    places = [problem.place for problem in caught.value.problems]
    assert places == ["curve.durations", "curve.coefficients[1]", "route", "curve"]
