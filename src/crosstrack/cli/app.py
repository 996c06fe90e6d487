"""The verbs of the command. What they need is imported when they run, so that `--help` is there at once."""

import signal
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from cyclopts import App, CycloptsError, Parameter

from crosstrack import __version__
from crosstrack.cli.codes import BAD_INPUT, DONE, INTERRUPTED, LINK_LOST
from crosstrack.cli.evaluating import evaluate
from crosstrack.cli.training import train
from crosstrack.errors import CrosstrackError, LinkLost

app = App(
    name="crosstrack",
    version=__version__,
    help="Fly quadrotor missions: plan, smooth, track, avoid, show.",
    help_epilogue="Exit codes: 0 done (arrived), 2 bad input, 3 not arrived, 4 collided, 5 link lost, 6 flights of a "
    "comparison lost to errors, 130 interrupted.",
)
bench = App(name="bench", help="Measure on worlds made from seeds.")
app.command(bench)
app.command(evaluate)
app.command(train)
Settings = Annotated[list[str], Parameter(name="--set", negative=())]
Trajectory = Annotated[Path | None, Parameter(name="--from")]
Switch = Annotated[bool, Parameter(negative=())]


@app.command
def fly(
    mission: Path,
    *,
    out: Path | None = None,
    trajectory: Trajectory = None,
    vehicle: str | None = None,
    settings: Settings | None = None,
    json: Switch = False,
    png: Switch = False,
) -> int:
    """Fly a mission; write its summary, log and report.

    Args:
        mission: the mission file
        out: folder for summary.json, flight.mcap and report.html; by default runs/NAME, with the name of the mission
        trajectory: fly the trajectory of this file, .json or .csv, instead of planning one
        vehicle: the kind of vehicle to fly with instead, such as point
        settings: change one value of the mission, such as tracker.lookahead=2; may be given several times
        json: print the summary on standard output, and nothing else there
        png: write the report's figures as pictures too
    """
    from crosstrack.cli import planning, verbs

    chosen = [f"vehicle.kind={vehicle}"] if vehicle is not None else []
    given = planning.from_file(mission, trajectory)
    return verbs.fly(mission, out, given + chosen + (settings or []), json, png)


@app.command
def plan(
    mission: Path,
    *,
    out: Path | None = None,
    trajectory: Trajectory = None,
    settings: Settings | None = None,
    json: Switch = False,
) -> int:
    """Plan a mission's trajectory, certify it and write both; exit with 2 where a limit is exceeded.

    Args:
        mission: the mission file, with a planner
        out: folder for trajectory.json and .csv, certificate.json and plan.html; by default runs/NAME, with the name of
            the mission
        trajectory: certify the trajectory of this file, .json or .csv, instead of planning one
        settings: change one value of the mission, such as planner.kind=minimum_jerk; may be given several times
        json: print the certificate on standard output, and nothing else there
    """
    from crosstrack.cli import planning

    return planning.plan(mission, trajectory, out, settings or [], json)


@app.command
def compare(
    *mission: Path,
    trackers: Annotated[list[str] | None, Parameter(negative=())] = None,
    wind: Annotated[list[str] | None, Parameter(negative=(), allow_leading_hyphen=True)] = None,
    seeds: int = 1,
    workers: int | None = None,
    cluster: str | None = None,
    out: Path | None = None,
    settings: Settings | None = None,
    json: Switch = False,
    png: Switch = False,
) -> int:
    """Fly missions with several trackers, winds and seeds side by side; rank the trackers.

    Results are kept as they come: after an interruption the same command flies what is missing.

    Args:
        mission: the mission files
        trackers: such as carrot,carrot:lookahead=2,mission, the last being the mission's own; by default all that can
            fly the missions
        wind: the velocity of the air as E,N,U or E,N,U,GUSTS (m/s; gusts none, light, moderate or severe), or calm; by
            default the mission's own; may be given several times
        seeds: how many, from that of the mission on
        workers: how many flights at once; by default one for every core
        cluster: the address of a Ray cluster to fly on instead, such as 10.0.0.1:6379
        out: folder for results.jsonl, results.csv and comparison.html; by default runs/compare
        settings: change one value of every mission, such as speed=3; may be given several times
        json: print the rankings on standard output, and nothing else there
        png: write the picture comparison.png too
    """
    from crosstrack.cli import comparing

    runner = comparing.runner_for(workers, cluster)
    return comparing.compare(mission, trackers or [], wind or [], seeds, runner, out, settings or [], json, png)


