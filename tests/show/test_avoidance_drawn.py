"""What the report and the pictures show of avoidance: what was known, seen and met, and who stepped in when."""

import base64
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from encounters import ABSENT, MAPPED, MOVERS, Potential, meeting
from matplotlib.colors import to_rgb
from PIL import Image

from crosstrack.flight.flight import Flight
from crosstrack.show import figures, pictures
from crosstrack.show.avoiding import interventions, names, seen
from crosstrack.show.extent import extent
from crosstrack.show.panels import panels
from crosstrack.show.report import figures as drawn_by_script
from crosstrack.show.report import view
from crosstrack.show.solids import faces
from crosstrack.show.stage import groups, stage
from crosstrack.show.style import INK, MOVING, UNMAPPED
from crosstrack.show.traffic import tracks
from crosstrack.types import Array
from crosstrack.world.world import World


@pytest.fixture
def met(flight: Flight) -> Flight:
    return meeting(flight)


def column(values: dict[str, str]) -> Array:
    return np.frombuffer(base64.b64decode(values["bdata"]), f"<{values['dtype']}").astype(float)


def trace(figure: dict[str, Any], name: str) -> dict[str, Any]:
    found: dict[str, Any] = next(each for each in figure["data"] if each["name"] == name)
    return found


def test_obstacles_that_no_map_shows_are_drawn_apart(met: Flight) -> None:
    drawn = stage(met.plan)
    mapped, absent = groups(drawn)
    assert (mapped.name, absent.name) == ("obstacles", "not on the map")
    assert (World(MAPPED).distance(mapped.mesh[0]) < 1e-6).all()
    assert (World(ABSENT).distance(absent.mesh[0]) < 1e-6).all()
    everything = drawn.solid()
    assert everything
    assert len(mapped.mesh[1]) + len(absent.mesh[1]) == len(everything[1])
    figure = figures.space([view(met, "a", "#000000")], drawn)
    assert trace(figure, "not on the map")["color"] == UNMAPPED != trace(figure, "obstacles")["color"]


@pytest.mark.parametrize("told", [World(), World((*MAPPED, *ABSENT))])
def test_where_nothing_or_all_is_on_the_map_there_is_one_group(flight: Flight, told: World) -> None:
    assert [group.name for group in groups(stage(meeting(flight, told).plan))] == ["obstacles"]


def test_the_figures_show_all_that_was_met_seen_and_done(met: Flight) -> None:
    drawn, views = stage(met.plan), [view(met, "a", "#000000")]
    for figure in (figures.space(views, drawn), figures.plan_view(views, drawn)):
        found = {each["name"] for each in figure["data"]}
        assert {"obstacles", "not on the map", "route", "planned again", "seen by the sensors"} <= found
        assert {"potential stepped in", "safety stepped in", "moving obstacles", "flown", "start", "goal"} <= found
        again = column(trace(figure, "planned again")["y"])
        np.testing.assert_allclose(again[np.isfinite(again)], 21.0)
        guarded = trace(figure, "safety stepped in")
        np.testing.assert_allclose(column(guarded["x"]), met.record.position[200:210, 0], atol=1e-5)
        assert guarded["marker"]["color"] == INK
        band = column(trace(figure, "potential stepped in")["x"])
        assert np.isfinite(band).sum() == 200


def test_seen_points_are_those_above_the_ground_and_in_the_picture(met: Flight) -> None:
    box = extent([met], stage(met.plan))
    assert len(seen(met, box, 10_000)) == np.sum(met.seen[:400, 2] > 0.1)
    assert 90 <= len(seen(met, box, 100)) <= 100


def test_the_panel_says_who_stepped_in_when(met: Flight) -> None:
    (panel,) = [each for each in panels(met, met.cross_track) if each.names]
    assert panel.heading == panel.title == "Avoiders that stepped in"
    assert panel.names == ("potential", "safety")
    potential, safety = panel.series
    rows = np.flatnonzero(np.isfinite(potential.values))
    assert (rows[0], rows[-1]) == (99, 299)
    assert set(safety.values[199:210]) == {2.0}
    assert np.isnan(safety.values[[198, 210]]).all()
    drawn = stage(met.plan)
    script = drawn_by_script([view(met, "a", "#000000")], drawn)
    axes = [axis for name, axis in script["times"]["layout"].items() if name.startswith("yaxis") and "ticktext" in axis]
    assert [axis["ticktext"] for axis in axes] == [["potential", "safety"]]
    figure = pictures.times(met, panels(met, met.cross_track))
    labels = [[tick.get_text() for tick in axes.get_yticklabels()] for axes in figure.axes]
    assert ["potential", "safety"] in labels


def test_a_second_avoider_of_a_kind_is_numbered(met: Flight) -> None:
    avoiders: Any = (*met.plan.avoiders, Potential())
    assert names(replace(met.plan, avoiders=avoiders)) == ["potential 1", "safety", "potential 2"]
    both = interventions(replace(met, plan=replace(met.plan, avoiders=avoiders)))
    assert not both[2].rows.any()
    assert both[0].color != both[2].color


