"""AirSim's own client, in an environment of its own: the libraries that it wants are older than ours."""

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SCRIPTS = ROOT / "tests" / "airsim" / "scripts"
CLIENT = ROOT / ".venv-airsim" / "bin" / "python"
LONGEST = 300.0
"""s, that a script may take"""
needs_client = pytest.mark.skipif(
    not (ROOT / ".venv-airsim" / "installed").exists(),
    reason="needs AirSim's own client: make .venv-airsim/installed",
)


def run(script: str, port: int, *more: object) -> str:
    """Run a script to its end against a server; return what it printed."""
    command = [str(part) for part in (CLIENT, SCRIPTS / f"{script}.py", port, *more)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST, check=False)
    assert done.returncode == 0, f"{script} ended with code {done.returncode}\n{done.stdout[-2000:]}\n{done.stderr}"
    return done.stdout
