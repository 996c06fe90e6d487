from pathlib import Path

import numpy as np
import pytest
from matplotlib.patches import Rectangle
from PIL import Image

from crosstrack.show.study import draw, study_picture
from crosstrack.trajectory.weights.study import Study, study


@pytest.fixture(scope="module")
def found() -> Study:
    points = [[0, 0], [1, 2], [2, -1], [4, 8], [5, 2]]
    return study(points, [0, 0.54, 1.3, 3.53, 5], weights=[0, 1e3, 1e5])


def test_it_is_drawn(found: Study, tmp_path: Path) -> None:
    path = study_picture(found, tmp_path / "deep" / "study.png")
    with Image.open(path) as image:
        assert min(image.size) > 900
        colors = image.convert("RGB").getcolors(maxcolors=1 << 20)
    assert colors is not None
    assert len(colors) > 50


def test_every_panel_shows_every_weight(found: Study) -> None:
    figure = draw(found)
    figure.draw_without_rendering()
    plan, speed, acceleration, by_speed, by_acceleration = figure.axes
    labels = [line.get_label() for line in plan.lines]
    assert labels == ["straight legs", "λ = 0", "λ = 1000", "λ = 100000", "waypoints"]
    east, north = plan.transData.transform([1, 1]) - plan.transData.transform([0, 0])
    assert east == pytest.approx(north, rel=0.01)
    for axes, order in ((speed, 1), (acceleration, 2)):
        for line, row in zip(axes.lines, found.rows, strict=True):
            t, values = np.asarray(line.get_xdata()), np.asarray(line.get_ydata())
            np.testing.assert_allclose(values, np.linalg.norm(row.curve(t, order), axis=1))
    for axes, name in ((by_speed, "max_speed"), (by_acceleration, "max_acceleration")):
        drawn = np.asarray(axes.collections[0].get_offsets())
        np.testing.assert_allclose(drawn, [[getattr(row, name), row.max_deviation] for row in found.rows])
        assert axes.get_xlabel().split(" (")[0] == name.replace("max_", "peak ")


def test_the_corridor_is_drawn_about_the_inner_waypoints(found: Study) -> None:
    boxed = Study(found.waypoints, found.times, found.derivative, found.rows, corridor=0.5)
    boxes = [patch for patch in draw(boxed).axes[0].patches if isinstance(patch, Rectangle)]
    assert [(*box.get_xy(), box.get_width()) for box in boxes] == [(0.5, 1.5, 1), (1.5, -1.5, 1), (3.5, 7.5, 1)]
