"""The page of a plan: what it draws is what was planned."""

import base64
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crosstrack.mission import loads
from crosstrack.mission.certified import Certified, certified
from crosstrack.show.plan_page import plan_page
from crosstrack.show.tube import band, capsule, stadium, tube

MISSION = """
name: "</script><b>hop"
start: {position: [0, 0, 5]}
route: [[6, 0, 5], [6, 5, 6]]
speed: 3
world: {shapes: [{box: {min: [1, 2, 0], max: [3, 4, 9]}}]}
planner: {kind: minimum_snap}
"""


@pytest.fixture(scope="module")
def found() -> Certified:
    mission = loads(MISSION.replace("</script>", ""))
    return certified(mission, mission.build())


def data_of(path: Path) -> Any:
    match = re.search(r'<script id="data" type="application/json">(.*?)</script>', path.read_text("utf-8"), re.S)
    assert match is not None
    return json.loads(match[1])


def unpacked(values: dict[str, str]) -> Any:
    return np.frombuffer(base64.b64decode(values["bdata"]), dtype=f"<{values['dtype']}")


def curve_named(figure: Any, name: str, axis: str = "y") -> Any:
    return next(trace for trace in figure["data"] if trace["name"] == name and trace.get("yaxis", axis) == axis)


def test_the_page_needs_nothing_else_and_names_cannot_become_markup(found: Certified, tmp_path: Path) -> None:
    text = plan_page(found, tmp_path / "deep/plan.html").read_text("utf-8")
    without_library = re.sub(r"<script>.*?</script>", "", text, flags=re.S)
    assert not re.search(r"\b(src|href|srcset)=|@import|url\(", without_library)
    assert "<b>hop" not in without_library
    assert "certified" in text


def test_derivatives_and_limits_are_drawn(found: Certified, tmp_path: Path) -> None:
    times = data_of(plan_page(found, tmp_path / "a.html"))["times"]
    speed = curve_named(times, "all")
    at = unpacked(speed["x"])
    np.testing.assert_allclose(
        unpacked(speed["y"]), np.linalg.norm(found.trajectory(at.astype(float), 1), axis=1), atol=1e-4
    )
    assert set(unpacked(curve_named(times, "limit")["y"])) == {3.0}
    titles = [note["text"] for note in times["layout"]["annotations"]]
    assert [re.sub("<.*?>", "", title) for title in titles] == [
        "Speed (m/s)", "Acceleration (m/s²)", "Jerk (m/s³)", "Snap (m/s⁴)", "Deviation from the route (m)",
        "Clearance (m)",
    ]  # fmt: skip
    deviation = next(trace for trace in times["data"] if trace["name"] == "from the legs")
    largest = found.certificate.deviation
    assert largest is not None
    assert unpacked(deviation["y"]).max() == pytest.approx(largest.value, abs=1e-3)


def test_the_corridor_is_drawn_where_there_is_one(found: Certified, tmp_path: Path) -> None:
    drawn = data_of(plan_page(found, tmp_path / "a.html"))
    assert all("corridor" in [trace["name"] for trace in drawn[name]["data"]] for name in ("space", "plan"))
    mission = loads(MISSION.replace("</script><b>", "").replace("snap}", "snap, guide: 0}"))
    drawn = data_of(plan_page(certified(mission, mission.build()), tmp_path / "b.html"))
    assert all("corridor" not in [trace["name"] for trace in drawn[name]["data"]] for name in ("space", "plan"))


def test_the_table_shows_every_line(found: Certified, tmp_path: Path) -> None:
    text = plan_page(found, tmp_path / "a.html").read_text("utf-8")
    for line in found.lines:
        assert f'<th scope="row">{line.quantity}</th><td>{line.value:.3f}</td>' in text


@pytest.mark.parametrize("end", [[3.0, 1, 2], [0.0, 0, 4], [0.0, -1, 0]])
def test_a_capsule_is_the_surface_of_the_tube(end: list[float]) -> None:
    start, tip = np.array([1.0, 2, 3]), np.array([1.0, 2, 3]) + end
    vertices, triangles = capsule(start, tip, 0.5)
    along = tip - start
    share = np.clip((vertices - start) @ along / (along @ along), 0, 1)
    np.testing.assert_allclose(np.linalg.norm(vertices - start - share[:, None] * along, axis=1), 0.5)
    corners = vertices[triangles]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    exact = 2 * np.pi * 0.5 * np.linalg.norm(along) + 4 * np.pi * 0.25
    assert areas.sum() == pytest.approx(exact, rel=0.03)


def test_a_stadium_goes_round_counter_clockwise() -> None:
    outline = stadium(np.array([0.0, 0]), np.array([3.0, 4]), 1.0)
    x, y = outline.T
    area = (x[:-1] * y[1:] - x[1:] * y[:-1]).sum() / 2
    assert area == pytest.approx(2 * 5 + np.pi, rel=0.02)


def test_tube_and_band_cover_every_leg() -> None:
    route = np.array([[0.0, 0, 0], [4, 0, 0], [4, 3, 1]])
    assert len(unpacked(tube(route, 0.2)["i"])) == 2 * len(capsule(route[0], route[1], 0.2)[1])
    assert np.isnan(unpacked(band(route, 0.2)["x"])).sum() == 1
