"""What moves is found in scans, with its velocity and size; what stands still is not, however it is looked at."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest

from crosstrack.sense.clusters import blob_of, blobs_of
from crosstrack.sense.lidar import Lidar
from crosstrack.sense.movers import Movers, Track, ahead, balls
from crosstrack.sense.views import surprises, view_of
from crosstrack.types import Array, Others, Scan, State, Vector
from crosstrack.world.moving import Moving, MovingObstacles
from crosstrack.world.shapes import Box, Cylinder, Shape, Sphere
from crosstrack.world.together import Together
from crosstrack.world.world import World

LEVEL = Lidar(lowest_deg=-15, highest_deg=15, noise=0.02)
OPEN = World()


def state_at(time: float, position: Array, velocity: Array, yaw: float = 0.0, roll: float = 0.0) -> State:
    half, lean = yaw / 2, roll / 2
    attitude = np.array(
        [
            math.sin(lean) * math.cos(half),
            math.sin(lean) * math.sin(half),
            math.cos(lean) * math.sin(half),
            math.cos(lean) * math.cos(half),
        ]
    )
    return State(time, position, velocity, attitude, np.zeros(3))


def forest(seed: int, density: float) -> World:
    """Return trunks with a lane of 1 m free to either side of the x axis."""
    rng = np.random.default_rng(seed)
    count = round(density * 60 * 20)
    trunks = zip(
        rng.uniform(-10, 50, count).tolist(),
        rng.uniform(-10, 10, count).tolist(),
        rng.uniform(0.1, 0.5, count).tolist(),
        strict=True,
    )
    return World(tuple(Cylinder((x, y), r, (0, 3)) for x, y, r in trunks if abs(y) > r + 1.0))


@dataclass(frozen=True)
class Look:
    """What was known after one scan."""

    time: float
    others: Others
    points: Array
    """(n, 3) m, that the scan hit and no scan before could see there"""


def looks(
    world: World,
    traffic: MovingObstacles | None = None,
    sensor: Lidar = LEVEL,
    told: World = OPEN,
    speed: float = 3.0,
    duration: float = 4.0,
    error: float = 0.0,
    spin: float = 0.0,
) -> Iterator[Look]:
    """Fly along the lane and look; `error` (m) is that of the estimated position, `spin` (rad/s) yaws."""
    rng = np.random.default_rng(7)
    movers = Movers(told)
    memory = movers.start()
    for step in range(round(duration * sensor.rate)):
        time = step / sensor.rate
        position = np.array([speed * time, 0.4 * math.sin(time), 1.5])
        state = state_at(time, position, np.array([speed, 0.0, 0.0]), spin * time, 0.2 * math.sin(2 * time))
        scene = Together((world, traffic.at(time))) if traffic else world
        scan = sensor.look(scene, state, rng)
        believed = state_at(
            time, position + error * rng.standard_normal(3), state.velocity, spin * time, 0.2 * math.sin(2 * time)
        )
        memory = movers.step(memory, scan, believed)
        yield Look(time, movers.others(memory, time), np.array([track.position for track in memory.tracks]))


@pytest.mark.parametrize(
    ("density", "columns", "error", "spin"),
    [(0.1, 360, 0.0, 0.0), (0.2, 360, 0.0, 0.0), (0.4, 360, 0.0, 0.0), (0.2, 900, 0.02, 0.0), (0.2, 360, 0.02, 1.0)],
)
def test_nothing_moves_in_a_forest_that_a_vehicle_flies_through(
    density: float, columns: int, error: float, spin: float
) -> None:
    sensor = Lidar(lowest_deg=-15, highest_deg=15, noise=0.03, dropouts=0.02, columns=columns)
    for seed in range(3):
        for look in looks(forest(seed, density), sensor=sensor, error=error, spin=spin):
            assert not len(look.others.radius), f"seed {seed}, {look.time} s: {look.others}"


@pytest.mark.parametrize("speed", [0.0, 3.0])
@pytest.mark.parametrize("velocity", [(0, 1, 0), (0, 2, 0), (0, -3, 0), (-1, 0, 0), (-2, 1, 0), (-1.5, -1, 0.2)])
def test_a_ball_is_found_within_a_second_and_a_half_of_the_first_scan(velocity: Vector, speed: float) -> None:
    radius, meets = 0.4, 2.5
    at_meeting = np.array([speed * meets + 3.0, 0.0, 1.5])
    begins = at_meeting - meets * np.array(velocity)
    traffic = MovingObstacles((Moving(Sphere(tuple(begins.tolist()), radius), velocity),))
    found, off, wrong = [], [], []
    for look in looks(World(), traffic, speed=speed):
        truth = traffic.others(look.time)
        assert len(look.others.radius) <= 1
        if len(look.others.radius):
            found.append(look.time)
            if look.time > found[0] + 0.4:
                off.append(float(np.linalg.norm(look.others.position[0] - truth.position[0])))
                wrong.append(float(np.linalg.norm(look.others.velocity[0] - truth.velocity[0])))
                assert abs(look.others.radius[0] - radius) < 0.3
    assert found[0] <= 1.5
    assert len(found) >= 0.9 * (4.0 - found[0]) * LEVEL.rate
    assert np.median(off) < radius / 2
    assert np.max(off) < 0.45
    assert np.median(wrong) < 0.35


def test_among_trees_only_the_ball_moves() -> None:
    traffic = MovingObstacles((Moving(Sphere((7.0, -5.0, 1.5), 0.4), (0, 2, 0)),))
    seen = 0
    for look in looks(forest(1, 0.1), traffic, speed=1.0):
        truth = traffic.others(look.time)
        gaps = np.linalg.norm(look.others.position - truth.position, axis=1)
        assert (gaps < 0.8).all()
        seen += bool(len(gaps))
    assert seen >= 10


def test_a_tall_obstacle_is_held_by_balls_one_above_another() -> None:
    traffic = MovingObstacles((Moving(Cylinder((8.0, -4.0), 0.3, (0.0, 3.0)), (0, 1.5, 0)),))
    last = list(looks(World(), traffic, speed=0.5, duration=3.0))[-1]
    assert len(last.others.radius) >= 2
    truth = np.array([8.0, -4.0 + 1.5 * last.time])
    np.testing.assert_allclose(last.others.position[:, :2], np.tile(truth, (len(last.others.radius), 1)), atol=0.2)
    np.testing.assert_allclose(last.others.velocity, np.tile([0, 1.5, 0], (len(last.others.radius), 1)), atol=0.4)
    assert (last.others.radius < 0.6).all()
    assert np.ptp(last.others.position[:, 2]) > 0.8


def test_what_stops_is_not_reported_for_long() -> None:
    there = Moving(Sphere((6.0, -3.0, 1.5), 0.4), (0, 2, 0))
    sensor, rng = LEVEL, np.random.default_rng(1)
    movers = Movers(World())
    memory = movers.start()
    counts = []
    for step in range(50):
        time = step / 10
        state = state_at(time, np.array([0, 0, 1.5]), np.zeros(3))
        scene = MovingObstacles((there,)).at(min(time, 1.5))
        memory = movers.step(memory, sensor.look(scene, state, rng), state)
        counts.append(len(movers.others(memory, time).radius))
    assert sum(counts[8:15]) >= 6
    assert sum(counts[35:]) == 0


def test_what_is_told_is_not_taken_for_a_mover() -> None:
    wall = Box((4.0, -3.0, 0.0), (4.3, 3.0, 3.0))
    sensor, rng = LEVEL, np.random.default_rng(1)
    for told, expected in ((World(), True), (World((wall,)), False)):
        movers = Movers(told)
        memory = movers.start()
        for time in (0.0, 0.2, 0.4, 0.6):
            scene = World((wall,) if time > 0.5 else ())
            state = state_at(time, np.array([0, 0, 1.5]), np.zeros(3))
            memory = movers.step(memory, sensor.look(scene, state, rng), state)
        assert bool(memory.tracks) is expected


def scan_of(solid: World, origin: Array, directions: Array) -> Scan:
    return Scan(0.0, np.zeros(3), directions, solid.cast(origin, directions, 20.0), 20.0)


def test_a_point_is_a_surprise_only_where_every_ray_around_it_went_past() -> None:
    rng = np.random.default_rng(3)
    directions = rng.standard_normal((60_000, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    then, now = np.array([0.0, 0, 2]), np.array([1.0, 0.5, 2.2])
    tree = Cylinder((5.0, 1.0), 0.4, (0, 6))
    before = view_of(scan_of(World((tree,)), then, directions), then, directions)
    new = Sphere((4.0, -2.5, 2.0), 0.5)
    after = scan_of(World((tree, new)), now, directions)
    hits = now + after.ranges[np.isfinite(after.ranges), None] * directions[np.isfinite(after.ranges)]
    points = surprises(hits, [before], 0.2)
    np.testing.assert_array_less(World((new,)).distance(points), 1e-3)
    on_new = World((new,)).distance(hits) < 1e-3
    assert len(points) > 0.95 * on_new.sum() > 50
    again = scan_of(World((tree,)), now, directions)
    seen = np.isfinite(again.ranges)
    assert not len(surprises(now + again.ranges[seen, None] * directions[seen], [before], 0.2))


def test_nothing_is_a_surprise_where_nothing_was_looked_at() -> None:
    ahead_only = Lidar(fov_deg=90, lowest_deg=-15, highest_deg=15, noise=0.0)
    rng = np.random.default_rng(0)
    state = state_at(0.0, np.array([0.0, 0, 1.5]), np.zeros(3))
    turned = state_at(1.0, np.array([0.0, 0, 1.5]), np.zeros(3), yaw=math.pi)
    world = World((Sphere((-5, 0, 1.5), 0.5),))
    movers = Movers(OPEN)
    memory = movers.step(movers.start(), ahead_only.look(world, state, rng), state)
    memory = movers.step(memory, ahead_only.look(world, turned, rng), turned)
    assert not memory.tracks


def lit(shape: Shape, origin: Array) -> Array:
    """Return where a dense bundle of rays hits a solid."""
    pan, tilt = np.meshgrid(np.linspace(-0.5, 0.5, 300), np.linspace(-0.5, 0.5, 300))
    directions = np.stack([np.cos(tilt) * np.cos(pan), np.cos(tilt) * np.sin(pan), np.sin(tilt)], axis=-1).reshape(
        -1, 3
    )
    ranges = World((shape,)).cast(origin, directions, 30.0)
    hit = np.isfinite(ranges)
    points: Array = origin + ranges[hit, None] * directions[hit]
    return points


def test_the_ball_laid_around_the_side_that_is_seen_is_the_ball() -> None:
    blob = blob_of(lit(Sphere((6.0, 1.0, 2.0), 0.5), np.array([0.0, 0, 2])), np.array([0.0, 0, 2]))
    np.testing.assert_allclose(blob.position, [6, 1, 2], atol=0.06)
    assert blob.radius == pytest.approx(0.5, abs=0.04)
    assert blob.rise == 0


def test_the_roll_laid_around_the_side_that_is_seen_is_the_roll() -> None:
    blob = blob_of(lit(Cylinder((6.0, 1.0), 0.3, (0.5, 3.5)), np.array([0.0, 0, 2])), np.array([0.0, 0, 2]))
    np.testing.assert_allclose(blob.position, [6, 1, 2], atol=0.06)
    assert blob.radius == pytest.approx(0.3, abs=0.03)
    assert blob.radius + blob.rise == pytest.approx(1.5, abs=0.1)


def test_two_things_apart_are_two() -> None:
    origin = np.array([0.0, 0, 2])
    points = np.concatenate([lit(Sphere((6, y, 2), 0.4), origin) for y in (-1.0, 1.0)])
    found = sorted(blobs_of(points, origin), key=lambda blob: float(blob.position[1]))
    assert [round(float(blob.position[1])) for blob in found] == [-1, 1]
    assert not blobs_of(points[:2], origin)


def test_balls_of_a_tall_track_cover_its_height_and_move_on() -> None:
    track = Track(1.0, np.array([0.0, 0, 2]), np.array([1.0, 0, 0]), (0.01, 0.0, 0.01), 0.3, 1.0, 1.0)
    position, velocity, radius = balls(ahead(track, 1.5))
    np.testing.assert_allclose(position[:, 0], 0.5)
    np.testing.assert_array_equal(velocity, np.tile([1.0, 0, 0], (len(radius), 1)))
    heights = np.linspace(1.0, 3.0, 50)
    inside = np.abs(heights[:, None] - position[:, 2]) <= radius
    assert inside.any(axis=1).all()
    assert ahead(track, 1.5).variance[0] > track.variance[0]
