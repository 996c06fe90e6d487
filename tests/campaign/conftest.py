"""Short flights to run as tasks."""

from pathlib import Path

import pytest

import crosstrack as ct
from crosstrack.campaign.grid import grid
from crosstrack.campaign.task import Task


@pytest.fixture(scope="package")
def hop() -> ct.Mission:
    """Return a short mission, noisy so that seeds matter."""
    return ct.loads(
        "{name: hop, start: {position: [0, 0, 5]}, route: [[6, 0], [6, 6]], speed: 3, timing: {timeout: 30},"
        " noise: {position: 0.01}}"
    )


@pytest.fixture(scope="package")
def tasks(hop: ct.Mission) -> list[Task]:
    """Return flights of it in two winds, and of a mission with a file."""
    rooms = ct.load(Path(__file__).parents[2] / "examples" / "rooms.yaml", ["timing.timeout=3"])
    varied = grid([hop], ["mission", "carrot:lookahead=2"], ["calm", "1,0,0,light"], 2)
    return [*varied, *grid([rooms], ["carrot"], ["calm"])]
