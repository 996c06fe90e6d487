"""What clients draw: kept, seen for as long as they say, and bounded."""

import math

import numpy as np
import pytest
from scenery import at, call, simulated, vector

from crosstrack.airsim.scene import markers
from crosstrack.airsim.scene.markers import FOREVER, Markers
from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.simulator import Simulator
from crosstrack.types import Array

RED = np.array([1, 0, 0, 1], np.float32)
LINE: Array = np.array([[0, 0, -1], [1, 0, -1], [1, 1, -1], [2, 2, -2]], dtype=float)


def kinds(simulator: Simulator) -> list[str]:
    """Return what is seen now."""
    return [one.kind for one in simulator.scene.markers.seen(simulator.now)]


def test_markers_end_when_their_time_is_over() -> None:
    simulator = simulated()
    call(simulator, "simPlotPoints", LINE, RED, 5.0, 0.5, False)
    call(simulator, "simPlotArrows", LINE, LINE + 1, RED, 5.0, 10.0, -1.0, False)
    call(simulator, "simPlotLineList", LINE, RED, 5.0, 0.0, True)
    assert kinds(simulator) == ["points", "arrows", "lines"]
    simulator.idle(0.6)
    assert kinds(simulator) == ["arrows", "lines"]
    simulator.idle(0.5)
    assert kinds(simulator) == ["lines"]
    simulator.idle(100.0)
    assert kinds(simulator) == ["lines"]
    assert [one.kind for one in simulator.scene.markers.drawn] == ["points", "arrows", "lines"]


def test_flushing_ends_all_but_texts() -> None:
    simulator = simulated()
    call(simulator, "simPlotPoints", LINE, RED, 5.0, 100.0, False)
    call(simulator, "simPlotTransforms", [at(1, 2, 3)], 5.0, 2.0, -1.0, True)
    call(simulator, "simPlotStrings", ["a", "b", "c", "d"], LINE, 5.0, RED, 100.0)
    simulator.idle(0.1)
    call(simulator, "simFlushPersistentMarkers")
    assert kinds(simulator) == ["strings"]
    drawn = simulator.scene.markers.drawn
    assert [one.ends for one in drawn][:2] == [simulator.now] * 2
    assert drawn[0].begins == simulator.now - 102_000_000


def test_lines_go_from_point_to_point() -> None:
    simulator = simulated()
    call(simulator, "simPlotLineStrip", LINE, RED, 5.0, 1.0, True)
    call(simulator, "simPlotLineList", LINE[:3], RED, 5.0, 1.0, True)
    call(simulator, "simPlotArrows", LINE[:1], LINE[1:2], RED, 5.0, 10.0, 1.0, True)
    strip, pairs, arrow = simulator.scene.markers.drawn
    np.testing.assert_array_equal(strip.points.reshape(-1, 2, 3), np.stack([LINE[:-1], LINE[1:]], axis=1))
    np.testing.assert_array_equal(pairs.points, LINE[:2])
    np.testing.assert_array_equal(arrow.points, LINE[:2])
    assert strip.ends == FOREVER


def test_transforms_keep_how_they_are_turned() -> None:
    simulator = simulated()
    poses = [at(1, 2, 3, yaw=90), at(4, 5, 6)]
    call(simulator, "simPlotTransformsWithNames", poses, ["one", "two"], 5.0, 2.0, 1.0, RED, 3.0)
    drawn = simulator.scene.markers.drawn[0]
    assert drawn.texts == ("one", "two")
    assert drawn.orientations is not None
    np.testing.assert_allclose(drawn.orientations, [pose.orientation for pose in poses])


def test_nothing_is_drawn_of_nothing() -> None:
    simulator = simulated()
    none = np.empty((0, 3))
    call(simulator, "simPlotPoints", none, RED, 5.0, 1.0, True)
    call(simulator, "simPlotLineStrip", none, RED, 5.0, 1.0, True)
    call(simulator, "simPlotLineStrip", LINE[:1], RED, 5.0, 1.0, True)
    call(simulator, "simPlotTransforms", [], 5.0, 2.0, 1.0, True)
    assert len(simulator.scene.markers.drawn) == 0


def test_unfit_markers_are_refused() -> None:
    simulator = simulated()
    with pytest.raises(Refused, match="colour of 3"):
        call(simulator, "simPlotPoints", LINE, RED[:3], 5.0, 1.0, True)
    with pytest.raises(Refused, match="finite"):
        call(simulator, "simPlotPoints", LINE * math.nan, RED, 5.0, 1.0, True)
    with pytest.raises(Refused, match="as many"):
        call(simulator, "simPlotArrows", LINE, LINE[1:], RED, 5.0, 1.0, 1.0, True)
    with pytest.raises(Refused, match="as many"):
        call(simulator, "simPlotStrings", ["a"], LINE, 5.0, RED, 1.0)
    with pytest.raises(Refused, match="letters"):
        call(simulator, "simPlotStrings", ["a" * 200_000], LINE[:1], 5.0, RED, 1.0)
    with pytest.raises(Refused, match="Sim-API"):
        call(simulator, "simSetTraceLine", RED, 3.0, "none")
    assert len(simulator.scene.markers.drawn) == 0


def test_the_oldest_go_where_there_are_too_many(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(markers, "MOST_POINTS", 10)
    simulator = simulated()
    for k in range(7):
        call(simulator, "simPlotPoints", LINE[:3] + k, RED, 5.0, 1.0, True)
    kept: Markers = simulator.scene.markers
    assert [one.points[0, 0] for one in kept.drawn] == [4, 5, 6]
    assert kept.dropped == 4


def test_the_trace_of_a_vehicle() -> None:
    simulator = simulated(settings='{"Vehicles": {"V": {"VehicleType": "SimpleFlight"}}}')
    call(simulator, "simSetTraceLine", RED, 7.0, "")
    trace = simulator.scene.markers.traces["V"]
    assert (trace.color, trace.thickness) == ((1.0, 0.0, 0.0, 1.0), 7.0)


def test_ends_in_far_futures() -> None:
    simulator = simulated()
    call(simulator, "simPlotPoints", LINE, RED, 5.0, 1e30, False)
    call(simulator, "simPlotPoints", LINE, RED, 5.0, math.inf, False)
    assert vector(*(one.ends for one in simulator.scene.markers.drawn)).min() > 1e17
