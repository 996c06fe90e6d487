"""A training that is killed and resumed ends as one that never was."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from crosstrack.policy.file import load

pytestmark = pytest.mark.slow

TASKS = {
    "ppo": ["--set", "learning.n_steps=16", "--set", "learning.batch_size=512"],
    "a2c": [],
    "sac": ["--set", "learning.learning_starts=500", "--set", "learning.buffer_size=20000"],
    "learned": ["--algo", "sac", "--set", "learning.ent_coef=auto", "--set", "learning.learning_starts=500"],
    "dqn": ["--set", "learning.learning_starts=500", "--set", "learning.buffer_size=20000"],
    "double-dqn": ["--network", "dueling", "--set", "learning.learning_starts=500", "--set", "learning.n_steps=1"],
    "recurrent": ["--algo", "ppo", "--network", "recurrent", "--set", "learning.n_steps=16"],
}
COMMON = ["--steps", "12000", "--envs", "64", "--seed", "4", "--set", "checkpoint_every=0"]
QUICK = ["--set", "evaluating.every=4000", "--set", "evaluating.episodes=20", "--set", "learning.batch_size=256"]


def command(name: str, out: Path, *more: str) -> list[str]:
    """Return the command of a training."""
    told = TASKS[name] if "--algo" in TASKS[name] else ["--algo", name, *TASKS[name]]
    quick = QUICK[:-2] if name == "a2c" else QUICK
    return [sys.executable, "-m", "crosstrack", "train", "hover", *told, *COMMON, *quick, "--out", str(out), *more]


@pytest.mark.parametrize("name", TASKS)
def test_a_training_that_is_killed_ends_with_the_same_weights(name: str, tmp_path: Path) -> None:
    whole, broken = tmp_path / "whole", tmp_path / "broken"
    subprocess.run(command(name, whole), check=True, capture_output=True)
    process = subprocess.Popen(command(name, broken), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while not (broken / "checkpoint.npz").exists():
        assert process.poll() is None
        time.sleep(0.02)
    time.sleep(0.3)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    done = subprocess.run(command(name, broken, "--resume"), check=False, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    with np.load(whole / "checkpoint.npz") as one, np.load(broken / "checkpoint.npz") as two:
        assert set(one.files) == set(two.files)
        for key in set(one.files) - {"tree"}:
            assert one[key].tobytes() == two[key].tobytes(), key
    first, second = load(whole / "policy.npz"), load(broken / "policy.npz")
    assert first.card.measured == second.card.measured
    assert "--resume" not in second.card.training["command"]
    for key in first.arrays:
        assert first.arrays[key].tobytes() == second.arrays[key].tobytes()


def test_ctrl_c_leaves_a_policy_and_a_checkpoint(tmp_path: Path) -> None:
    process = subprocess.Popen(
        [*command("ppo", tmp_path), "--set", "steps=100000000"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
    )
    while not (tmp_path / "checkpoint.npz").exists():
        assert process.poll() is None
        time.sleep(0.05)
    process.send_signal(signal.SIGINT)
    process.communicate()
    assert process.returncode == 130
    assert load(tmp_path / "policy.npz").card.training["steps"] > 0
    assert (tmp_path / "learning_curve.png").exists()
