import base64
import json
import re
from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from crosstrack.flight.flight import Flight
from crosstrack.flight.metrics import Metrics
from crosstrack.flight.scene import Scene, scene
from crosstrack.flight.summary import summary
from crosstrack.show.extent import extent
from crosstrack.show.footprint import footprint
from crosstrack.show.panels import panels
from crosstrack.show.report import report, thinned
from crosstrack.show.traces import packed
from crosstrack.show.words import LABELS, number

Fly = Callable[..., Flight]


class Page(HTMLParser):
    """The parts of a page: texts by element, table cells, scripts, and addresses that would be fetched."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.open: list[str] = []
        self.texts: dict[str, list[str]] = {}
        self.rows: list[list[str]] = []
        self.fetched: list[str] = []
        self.tags: list[str] = []
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: Sequence[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.fetched += [value or "" for name, value in attrs if name in ("src", "href", "srcset")]
        if tag == "tr":
            self.rows.append([])
        if tag not in ("meta", "input", "link"):
            self.open.append(tag)
            self.texts.setdefault(tag, []).append("")

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open:
            self.texts[self.open[-1]][-1] += data
            if self.open[-1] in ("td", "th") and self.rows and data.strip():
                self.rows[-1].append(data.strip())


def data_of(page: Page) -> Any:
    return json.loads(page.texts["script"][0])


def unpacked(values: dict[str, str]) -> Any:
    return np.frombuffer(base64.b64decode(values["bdata"]), dtype=f"<{values['dtype']}")


def test_page_needs_nothing_else(flight: Flight, tmp_path: Path) -> None:
    page = Page(report([flight], tmp_path / "a.html"))
    assert page.fetched == []
    assert "link" not in page.tags
    assert not re.search(r"@import|url\(", page.texts["style"][0])


def test_page_says_how_it_ended_and_shows_every_metric(flight: Flight, tmp_path: Path) -> None:
    page = Page(report([flight], tmp_path / "a.html"))
    assert flight.outcome.value in " ".join(page.texts["p"])
    numbers = summary(flight)
    expected = [
        [label, number(numbers[name], style), *([unit] if unit else [])]
        for name, (label, unit, style) in LABELS.items()
    ]
    assert page.rows == expected


def test_every_metric_has_a_label() -> None:
    assert LABELS.keys() == {field.name for field in fields(Metrics)}


def test_mission_can_be_read_back_from_the_page(flight: Flight, tmp_path: Path) -> None:
    page = Page(report([flight], tmp_path / "a.html"))
    assert yaml.safe_load(page.texts["pre"][0]) == flight.plan.document


HOSTILE = "</script><script>alert(1)</script><img src=x onerror=alert(1)> & \"quoted\" 'name' {{ 7 * 7 }}"


@pytest.mark.parametrize("count", [1, 2])
def test_names_cannot_become_markup(flight: Flight, tmp_path: Path, count: int) -> None:
    plan = replace(flight.plan, name=HOSTILE, document={"name": HOSTILE})
    page = Page(report([replace(flight, plan=plan)] * count, tmp_path / "a.html"))
    assert HOSTILE in page.texts["h1"]
    assert "img" not in page.tags
    assert page.tags.count("script") == 3
    assert page.fetched == []
    assert yaml.safe_load(page.texts["pre"][0]) == {"name": HOSTILE}
    names = [trace["name"] for trace in data_of(page)["space"]["data"]]
    assert not any("<" in name for name in names)


def test_flights_stand_side_by_side(fly_square: Fly, tmp_path: Path) -> None:
    flights = [fly_square(name="calm", wiggle=0.02), fly_square(name="windy", wiggle=0.5, duration=12.0)]
    page = Page(report(flights, tmp_path / "a.html"))
    assert page.rows[0] == ["1: calm", "2: windy"]
    index = list(LABELS).index("cross_track_max_m")
    _, first, second, _ = page.rows[1 + index]
    assert float(first) == pytest.approx(summary(flights[0])["cross_track_max_m"], abs=5e-4)
    assert float(second) == pytest.approx(summary(flights[1])["cross_track_max_m"], abs=5e-4)
    flown = [trace for trace in data_of(page)["space"]["data"] if trace.get("meta") == "flown"]
    assert [trace["name"] for trace in flown] == ["1: calm", "2: windy"]
    assert flown[0]["line"]["color"] != flown[1]["line"]["color"]


def test_path_drawn_is_the_path_flown(flight: Flight, tmp_path: Path) -> None:
    data = data_of(Page(report([flight], tmp_path / "a.html")))
    (flown,) = [trace for trace in data["space"]["data"] if trace.get("meta") == "flown"]
    drawn = np.column_stack([unpacked(flown[axis]) for axis in "xyz"])
    np.testing.assert_allclose(drawn, flight.record.position, atol=1e-5)
    (vehicle,) = data["vehicles"]
    at = np.searchsorted(flight.record.time, data["stops"], side="right") - 1
    np.testing.assert_allclose(unpacked(vehicle["position"]).reshape(-1, 3), flight.record.position[at], atol=1e-5)
    head, tail = unpacked(vehicle["head"]), unpacked(vehicle["tail"])
    assert ((tail <= head) & (head < len(drawn))).all()
    np.testing.assert_allclose(drawn[head], flight.record.position[at], atol=1e-5)


def test_a_long_flight_stays_small(fly_square: Fly, tmp_path: Path) -> None:
    path = report([fly_square(duration=300.0)], tmp_path / "a.html")
    assert path.stat().st_size < 8_000_000
    data = data_of(Page(path))
    assert len(data["stops"]) <= 200


def test_thinning_keeps_the_ends_and_the_worst() -> None:
    error = np.random.default_rng(1).uniform(size=20011)
    rows = thinned(error, 500)
    assert len(rows) <= 501
    assert {0, len(error) - 1, int(error.argmax())} <= set(rows.tolist())
    assert np.array_equal(thinned(error[:300], 500), np.arange(300))


def test_panels_without_rotors_wind_or_obstacles(flight: Flight) -> None:
    count = len(flight.record.time)
    bare = replace(
        flight.record,
        rotor_speeds=np.empty((count, 0)),
        wind=np.zeros((count, 3)),
        clearance=np.full(count, np.inf),
        command_rate=np.full((count, 3), np.nan),
        command_thrust=np.full(count, np.nan),
    )
    shown = panels(replace(flight, record=bare), flight.cross_track)
    assert [panel.title for panel in shown] == ["Cross-track error", "Speed", "Height", "Tilt"]


def test_footprint_covers_what_lies_under_the_mesh(flight: Flight) -> None:
    still = scene(flight.plan)
    box = extent([flight], still)
    image = np.asarray(footprint(still, box))
    metre = image.shape[1] / (box[1, 0] - box[0, 0])
    assert image.sum() / metre**2 == pytest.approx(16.0, rel=0.01)
    row, column = (image.shape[0] - (10 - box[0, 1]) * metre, (10 - box[0, 0]) * metre)
    assert np.argwhere(image).mean(axis=0) == pytest.approx([row, column], abs=2)


def test_extent_of_a_level_flight_has_a_height(flight: Flight) -> None:
    still = scene(flight.plan)
    low, high = extent([flight], Scene(still.route, still.course, ()))
    assert (high - low)[2] > 0.2 * (high - low)[:2].max() / 1.1
    assert (low < flight.record.position.min(axis=0)).all()
    assert (high > flight.record.position.max(axis=0)).all()


@pytest.mark.parametrize("kind", [np.float64, np.int64])
def test_packed_numbers_come_back(kind: type[np.generic]) -> None:
    values = np.arange(-5, 6).astype(kind)
    assert np.array_equal(unpacked(packed(values)), values)
