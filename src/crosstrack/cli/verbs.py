"""What the verbs of the command do."""

import json
import shlex
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.resources import files
from pathlib import Path
from typing import Any

from crosstrack import mission as missions
from crosstrack.cli import codes
from crosstrack.cli.watch import Interrupt, Progress, say
from crosstrack.compiled import cache_folder
from crosstrack.errors import InputError, Problem
from crosstrack.flight import loop
from crosstrack.flight.flight import Flight
from crosstrack.flight.log import LogWriter
from crosstrack.flight.observer import Observer
from crosstrack.flight.plan import Plan
from crosstrack.flight.recording import read_log
from crosstrack.flight.summary import summary, summary_together
from crosstrack.mission.certified import certified
from crosstrack.mission.certified import remarks as breaches
from crosstrack.mission.check import remarks
from crosstrack.mission.load import dump
from crosstrack.types import Outcome

CODES = {
    Outcome.ARRIVED: codes.DONE,
    Outcome.COLLIDED: codes.COLLIDED,
    Outcome.LINK_LOST: codes.LINK_LOST,
    Outcome.INTERRUPTED: codes.INTERRUPTED,
}
LOG, SUMMARY, REPORT = "flight.mcap", "summary.json", "report.html"
SHOWN = {
    "flight_time_s": "flight time, s",
    "ideal_time_s": "planned time, s",
    "cross_track_rms_m": "cross-track error, RMS, m",
    "cross_track_max_m": "largest cross-track error, m",
    "tracking_rms_m": "tracking error, RMS, m",
    "tracking_max_m": "largest tracking error, m",
    "final_error_m": "distance to the last waypoint, m",
    "min_clearance_m": "least clearance, m",
    "min_separation_m": "least separation, m",
    "planning_time_s": "time to plan, s",
    "replans": "plans made in flight",
    "safety_interventions": "times that safety stepped in",
    "max_speed_mps": "top speed, m/s",
}


def fly(file: Path, out: Path | None, settings: Sequence[str], as_json: bool, png: bool) -> int:
    """Fly a mission and write what it leaves behind."""
    mission = missions.load(file, settings)
    announce("Getting ready")
    plans = mission.plans()
    for remark in notes(mission, plans):
        say(f"note: {remark}")
    folder = emptied(out or Path("runs") / mission.name)
    loop.warm_up(plans[0])
    with named(folder):
        with Interrupt() as interrupt:
            logs = [LogWriter(folder / log) for log in log_names(mission)]
            watching: list[list[Observer]] = [[log] for log in logs]
            watching[0] += [Progress(plans[0]), interrupt]
            flights = loop.fly_together(plans, watching)
        write(flights, folder, png)
    tell(flights, folder, as_json)
    return max(CODES.get(flight.outcome, codes.NOT_ARRIVED) for flight in flights)


def log_names(mission: missions.Mission) -> list[str]:
    """Return the names of the logs, one for each vehicle."""
    return [f"{member.name}.mcap" for member in mission.members] if mission.vehicles else [LOG]


def announce(doing: str, module: str = "") -> None:
    """Say what is done first, and that it takes long where no earlier run compiled the module, or anything at all."""
    compiled_before = any(cache_folder().rglob(f"{module}*.nbc"))
    say(f"{doing} ..." if compiled_before else f"{doing}; the first run compiles for some two minutes ...")


def notes(mission: missions.Mission, plans: Sequence[Plan]) -> list[str]:
    """Say what is odd about a mission and its plans, and which limits their trajectories break."""
    found = []
    for member, plan in zip(mission.members, plans, strict=True):
        planned = breaches(certified(member, plan)) if member.planner is not None else []
        found += [*remarks(member), *planned, *late(plan)]
    return list(dict.fromkeys(found))


def late(plan: Plan) -> list[str]:
    """Say when the time allowed is shorter than the time planned."""
    planned = plan.course.speed.duration
    if planned <= plan.timeout:
        return []
    return [f"the route is planned for {planned:.0f} s, longer than timing.timeout, {plan.timeout:g} s"]


def emptied(folder: Path) -> Path:
    """Make a folder, without the results of an earlier flight."""
    made(folder)
    for name in (LOG, SUMMARY, REPORT):
        (folder / name).unlink(missing_ok=True)
    return folder


