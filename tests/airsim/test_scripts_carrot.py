"""The carrot-chasing law of a tutorial, flown by AirSim's own client against the command that serves."""

import json
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

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
            try:
                assert server.wait(30) == 0
            finally:
                server.kill()


def chase(speed: float, port: int, folder: Path) -> dict[str, Any]:
    """Fly after the carrot; return how well it went."""
    file = folder / f"{speed}.json"
    run("carrot", port, speed, file)
    found: dict[str, Any] = json.loads(file.read_text())
    return found


def test_a_slow_carrot_is_followed_and_a_fast_one_ends_metres_off_the_same_way_each_time(
    tmp_path: Path,
) -> None:
    with command(tmp_path) as port:
        fast, slow = chase(10.0, port, tmp_path), chase(1.0, port, tmp_path)
    with command(tmp_path) as port:
        again = chase(10.0, port, tmp_path)
    assert slow["root_mean_square"] < 0.3
    assert slow["miss_at_end"] < 0.5
    assert fast["miss_at_end"] > 1.0
    assert fast == again
