"""One training, from the first decision or from a checkpoint to its policy."""

import csv
import json
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.callbacks import BaseCallback

from crosstrack.errors import InputError, Problem
from crosstrack.learn import tasks
from crosstrack.learn.export import policy_of
from crosstrack.learn.measuring import CHOOSING, Measured, Range
from crosstrack.learn.stable import StableVector
from crosstrack.learn.training import checkpoint
from crosstrack.learn.training.config import Training
from crosstrack.learn.training.model import model_of
from crosstrack.learn.training.reading import MOST_BYTES, unknown, validated
from crosstrack.learn.vector import Vector
from crosstrack.policy.card import Observation
from crosstrack.policy.file import load, save
from crosstrack.policy.policy import Policy

CONFIG, EVALUATIONS, POLICY = "config.json", "evaluations.csv", "policy.npz"
MEANS = {"success": "success", "reward": "r"}
"""what is noted of the last episodes of a training, and its name in their accounts"""
Q_LEARNING = {"dqn", "double-dqn"}
"""algorithms whose actions are counted"""
EPISODES = 500
"""of the last measurement"""


class Enough(Exception):  # noqa: N818 - no error
    """The training is over before its steps are flown."""


@dataclass
class Progress:
    """How far a training has come."""

    steps: int = 0
    """decisions"""
    seconds: float = 0.0
    """that it has taken, over all its parts"""
    stage: int = 0
    """of the curriculum"""
    next_evaluation: int = 0
    """decisions"""
    best: float = -1.0
    """success of the best policy so far, and less than 1 for its reward to decide between equals"""
    history: list[dict[str, Any]] = field(default_factory=list)
    """evaluations"""
    recent: dict[str, float] = field(default_factory=dict)
    """mean over the last episodes of the training: success, reward"""
    command: str = ""
    """that began it"""


Watch = Callable[[Progress], None]


class Run:
    """A training in its folder."""

    def __init__(self, asked: Training, folder: Path, command: str, held: dict[str, Any] | None = None) -> None:
        """Begin, or go on from what a checkpoint holds.

        Raises:
            InputError: options that the task does not have, or a network that does not fit it.
        """
        torch.set_num_threads(asked.threads)
        self.asked, self.folder = asked, folder
        self.task = task_of(asked)
        self.env = StableVector(Vector(self.task, asked.envs, asked.seed))
        folder.mkdir(parents=True, exist_ok=True)
        self.model = model_of(asked, self.task, self.env, folder / "tensorboard")
        self.range = Range(self.task, asked.evaluating.episodes, CHOOSING)
        self.progress = Progress(next_evaluation=asked.evaluating.every)
        self.stopped = False
        if held is not None:
            self.progress = Progress(**held["document"])
        self.progress.command = self.progress.command or command
        self.climb()
        if held is not None:
            checkpoint.restore(self.model, self.env, held)
        self.written = self.begun = time.monotonic()
        self.before = self.progress.seconds

    def fly(self, watch: Watch) -> Policy:
        """Train until the end, and return the policy that did best.

        Raises:
            KeyboardInterrupt: Ctrl-C, after checkpoint and policy were written.
        """
        (self.folder / CONFIG).write_text(json.dumps(self.asked.document(), indent=1) + "\n", "utf-8")
        inner: Any = self.model.train

        def train(*arguments: Any, **options: Any) -> None:
            inner(*arguments, **options)
            self.updated(watch)

        self.model.train = train  # between updates the state is simple
        first = self.progress.steps == 0
        left = self.asked.steps - self.model.num_timesteps
        with interruptible(self):
            try:
                if left > 0:
                    self.model.learn(left, Listener(self), log_interval=10, reset_num_timesteps=first)
            except Enough:
                pass
        self.keep()
        if self.stopped:
            self.finish(self.range.episodes)
            raise KeyboardInterrupt
        return self.finish(EPISODES)

    def updated(self, watch: Watch) -> None:
        """Look after a training after each update."""
        progress, asked = self.progress, self.asked
        progress.steps = self.model.num_timesteps
        progress.seconds = self.before + time.monotonic() - self.begun
        self.recall()
        enough = self.stopped
        if progress.steps >= progress.next_evaluation:
            progress.next_evaluation += asked.evaluating.every
            enough |= self.evaluate()
        self.climb()
        watch(progress)
        if time.monotonic() - self.written >= asked.checkpoint_every:
            self.keep()
        if enough or (asked.minutes is not None and progress.seconds >= 60 * asked.minutes):
            raise Enough

    def recall(self) -> None:
        """Note how the last episodes went."""
        episodes = list(self.model.ep_info_buffer or ())
        if episodes:
            means = {name: float(np.mean([one[key] for one in episodes])) for name, key in MEANS.items()}
            self.progress.recent = means

    def climb(self) -> None:
        """Fly the stage of the curriculum that the progress calls for."""
        progress, stages = self.progress, self.asked.curriculum
        while progress.stage < len(stages):
            stage = stages[progress.stage]
            episodes = self.model.ep_info_buffer
            known = episodes is not None and len(episodes) == episodes.maxlen
            good = known and progress.recent.get("success", 0.0) >= stage.success
            if not (good or (stage.steps is not None and progress.steps >= stage.steps)):
                break
            progress.stage += 1
            progress.recent = {}
            if episodes is not None:
                episodes.clear()
        level: dict[str, Any] = {name: getattr(self.task, name) for stage in stages for name in stage.level}
        if progress.stage < len(stages):
            level |= stages[progress.stage].level
        if any(getattr(self.env.env.task, name) != value for name, value in level.items()):
            self.env.env.level(**level)

    def evaluate(self) -> bool:
        """Measure the policy as it is; keep it where it is the best; return whether it is good enough to end."""
        progress = self.progress
        policy = self.exported()
        found = self.range.measure(policy)
        progress.history.append({"steps": progress.steps, "seconds": round(progress.seconds, 1), **found.document()})
        write_history(self.folder / EVALUATIONS, progress.history)
        self.model.logger.record("eval/success", found.success)
        merit = found.success + np.tanh(found.reward / 1000) / (10 * found.episodes)
        if merit > progress.best:
            progress.best = float(merit)
            save(policy, self.folder / POLICY)
        return self.asked.until is not None and found.success >= self.asked.until

    def exported(self) -> Policy:
        """Return the policy as it is, not measured yet."""
        task, asked = self.task, self.asked
        seen = tuple(task.seen)
        drawn = getattr(task, "picture", None) if asked.network == "cnn" else None
        return policy_of(
            self.model,
            task=task.name,
            options=tasks.options(task),
            observation=Observation(sum(size for _, size in seen), seen, drawn and tuple(drawn)),
            algorithm=asked.algo,
            network=asked.network,
            training=self.account(),
            measured={},
        )

    def account(self) -> dict[str, Any]:
        """Return how the policy came about."""
        progress = self.progress
        return {
            "command": progress.command,
            "seed": self.asked.seed,
            "steps": progress.steps,
            "seconds": round(progress.seconds, 1),
        }

    def finish(self, episodes: int) -> Policy:
        """Measure the best policy in worlds that nothing was chosen by, and write it."""
        if not self.progress.history:
            self.evaluate()
        best = load(self.folder / POLICY)
        found: Measured = Range(self.task, episodes).measure(best)
        best = Policy(replace(best.card, measured=found.document()), best.arrays)
        save(best, self.folder / POLICY)
        return best

    def keep(self) -> None:
        """Write a checkpoint."""
        checkpoint.write(self.folder, self.model, self.env, vars(self.progress))
        self.written = time.monotonic()


