"""A safety layer: the vehicle can always come to rest before any obstacle it knows of."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np
from annotated_types import Gt, Le

from crosstrack.avoid.barrier import least_acceleration, nearest
from crosstrack.avoid.safety_command import asked_by, clip, keeps_upright
from crosstrack.avoid.safety_motion import Ability, Motion, ability, bound_for, moderate, started, support, thrown
from crosstrack.avoid.safety_stopping import Escape, Stop, way_to_rest
from crosstrack.avoid.safety_way import Block, Room, first_block, least_clearance, planes_of
from crosstrack.errors import InputError, Problem
from crosstrack.protocols import Course, Surroundings
from crosstrack.types import GRAVITY, Array, Command, NonNegative, Setpoint, State, unset

BRAKE = Escape(np.zeros(3), 0.0)
TRIES = 4
"""commands tried before the vehicle begins a way to rest"""
CAUTION = 0.95
"""of the deceleration counted on, for commands that are proposed: so that they are found safe"""
SLOW = 0.85
"""of the response time, by which a vehicle may begin to brake later than expected"""
WARY = 1.15
"""the same, for a command to pass after one that did not: so that passing and braking do not alternate"""
LIGHT = 1.0
"""of the response time, more by so much where a command asks for no thrust at all: rotors that hardly turn have little
torque to turn the vehicle back"""
EVADE = 0.7
"""of the acceleration counted on, for turning away: a turn is known less well than braking"""
HARD = 2.5
"""of the gain, where no way is free: it may overshoot then, since that is away from what is in the way"""
WORTH = 0.005
"""m, of clearance that a way must gain to be taken instead of pressing away from obstacles"""
SKIM = 1.0
"""m/s, sideways, above which a vehicle keeps its radius above the ground: it is not landing"""
NOTHING = unset()
GROUND = np.array([[0.0, 0.0, 0.0, 1.0], *np.zeros((6, 4))])
"""(7, 4) which of the planes is the ground"""


@dataclass(frozen=True)
class SafetyMemory:
    """What the safety layer remembers."""

    counted: Ability
    """what it counts on for braking"""
    full: Ability
    """what the vehicle is able to"""
    radius: float
    """m, of the vehicle"""
    planes: Array
    """(n, 4) ground and bounds, see `safety_way.planes_of`"""
    asked: Array
    """(3,) m/s², acceleration asked for last"""
    jerk: Array = field(default_factory=unset)
    """(3,) m/s³, then"""
    escape: Escape = BRAKE
    """how it would come to rest"""
    seen: float = math.inf
    """m, as far as its sensors see"""
    between: float = 0.0
    """s, between two scans"""
    scanned: float = -math.inf
    """s, time of the last scan"""
    intervening: bool = False
    """whether it changed the last command"""


@dataclass(frozen=True)
class Safety:
    """Change a command as little as possible so that the vehicle can always come to rest clear of obstacles.

    A command passes if the vehicle, after holding it for a period, can still come to rest, by braking or by turning
    away and then braking, with the clearance kept all along the way. Otherwise the acceleration nearest to the one
    asked for takes its place, out of those that approach no obstacle faster than can be stopped, if it passes the same
    test; and where none does, the vehicle begins a free way to rest.

    Sources: braking distance as a limit, Fox, Burgard, Thrun 1997; barriers, Ames et al. 2017; a command let through as
    long as a way back is known, Agrawal, Chen, Panagou 2023; at rest by contact, Bouraine, Fraichard, Salhi 2012.
    """

    guards = True

    share: Annotated[float, Gt(0), Le(1)] = 0.75
    """of the vehicle's acceleration, counted on for braking; the rest is held in reserve"""
    margin: NonNegative = 0.01
    """m, kept beyond the vehicle's radius; at least what the map's distances may be too large by"""

    def start(self, course: Course, around: Surroundings, state: State) -> SafetyMemory:
        """Begin with what the vehicle can do.

        Raises:
            InputError: the vehicle cannot come to rest.
        """
        envelope = course.envelope
        if not envelope.stops:
            problem = Problem("vehicle", "safety is for a vehicle that can come to rest; this one cannot")
            raise InputError("avoid", [problem])
        return SafetyMemory(
            ability(envelope, self.share),
            ability(envelope, 1.0),
            envelope.radius,
            planes_of(around.obstacles, self.margin),
            np.zeros(3),
        )

    def step(
        self, memory: SafetyMemory, command: Command, state: State, around: Surroundings, duration: float
    ) -> tuple[Command, SafetyMemory]:
        """Return the same command where it is safe, and the nearest that is found safe otherwise."""
        decision = Decision(self, noticed(memory, around), state, around, duration)
        return decision.made(command)


