"""How closely every law follows: paths for the followers, aggressive trajectories for the trackers.

Run as `python benchmarks/tracking.py [followers|trackers] [--workers N]`. All flights follow from seeds and repeat
exactly; the spread is over routes and seeds. The results are kept in runs/bench, so that an interrupted run goes on.
"""

import argparse
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import chain, count, islice
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import Progress
from rich.table import Table

import crosstrack as ct
from crosstrack import registry
from crosstrack.campaign.complete import complete, kept
from crosstrack.campaign.flights import flight_task
from crosstrack.campaign.local import Local
from crosstrack.campaign.store import Store
from crosstrack.campaign.task import Task
from crosstrack.trajectory import PiecewisePolynomial, certify, minimum
from crosstrack.trajectory.files.json_file import to_json
from crosstrack.trajectory.flatness.flat import flatten
from crosstrack.types import Array, Mismatch, Noise, Wind

SPEEDS = {1.0: 5.0, 5.0: 15.0, 10.0: 30.0}
"""m/s of the followers, and the radius (m) of the circle flown at it"""
SEEDS = 3
RANDOM = 5
PEAK_SPEED, PEAK_ACCELERATION = 12.5, 2 * 9.80665
"""m/s and m/s², of the trajectories"""
WRONG = Mismatch(mass=1.1, drag=1.2)
ALTITUDE = 20.0
"""m"""
Values = Sequence[Mapping[str, Any]]


def followers() -> list[str]:
    """Return the trackers that need a path only."""
    return [name for name in registry.names("tracker") if not registry.find("tracker", name)().needs]


def trackers() -> list[str]:
    """Return the trackers that follow trajectories."""
    return [name for name in registry.names("tracker") if registry.find("tracker", name)().needs]


def ring(x: Array, y: Array, z: Array) -> list[list[float]]:
    """Return points of a curve about the start, (n, 3) m, as plain numbers."""
    points: list[list[float]] = np.round(np.column_stack([x, y, z + ALTITUDE]), 3).tolist()
    return points


def routes(radius: float) -> Iterator[tuple[str, list[list[float]]]]:
    """Yield the routes of the followers by name, the first point being where they start."""
    yield "straight", [[0, 0, ALTITUDE], [100, 0, ALTITUDE]]
    turn = np.linspace(0, 2 * math.pi, 73)
    yield "circle", ring(radius * np.sin(turn), radius * (1 - np.cos(turn)), 0 * turn)
    for side in (20, 40):
        corners = [[0, 0], [side, 0], [side, side], [0, side], [0, 0]]
        yield f"square {side}", [[x, y, ALTITUDE] for x, y in corners]
    yield "eight", ring(20 * np.sin(turn), 10 * np.sin(2 * turn), 0 * turn)
    climb = np.linspace(0, 6 * math.pi, 145)
    yield "spiral", ring((10 - climb / 4) * np.cos(climb) - 10, (10 - climb / 4) * np.sin(climb), climb)
    rng = np.random.default_rng(7)
    steps = rng.uniform(-1, 1, (9, 3)) * [25, 25, 6]
    yield "random", [[0, 0, ALTITUDE], *np.round(np.cumsum(steps, axis=0) + [0, 0, ALTITUDE], 2).tolist()]


def following() -> Iterator[Task]:
    """Yield the flights of the followers: calm, and in a crosswind of half the speed with moderate gusts."""
    for speed, radius in SPEEDS.items():
        for name, points in routes(radius):
            document = {"start": {"position": points[0]}, "route": points[1:], "speed": speed, "name": name}
            for law in followers():
                mission = ct.from_document(document | {"tracker": {"kind": law}})
                yield flight_task(mission, labels(law, f"{name} {speed:g}", "calm", 1, speed=speed))
                windy = replace(mission, wind=Wind((0.4 * speed, 0.3 * speed, 0.0), "moderate"))
                for seed in range(1, SEEDS + 1):
                    flown = replace(windy, seed=seed)
                    yield flight_task(flown, labels(law, f"{name} {speed:g}", "wind", seed, speed=speed))


def labels(law: str, mission: str, case: str, seed: int, **more: Any) -> dict[str, Any]:
    """Return what a flight is filed under."""
    return {"tracker": law, "mission": mission, "wind": case, "seed": seed} | more


def scaled(points: Array, times: Array, speed: float, acceleration: float) -> PiecewisePolynomial:
    """Return minimum snap through points with the shape given, its largest speed and acceleration as asked for."""
    for _ in range(2):
        peaks = certify(minimum(points, times, 4)).peaks
        v, a = peaks["speed"].value, peaks["acceleration"].value
        slower = (speed / v) / (acceleration / a)
        points, times = points * (slower * speed / v), times * slower
    return minimum(points + [0, 0, ALTITUDE], times, 4)


def lemniscate() -> tuple[Array, Array]:
    """Return points and times of two rounds of a figure of eight, from rest to rest."""
    phase = np.linspace(0, 4 * math.pi, 49)
    times = np.linspace(0, 4 * math.pi, 49)
    times[1:] += 0.6
    times[-1] += 0.6
    return np.column_stack([np.sin(phase), 0.5 * np.sin(2 * phase), 0.1 * np.sin(phase)]), times


def wander(seed: int) -> tuple[Array, Array]:
    """Return random points and times."""
    rng = np.random.default_rng(seed)
    points = np.concatenate([np.zeros((1, 3)), np.cumsum(rng.normal(0, 1, (7, 3)) * [1, 1, 0.3], axis=0)])
    spans = np.linalg.norm(np.diff(points, axis=0), axis=1) ** 0.5 + 0.2
    spans[[0, -1]] *= 1.5
    return points, np.concatenate([[0.0], np.cumsum(spans)])


