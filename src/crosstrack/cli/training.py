"""`crosstrack train`: a policy learned, in a folder of its own."""

import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from crosstrack.cli.codes import DONE
from crosstrack.errors import InputError, Problem

Settings = Annotated[list[str] | None, Parameter(name="--set", negative=())]
CONFIG, POLICY = "config.json", "policy.npz"
Switch = Annotated[bool, Parameter(negative=())]


def train(
    task: str,
    *,
    algo: str | None = None,
    network: str | None = None,
    preset: str | None = None,
    steps: int | None = None,
    envs: int | None = None,
    seed: int | None = None,
    until: float | None = None,
    minutes: float | None = None,
    config: Path | None = None,
    settings: Settings = None,
    out: Path | None = None,
    resume: Switch = False,
) -> int:
    """Train a policy in simulation; write it, its learning curve and logs for TensorBoard.

    Args:
        task: avoid, follow or hover
        algo: dqn, double-dqn, ppo, sac or a2c
        network: mlp, dueling, cnn or recurrent
        preset: what to begin from: tuned; staged, A2C that begins in an empty world; article, the DQN of a tutorial
        steps: decisions
        envs: vehicles that fly at once
        seed: of everything that chance decides
        until: success in worlds held out, as a share, that ends the training
        minutes: after which it ends
        config: a YAML file of these and all other fields, see docs/learning.md
        settings: set one field, such as learning.gamma=0.98 or options.density=0.2; may be given several times
        out: folder; by default runs/train/TASK-ALGO
        resume: go on from the checkpoint in the folder
    """
    fields = {
        "network": network,
        "steps": steps,
        "envs": envs,
        "seed": seed,
        "until": until,
        "minutes": minutes,
    }
    with extra():
        from crosstrack.learn.training.reading import Asked, mapping, resumed, training
    told = Asked(algo, preset, config, fields, settings or ())
    folder = out or Path("runs") / "train" / f"{task}-{algo}"
    wanted = resumed(mapping(folder / CONFIG), task, told, str(folder / CONFIG)) if resume else training(task, told)
    with extra():
        from crosstrack.learn.training import checkpoint
        from crosstrack.learn.training.run import Run
    from rich.console import Console

    from crosstrack.cli.learning_curve import Curve
    from crosstrack.show.learning import learning_curve

    held = checkpoint.read(folder) if resume else None
    if held is None and (folder / checkpoint.NAME).exists():
        message = "holds a training already: go on with --resume, or name another folder with --out"
        raise InputError(str(folder), [Problem("", message)])
    command = shlex.join(["crosstrack", *sys.argv[1:]])
    run = Run(wanted, folder, command, held)
    console = Console(stderr=True)
    try:
        with Curve(console, wanted) as curve:
            policy = run.fly(curve.show)
    finally:
        if run.progress.history:
            learning_curve(run.progress.history, folder / "learning_curve.png", f"{task} by {wanted.algo}")
    found = policy.card.measured
    console.print(
        f"{found['success']:.1%} of {found['episodes']} worlds that it had never seen, "
        f"in {run.progress.steps:,} decisions and {run.progress.seconds / 60:.1f} minutes"
    )
    print(folder / POLICY)
    return DONE


@contextmanager
def extra() -> Iterator[None]:
    """Say what to install where an import finds that it is missing.

    Raises:
        InputError: it is.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        message = f"needs the package {error.name}: pip install 'crosstrack[rl]'"
        raise InputError("train", [Problem("", message)]) from None