def test_what_was_planned_ends_where_it_is_planned_again(met: Flight) -> None:
    for title in ("Speed", "Height"):
        (panel,) = [each for each in panels(met, met.cross_track) if each.title == title]
        planned = next(series for series in panel.series if series.role == "planned").values
        time = met.record.time
        assert np.isfinite(planned[time < 8.0]).all()
        assert np.isnan(planned[time >= 8.0]).all()


def test_moving_obstacles_follow_the_slider(met: Flight) -> None:
    script = drawn_by_script([view(met, "a", "#000000")], stage(met.plan))
    stops = np.array(script["stops"])
    for mover, shift in zip(MOVERS, script["shifts"], strict=True):
        expected = np.array([mover.shift(time) for time in stops])
        np.testing.assert_allclose(column(shift).reshape(-1, 3), expected, atol=1e-4)
    for name in ("space", "plan"):
        assert sum(each.get("meta") == "mover" for each in script[name]["data"]) == len(MOVERS)


def test_a_track_stays_in_the_picture_and_knows_when_it_came_nearest(met: Flight) -> None:
    box = extent([met], stage(met.plan))
    first, second = tracks([met], box)
    inside = first.line[np.isfinite(first.line).all(axis=1)]
    assert ((inside >= box[0]) & (inside <= box[1])).all()
    np.testing.assert_allclose(inside[:, [0, 2]], np.tile([20.0, 10.0], (len(inside), 1)))
    times = met.record.time
    gaps = np.linalg.norm(met.record.position - (np.array([20.0, -4, 10]) + times[:, None] * [0, 1, 0]), axis=1)
    assert abs(first.nearest - times[np.argmin(gaps)]) < 0.2
    outline = second.outline(second.mesh.vertices)
    np.testing.assert_allclose(np.linalg.norm(outline - [14, 20], axis=1), 0.4, atol=1e-9)
    np.testing.assert_array_equal(outline[0], outline[-1])


def test_the_pictures_draw_each_kind_in_its_colour(met: Flight, tmp_path: Path) -> None:
    drawn = stage(met.plan)
    _, colors = faces(drawn, tracks([met], extent([met], drawn)))
    assert {to_rgb(UNMAPPED), to_rgb(MOVING)} < set(map(tuple, colors.tolist()))
    paths = pictures.pictures(met, tmp_path)
    for path in paths[:2]:
        with Image.open(path) as image:
            pixels = np.asarray(image.convert("RGB")).reshape(-1, 3).astype(int)
        for color in (UNMAPPED, MOVING):
            hue = np.array(to_rgb(color)) / np.max(to_rgb(color))
            bright = pixels[pixels.max(axis=1) > 100]
            assert (np.abs(bright / bright.max(axis=1)[:, None] - hue).max(axis=1) < 0.15).sum() > 50
    space, above = pictures.space(met, drawn, met.cross_track), pictures.plan_view(met, drawn)
    legends = [space.axes[0].get_legend(), *above.legends]
    for legend in legends:
        assert legend is not None
        texts = [text.get_text() for text in legend.get_texts()]
        assert len(texts) == len(set(texts))
        expected = {"not on the map", "moving obstacles", "seen by the sensors", "safety stepped in"}
        assert expected | {"potential stepped in"} <= set(texts)
    above.draw_without_rendering()
    width, height = above.get_size_inches() * above.dpi
    box = above.legends[0].get_window_extent()
    assert box.x0 >= 0
    assert box.x1 <= width
    assert box.y0 >= 0
    assert box.y1 <= height


def test_vehicles_that_fly_at_once_show_how_near_they_come(fly_square: Callable[..., Flight]) -> None:
    flights = [apart(fly_square(name=name), distance) for name, distance in (("a", 3.0), ("b", 2.0))]
    views = [
        view(flight, flight.plan.name, color) for flight, color in zip(flights, ("#000000", "#ffffff"), strict=True)
    ]
    alone = next(each for each in views[0].panels if each.title.startswith("Distance to the nearest vehicle"))
    separation, touch = alone.series
    assert separation.values[0] == 3.0
    assert set(touch.values) == {0.5}
    shown = [curve["name"] for curve in figures.times(views)["data"]]
    assert shown.count("a") == shown.count("b") == len(views[0].panels)


def apart(flight: Flight, distance: float) -> Flight:
    vehicle: Any = SimpleNamespace(radius=0.25)
    record = replace(flight.record, separation=np.full(len(flight.record.time), distance))
    return replace(flight, plan=replace(flight.plan, vehicle=vehicle), record=record)


def test_each_vehicle_has_its_route_and_its_goal(fly_along: Callable[..., Flight]) -> None:
    time = np.linspace(0, 4, 50)
    routes = [np.array([[0, 0, 5], [8, 0, 5.0]]), np.array([[8, 0, 5], [0, 0, 5.0]])]
    flights = [
        fly_along(route, time, route[0] + (route[1] - route[0]) * time[:, None] / 4, 2 * time) for route in routes
    ]
    figure = figures.plan_view([view(flight, "f", "#000000") for flight in flights], stage(flights[0].plan))
    np.testing.assert_allclose(column(trace(figure, "goal")["x"]), [8, 0])
    assert [each.get("showlegend", True) for each in figure["data"] if each["name"] == "route"] == [True, False]
