"""Voxel grids: cells that are in the way, in binvox files that another reader understands."""

import io
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scenery import call, simulated, vector

from crosstrack.airsim.scene.voxel_grid import binvox, runs
from crosstrack.airsim.server.errors import Refused
from crosstrack.world.shapes import Box, Sphere


def unpacked(data: bytes) -> tuple[list[int], list[float], float, NDArray[np.bool_]]:
    """Read a binvox file as its format says: sizes, lowest corner, scale and values in the file's order."""
    file = io.BytesIO(data)
    assert file.readline() == b"#binvox 1\n"
    sizes = [int(part) for part in file.readline().split()[1:]]
    corner = [float(part) for part in file.readline().split()[1:]]
    scale = float(file.readline().split()[1])
    assert file.readline() == b"data\n"
    pairs = np.frombuffer(file.read(), np.uint8).reshape(-1, 2)
    return sizes, corner, scale, np.repeat(pairs[:, 0], pairs[:, 1]).astype(bool)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Work in a folder that is empty."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_box_and_the_ground(folder: Path) -> None:
    simulator = simulated(Box((2, -4, 0), (4, 6, 5)))
    assert call(simulator, "simCreateVoxelGrid", vector(0, 0, -3), 20, 16, 12, 1.0, "map.binvox")
    sizes, corner, scale, values = unpacked((folder / "map.binvox").read_bytes())
    assert (sizes, corner) == ([20, 12, 16], [-10.0, -8.0, -6.0])
    assert scale == pytest.approx(1 / 20)
    cells = values.reshape(16, 12, 20)  # east, up, north
    for k, east in enumerate(np.arange(16) - 8.0):
        for j, up in enumerate(np.arange(12) - 6 + 3.0):
            for i, north in enumerate(np.arange(20) - 10.0):
                gap = max(2 - east, east - 4, -4 - north, north - 6, up - 5, -up)
                expected = gap <= 0.5 or up - 0.5 < 0
                if (
                    abs(gap - 0.5) > 1e-9
                    and sum(c > 0 for c in (2 - east, east - 4, -4 - north, north - 6, up - 5)) < 2
                ):
                    assert cells[k, j, i] == expected, (north, east, up)


def test_the_volume_of_a_ball() -> None:
    simulator = simulated(Sphere((0, 0, 10), 4.0))
    call(simulator, "simCreateVoxelGrid", vector(0, 0, -10), 10, 10, 10, 0.25, "ball.binvox")
    *_, values = unpacked(Path("ball.binvox").read_bytes())
    assert values.sum() * 0.25**3 == pytest.approx(4 / 3 * math.pi * (4 + 0.125) ** 3, rel=0.02)


@given(st.lists(st.tuples(st.booleans(), st.integers(1, 700)), min_size=1, max_size=20))
def test_runs_hold_the_values(pieces: list[tuple[bool, int]]) -> None:
    values = np.concatenate([np.full(length, value) for value, length in pieces])
    pairs = np.frombuffer(runs(values), np.uint8).reshape(-1, 2)
    np.testing.assert_array_equal(np.repeat(pairs[:, 0], pairs[:, 1]).astype(bool), values)
    assert (pairs[:, 1] > 0).all()
    least = sum(-(-len(list(run)) // 255) for run in np.split(values, np.flatnonzero(np.diff(values)) + 1))
    assert len(pairs) == least


def test_a_grid_of_one_cell() -> None:
    assert unpacked(binvox(np.ones((1, 1, 1), dtype=bool), (1, 1, 1)))[3].tolist() == [True]


def test_unfit_grids_are_refused(folder: Path) -> None:
    simulator = simulated()
    good: list[object] = [vector(0, 0, 0), 4, 4, 4, 1.0, "a.binvox"]
    bad: list[tuple[int, object]] = [
        (0, vector(math.nan, 0, 0)),
        (1, 0),
        (2, -5),
        (3, 2_000_000_000),
        (4, 0.0),
        (4, math.nan),
        (4, -1.0),
        (4, 1e-4),
        (4, 100.0),
        (5, "../a.binvox"),
        (5, "/etc/a.binvox"),
        (5, "a.txt"),
    ]
    for place, value in bad:
        with pytest.raises(Refused):
            call(simulator, "simCreateVoxelGrid", *good[:place], value, *good[place + 1 :])
    assert list(folder.iterdir()) == []
    assert not call(simulator, "simCreateVoxelGrid", *good[:5], "no/such/folder/a.binvox")
