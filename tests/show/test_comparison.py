"""The page of a comparison: what it draws is what was flown, ranked, with failures named."""

import base64
import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from crosstrack.campaign.ranking import Loss
from crosstrack.show.comparison import comparison_page
from crosstrack.show.comparison_figures import binned
from crosstrack.show.comparison_flights import Flown, flown, groups, looks
from crosstrack.show.comparison_picture import comparison_picture
from crosstrack.show.comparison_table import standings
from crosstrack.types import Outcome

ROUTE = [[0.0, 0.0, 5.0], [20.0, 0.0, 5.0], [20.0, 10.0, 5.0]]


def result(
    tracker: str,
    seed: int = 1,
    *,
    mission: str = "bend",
    wind: str = "calm",
    error: float = 0.1,
    outcome: Outcome = Outcome.ARRIVED,
    tracking: float | None = None,
    captured: bool = True,
) -> dict[str, Any]:
    """Return a flight along the route at a constant distance from it; one that fails ends half way."""
    arrived = outcome is Outcome.ARRIVED
    share = np.linspace(0, 1 if arrived else 0.5, 60)
    corner = 20 / 30
    x, y = 20 * np.minimum(share / corner, 1), 10 * np.maximum(share - corner, 0) / (1 - corner)
    position = np.column_stack([x, y + error, np.full(60, 5.0)])
    return {
        "labels": {"mission": mission, "tracker": tracker, "wind": wind, "seed": seed},
        "summary": {
            "outcome": outcome.name.lower(),
            "outcome_text": outcome.value,
            "arrived": arrived,
            "collided": outcome is Outcome.COLLIDED,
            "flight_time_s": 10.0 * share[-1],
            "time_ratio": 1.02 if arrived else None,
            "cross_track_rms_m": error,
            "cross_track_rms_captured_m": error if captured else None,
            "cross_track_max_captured_m": error if captured else None,
            "tracking_rms_m": tracking,
            "rms_jerk_mps3": 3.0,
        },
        "trace": {
            "time": (10 * share).tolist(),
            "position": position.tolist(),
            "cross_track": [error] * 60,
            "tracking": None if tracking is None else [tracking] * 60,
            "speed": [3.0] * 60,
        },
        "route": ROUTE,
    }


def data_of(path: Path) -> list[dict[str, Any]]:
    match = re.search(r'<script id="data" type="application/json">(.*?)</script>', path.read_text("utf-8"), re.S)
    assert match is not None
    found: list[dict[str, Any]] = json.loads(match[1])["groups"]
    return found


def unpacked(values: Mapping[str, str]) -> Any:
    return np.frombuffer(base64.b64decode(values["bdata"]), dtype=f"<{values['dtype']}")


def body_of(path: Path) -> str:
    return re.sub(r"<(script|style)\b.*?</\1>", "", path.read_text("utf-8"), flags=re.S)


def drawn(figure: Mapping[str, Any], tracker: int) -> list[dict[str, Any]]:
    return [trace for trace in figure["data"] if trace.get("meta") == tracker]


def text_of(row: str) -> str:
    return " ".join(re.sub("<.*?>", " ", row, flags=re.S).split())


def test_the_page_needs_nothing_else_and_names_cannot_become_markup(tmp_path: Path) -> None:
    name = "</script><b>carrot"
    loss = Loss({"mission": "bend", "tracker": name, "wind": "calm", "seed": 2}, "ValueError: <b>no")
    path = comparison_page([result(name, mission=name, wind=name)], tmp_path / "deep/a.html", [loss])
    text = path.read_text("utf-8")
    without_library = re.sub(r"<script>.*?</script>", "", text, flags=re.S)
    assert not re.search(r"\b(src|href|srcset)=|@import|url\(", without_library)
    assert "<b>carrot" not in without_library
    assert "<b>no" not in without_library
    assert all("<b>carrot" not in str(figure) for group in data_of(path) for figure in group.values() if figure)


def test_the_flight_in_the_middle_is_drawn_from_end_to_end(tmp_path: Path) -> None:
    flights = [result("carrot", seed, error=error) for seed, error in enumerate([0.5, 0.1, 0.3])]
    (group,) = data_of(comparison_page(flights, tmp_path / "a.html"))
    (path,) = drawn(group["plan"], 0)
    ends = np.array([unpacked(path[axis])[[0, -1]] for axis in "xy"])
    np.testing.assert_allclose(ends, np.array([[0.0, 20.0], [0.3, 10.3]]), atol=1e-5)
    error = next(trace for trace in drawn(group["times"], 0) if trace["yaxis"] == "y")
    assert unpacked(error["y"]).max() == pytest.approx(0.3)
    (box,) = drawn(group["boxes"], 0)
    assert box["x"] == [0.5, 0.1, 0.3]
    layout = group["plan"]["layout"]
    assert layout["yaxis"]["scaleanchor"] == "x"
    for axis, low, high in (("xaxis", 0, 20), ("yaxis", 0, 10.3)):
        assert layout[axis]["range"][0] < low
        assert layout[axis]["range"][1] > high


