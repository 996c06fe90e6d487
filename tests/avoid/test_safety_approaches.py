"""Rotor-level quadrotors flown at walls, trunks and the ground by pilots who want to hit them."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from flights import CALM, EXACT, LIMITS

from crosstrack.avoid.safety import Safety
from crosstrack.protocols import Course, Map, Scenario, Surroundings
from crosstrack.types import (
    GRAVITY,
    Air,
    Array,
    AttitudeSetpoint,
    Command,
    Envelope,
    Limits,
    Noise,
    RateSetpoint,
    Setpoint,
    State,
    Wind,
)
from crosstrack.vehicles.quadrotor import Quadrotor
from crosstrack.world.generate import Forest
from crosstrack.world.grids import Relief, Voxels
from crosstrack.world.shapes import Box, Cylinder
from crosstrack.world.world import World

RADIUS, PERIOD, SAFETY = 0.2, 0.02, Safety()
Pilot = Callable[[State, World, Envelope], Command]


def thin_box() -> World:
    """A wall of 1 cm."""
    return World((Box((10.0, -20.0, -1.0), (10.01, 20.0, 30.0)),))


def thin_voxels() -> World:
    """A wall of one cell of 0.1 m."""
    return World(grids=(Voxels(np.ones((1, 160, 160), dtype=bool), (10.0, -8.0, 0.0), 0.1),))


def thin_image() -> World:
    """A wall as thick as one square of an image, 0.1 m, at an angle to its rows."""
    occupied = np.zeros((120, 240), dtype=bool)
    for row in range(240):
        column = 20 + row // 3
        occupied[column : column + 2, row] = True
    return World(grids=(Relief(occupied, (6.0, -12.0), 0.1, (0.0, 30.0)),))


def forest() -> World:
    return World(tuple(Forest(seed=4, density=0.2, clear=((2.0, 10.0),)).shapes()), ground=-1.0)


def room() -> World:
    """Inside four walls with a beam across."""
    shapes = (
        Box((9.0, -9.0, 0.0), (9.01, 9.0, 8.0)),
        Box((-9.01, -9.0, 0.0), (-9.0, 9.0, 8.0)),
        Box((-9.0, 9.0, 0.0), (9.0, 9.01, 8.0)),
        Box((-9.0, -9.01, 0.0), (9.0, -9.0, 8.0)),
        Cylinder((3.0, 3.0), 0.15, (0.0, 8.0)),
        Box((-9.0, -4.0, 3.0), (9.0, -3.9, 3.1)),
    )
    return World(shapes, bounds=np.array([[-9.0, -9.0, 0.0], [9.0, 9.0, 8.0]]))


WORLDS: dict[str, tuple[Callable[[], World], tuple[float, float, float]]] = {
    "thin box": (thin_box, (0.0, 0.0, 8.0)),
    "thin voxels": (thin_voxels, (0.0, 0.0, 8.0)),
    "thin image": (thin_image, (-1.0, 0.0, 8.0)),
    "forest": (forest, (2.0, 10.0, 1.5)),
    "room": (room, (-2.0, 0.0, 4.0)),
}
WALLS = ("thin box", "thin voxels", "thin image")
GRAZED = 0.05
"""m, closer than the radius"""
RARELY = 0.01
"""of the approaches"""


def straight_at_it(random: np.random.Generator) -> Pilot:
    """Full speed to the nearest obstacle, always."""

    def pilot(state: State, world: World, able: Envelope) -> Command:
        return Setpoint(velocity=-able.speed * world.gradient(state.position))

    return pilot


def held(random: np.random.Generator, draw: Callable[[], Any]) -> Callable[[float], Any]:
    """Hold what is drawn for a random time of up to 1.5 s."""
    until, value = -1.0, None

    def at(time: float) -> Any:
        nonlocal until, value
        if time >= until:
            until, value = time + random.uniform(0.05, 1.5), draw()
        return value

    return at


def fast_anywhere(random: np.random.Generator) -> Pilot:
    """A velocity in a random direction at the top speed, and more."""
    wish = held(random, lambda: random.normal(size=3) * (1, 1, 0.3))

    def pilot(state: State, world: World, able: Envelope) -> Command:
        way = wish(state.time)
        return Setpoint(velocity=1.2 * able.speed * way / np.linalg.norm(way))

    return pilot


def pushing(random: np.random.Generator) -> Pilot:
    """An acceleration alone, or a place far behind the obstacles with it."""
    wish = held(random, lambda: (random.normal(size=3) * (9, 9, 2), random.random() < 0.5))

    def pilot(state: State, world: World, able: Envelope) -> Command:
        push, far = wish(state.time)
        return Setpoint(state.position + 10 * push, acceleration=push) if far else Setpoint(acceleration=push)

    return pilot


def leaning(random: np.random.Generator) -> Pilot:
    """An attitude tilted at random with a random thrust."""
    wish = held(random, lambda: (random.uniform(0, math.tau), random.uniform(0, 0.8), random.uniform(0.6, 1.5)))

    def pilot(state: State, world: World, able: Envelope) -> Command:
        towards, tilt, lift = wish(state.time)
        half = 0.5 * tilt
        x, y = math.cos(towards) * math.sin(half), math.sin(towards) * math.sin(half)
        return AttitudeSetpoint(np.array([x, y, 0.0, math.cos(half)]), lift * GRAVITY)

    return pilot


def spinning(random: np.random.Generator) -> Pilot:
    """Random body rates with a random thrust: a tracker gone mad."""
    wish = held(random, lambda: (random.normal(size=3) * (3, 3, 1), random.uniform(0.6, 1.5)))

    def pilot(state: State, world: World, able: Envelope) -> Command:
        rate, lift = wish(state.time)
        return RateSetpoint(rate, lift * GRAVITY)

    return pilot


PILOTS = {law.__name__: law for law in (straight_at_it, fast_anywhere, pushing, leaning, spinning)}
STRONG = Limits(speed=15.0, acceleration=12.0, tilt_deg=60.0)
WEAK = Limits(speed=8.0, acceleration=3.0, tilt_deg=25.0)


@dataclass(frozen=True)
class Approach:
    """What came of one."""

    clearance: float
    """m, the least, swept"""
    lost: bool
    """whether it turned over or left the bounds"""
    impact: bool
    """whether it hit the ground hard"""
    interventions: int
    moved: float
    """m, flown"""


def upright(state: State) -> bool:
    x, y = state.attitude[:2]
    return bool(1 - 2 * (x * x + y * y) > 0)


def fly_at(
    world: World,
    start: Array,
    velocity: Array,
    pilot: Pilot,
    airframe: Any = "generic",
    limits: Limits = LIMITS,
    seconds: float = 3.0,
    law: Safety | None = SAFETY,
    wind: Wind = CALM,
    noise: Noise = EXACT,
    known: Map | None = None,
) -> Approach:
    """Fly a vehicle from a motion on, with the safety layer behind its pilot."""
    vehicle = Quadrotor(airframe=airframe, radius=RADIUS)
    scenario = Scenario(start, 0.0, world, limits.speed, limits, wind, Air(), noise, PERIOD, 1)
    able = vehicle.envelope(scenario)
    session: Any = vehicle.launch(scenario)
    session.rows["state"][0, 3:6] = velocity
    session.state = session.estimated = session.read()
    nothing: Any = None
    around = Surroundings(known or world)
    memory = law.start(Course(nothing, nothing, able), around, session.sense()) if law else None
    least, lost, interventions, moved = math.inf, False, 0, 0.0
    for _ in range(round(seconds / PERIOD)):
        state = session.sense()
        command = pilot(state, world, able)
        if law and memory:
            command, memory = law.step(memory, command, state, around, PERIOD)
            interventions += memory.intervening
        before = session.truth().position
        session.advance(command, PERIOD)
        now = session.truth()
        least = min(least, world.swept(before, now.position))
        moved += float(np.linalg.norm(now.position - before))
        lost |= not upright(now)
        if world.bounds is not None:
            lost |= not ((world.bounds[0] <= now.position) & (now.position <= world.bounds[1])).all()
        if lost:
            break
    return Approach(least, bool(lost), session.touched(), interventions, moved)


def drawn(world: World, middle: tuple[float, float, float], able: Envelope, random: np.random.Generator) -> Any:
    """Draw a start clear of obstacles, and a velocity up to the top speed from which the vehicle can still stop."""
    while True:
        start = np.array(middle) + random.uniform(-1, 1, 3) * (8.0, 5.0, 0.5)
        if world.distance(start) < RADIUS + 0.1:
            continue
        way = random.normal(size=3) * (1, 1, 0.2)
        way /= np.linalg.norm(way)
        speed = able.speed * random.uniform(0.0, 1.0)
        speed = min(speed, able.speed_vertical / max(1e-9, abs(way[2])))
        gap = speed**2 / (2 * 0.6 * able.acceleration) + speed * (2 * able.response_time + 0.1)
        ahead = start + way * gap
        if world.swept(start, ahead) < RADIUS + 0.1 or ahead[2] < world.ground + 0.3:
            continue
        if world.bounds is not None and not ((world.bounds[0] + 0.3 < ahead) & (ahead < world.bounds[1] - 0.3)).all():
            continue
        return start, speed * way


@dataclass(frozen=True)
class Beginning:
    """Of one random approach."""

    start: Array
    velocity: Array
    airframe: Any
    limits: Limits
    random: np.random.Generator
    """for the pilot"""


def begun(number: int, world: World, middle: tuple[float, float, float], pilot: str) -> Beginning:
    """Draw one random approach: its number is its seed."""
    random = np.random.default_rng([number, len(pilot)])
    airframe: Any = ("generic", "crazyflie", "racer")[number % 3]
    limits = (Limits(), STRONG, WEAK)[number // 3 % 3]
    scenario = Scenario(np.zeros(3), 0.0, world, 5.0, limits, Wind(), Air(), Noise(), PERIOD, 1)
    able = Quadrotor(airframe=airframe).envelope(scenario)
    start, velocity = drawn(world, middle, able, random)
    return Beginning(start, velocity, airframe, limits, random)


def approached(number: int, world: World, middle: tuple[float, float, float], pilot: str, seconds: float) -> Approach:
    """Fly one random approach."""
    at = begun(number, world, middle, pilot)
    return fly_at(world, at.start, at.velocity, PILOTS[pilot](at.random), at.airframe, at.limits, seconds)


def passed(number: int, pilot: str, seconds: float, law: Safety | None) -> Approach:
    """Fly an approach of the thin wall where there is none: the pilot goes for it all the same."""
    wall = thin_box()
    at = begun(number, wall, WORLDS["thin box"][1], pilot)
    flown = PILOTS[pilot](at.random)

    def blind(state: State, world: World, able: Envelope) -> Command:
        return flown(state, wall, able)

    return fly_at(World(), at.start, at.velocity, blind, at.airframe, at.limits, seconds, law)


@pytest.fixture(scope="module")
def worlds() -> dict[str, World]:
    return {name: make() for name, (make, _) in WORLDS.items()}


def wrong(worlds: dict[str, World], world: str, pilot: str, numbers: range, seconds: float) -> dict[int, Approach]:
    """Fly approaches; return those that came closer than the radius, hit the ground, turned over or left the bounds."""
    made = {number: approached(number, worlds[world], WORLDS[world][1], pilot, seconds) for number in numbers}
    return {n: one for n, one in made.items() if one.clearance < RADIUS or ended(one, pilot)}


def ended(made: Approach, pilot: str) -> bool:
    """Return whether an approach ended badly, whatever its clearance; body rates may turn any vehicle over."""
    return made.impact or (made.lost and pilot != "spinning")


@pytest.mark.parametrize("pilot", PILOTS)
@pytest.mark.parametrize("world", WORLDS)
def test_no_pilot_hits_anything(worlds: dict[str, World], world: str, pilot: str) -> None:
    assert wrong(worlds, world, pilot, range(4), 2.0) == {}


@pytest.mark.parametrize(
    ("world", "pilot", "number"),
    [
        ("room", "pushing", 158),
        ("room", "straight_at_it", 128),
        ("forest", "pushing", 228),
        ("forest", "straight_at_it", 147),
        ("forest", "fast_anywhere", 309),
        ("room", "straight_at_it", 322),
    ],
)
def test_the_hardest_approaches_are_survived(worlds: dict[str, World], world: str, pilot: str, number: int) -> None:
    """Climbing to a ceiling, past a beam, between trunks, and with rotors that hardly turn."""
    assert wrong(worlds, world, pilot, range(number, number + 1), 3.0) == {}


def test_where_no_way_is_free_it_brakes_as_hard_as_it_can(worlds: dict[str, World]) -> None:
    """Rates tilt a racer by 57° where 25° are usual: by the time it is level again it is late."""
    assert wrong(worlds, "forest", "spinning", range(107, 108), 2.5) == {}


@pytest.mark.slow
@pytest.mark.parametrize("pilot", PILOTS)
@pytest.mark.parametrize("world", WALLS)
def test_no_pilot_crosses_a_thin_wall_in_ten_thousand_approaches(
    worlds: dict[str, World], world: str, pilot: str
) -> None:
    assert wrong(worlds, world, pilot, range(100, 767), 3.0) == {}


@pytest.mark.slow
@pytest.mark.parametrize("pilot", PILOTS)
@pytest.mark.parametrize("world", sorted(set(WORLDS) - set(WALLS)))
def test_among_many_obstacles_few_pilots_graze_one(worlds: dict[str, World], world: str, pilot: str) -> None:
    """What the layer's model leaves out is known: the docs say how often, and by how much."""
    numbers = range(100, 500)
    made = wrong(worlds, world, pilot, numbers, 3.0)
    assert [number for number, one in made.items() if ended(one, pilot) or one.clearance < RADIUS - GRAZED] == []
    assert len(made) <= RARELY * len(numbers)


