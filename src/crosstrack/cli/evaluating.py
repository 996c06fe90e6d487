"""What `crosstrack evaluate` does."""

import json as plain
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from crosstrack.errors import InputError, Problem

if TYPE_CHECKING:
    from crosstrack.learn.evaluation.evaluate import Evaluation, Setup

PICTURE, SCORES = "evaluation.png", "results.json"
Words = Annotated[list[str] | None, Parameter(negative=())]


def evaluate(
    policy: str,
    *,
    maps: int = 100,
    seed: int = 500_000,
    density: Words = None,
    family: Words = None,
    beside: Words = None,
    jobs: int | None = None,
    out: Path | None = None,
    json: Annotated[bool, Parameter(negative=())] = False,
) -> int:
    """Fly a learned policy where it was never trained, and others beside it; print how often each arrives.

    Results are kept as they come: after an interruption the same command flies what is missing.

    Args:
        policy: its file, .npz, or the name of one that ships, such as avoid-ppo
        maps: how many worlds of each kind; of a policy that follows, how many routes
        seed: of the first world
        density: trees per m² of forests, such as 0.1,0.2; by default 0.1
        family: worlds such as forest, maze, discs-20, discs-30, trap, gap or beside; by default forest
        beside: what else flies: safe (the policy with the safety layer behind it), field (the potential field), planner
            and random; carrot and npfg beside a policy that follows; by default all of these; none for the policy alone
        jobs: how many flights at once; by default one for every core
        out: folder for results.jsonl, results.csv, results.json and evaluation.png; by default runs/evaluate/POLICY
        json: print the scores on standard output, and nothing else there
    """
    from crosstrack.campaign.local import Local
    from crosstrack.cli.campaigns import TABLE, flown, told
    from crosstrack.cli.verbs import announce, made
    from crosstrack.show.learned_picture import evaluation_picture

    asked = said(policy, maps, seed, words(density), words(family), words(beside), jobs)
    announce("Getting ready")
    tasks = asked.tasks()
    folder = made(out or Path("runs") / "evaluate" / Path(policy).stem)
    with flown("Flights of the evaluation", tasks, Local(jobs), folder) as done:
        found = asked.judged(tasks, done)
        found.write_csv(folder / TABLE)
        (folder / SCORES).write_text(plain.dumps(found.document(), indent=2) + "\n", encoding="utf-8")
        if found.results:
            evaluation_picture(found.results, folder / PICTURE)
    tell(found, folder, json)
    return told(found.losses)


def said(
    policy: str,
    maps: int,
    seed: int,
    densities: Sequence[str] | None,
    families: Sequence[str] | None,
    beside: Sequence[str] | None,
    jobs: int | None,
) -> "Setup":
    """Return what is asked for.

    Raises:
        InputError: everything that is wrong, or a package is missing.
    """
    from crosstrack.campaign.local import MOST

    try:
        from crosstrack.learn.evaluation.evaluate import setup
    except ModuleNotFoundError as error:
        message = f"needs the package {error.name}: pip install 'crosstrack[rl]'"
        raise InputError("evaluate", [Problem("", message)]) from None
    dense, problems = numbers(densities)
    if jobs is not None and not 1 <= jobs <= MOST:
        problems.append(Problem("jobs", f"must be from 1 to {MOST}, found {jobs}"))
    try:
        found = setup(policy, maps=maps, seed=seed, densities=dense, families=families, beside=beside)
    except InputError as error:
        problems = [*error.problems, *problems]
    if problems:
        raise InputError("evaluate", problems)
    return found


def words(texts: Sequence[str] | None) -> list[str] | None:
    """Return the words of lists such as `forest,maze`; None for none given."""
    return None if texts is None else [word.strip() for text in texts for word in text.split(",")]


def numbers(words: Sequence[str] | None) -> tuple[list[float] | None, list[Problem]]:
    """Return the numbers that words are, and what is wrong with those that are none; None for none given."""
    if words is None:
        return None, []
    found, problems = [], []
    for word in words:
        try:
            found.append(float(word))
        except ValueError:
            problems.append(Problem("density", f"must be numbers such as 0.1,0.2, found {word!r:.60}"))
    return found, problems


def tell(found: "Evaluation", folder: Path, as_json: bool) -> None:
    """Print the scores."""
    from crosstrack.cli.comparing import filled, show
    from crosstrack.show.learned_table import EXPLAINED, HEADINGS, cells

    if as_json:
        print(plain.dumps(found.document(), indent=2))
        return
    show([filled(HEADINGS, [cells(row) for row in found.scores])])
    print(EXPLAINED)
    print(f"Flights: {folder / PICTURE}" if found.results else "No flight came back.")