def test_failures_are_ranked_last_named_and_marked_where_they_ended(tmp_path: Path) -> None:
    flights = [result("wild", seed, error=0.01, outcome=Outcome.COLLIDED) for seed in (1, 2)]
    flights += [result("wild", 3, error=0.01), result("tame", 1, error=0.5), result("tame", 2, error=0.7)]
    path = comparison_page(flights, tmp_path / "a.html")
    ranking = re.findall(r"<tr data-tracker.*?</tr>", body_of(path), re.S)
    assert text_of(ranking[0]).startswith("1 tame 2 of 2 0.600 0.500 to 0.700 0.700")
    assert text_of(ranking[1]).startswith("2 wild 1 of 3 2 collided 0.010")
    lost = [text_of(row) for row in re.findall(r"<tr>.*?</tr>", body_of(path).split('id="lost"')[1], re.S)][1:]
    assert lost == ["wild bend calm 1 collided 5.0 s", "wild bend calm 2 collided 5.0 s"]
    (group,) = data_of(path)
    line, crosses = drawn(group["plan"], 0)  # the middle one of three, two of which collided, is one that collided
    assert unpacked(line["x"])[-1] == pytest.approx(15.0)
    np.testing.assert_allclose(unpacked(crosses["x"]), [15.0, 15.0])
    assert "seed 2" in crosses["text"][1]
    box = drawn(group["boxes"], 0)[0]
    assert box["x"] == [0.01]
    assert "2 of 3 not shown" in box["name"]


def test_looks_are_fixed_told_apart_and_the_same_in_every_panel(tmp_path: Path) -> None:
    names = [f"tracker {index}" for index in range(16)]
    found = looks(names)
    assert len({(look.color, look.dash) for look in found.values()}) == 16
    (group,) = data_of(comparison_page([result(name) for name in names], tmp_path / "a.html"))
    for look in found.values():
        lines = [drawn(group[name], look.index)[0]["line"] for name in ("plan", "times", "speeds", "boxes")]
        assert {line["color"] for line in lines} == {look.color}
        assert {line["dash"] for line in lines[:3]} == {look.dash}


def test_every_mission_and_wind_has_its_figures_and_its_ranking(tmp_path: Path) -> None:
    flights = [
        result(tracker, mission=mission, wind=wind, error=error)
        for mission in ("bend", "loop")
        for wind, error in (("calm", 0.1), ("0,3,0,light", 0.2))
        for tracker in ("carrot", "pull")
    ]
    path = comparison_page(flights, tmp_path / "a.html")
    titles = re.findall(r"<option.*?>(.*?)</option>", body_of(path))
    assert titles == ["bend, calm", "bend, wind 0,3,0,light", "loop, calm", "loop, wind 0,3,0,light"]
    shown = data_of(path)
    assert len(shown) == 4
    assert [drawn(group["boxes"], 0)[0]["x"] for group in shown] == [[0.1, 0.2]] * 4
    assert body_of(path).count('class="ranking"') == 5


def test_tracking_errors_are_shown_where_there_are_some(tmp_path: Path) -> None:
    flights = [result("carrot", tracking=0.4), result("pull")]
    (group,) = data_of(comparison_page(flights, tmp_path / "a.html"))
    assert drawn(group["tracking"], 0)[0]["x"] == [0.4]
    titles = [note["text"] for note in group["times"]["layout"]["annotations"]]
    assert sum("trajectory" in title for title in titles) == 1
    (without,) = data_of(comparison_page(flights[1:], tmp_path / "b.html"))
    assert without["tracking"] is None


def test_the_page_says_what_it_ranks_by(tmp_path: Path) -> None:
    by_clock = [result("near", error=0.3, tracking=0.1), result("far", error=0.1, tracking=0.4)]
    text = text_of(body_of(comparison_page(by_clock, tmp_path / "a.html")))
    assert "1 near 1 of 1" in text
    assert "by the median of the tracking error, since every flight has a trajectory, then of the cross-track" in text
    text = text_of(body_of(comparison_page([*by_clock, result("pull", error=0.2)], tmp_path / "b.html")))
    assert "1 far 1 of 1" in text
    assert "by the median of the cross-track error" in text