def lightness(asked: Array) -> float:
    """Return by what share of its weight the thrust for an acceleration (3,) m/s² falls short of it."""
    x, y, z = asked.tolist()
    return max(0.0, 1.0 - math.hypot(x, y, z + GRAVITY) / GRAVITY)


def noticed(memory: SafetyMemory, around: Surroundings) -> SafetyMemory:
    """Return the memory with what the latest scans say of how far and how often is seen."""
    if not around.scans:
        return memory
    reach = max(scan.max_range for scan in around.scans)
    seen = reach if math.isinf(memory.seen) else max(memory.seen, reach)
    time = around.scans[-1].time
    between = time - memory.scanned if math.isfinite(memory.scanned) else 0.0
    return replace(memory, seen=seen, between=max(memory.between, between), scanned=time)


@dataclass
class Decision:
    """One step of the safety layer."""

    law: Safety
    memory: SafetyMemory
    state: State
    around: Surroundings
    duration: float
    motion: Motion = field(init=False)
    room: Room = field(init=False)

    def __post_init__(self) -> None:
        memory, state = self.memory, self.state
        known = state.acceleration if math.isfinite(state.acceleration.sum()) else memory.asked
        jerk = thrown(known, state.attitude, state.rate)
        self.motion = started(
            state.position, state.velocity, known, jerk, memory.jerk, memory.asked, self.duration, memory.full
        )
        self.memory = replace(memory, jerk=jerk)
        here = self.motion[0]
        needed = memory.radius + max(self.law.margin, self.around.obstacles.optimism)
        blind = math.sqrt(float(state.velocity @ state.velocity)) * (memory.between + self.duration)
        distance = float(self.around.obstacles.distance(here))
        planes = memory.planes
        if math.hypot(state.velocity[0], state.velocity[1]) > SKIM:
            planes = planes + memory.radius * GROUND[: len(planes)]
        self.room = Room(here, distance, needed, max(0.0, memory.seen - needed - blind), planes)

    def made(self, command: Command) -> tuple[Command, SafetyMemory]:
        """Return the command to fly, and the new memory."""
        full = self.memory.full
        asked = asked_by(command, self.state, full, self.duration)
        block: Block | None = None
        if keeps_upright(command, self.state, self.duration + full.turn_time + full.spin_time):
            escape, block = self.judged(asked, WARY if self.memory.intervening else SLOW)
            if escape is not None:
                return command, replace(self.memory, asked=asked, escape=escape, intervening=False)
        found = self.proposed(moderate(asked, self.memory.full), block) or self.retreat(asked)
        stop, escape = found
        yaw = (command.yaw, command.yaw_rate) if isinstance(command, Setpoint) else (math.nan, math.nan)
        changed = Setpoint(NOTHING, stop.velocity, stop.asked, *yaw)
        return changed, replace(self.memory, asked=stop.asked, escape=escape, intervening=True)

    def way(self, asked: Array, escape: Escape, able: Ability, extra: float = 0.0) -> Stop:
        """Return the way to rest after an acceleration (3,) m/s² asked for during this period; NaN for none.

        Args:
            asked: (3,) m/s²
            escape: what follows
            able: what it brakes with
            extra: s, for which the command goes on acting
        """
        return way_to_rest(self.motion, asked, self.duration + extra, escape, able)

    def blocked(self, way: Stop) -> Block | None:
        """Return what a way runs into."""
        return first_block(way, self.around, self.room)

    def judged(self, asked: Array, slow: float) -> tuple[Escape | None, Block | None]:
        """Return how the vehicle can come to rest after an acceleration (3,) m/s² asked for, or what is in the way.

        Args:
            asked: (3,) m/s²
            slow: of the response time, for which the command goes on acting, at least
        """
        able, extra = self.memory.counted, (slow + LIGHT * lightness(asked)) * self.memory.full.response
        block = self.blocked(self.way(asked, BRAKE, able, extra))
        if block is None:
            return BRAKE, None
        able = able._replace(sideways=EVADE * able.sideways, vertical=EVADE * able.vertical)
        for escape in self.escapes(block, asked, able, extra):
            if self.blocked(self.way(asked, escape, able, extra)) is None:
                return escape, None
        return None, block

    def escapes(self, block: Block, asked: Array, able: Ability, extra: float = 0.0) -> Iterator[Escape]:
        """Yield ways to turn away from what is in the way, the one remembered last."""
        aside = Escape(block.normal, 0.0)
        yield aside
        yield Escape(block.normal, 1.0)
        second = self.blocked(self.way(asked, aside, able, extra))
        if second is not None:
            both = block.normal + second.normal
            size = float(np.linalg.norm(both))
            if size > 0.1:
                yield Escape(both / size, 0.0)
        if self.memory.escape is not BRAKE:
            yield self.memory.escape

    def proposed(self, asked: Array, block: Block | None) -> tuple[Stop, Escape] | None:
        """Return a command near the one asked for that is found safe: on the safe side of all that is in the way."""
        blocks = self.closest()
        for _ in range(TRIES):
            if block is None:
                break
            blocks.append(block)
            nearby = self.pushed(asked, blocks, strong=False)
            escape, block = self.judged(nearby, SLOW)
            if escape is not None:
                return self.way(nearby, escape, self.memory.counted), escape
        return None

    def pushed(self, asked: Array, blocks: list[Block], *, strong: bool) -> Array:
        """Return the acceleration (3,) m/s² nearest to the one asked for on the safe side of all that is in the way.

        Nearest in the ellipsoid of what the vehicle is able to: it is pushed aside more easily than up or down.
        """
        full = self.memory.full
        place, velocity = np.empty(3), np.empty(3)
        bound_for(self.motion, full, place, velocity)
        axes = np.array([full.sideways, full.sideways, full.vertical])
        normals = axes * np.array([block.normal for block in blocks])
        sizes = np.sqrt((normals * normals).sum(axis=1))
        least = np.array([self.least(block, place, velocity, strong=strong) for block in blocks])
        near = axes * nearest(asked / axes, normals / sizes[:, None], least / sizes)
        clip(near, full)
        return np.asarray(near)

    def least(self, block: Block, place: Array, velocity: Array, *, strong: bool) -> float:
        """Return the least acceleration (m/s²) along the normal of what is in the way."""
        n = block.normal
        speed = float(n @ velocity) - block.approach
        room = block.room + float(n @ (place - self.room.here))
        deceleration = support(n, self.memory.full) if strong else CAUTION * support(n, self.memory.counted)
        return least_acceleration(room, speed, deceleration, self.memory.full.gain)

    def retreat(self, asked: Array) -> tuple[Stop, Escape]:
        """Return the free way to rest, beginning now, that is nearest to what was asked for; the best if none is."""
        blocks: list[Block] = []
        hard = self.memory.full._replace(gain=HARD * self.memory.full.gain)
        for able in (self.memory.counted, self.memory.full, hard):
            ways = [(self.way(NOTHING, BRAKE, able), BRAKE)]
            block = self.blocked(ways[0][0]) or self.blocked(self.way(asked, BRAKE, able))
            if block is not None:
                ways += [(self.way(NOTHING, escape, able), escape) for escape in self.escapes(block, NOTHING, able)]
            found = [self.blocked(way) for way, _ in ways]
            free = [pair for pair, hit in zip(ways, found, strict=True) if hit is None]
            if free:
                return min(free, key=lambda pair: float(np.linalg.norm(pair[0].asked - asked)))
            blocks = [hit for hit in found if hit is not None]
        pressed = self.pressed(ways[0][0].asked, blocks + self.closest(), hard)
        best = max(ways, key=self.clearance)
        gained = self.clearance(best) - self.clearance(pressed)
        return best if gained > WORTH else pressed

    def clearance(self, found: tuple[Stop, Escape]) -> float:
        """Return the least clearance (m) along a way to rest."""
        return least_clearance(found[0], self.around, self.room)

    def closest(self) -> list[Block]:
        """Return the nearest obstacle, where there is any, as a half-space."""
        if math.isinf(self.room.distance):
            return []
        normal = self.around.obstacles.gradient(self.room.here)
        return [Block(normal, self.room.distance - self.room.needed, 0.0)] if normal.any() else []

    def pressed(self, asked: Array, blocks: list[Block], able: Ability) -> tuple[Stop, Escape]:
        """Return braking (3,) m/s², pressed to the safe side of all that is in the way as hard as the vehicle can."""
        return self.way(self.pushed(asked, blocks, strong=True), BRAKE, able), BRAKE
