"""The page of a served session: what its figures hold, and that names cannot break it."""

import base64
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scenery import simulated
from served_flown import PATH, flown

from crosstrack import frames
from crosstrack.airsim.scene.markers import FOREVER, Marker, Trace
from crosstrack.flight.served import Recorder, Session
from crosstrack.show import served_markers
from crosstrack.show.served_figures import figures, under_way, ways
from crosstrack.show.served_markers import LIGHTEST, LUMINANCE, arrows, gapped, hexadecimal, rgb, shown, strokes
from crosstrack.show.served_page import served_page
from crosstrack.types import Array

Figures = dict[str, Any]
SHARE = st.floats(0.0, 1.0)


def numbers(values: Figures) -> Array:
    """Return what is packed."""
    kind = {"f4": "<f4", "i4": "<i4"}[values["dtype"]]
    return np.frombuffer(base64.b64decode(values["bdata"]), kind).astype(float)


def places(trace: Figures) -> Array:
    """Return the points (n, 3) of a trace in space."""
    return np.column_stack([numbers(trace[axis]) for axis in "xyz"])


def dots(count: int, color: tuple[float, float, float, float] = (1, 0, 0, 1), at: float = 0.0) -> Marker:
    """Return points that are drawn."""
    return Marker("points", np.full((count, 3), at), color, 5.0, 0, FOREVER)


@pytest.fixture(scope="module")
def drawn() -> Figures:
    """What is drawn of the session, as it stands in the page."""
    held: Figures = json.loads(json.dumps(figures(flown().session)))
    return held


def found(drawn: Figures, view: str, name: str) -> list[Figures]:
    """Return the traces of a name."""
    return [trace for trace in drawn[view]["data"] if trace["name"] == name]


def test_vehicles_are_drawn_where_they_flew_in_the_colour_of_their_trace(drawn: Figures) -> None:
    for name, track in flown().session.tracks.items():
        (trace,) = found(drawn, "space", name)
        line = places(trace)
        gap = np.flatnonzero(np.isnan(line[:, 0]))
        np.testing.assert_array_equal(gap, track.jumps)
        np.testing.assert_allclose(np.delete(line, gap, axis=0), track.position, atol=1e-4)
    assert found(drawn, "space", "One")[0]["line"]["color"] == "#008000"
    assert found(drawn, "plan", "One")[0]["line"]["color"] == "#008000"


def test_height_over_time_is_that_of_the_tracks(drawn: Figures) -> None:
    track = flown().session.tracks["Two"]
    height = next(trace for trace in found(drawn, "times", "Two") if trace["yaxis"] == "y")
    time, value = numbers(height["x"]), numbers(height["y"])
    known = np.isfinite(value)
    np.testing.assert_allclose(value[known], track.position[:, 2], atol=1e-4)
    np.testing.assert_allclose(time[known], track.time, atol=1e-4)


def test_moves_are_drawn_while_they_were_under_way() -> None:
    session = flown().session
    names = ("moveOnPath", "moveByVelocity")
    time, value = under_way(session, "Two", names)
    calls = [one for one in session.calls if one.vehicle == "Two" and one.name in names]
    assert len(calls) == 2
    np.testing.assert_allclose(time.reshape(-1, 3)[:, :2], [[one.begins, one.ends] for one in calls])
    np.testing.assert_array_equal(value.reshape(-1, 3)[:, :2], 2.0)
    assert np.isnan(value.reshape(-1, 3)[:, 2]).all()


def test_what_was_drawn_is_drawn_where_it_was(drawn: Figures) -> None:
    corners = frames.enu_from_ned(PATH)
    (points,) = found(drawn, "space", "points")
    np.testing.assert_allclose(places(points), corners, atol=1e-5)
    assert points["marker"]["color"] == hexadecimal((1.0, 0.0, 0.0, 1.0)) == "#ff0000"
    (line,) = found(drawn, "space", "lines")
    np.testing.assert_allclose(places(line)[:2], corners, atol=1e-5)
    (text,) = found(drawn, "space", "strings")
    assert (text["mode"], text["text"]) == ("text", ["<b>here</b>"])
    assert found(drawn, "plan", "strings")[0]["text"] == ["&lt;b&gt;here&lt;/b&gt;"]
    axes = found(drawn, "space", "transforms")
    assert [axis["line"]["color"] for axis in axes] == ["#ff0000", *[axis["line"]["color"] for axis in axes[1:]]]
    assert len(axes) == 3
    assert len(found(drawn, "space", "collisions")) == len(found(drawn, "plan", "collisions")) == 1


@given(st.integers(0, 2**32 - 1), st.booleans())
def test_arrows_end_at_their_tips_and_have_even_heads(seed: int, steep: bool) -> None:
    rng = np.random.default_rng(seed)
    pairs = rng.normal(size=(5, 2, 3))
    if steep:
        pairs[:, 1, :2] = pairs[:, 0, :2]
    strokes = arrows(pairs)
    way, length = pairs[:, 1] - pairs[:, 0], np.linalg.norm(pairs[:, 1] - pairs[:, 0], axis=1)
    np.testing.assert_array_equal(strokes[:, [0, 1]], pairs)
    np.testing.assert_array_equal(strokes[:, 3], pairs[:, 1])
    left, right = strokes[:, 2] - pairs[:, 1], strokes[:, 4] - pairs[:, 1]
    np.testing.assert_allclose(left + right, -2 * served_markers.BARB * way, atol=1e-9)
    sizes = np.linalg.norm(left - right, axis=1)
    np.testing.assert_allclose(sizes, 2 * served_markers.SPREAD * length, rtol=1e-6)
    np.testing.assert_allclose(((left - right) * way).sum(axis=1), 0.0, atol=1e-9)


