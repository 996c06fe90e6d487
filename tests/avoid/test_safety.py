"""What the safety layer lets pass, what it changes, and how."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosstrack.avoid.safety import Safety, SafetyMemory
from crosstrack.avoid.safety_stopping import Stop
from crosstrack.avoid.safety_way import Room, least_clearance, planes_of
from crosstrack.errors import InputError
from crosstrack.protocols import Course, Scenario, Surroundings
from crosstrack.types import (
    GRAVITY,
    Air,
    Array,
    AttitudeSetpoint,
    Command,
    Envelope,
    Limits,
    Noise,
    Others,
    RateSetpoint,
    Scan,
    Setpoint,
    State,
    Wind,
)
from crosstrack.vehicles.point import Point
from crosstrack.vehicles.quadrotor import Quadrotor
from crosstrack.world.shapes import Box, Cylinder
from crosstrack.world.world import World

PERIOD, RADIUS = 0.02, 0.2
WALL = World((Box((10.0, -50.0, -1.0), (10.01, 50.0, 50.0)),))
GAP = World((Cylinder((10.0, 0.0), 0.3, (0.0, 20.0)), Cylinder((10.0, 1.1), 0.3, (0.0, 20.0))))
LAYER = Safety()
LEVEL = np.array([0.0, 0.0, 0.0, 1.0])


def scenario(world: World, start: Any) -> Scenario:
    return Scenario(np.array(start, dtype=float), 0.0, world, 5.0, Limits(), Wind(), Air(), Noise(), PERIOD, 1)


def course_for(envelope: Envelope) -> Course:
    nothing: Any = None
    return Course(nothing, nothing, envelope)


ENVELOPE = Quadrotor(radius=RADIUS).envelope(scenario(WALL, (0, 0, 5)))


def stepped(
    world: World,
    command: Command,
    position: Any,
    velocity: Any,
    law: Safety = LAYER,
    **known: Any,
) -> tuple[Command, SafetyMemory]:
    """Take one step of the layer in steady level flight."""
    still = np.zeros(3)
    state = State(0.0, np.array(position, dtype=float), np.array(velocity, dtype=float), LEVEL, still, still)
    around = Surroundings(world, **known)
    memory = law.start(course_for(ENVELOPE), around, state)
    return law.step(memory, command, state, around, PERIOD)


class Flown:
    """A flight with the layer behind a constant command."""

    def __init__(self, world: World, command: Command, start: Any, seconds: float, others: Any = None) -> None:
        vehicle, law = Quadrotor(radius=RADIUS), Safety()
        where = scenario(world, start)
        session = vehicle.launch(where)
        around = Surroundings(world)
        memory = law.start(course_for(vehicle.envelope(where)), around, session.sense())
        self.states, self.intervened = [session.truth()], 0
        for _ in range(round(seconds / PERIOD)):
            state = session.sense()
            if others is not None:
                around = replace(around, others=others(state.time))
            told, memory = law.step(memory, command, state, around, PERIOD)
            self.intervened += memory.intervening
            session.advance(told, PERIOD)
            self.states.append(session.truth())
        self.touched = session.touched()
        self.position: Array = np.array([state.position for state in self.states])
        self.velocity: Array = np.array([state.velocity for state in self.states])


@pytest.mark.parametrize(
    "command",
    [
        Setpoint(velocity=np.array([3.0, 0, 0])),
        Setpoint(position=np.array([3.0, 0, 5])),
        Setpoint(acceleration=np.array([1.0, 0, 0])),
        AttitudeSetpoint(LEVEL, GRAVITY),
        RateSetpoint(np.array([0.1, 0, 0]), GRAVITY),
    ],
)
def test_a_safe_command_passes_as_the_same_object(command: Command) -> None:
    told, memory = stepped(WALL, command, (0, 0, 5), (2, 0, 0))
    assert told is command
    assert not memory.intervening


def test_a_deadly_command_does_not_pass() -> None:
    for command in (
        Setpoint(velocity=np.array([8.0, 0, 0])),
        Setpoint(position=np.array([30.0, 0, 5])),
        Setpoint(acceleration=np.array([8.0, 0, 0])),
        AttitudeSetpoint(np.array([0.0, math.sin(0.3), 0, math.cos(0.3)]), 1.2 * GRAVITY),
    ):
        told, memory = stepped(WALL, command, (8.6, 0, 5), (3.5, 0, 0))
        assert memory.intervening
        assert isinstance(told, Setpoint)
        assert told.acceleration[0] < -3.0


def test_the_yaw_asked_for_is_kept() -> None:
    told, _ = stepped(WALL, Setpoint(velocity=np.array([8.0, 0, 0]), yaw=1.2, yaw_rate=0.3), (8.6, 0, 5), (3.5, 0, 0))
    assert isinstance(told, Setpoint)
    assert (told.yaw, told.yaw_rate) == (1.2, 0.3)


def test_passing_close_beside_a_trunk_at_speed_is_no_danger() -> None:
    """Through a gap of 0.5 m, in the middle and 3.5 cm beside it."""
    for y in (0.515, 0.55, 0.585):
        command = Setpoint(velocity=np.array([4.0, 0, 0]))
        for x in np.linspace(7.0, 11.0, 41):
            told, _ = stepped(GAP, command, (x, y, 5), (4, 0, 0))
            assert told is command, (x, y)


def test_a_gap_too_narrow_is_not_flown_into() -> None:
    flown = Flown(GAP, Setpoint(velocity=np.array([4.0, 0.0, 0])), (0.0, 0.2, 5), 5.0)
    clear = min(GAP.swept(a, b) for a, b in zip(flown.position[:-1], flown.position[1:], strict=True))
    assert clear >= RADIUS


def test_it_slides_along_a_wall() -> None:
    """Flown at a wall at 45°, it keeps the motion along the wall."""
    flown = Flown(WALL, Setpoint(velocity=np.array([3.0, 3.0, 0])), (5.0, 0.0, 5), 6.0)
    assert 10.0 - RADIUS - 0.05 < flown.position[-1, 0] <= 10.0 - RADIUS
    assert flown.velocity[-1, 1] == pytest.approx(3.0, abs=0.3)
    assert flown.position[:, 0].max() <= 10.0 - RADIUS


def test_it_waits_at_a_wall_for_as_long_as_it_is_pushed() -> None:
    flown = Flown(WALL, Setpoint(velocity=np.array([6.0, 0.0, 0])), (2.0, 0.0, 5), 8.0)
    late = flown.position[-100:]
    assert np.ptp(late[:, 0]) < 0.02
    assert np.ptp(late[:, 2]) < 0.2
    assert flown.position[-1, 0] == pytest.approx(9.79, abs=0.02)


def test_it_lands_without_hitting_the_ground() -> None:
    sinking = Setpoint(velocity=np.array([0.0, 0, -6.0]))
    flown = Flown(World(), sinking, (0.0, 0.0, 12), 8.0)
    assert flown.velocity[:, 2].min() < -2.0
    assert not flown.touched
    assert flown.position[-1, 2] < 0.2
    gentle = Flown(World(), Setpoint(velocity=np.array([0.0, 0, -0.5])), (0.0, 0.0, 2), 5.0)
    assert gentle.position[-1, 2] < 0.15
    up = Flown(World(), Setpoint(velocity=np.array([0.0, 0, 2.0])), (0.0, 0.0, 0.1), 3.0)
    assert up.intervened == 0
    assert up.position[-1, 2] > 4.0


def test_it_stays_within_bounds() -> None:
    bounds = np.array([[-5.0, -5.0, 0.0], [5.0, 5.0, 8.0]])
    for way in ((1, 0, 0), (-1, -1, 0), (0.3, 1, 0.3), (0, 0, 1)):
        flown = Flown(World(bounds=bounds), Setpoint(velocity=8.0 * np.array(way)), (0.0, 0.0, 4), 3.0)
        assert (flown.position >= bounds[0]).all()
        assert (flown.position <= bounds[1]).all()
        assert np.linalg.norm(flown.position[-1] - (0, 0, 4)) > 3.0


def test_a_ceiling_counts_as_an_obstacle_where_no_way_is_free() -> None:
    """Of two ways clear of obstacles the one that ends below the ceiling is the better one."""
    world = World(bounds=np.array([[-5.0, -5.0, 0.0], [5.0, 5.0, 8.0]]))
    around = Surroundings(world)
    here = np.array([0.0, 0.0, 7.0])
    room = Room(here, math.inf, 0.21, math.inf, planes_of(world, 0.01))
    for end, over in ((7.5, -0.49), (8.3, 0.31)):
        points = np.array([here, (0.0, 0.0, end)])
        way = Stop(points, np.array([0.0, 1.0]), True, end - 7.0, np.zeros(3), np.zeros(3))
        assert least_clearance(way, around, room) == pytest.approx(0.21 - over)


def test_it_flies_no_faster_than_its_sensors_see() -> None:
    rays = np.array([[1.0, 0, 0], [0, 1.0, 0]])
    scan = Scan(0.0, np.zeros(3), rays, np.full(2, np.inf), 4.0)
    command = Setpoint(velocity=np.array([9.0, 0, 0]))
    free, _ = stepped(World(), command, (0, 0, 5), (8, 0, 0))
    assert free is command
    told, memory = stepped(World(), command, (0, 0, 5), (8, 0, 0), scans=(scan,))
    assert memory.intervening
    assert isinstance(told, Setpoint)
    assert told.acceleration[0] < -3.0
    slow = Setpoint(velocity=np.array([4.0, 0, 0]))
    assert stepped(World(), slow, (0, 0, 5), (4, 0, 0), scans=(scan,))[0] is slow


def balls(position: Any, velocity: Any, radius: float = 0.3) -> Others:
    return Others(np.array([position], float), np.array([velocity], float), np.array([radius]), np.array([False]))


def test_it_stops_for_what_comes_towards_it() -> None:
    """At rest by the time of contact, it is all that braking can promise; from the side it is not hit at all."""
    ahead = Flown(
        World(), Setpoint(velocity=np.array([4.0, 0, 0])), (0.0, 0, 5), 3.0,
        lambda time: balls((10 - 1.5 * time, 0, 5), (-1.5, 0, 0)),
    )  # fmt: skip
    gaps = 10 - 1.5 * PERIOD * np.arange(len(ahead.states)) - ahead.position[:, 0] - 0.3
    touching = np.flatnonzero(gaps < RADIUS)
    assert ahead.intervened > 0
    assert touching.size == 0 or ahead.velocity[touching[0], 0] < 0.1


def test_what_crosses_behind_or_flies_along_is_no_danger() -> None:
    command = Setpoint(velocity=np.array([4.0, 0, 0]))
    for other in (balls((-2, 0, 5), (2, 0, 0)), balls((3, 1.0, 5), (4, 0, 0)), balls((1, -6, 5), (0, 2, 0))):
        assert stepped(World(), command, (0, 0, 5), (4, 0, 0), others=other)[0] is command


def test_a_vehicle_that_cannot_stop_is_refused() -> None:
    envelope = Point().envelope(scenario(WALL, (0, 0, 5)))
    state = State(0.0, np.zeros(3), np.zeros(3), LEVEL, np.zeros(3))
    with pytest.raises(InputError, match="cannot"):
        Safety().start(course_for(envelope), Surroundings(WALL), state)


numbers = st.one_of(st.just(math.nan), st.floats(-50, 50))
triples = st.tuples(numbers, numbers, numbers)


@settings(max_examples=60)
@given(triples, triples, triples, st.floats(6.0, 9.7), st.floats(-3, 3))
def test_any_setpoint_is_answered_with_one_that_can_be_flown(
    position: Any, velocity: Any, acceleration: Any, x: float, speed: float
) -> None:
    command = Setpoint(np.array(position), np.array(velocity), np.array(acceleration))
    told, memory = stepped(WALL, command, (x, 0, 5), (speed, 0, 0))
    assert told is command or memory.intervening
    if isinstance(told, Setpoint) and told is not command:
        assert np.isfinite(told.velocity).all()
        assert np.linalg.norm(told.acceleration) < 3 * GRAVITY


def test_the_same_state_gets_the_same_answer() -> None:
    command = Setpoint(velocity=np.array([8.0, 1.0, 0]))
    one, two = (stepped(WALL, command, (8.6, 0, 5), (3.5, 0.5, 0))[0] for _ in range(2))
    assert isinstance(one, Setpoint)
    assert isinstance(two, Setpoint)
    assert one.acceleration.tobytes() == two.acceleration.tobytes()
