"""A curriculum leads to the task as it was asked for; what cannot be gone on from is said."""

from collections import deque
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crosstrack.errors import InputError

pytestmark = pytest.mark.slow

QUICK = ("options.maps=2", "envs=8", "learning.batch_size=64", "evaluating.episodes=2")


def begun(folder: Path, *settings: str) -> Any:
    """Return a training before its first decision."""
    from crosstrack.learn.training.reading import Asked, training
    from crosstrack.learn.training.run import Run

    return Run(training("avoid", Asked(algo="ppo", settings=(*QUICK, *settings))), folder, "train")


def went(run: Any, success: float, episodes: int = 100) -> None:
    """Let the last episodes of a training have gone so, and go on."""
    run.model.ep_info_buffer = deque([{"success": success, "r": 0.0}] * episodes, maxlen=100)
    run.recall()
    run.climb()


def test_the_last_stage_is_followed_by_the_task_itself(tmp_path: Path) -> None:
    run = begun(tmp_path, "curriculum=[{level: {density: 0.02}}, {level: {speed: 2.0}, success: 0.5}]")
    whole, env = run.task, run.env.env
    assert (env.task.density, env.task.speed) == (0.02, whole.speed)
    went(run, 0.79)
    assert env.task.density == 0.02
    went(run, 1.0, 99)
    assert env.task.density == 0.02, "too few episodes to tell"
    went(run, 0.81)
    assert len(run.model.ep_info_buffer) == 0, "those of the stage before say nothing of this one"
    assert (env.task.density, env.task.speed) == (whole.density, 2.0)
    went(run, 0.51)
    assert env.task == whole
    field = env.field
    run.climb()
    assert env.field is field


def test_a_level_names_options_of_the_task(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"curriculum\[0\].level.densty: unknown; did you mean 'density'"):
        begun(tmp_path, "curriculum=[{level: {densty: 0.02}}]")


@pytest.mark.parametrize("damage", ["empty", "short", "text"])
def test_a_damaged_checkpoint_is_told(damage: str, tmp_path: Path) -> None:
    from crosstrack.learn.training import checkpoint

    path = tmp_path / checkpoint.NAME
    np.savez(path, tree=np.arange(1000, dtype=np.uint8))
    whole = path.read_bytes()
    path.write_bytes({"empty": b"", "short": whole[: len(whole) // 2], "text": b"hello"}[damage])
    with pytest.raises(InputError, match="no checkpoint that can be read"):
        checkpoint.read(tmp_path)