def test_without_the_layer_the_same_pilots_hit(worlds: dict[str, World]) -> None:
    """The approaches are hard: most of those that mean to hit do so."""
    world, middle = worlds["forest"], WORLDS["forest"][1]
    hits = 0
    for number in range(6):
        random = np.random.default_rng(number)
        able = Quadrotor().envelope(Scenario(np.zeros(3), 0, world, 5, Limits(), Wind(), Air(), Noise(), PERIOD, 1))
        start, velocity = drawn(world, middle, able, random)
        hits += fly_at(world, start, velocity, straight_at_it(random), law=None).clearance < RADIUS
    assert hits >= 4


@pytest.mark.parametrize("pilot", ["fast_anywhere", "pushing"])
def test_nothing_is_changed_where_there_is_nothing(pilot: str) -> None:
    """Of the time of a run without a wall, nothing is lost to the layer: it passes what it is given."""
    sky = World(ground=-1000.0)
    for number in range(6):
        made = fly_at(sky, np.zeros(3), np.zeros(3), PILOTS[pilot](np.random.default_rng(number)))
        assert made.interventions == 0
        assert made.moved > 3.0


def share_lost(pilot: str, numbers: range, seconds: float) -> float:
    """Return the share of the way in a given time, 1, that the layer costs where there is nothing but the ground."""
    freely = sum(passed(number, pilot, seconds, None).moved for number in numbers)
    return 1.0 - sum(passed(number, pilot, seconds, Safety()).moved for number in numbers) / freely


