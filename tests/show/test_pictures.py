from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from mpl_toolkits.mplot3d import Axes3D
from PIL import Image

from crosstrack.flight.flight import Flight
from crosstrack.flight.scene import scene
from crosstrack.show.panels import panels
from crosstrack.show.pictures import pictures, plan_view, space, times


def test_pictures_are_drawn(flight: Flight, tmp_path: Path) -> None:
    odd = replace(flight, plan=replace(flight.plan, name="50 $ and a_b^{c \\"))
    paths = pictures(odd, tmp_path / "deep" / "folder")
    assert [path.name for path in paths] == ["space.png", "plan.png", "times.png"]
    for path in paths:
        with Image.open(path) as image:
            assert min(image.size) > 600
            colors = image.convert("RGB").getcolors(maxcolors=1 << 20)
        assert colors is not None
        assert len(colors) > 50


def test_plan_view_shows_the_flight_with_equal_axes(flight: Flight) -> None:
    figure = plan_view(flight, scene(flight.plan))
    figure.draw_without_rendering()
    (axes,) = figure.axes
    corner = axes.transData.transform([[0, 0], [1, 0], [0, 1]])
    east, north = np.abs(corner[1] - corner[0])[0], np.abs(corner[2] - corner[0])[1]
    assert east == pytest.approx(north)
    flown = next(line for line in axes.lines if line.get_label() == "flown")
    np.testing.assert_array_equal(flown.get_xydata(), flight.record.position[:, :2])
    assert axes.get_xlabel().endswith("(m)")
    assert axes.get_ylabel().endswith("(m)")


def test_view_in_space_has_equal_axes(flight: Flight) -> None:
    figure = space(flight, scene(flight.plan), flight.cross_track)
    (axes,) = [axes for axes in figure.axes if isinstance(axes, Axes3D)]
    sides = np.ptp([axes.get_xlim(), axes.get_ylim(), axes.get_zlim()], axis=1)
    np.testing.assert_allclose(axes._box_aspect / axes._box_aspect[0], sides / sides[0])


def test_panels_name_their_units_and_nothing_is_cut_off(fly_square: Callable[..., Flight]) -> None:
    flight = fly_square()
    shown = panels(flight, flight.cross_track)
    figure = times(flight, shown)
    figure.draw_without_rendering()
    width, height = figure.get_size_inches() * figure.dpi
    for axes, panel in zip(figure.axes, shown, strict=True):
        assert axes.get_title(loc="left") == f"{panel.title} ({panel.unit})"
        box = axes.get_tightbbox()
        assert box is not None
        assert box.x0 >= 0
        assert box.y0 >= 0
        assert box.x1 <= width
        assert box.y1 <= height
    assert figure.axes[-1].get_xlabel() == "time (s)"