def made(folder: Path) -> Path:
    """Make a folder for results.

    Raises:
        InputError: it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise InputError("--out", [Problem(str(folder), "must be a folder, found a file")]) from None
    except OSError as error:
        raise InputError("--out", [Problem(str(folder), f"this folder cannot be made: {error.strerror}")]) from None
    return folder


@contextmanager
def named(folder: Path) -> Iterator[None]:
    """Name the folder in an error that names no file, such as that of a full disk."""
    try:
        yield
    except OSError as error:
        error.filename = error.filename or str(folder)
        raise


def write(flights: Sequence[Flight], folder: Path, png: bool) -> None:
    """Write the summary, the report and, where asked, the pictures of one flight or of several at once."""
    from crosstrack.show.report import report

    (folder / SUMMARY).write_text(json.dumps(numbers_of(flights), indent=2) + "\n", encoding="utf-8")
    report(flights, folder / REPORT)
    if png and len(flights) == 1:
        from crosstrack.show.pictures import pictures

        pictures(flights[0], folder)
    elif png:
        from crosstrack.show.together_picture import picture_together

        picture_together(flights, folder / "together.png")


def numbers_of(flights: Sequence[Flight]) -> dict[str, Any]:
    """Return the summary of one flight, or of several at once."""
    return summary(flights[0]) if len(flights) == 1 else summary_together(flights)


def tell(flights: Sequence[Flight], folder: Path, as_json: bool) -> None:
    """Print the summary of one flight, or of several at once."""
    numbers = numbers_of(flights)
    if as_json:
        print(json.dumps(numbers, indent=2))
        return
    if len(flights) > 1:
        arrived = sum(flight.outcome is Outcome.ARRIVED for flight in flights)
        print(f"{arrived} of {len(flights)} arrived.")
        for outcome, count in Counter(flight.outcome for flight in flights).items():
            if outcome is not Outcome.ARRIVED:
                print(f"  {count}: {outcome.value}")
    else:
        print(flights[0].outcome.value)
    for name, label in SHOWN.items():
        if numbers.get(name) is not None:
            value = numbers[name]
            print(f"  {label:<32}{value:10.3f}" if isinstance(value, float) else f"  {label:<32}{value:10d}")
    print(f"Report: {folder / REPORT}")


def check(file: Path | None, schema: bool, settings: Sequence[str]) -> int:
    """Print a resolved mission, or the schema of missions."""
    if schema:
        print(json.dumps(missions.schema(), indent=2))
        return 0
    if file is None:
        raise InputError("check", [Problem("FILE", "name a mission file, or give --schema")])
    mission = missions.load(file, settings)
    plans = mission.plans()
    sys.stdout.write(dump(mission.document()))
    told = notes(mission, plans)
    for remark in told:
        say(f"note: {remark}")
    verdict = "valid, but see the notes" if told else "fine"
    length, duration = (
        max(each) for each in zip(*((p.route.length, p.course.speed.duration) for p in plans), strict=True)
    )
    longest = "The longest route" if mission.vehicles else "Route"
    say(f"{file}: {verdict}. {longest} {length:.1f} m, planned for {duration:.1f} s.")
    return 0


def init(name: str) -> int:
    """Write a mission to start from."""
    path = Path(f"{name.removesuffix('.yaml')}.yaml")
    if path.name == ".yaml":
        raise InputError("init", [Problem("NAME", f"must be the name of a mission, such as square; found {name!r}")])
    template = files("crosstrack.mission").joinpath("template.yaml").read_text(encoding="utf-8")
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(template)
    except FileExistsError:
        raise InputError("init", [Problem(str(path), "exists already and is not overwritten")]) from None
    print(f"Wrote {path}. Fly it: crosstrack fly {shlex.quote(str(path))}")
    return 0


def replay(log: Path, out: Path | None, as_json: bool, png: bool) -> int:
    """Make the summary and the report again from a log."""
    recording = read_log(log)
    plan = missions.from_document(recording.document, recording.files).build()
    outcome = recording.outcome
    if outcome is None:
        say("note: the log ends before the flight did")
    flight = Flight(
        plan,
        outcome or Outcome.INTERRUPTED,
        recording.record,
        recording.effort,
        recording.replans,
        recording.seen,
    )
    folder = made(out or log.parent)
    with named(folder):
        write([flight], folder, png)
    tell([flight], folder, as_json)
    return 0


def export(file: Path, out: Path, settings: Sequence[str]) -> int:
    """Write a mission as a plan, or as AirSim's settings."""
    mission = missions.load(file, settings)
    if out.suffix == ".json":
        from crosstrack.mission.airsim import airsim_settings

        out.write_text(json.dumps(airsim_settings(mission), indent=2) + "\n", encoding="utf-8")
    else:
        missions.export_plan(mission, out)
    print(f"Wrote {out}.")
    return 0