class Listener(BaseCallback):
    """What Stable-Baselines3 asks for; a training is looked after between updates."""

    def __init__(self, run: Run) -> None:
        super().__init__()
        self.run = run

    def _on_step(self) -> bool:
        return True


def task_of(asked: Training) -> Any:
    """Return the task of a training.

    Raises:
        InputError: it has no such option.
    """
    said = {"action": "stick"} | asked.options if asked.algo in Q_LEARNING else asked.options
    kind = tasks.find(asked.task)
    problems = list(unknown(kind, said, ("options",)))
    made, faults = validated(kind, said, ("options",))
    for index, stage in enumerate(asked.curriculum):
        place = ("curriculum", index, "level")
        faults += [*unknown(kind, stage.level, place), *validated(kind, stage.level, place)[1]]
    if problems + faults:
        raise InputError("train", problems + faults)
    told = getattr(asked.learning, "buffer_size", 0)
    most = MOST_BYTES // (8 * sum(size for _, size in made.seen) + 16)
    if told > most:
        message = f"must be at most {most:,}, which take {MOST_BYTES:,} bytes; found {told:,}"
        raise InputError("train", [Problem("learning.buffer_size", message)])
    q = asked.algo in Q_LEARNING
    if (made.action == "stick") != q and asked.algo not in {"ppo", "a2c"}:
        kinds = "chooses one of several actions: action must be stick" if q else "needs continuous actions, not stick"
        raise InputError("train", [Problem("options.action", f"{asked.algo} {kinds}")])
    if asked.network == "cnn" and getattr(made, "observation", "") != "depth":
        raise InputError("train", [Problem("network", "cnn needs a picture: options.observation must be depth")])
    return made


def write_history(path: Path, history: list[dict[str, Any]]) -> None:
    """Write evaluations as a table."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, list(history[0]))
        writer.writeheader()
        writer.writerows(history)


@contextmanager
def interruptible(run: Run) -> Iterator[None]:
    """Have Ctrl-C end a training after the update at hand."""

    def stop(number: int, frame: Any) -> None:
        run.stopped = True

    before = signal.signal(signal.SIGINT, stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
