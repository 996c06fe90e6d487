"""One vehicle or many, one call or many: the same flight."""

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crosstrack.sim.airframe import AIRFRAMES, GENERIC
from crosstrack.sim.fleet import MOTION, ROW, fleet, place
from crosstrack.sim.kernel import STEP, fly
from crosstrack.types import Air, Limits


def squadron(count: int, seed: int = 0) -> Any:
    """Return vehicles of every airframe with commands of their own."""
    rng = np.random.default_rng(seed)
    frames = [AIRFRAMES[name] for name in rng.choice(sorted(AIRFRAMES), count)]
    rows: Any = np.concatenate([fleet(frame, Air(), Limits(), ground=0.0) for frame in frames])
    place(rows, rng.uniform(2, 20, (count, 3)), rng.uniform(-3, 3, count))
    rows["level"] = MOTION
    rows["command"][:, 3:6] = rng.uniform(-3, 3, (count, 3))
    rows["command"][:, 9] = rng.uniform(-3, 3, count)
    rows["wind"] = rng.uniform(-2, 2, (count, 3))
    return rows


def test_many_together_fly_as_each_alone_bit_for_bit() -> None:
    together = squadron(40)
    alone = [together[i : i + 1].copy() for i in range(len(together))]
    for _ in range(10):
        fly(together, STEP, 8)
        for row in alone:
            fly(row, STEP, 8)
    assert np.concatenate(alone).tobytes() == together.tobytes()
    assert np.unique(together["state"], axis=0).shape == together["state"].shape


def test_one_long_call_is_many_short_ones() -> None:
    one, many = squadron(5), squadron(5)
    fly(one, STEP, 80)
    for _ in range(10):
        fly(many, STEP, 8)
    for name in ROW.names or ():
        np.testing.assert_allclose(one[name], many[name], rtol=1e-9, atol=1e-12)


def test_flight_is_the_same_when_flown_again() -> None:
    one, again, other = squadron(5), squadron(5), squadron(5, seed=1)
    for rows in (one, again, other):
        fly(rows, STEP, 200)
    assert one.tobytes() == again.tobytes()
    assert one.tobytes() != other.tobytes()


GUSTY = """
import numpy as np
from crosstrack.sim.airframe import CRAZYFLIE
from crosstrack.sim.fleet import fleet, place
from crosstrack.sim.kernel import STEP, fly
from crosstrack.types import Air, Limits

rows = fleet(CRAZYFLIE, Air(), Limits(), ground=0.0)
place(rows, np.array([0.0, 0.0, 9.0]), 0.3)
rng = np.random.default_rng(1)
for _ in range(100):
    rows["command"][:, 3:6] = rng.uniform(-2, 2, 3)
    rows["wind"] = rng.uniform(-2, 2, 3)
    fly(rows, STEP, 8)
print(rows["state"].tobytes().hex())
"""


def test_the_flight_that_compiles_is_bit_for_bit_the_later_ones(tmp_path: Path) -> None:
    settings = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    compiling, cached = (
        subprocess.run([sys.executable, "-c", GUSTY], env=settings, capture_output=True, text=True, check=True)
        for _ in range(2)
    )
    assert len(compiling.stdout.strip()) == 2 * 17 * 8
    assert cached.stdout == compiling.stdout


def test_only_the_flown_state_changes() -> None:
    rows = squadron(6)
    before = rows.copy()
    fly(rows, STEP, 40)
    kept = set(ROW.names or ()) - {"state", "expected", "yaw", "impact"}
    for name in kept:
        np.testing.assert_array_equal(rows[name], before[name])
    assert not np.array_equal(rows["state"], before["state"])


@pytest.mark.parametrize("speed", [0.5, 2.0])
def test_impact_is_the_speed_of_the_touch(speed: float) -> None:
    rows: Any = fleet(GENERIC, Air(), Limits(), ground=0.0)
    place(rows, np.array([0.0, 0.0, 1.5]), 0.0)
    rows["command"][:, 3:6] = 0.0, 0.0, -speed
    fly(rows, STEP, int(4 / STEP))
    assert rows["impact"][0] == pytest.approx(speed, rel=0.15)
    assert rows["state"][0, 2] == pytest.approx(GENERIC.gear, abs=0.01)