def test_without_flights_the_page_says_so(tmp_path: Path) -> None:
    path = comparison_page([], tmp_path / "a.html")
    assert "No flight came back: there is nothing to compare." in body_of(path)
    loss = Loss(
        {"mission": "bend", "tracker": "carrot", "wind": "calm", "seed": 2}, "the worker died: killed by signal 9"
    )
    text = text_of(body_of(comparison_page([], path, [loss])))
    assert "1 flight broken by an error" in text
    assert "the worker died: killed by signal 9" in text
    only = Loss({**loss.labels, "tracker": "pull"}, loss.error)
    assert "2 pull 0 of 1 1 broken by an error" in text_of(body_of(comparison_page([result("carrot")], path, [only])))


def test_a_flight_that_never_captures_the_route_or_is_not_finite_is_shown(tmp_path: Path) -> None:
    wild = result("wild", outcome=Outcome.LOST_CONTROL, captured=False)
    wild["trace"]["position"][-1] = [None, None, None]
    wild["trace"]["cross_track"][-1] = wild["trace"]["speed"][-1] = None
    path = comparison_page([wild], tmp_path / "a.html")
    (group,) = data_of(path)
    assert group["boxes"] is None
    assert np.isfinite(unpacked(drawn(group["plan"], 0)[1]["x"])).all()
    assert "0 of 1 1 lost control never" in text_of(body_of(path))


def test_four_hundred_flights_stay_small(tmp_path: Path) -> None:
    flights = []
    for tracker in range(16):
        for seed in range(5):
            for mission in range(5):
                one = result(f"tracker {tracker}", seed, mission=f"mission {mission}", error=0.1 + tracker)
                for name in ("time", "cross_track", "speed", "position"):
                    one["trace"][name] = one["trace"][name] * 7
                flights.append(one)
    assert comparison_page(flights, tmp_path / "a.html").stat().st_size < 10e6


def test_errors_against_speed_are_root_mean_squares_of_bins() -> None:
    one, two = result("a"), result("a", 2)
    one["trace"]["speed"], one["trace"]["cross_track"] = [0.5] * 30 + [1.5] * 30, [0.3] * 30 + [0.0, 0.2] * 15
    two["trace"]["speed"], two["trace"]["cross_track"] = [0.7] * 58 + [2.5] * 2, [0.4] * 58 + [9.0] * 2
    speed, error = binned(flown([one, two]), np.array([0.0, 1.0, 2.0, 3.0]))
    mean = (0.5 * 30 + 0.7 * 58) / 88
    square = (0.3**2 * 30 + 0.4**2 * 58) / 88
    np.testing.assert_allclose(speed, [mean, 1.5])  # two samples are no bin
    np.testing.assert_allclose(error, [np.sqrt(square), np.sqrt(0.02)])


def test_the_middle_of_an_even_number_is_the_better_one() -> None:
    (group,) = groups(flown([result("a", seed, error=error) for seed, error in enumerate([0.4, 0.1, 0.3, 0.2])]))
    middle = group.median("a")
    assert isinstance(middle, Flown)
    assert middle.seed == 3
    assert group.median("b") is None


def test_rows_are_ranked_by_arrivals_then_by_error() -> None:
    lost = result("c", error=0.01, outcome=Outcome.TIMED_OUT)
    rows = standings(flown([result("a", error=0.3), lost, result("b", error=0.2)]))
    assert [(row.rank, row.tracker, row.failures) for row in rows] == [
        (1, "b", ""),
        (2, "a", ""),
        (3, "c", "1 out of time"),
    ]


def test_the_picture_is_drawn_in_the_colours_of_the_page(tmp_path: Path) -> None:
    flights = [result(name, seed, error=0.1 * seed) for name in ("carrot", "pull") for seed in (1, 2, 3)]
    flights.append(result("carrot", 4, outcome=Outcome.COLLIDED))
    path = comparison_picture(flights, tmp_path / "deep/a.png")
    with Image.open(path) as image:
        pixels = np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)
    colors = {"#" + bytes(pixel.tolist()).hex().upper() for pixel in pixels}
    assert {look.color for look in looks(["carrot", "pull"]).values()} <= colors
    comparison_picture([], tmp_path / "none.png")
    assert (tmp_path / "none.png").stat().st_size > 0
