"""What the figures of the report and the pictures show of a flight, and at which scale."""

import base64
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

from crosstrack.flight.flight import Flight
from crosstrack.flight.metrics import cross_track
from crosstrack.flight.scene import Scene, scene
from crosstrack.show import figures, pictures
from crosstrack.show.extent import extent
from crosstrack.show.panels import Panel, Series, panels
from crosstrack.show.report import figures as drawn_by_script
from crosstrack.show.report import shortened, view
from crosstrack.show.style import FOOTPRINT, GRID, SCALE
from crosstrack.types import Array, Outcome


def unpacked(trace: dict[str, Any]) -> Array:

    columns = [np.frombuffer(base64.b64decode(trace[axis]["bdata"]), np.float32) for axis in "xy"]
    return np.column_stack(columns).astype(float)


def test_all_obstacles_are_one_mesh_of_the_same_triangles(flight: Flight) -> None:
    (_, vertices, triangles), *_ = scene(flight.plan).meshes
    twice = Scene(np.zeros((2, 3)), np.zeros((2, 3)), (("a", vertices, triangles), ("b", vertices + 20, triangles)))
    solid = twice.solid()
    assert solid is not None
    np.testing.assert_array_equal(solid[0][solid[1]], np.concatenate([vertices[triangles], vertices[triangles] + 20]))
    assert replace(twice, meshes=()).solid() is None


def test_only_the_faces_turned_to_the_viewer_are_drawn(flight: Flight) -> None:
    ((_, _, triangles),) = scene(flight.plan).meshes
    figure = pictures.space(flight, scene(flight.plan), cross_track(flight.plan, flight.record))
    figure.draw_without_rendering()
    (solid,) = [part for axes in figure.axes for part in axes.collections if isinstance(part, Poly3DCollection)]
    assert len(triangles) == 12
    assert len(solid.get_facecolor()) == 6


def test_the_picture_in_space_names_what_it_shows(flight: Flight) -> None:
    figure = pictures.space(flight, scene(flight.plan), cross_track(flight.plan, flight.record))
    legend = figure.axes[0].get_legend()
    assert legend is not None
    assert [text.get_text() for text in legend.get_texts()] == ["route", "flown", "start", "goal"]


@pytest.mark.parametrize(("outcome", "ended"), [(Outcome.ARRIVED, False), (Outcome.COLLIDED, True)])
def test_goal_and_end_of_flight_are_told_apart(flight: Flight, outcome: Outcome, ended: bool) -> None:
    short = replace(flight.record, position=flight.record.position.copy())
    short.position[-1] = [3.0, 4.0, 5.0]
    flown = replace(flight, outcome=outcome, record=short)
    still = scene(flown.plan)
    traces = {trace["name"]: trace for trace in figures.plan_view([view(flown, "f", "#000000")], still)["data"]}
    np.testing.assert_allclose(unpacked(traces["goal"]), still.route[-1:, :2])
    assert ("ended here" in traces) is ended
    names = [trace["name"] for trace in figures.space([view(flown, "f", "#000000")], still)["data"]]
    assert {"start", "goal", "flown"} <= set(names)
    assert ("ended here" in names) is ended
    if ended:
        np.testing.assert_allclose(unpacked(traces["ended here"]), [[3.0, 4.0]])
    found = {name: point for name, point, _ in pictures.ends(flown, still)}
    np.testing.assert_array_equal(found["goal"], still.route[-1])
    assert ("ended here" in found) is ended


def test_a_level_flight_has_its_room_above_the_ground_where_obstacles_stand(flight: Flight) -> None:
    still = scene(flight.plan)
    flat = replace(still, meshes=tuple((name, points * [10, 10, 0.1], faces) for name, points, faces in still.meshes))
    low, high = extent([], flat)
    longest = (high - low).max()
    assert -0.1 * longest < low[2] <= 0
    assert high[2] - low[2] > 0.15 * longest


def test_centimetres_are_drawn_as_small(fly_square: Callable[..., Flight]) -> None:
    steady = fly_square(wiggle=0.01)
    error = cross_track(steady.plan, steady.record)
    assert error.max() < 0.05
    assert drawn_by_script([view(steady, "f", "#000000")], scene(steady.plan))["least"]["error"] == 0.1
    (axes, *_) = pictures.space(steady, scene(steady.plan), error).axes
    (path,) = [part for part in axes.collections if isinstance(part, Line3DCollection)]
    assert path.get_colors()[:, 2].min() > to_rgb(SCALE[1][1])[2]  # no further along the scale than its middle
    (height,) = [panel for panel in panels(steady, error) if panel.title == "Height"]
    limits = height.range()
    assert limits is not None
    assert limits[1] - limits[0] == pytest.approx(1.0)


def test_an_axis_is_left_to_values_that_fill_it() -> None:
    wide = Series("a", np.array([0.0, np.nan, 5.0]))
    assert Panel("A", "m", (wide,), span=1.0).range() is None
    assert Panel("A", "m", (wide,)).range() is None
    assert Panel("A", "m", (Series("a", np.full(3, np.nan)),), span=1.0).range() is None


def test_long_lists_of_a_mission_are_cut_and_counted() -> None:
    document = {"route": [[float(k), 0.0] for k in range(1000)], "world": {"shapes": [1, 2]}}
    cut = shortened(document)
    assert cut["route"][:2] == [[0.0, 0.0], [1.0, 0.0]]
    assert cut["route"][-1] == "... and 800 more"
    assert cut["world"] == {"shapes": [1, 2]}
    assert len(document["route"]) == 1000


def test_obstacles_from_above_stand_out_from_the_grid() -> None:
    assert sum(to_rgb(GRID)) - sum(to_rgb(FOOTPRINT)) > 0.6