# Random rates without the layer turn a quadrotor over at once: there is nothing to compare with.
@pytest.mark.parametrize("pilot", ["straight_at_it", "fast_anywhere", "pushing", "leaning"])
def test_without_the_wall_hardly_any_time_is_lost(pilot: str) -> None:
    assert share_lost(pilot, range(3), 2.0) <= 0.05


@pytest.mark.slow
@pytest.mark.parametrize("pilot", ["straight_at_it", "fast_anywhere", "pushing", "leaning"])
def test_without_the_wall_hardly_any_time_is_lost_in_hundreds_of_runs(pilot: str) -> None:
    assert share_lost(pilot, range(100, 500), 3.0) <= 0.05


def test_late_and_noisy_estimates_take_a_margin(worlds: dict[str, World]) -> None:
    noise = Noise(position=0.01, velocity=0.02, delay=0.08)
    for number in range(4):
        random = np.random.default_rng(number)
        made = fly_at(
            worlds["thin box"], np.array([2.0, 0, 8]), np.zeros(3), straight_at_it(random),
            noise=noise, law=Safety(margin=0.15), seconds=4.0,
        )  # fmt: skip
        assert made.clearance >= RADIUS
        assert made.moved > 5.0


def test_a_wind_towards_the_wall_is_withstood(worlds: dict[str, World]) -> None:
    for airframe in ("generic", "crazyflie", "racer"):
        random = np.random.default_rng(3)
        made = fly_at(
            worlds["thin box"], np.array([2.0, 0, 8]), np.zeros(3), straight_at_it(random), airframe,
            wind=Wind((4.0, 0.0, 0.0)), law=Safety(margin=0.1), seconds=4.0,
        )  # fmt: skip
        assert made.clearance >= RADIUS