@app.command
def tune(
    mission: Path,
    *,
    tracker: str | None = None,
    parameter: Annotated[list[str] | None, Parameter(negative=())] = None,
    cost: Annotated[str | None, Parameter(allow_leading_hyphen=True)] = None,
    seeds: int | None = None,
    budget: int = 300,
    wind: Annotated[list[str] | None, Parameter(negative=(), allow_leading_hyphen=True)] = None,
    workers: int | None = None,
    cluster: str | None = None,
    out: Path | None = None,
    settings: Settings | None = None,
    json: Switch = False,
) -> int:
    """Find the parameters of a tracker with which a mission is flown best; write the mission with them.

    A flight that does not arrive costs more than any that does. The present values are kept unless others are better.

    Args:
        mission: the mission file
        tracker: the kind to tune, with its defaults to begin with; by default the mission's own, as it is
        parameter: a parameter to search, as NAME or NAME=LOW:HIGH; by default all positive ones, each from a fifth to
            five times its present value; may be given several times
        cost: what to minimise, as [NUMBER*]METRIC [+ ...], averaged over seeds and winds; by default tracking_rms_m for
            a tracker of trajectories, cross_track_rms_captured_m for others
        seeds: how many to tune on, from that of the mission on, and as many after them to check with; by default 3
            where the seed makes a difference
        budget: flights at most
        wind: as for compare; may be given several times
        workers: how many flights at once; by default one for every core
        cluster: the address of a Ray cluster to fly on instead, such as 10.0.0.1:6379
        out: the mission to write, with a page of the flights before and after beside it; by default
            runs/tune/NAME.yaml
        settings: change one value of the mission, such as speed=3; may be given several times
        json: print what was found on standard output, and nothing else there
    """
    from crosstrack.cli import comparing, tuning

    runner = comparing.runner_for(workers, cluster)
    return tuning.run(
        *(mission, tracker, parameter or [], cost, wind or [], seeds, budget, runner, out, settings or [], json)
    )


@bench.command
def avoid(
    *,
    maps: int = 1,
    families: Annotated[list[str] | None, Parameter(negative=())] = None,
    planners: Annotated[list[str] | None, Parameter(negative=())] = None,
    seed: int = 1,
    workers: int | None = None,
    cluster: str | None = None,
    out: Path | None = None,
    json: Switch = False,
) -> int:
    """Fly to goals through forests, discs, mazes, traps and gaps, in several ways; print how often each gets there.

    Results are kept as they come: after an interruption the same command flies what is missing.

    Args:
        maps: how many of each family
        families: such as forest,maze or forest-0.4; by default all
        planners: ways to fly, such as planned,unknown,fallback,field; by default all of these
        seed: of the first map of each family
        workers: how many flights at once; by default one for every core
        cluster: the address of a Ray cluster to fly on instead, such as 10.0.0.1:6379
        out: folder for results.jsonl, results.csv, benchmark.html and the failures; by default runs/bench/avoid
        json: print the scores on standard output, and nothing else there
    """
    from crosstrack.cli import benching, comparing

    runner = comparing.runner_for(workers, cluster)
    return benching.avoid(families or [], planners or [], maps, seed, runner, out, json)