def flyable(curve: PiecewisePolynomial) -> bool:
    """Return whether a thrust of at least 0.3 g, at most 75° from upright, flies a curve against rotor drag."""
    flat = flatten(curve, np.linspace(0, curve.duration, 2000), drag=(0.54, 0.39, 0.0))
    return bool(flat.thrust.min() > 3 and math.degrees(flat.tilt.max()) < 75)


def shapes() -> Iterator[tuple[str, PiecewisePolynomial, PiecewisePolynomial]]:
    """Yield name, fast and slow curve: the figure of eight, and the first random ones that can be flown upright."""
    wanted = chain([("lemniscate", lemniscate())], ((f"random {seed}", wander(seed)) for seed in count()))
    curves = ((name, scaled(*shape, PEAK_SPEED, PEAK_ACCELERATION), scaled(*shape, 5.0, 4.0)) for name, shape in wanted)
    return islice((found for found in curves if flyable(found[1])), 1 + RANDOM)


def tracking() -> Iterator[Task]:
    """Yield the flights of the trackers: as known, with everything wrong, with a noisy estimate, and at 5 m/s."""
    for name, fast, slow in shapes():
        for law in trackers():
            known, gentle = racing(fast, name, law), racing(slow, name, law)
            noisy = replace(known, noise=Noise(position=0.01, velocity=0.03, acceleration=0.3, delay=0.005))
            wrong = replace(known, mismatch=WRONG, wind=Wind(gusts="moderate"))
            yield flight_task(known, labels(law, name, "known", 1))
            yield flight_task(gentle, labels(law, name, "5 m/s", 1))
            for seed in range(1, SEEDS + 1):
                yield flight_task(replace(wrong, seed=seed), labels(law, name, "wrong", seed))
                yield flight_task(replace(noisy, seed=seed), labels(law, name, "noisy", seed))


def racing(curve: PiecewisePolynomial, name: str, law: str) -> ct.Mission:
    """Return the mission of flying a curve with the racer."""
    points = curve(np.linspace(0, curve.duration, 200)).round(3).tolist()
    document = {
        "name": name,
        "start": {"position": points[0]},
        "route": points[1:],
        "speed": 14,
        "tolerance": 1,
        "vehicle": {"kind": "quadrotor", "airframe": "racer"},
        "planner": {"kind": "file", "file": "trajectory.json"},
        "tracker": {"kind": law},
        "limits": {"speed": 20, "acceleration": 40, "tilt_deg": 80},
        "timing": {"rate": 100},
    }
    return ct.from_document(document, {"trajectory.json": to_json(curve).encode()})


def fly(tasks: list[Task], workers: int | None) -> Values:
    """Fly all and return their results; raise where one could not be flown."""
    folder = Path("runs/bench")
    folder.mkdir(parents=True, exist_ok=True)
    bar = Progress(console=Console(stderr=True))
    with Local(workers) as runner, Store(folder / "tracking.jsonl") as store, bar:
        flown = bar.add_task("Flying", total=len(tasks), completed=kept(tasks, store))
        done = complete(tasks, runner, store, lambda _: bar.advance(flown))
    lost = [one.error for one in done if one.error]
    if lost:
        raise SystemExit(f"{len(lost)} flights were lost, the first by {lost[0]}")
    return [one.value for one in done if one.value]


def written(flights: Values, metric: str) -> str:
    """Return median and greatest of a metric, and how many flights did not arrive."""
    values = [flight["summary"][metric] for flight in flights]
    known = [value for value in values if value is not None]
    missing = sum(not flight["summary"]["arrived"] for flight in flights)
    text = f"{median(known):.3f} ({max(known):.3f})" if known else "never"
    return text + (f", {missing} lost" if missing else "")


def chosen(results: Values, **wanted: Any) -> Values:
    """Return the results with these labels."""
    return [result for result in results if all(result["labels"].get(name) == value for name, value in wanted.items())]


def show_followers(results: Values, console: Console) -> None:
    """Print a row for each follower and case: error over all routes, and time over the planned one."""
    table = Table(title="Followers: captured RMS over 7 routes, m: median (greatest); greatest error, m; time ratio")
    for column in ("law", "speed", "air", "RMS", "greatest error", "time ratio"):
        table.add_column(column)
    for speed in SPEEDS:
        for air in ("calm", "wind"):
            for law in followers():
                some = chosen(results, tracker=law, speed=speed, wind=air)
                table.add_row(
                    law,
                    f"{speed:g}",
                    air,
                    written(some, "cross_track_rms_captured_m"),
                    written(some, "cross_track_max_captured_m"),
                    written(some, "time_ratio"),
                )
            table.add_section()
    console.print(table)


def show_trackers(results: Values, console: Console) -> None:
    """Print a row for each tracker, a column for each case."""
    table = Table(title="Trackers, racer, lemniscate and 5 random: tracking RMS, m: median (greatest)")
    cases = ("5 m/s", "known", "noisy", "wrong")
    for column in ("law", *cases):
        table.add_column(column)
    for law in trackers():
        cells = [written(chosen(results, tracker=law, wind=case), "tracking_rms_m") for case in cases]
        table.add_row(law, *cells)
    console.print(table)


def main() -> None:
    """Fly and print both tables, or one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("what", nargs="?", choices=("followers", "trackers"))
    parser.add_argument("--workers", type=int)
    options = parser.parse_args()
    console = Console(width=150)
    if options.what != "trackers":
        show_followers(fly(list(following()), options.workers), console)
    if options.what != "followers":
        show_trackers(fly(list(tracking()), options.workers), console)


if __name__ == "__main__":
    main()
