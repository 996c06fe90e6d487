"""What `crosstrack plan` does, and where a trajectory comes from a file."""

import json
import os
from collections.abc import Sequence
from pathlib import Path

from crosstrack import mission as missions
from crosstrack.cli import codes
from crosstrack.cli.watch import say
from crosstrack.errors import InputError, Problem
from crosstrack.mission.certified import Certified, Line, certified
from crosstrack.mission.certified import remarks as breaches
from crosstrack.trajectory.files.csv_file import TERMS, to_csv
from crosstrack.trajectory.files.json_file import to_json

JSON, CSV, CERTIFICATE, PAGE = "trajectory.json", "trajectory.csv", "certificate.json", "plan.html"


def from_file(mission: Path, trajectory: Path | None) -> list[str]:
    """Return the settings with which a mission takes its trajectory from a file.

    Raises:
        InputError: there is no such file.
    """
    if trajectory is None:
        return []
    if not trajectory.is_file():
        raise InputError("--from", [Problem(str(trajectory), "no such file")])
    relative = os.path.relpath(trajectory, mission.parent)
    return ["planner.kind=file", f"planner.file={json.dumps(relative)}"]


def plan(file: Path, trajectory: Path | None, folder: Path | None, settings: Sequence[str], as_json: bool) -> int:
    """Plan a mission's trajectory, certify it, and write both."""
    from crosstrack.cli.verbs import announce, made, named

    mission = missions.load(file, [*from_file(file, trajectory), *settings])
    if mission.planner is None:
        message = (
            "is required to plan a trajectory: add planner: {kind: minimum_snap}, or --set planner.kind=minimum_snap"
        )
        raise InputError(str(file), [Problem("planner", message)])
    announce("Planning", "interior")
    found = certified(mission, mission.build())
    folder = made(folder or Path("runs") / mission.name)
    with named(folder):
        write(found, folder)
    tell(found, folder, as_json)
    for remark in breaches(found):
        say(f"note: {remark}")
    return codes.BAD_INPUT if found.broken else codes.DONE


def write(found: Certified, folder: Path) -> None:
    """Write trajectory, certificate and page."""
    from crosstrack.show.plan_page import plan_page

    texts = {JSON: to_json(found.trajectory), CERTIFICATE: json.dumps(found.document(), indent=2) + "\n"}
    if found.trajectory.degree < TERMS:
        texts[CSV] = to_csv(found.trajectory)
    else:
        say(f"note: no {CSV}, which holds degrees up to {TERMS - 1}: these have {found.trajectory.degree}")
    (folder / CSV).unlink(missing_ok=True)
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    plan_page(found, folder / PAGE)


def tell(found: Certified, folder: Path, as_json: bool) -> None:
    """Print what is certified."""
    if as_json:
        print(json.dumps(found.document(), indent=2))
        return
    for line in found.lines:
        print(f"  {line.quantity:<34}{line.value:10.3f} {line.unit:<5}{versus(line)}".rstrip())
    print(f"Page: {folder / PAGE}")


def versus(line: Line) -> str:
    """Return the limit of a quantity as text."""
    if line.limit is None:
        return ""
    allowed = f"{'at least' if line.least else 'at most'} {max(line.limit, 0.0) if line.least else line.limit:.3f}"
    return f"  {allowed}" + ("" if line.holds else "  EXCEEDED")