@app.command
def check(file: Path | None = None, *, schema: Switch = False, settings: Settings | None = None) -> int:
    """Print a mission with all its defaults, or everything that is wrong with it.

    Args:
        file: the mission file
        schema: print the JSON Schema of mission files instead
        settings: change one value of the mission, such as tracker.lookahead=2; may be given several times
    """
    from crosstrack.cli import verbs

    return verbs.check(file, schema, settings or [])


@app.command
def init(name: str = "mission") -> int:
    """Write a commented mission to start from.

    Args:
        name: of the mission; the file is NAME.yaml, which must not exist
    """
    from crosstrack.cli import verbs

    return verbs.init(name)


@app.command(name="list")
def list_parts() -> int:
    """List what a mission can name, with every field, its default and what it means."""
    from crosstrack.cli import catalogue

    return catalogue.show()


@app.command
def replay(log: Path, *, out: Path | None = None, json: Switch = False, png: Switch = False) -> int:
    """Make the summary and the report again from a log alone.

    Args:
        log: a flight.mcap
        out: folder for summary.json and report.html; by default the log's
        json: print the summary on standard output, and nothing else there
        png: write the report's figures as pictures too
    """
    from crosstrack.cli import verbs

    return verbs.replay(log, out, json, png)


@app.command
def serve(
    *,
    settings: Path | None = None,
    world: Path | None = None,
    host: str | None = None,
    port: int | None = None,
    clock_speed: float | None = None,
    lockstep: Switch = False,
    ideal: Switch = False,
    seed: int = 1,
    out: Path | None = None,
) -> int:
    """Serve AirSim's API on the embedded simulator: any AirSim script flies here, without Unreal.

    Ctrl-C ends it.

    Args:
        settings: AirSim's settings.json; by default what the mission needs, else AirSim's defaults
        world: a mission file, whose world is served; by default one of our own, with obstacles of several kinds
        host: address to listen at; by default that of the settings, else this machine alone
        port: by default that of the settings, else 41451; 0 for any free one
        clock_speed: simulated over real time; by default that of the settings, else 1
        lockstep: advance the clock only while a client waits for a move, or as it asks, as fast as the machine can
        ideal: fly without AirSim's known mistakes
        seed: of the noise of sensors
        out: folder for session.mcap, written as clients fly, and report.html, written at the end; by default neither
    """
    from crosstrack.cli import serving

    return serving.serve(settings, world, host, port, clock_speed, lockstep, ideal, seed, out)


@app.command
def export(mission: Path, file: Path, *, settings: Settings | None = None) -> int:
    """Write a mission's route and speed as a QGroundControl plan, or what AirSim needs to know for it.

    Args:
        mission: the mission file
        file: the file to write: a plan, such as out.plan, or AirSim's settings.json
        settings: change one value of the mission, such as speed=3; may be given several times
    """
    from crosstrack.cli import verbs

    return verbs.export(mission, file, settings or [])


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command and exit with its code."""
    try:
        code = run(sys.argv[1:] if arguments is None else arguments)
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # all is written: one more Ctrl-C only waits for the exit
    sys.exit(code)


def run(arguments: Sequence[str]) -> int:
    """Run the command and return its exit code; what is wrong with the input is said on standard error."""
    try:
        result = app(list(arguments), exit_on_error=False, print_error=False, result_action="return_value")
    except CycloptsError as error:
        return complain(f"{error}\nTry: crosstrack --help", BAD_INPUT)
    except LinkLost as error:
        return complain(str(error), LINK_LOST)
    except CrosstrackError as error:
        return complain(str(error), BAD_INPUT)
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        return complain("interrupted", INTERRUPTED)
    except BrokenPipeError:
        sys.stderr.close()  # whoever read the output is gone: nothing to say, and no one to say it to
        return DONE
    except OSError as error:
        name = f"{error.filename}: " if error.filename else ""
        return complain(f"{name}{error.strerror or error}", BAD_INPUT)
    return result if isinstance(result, int) else DONE


def complain(message: str, code: int) -> int:
    """Say what went wrong and return the exit code."""
    print(message, file=sys.stderr)
    return code