def test_lines_end_where_they_end() -> None:
    lines = np.arange(12.0).reshape(2, 2, 3)
    line = gapped(lines)
    np.testing.assert_array_equal(np.isnan(line[:, 0]), [False, False, True] * 2)
    np.testing.assert_array_equal(line[[0, 1, 3, 4]], lines.reshape(-1, 3))


@given(SHARE, SHARE, SHARE)
def test_colours_can_be_seen_on_white(red: float, green: float, blue: float) -> None:
    given_, shade = np.array([red, green, blue]), rgb(hexadecimal((red, green, blue, 1.0))) / 255
    assert shade @ LUMINANCE < LIGHTEST + 0.003
    if given_ @ LUMINANCE <= LIGHTEST:
        np.testing.assert_allclose(shade, given_, atol=0.003)
    np.testing.assert_allclose(np.cross(shade, given_), 0.0, atol=0.005)


def test_rare_colours_join_the_nearest_of_the_others() -> None:
    rng = np.random.default_rng(1)
    many = [dots(1, (*rng.uniform(0, 0.7, 3), 1.0)) for _ in range(200)]
    found = strokes([*many, dots(50, (0.7, 0.0, 0.0, 1.0))], 1.0)
    assert len(found) == served_markers.MOST_COLORS
    assert sum(len(stroke.points) for stroke in found) == 250
    assert max(found, key=lambda stroke: len(stroke.points)).color == hexadecimal((0.7, 0.0, 0.0, 1.0))


def test_the_latest_markers_are_drawn_where_there_are_too_many(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(served_markers, "MOST_POINTS", 10)
    markers = [dots(4, at=float(number)) for number in range(4)]
    assert [marker.points[0, 0] for marker in shown(markers)] == [2.0, 3.0]


def test_markers_far_off_do_not_shrink_the_view(drawn: Figures) -> None:
    session = flown().session
    far = replace(session, markers=(*session.markers, dots(3, at=1e30)))
    assert figures(far)["space"]["layout"] == figures(session)["space"]["layout"]  # type: ignore[index]


def test_markers_as_far_off_as_numbers_go_do_no_harm() -> None:
    end = 3.4e38
    pair = np.array([[end, -end, end], [-end, end, end]])
    kinds = {"lines": None, "arrows": None, "transforms": np.zeros((2, 4))}
    far = [Marker(kind, pair, (1, 0, 0, 1), end, 0, FOREVER, ("a", "b"), turns) for kind, turns in kinds.items()]
    traces = [trace for stroke in strokes(far, 10.0) for trace in (stroke.in_space(), stroke.from_above())]
    assert len(traces) == 2 * (1 + 1 + 3 + 1)
    assert max(np.nanmax(np.abs(numbers(trace["x"]))) for trace in traces) <= 1e9


def test_names_cannot_break_the_page(tmp_path: Path) -> None:
    session = flown().session
    bad = "</script><b>&amp;'\""
    tracks = {bad: session.tracks["One"], "b": session.tracks["Two"]}
    calls = tuple(replace(one, vehicle=bad, answer=bad, arguments=bad) for one in session.calls)
    mad = replace(session, tracks=tracks, calls=calls, traces={bad: Trace((1.0, 1.0, 1.0, 1.0), 1.0)})
    text = served_page(mad, tmp_path / "a.html", bad).read_text()
    assert "</script><b>" not in text
    assert text.count("</script>") == 3
    data = re.search(r'<script id="data" type="application/json">(.*?)</script>', text, re.DOTALL)
    assert data
    assert json.loads(data[1])["vehicles"][0]["name"].startswith("&lt;/script&gt;")


def test_the_page_tells_what_happened(tmp_path: Path) -> None:
    session = flown().session
    text = served_page(session, tmp_path / "a.html").read_text()
    body = text[: text.index('<script id="data"')]
    for part in ("2 vehicles", "5 markers drawn", "moveOnPath(2 points", "Box_1", "Ground", flown().error[-30:-1]):
        assert part in body
    assert f"{len(session.collisions)} collision" in body
    assert "http" not in body.replace("http-equiv", "")


def test_a_session_in_which_nothing_happened_has_a_page(tmp_path: Path) -> None:
    simulator = simulated()
    session: Session = Recorder(simulator).close()
    assert session.scene.meshes == ()
    text = served_page(session, tmp_path / "a.html").read_text()
    assert "0 calls of moves, 0 collisions, 0 markers drawn" in text
    assert "<h2>Moves</h2>" not in text


def test_long_tracks_are_thinned_but_keep_their_jumps(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("crosstrack.show.served_figures.DRAWN", 100)
    monkeypatch.setattr("crosstrack.show.served_figures.LEAST", 40)
    for way in ways(flown().session):
        assert 40 <= len(way.rows) <= 55
        line = way.line()
        assert np.isnan(line[:, 0]).sum() == len(way.track.jumps) == 1
        assert len(line) == len(way.time()) == len(way.with_gaps(way.track.time))
