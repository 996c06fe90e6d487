"""The carrot-chasing law of a tutorial, flown by AirSim's own client against the command that serves."""

import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from reference_client import needs_client, run

pytestmark = needs_client


@contextmanager
def command(folder: Path) -> Iterator[int]:
    """Serve with `crosstrack serve --lockstep` at any free port, until interrupted."""
    serve = [sys.executable, "-m", "crosstrack", "serve", "--lockstep", "--port", "0"]
    with subprocess.Popen(serve, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=folder) as server:
        try:
            assert server.stdout is not None
            found = None
            while found is None:
                line = server.stdout.readline()
                assert line, "it ended before it served"
                found = re.search(r":(\d+),", line)
            yield int(found[1])
        finally:
            server.send_signal(signal.SIGINT)
            server.wait(30)


def chase(speed: float, folder: Path) -> dict[str, Any]:
    """Fly after the carrot; return how well it went."""
    with command(folder) as port:
        run("carrot", port, speed, folder / "out.json")
    found: dict[str, Any] = json.loads((folder / "out.json").read_text())
    return found


def test_a_carrot_at_walking_pace_is_followed_closely_and_bit_for_bit_the_same_each_time(tmp_path: Path) -> None:
    one, two = chase(1.0, tmp_path), chase(1.0, tmp_path)
    assert one["root_mean_square"] < 0.3
    assert one["miss_at_end"] < 0.5
    assert one == two


def test_a_fast_carrot_ends_metres_off(tmp_path: Path) -> None:
    assert chase(10.0, tmp_path)["miss_at_end"] > 1.0
