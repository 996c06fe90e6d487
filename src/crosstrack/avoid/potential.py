"""Potential fields that fly: the command of the tracker attracts, obstacles repel, and the force is an acceleration."""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Gt, Le

from crosstrack.avoid.potential_braking import allowed, held_back
from crosstrack.avoid.potential_escape import Clear, Escape, Escaping, Side, Situation, decided
from crosstrack.avoid.potential_field import Factor, Terms, repulsions
from crosstrack.avoid.potential_run import walls
from crosstrack.avoid.potential_sources import NOTHING, Near, near_map, near_others
from crosstrack.avoid.potential_turning import along, turned_all
from crosstrack.protocols import Course, Surroundings
from crosstrack.types import Array, Command, Envelope, NonNegative, Positive, Setpoint, State
from crosstrack.vectors import direction, dot, limited, norm

LEAD = 0.3
"""s, for which the acceleration asked for beside a velocity counts: at rest it is all that asks"""
RETURN = 1.0
"""1/s, velocity asked for over the distance to a position that is asked for"""
BRAKING = 0.6
"""of the vehicle's acceleration, that it is counted on to brake with; the rest is left to errors"""
DELAY = 1.5
"""response times that pass before it brakes"""
ACCELERATION_MOST = 50.0
"""m/s², of a vehicle that turns at once"""
SLOWEST = 0.5
"""m/s, that the field moves a vehicle with that is asked to stand"""
FLANK = 4
"""power of the cosine by which a point on the flank of an obstacle repels less"""
UNCHANGED = 1e-3
"""m/s, change of the velocity that is none"""
SURE = 0.05
"""s, by which it brakes earlier still: what passes between two commands"""
TURNING = 0.9
"""of the vehicle's acceleration, that a change of the command may ask for"""


@dataclass(frozen=True)
class PotentialMemory:
    """What the field remembers."""

    intervening: bool
    """whether the last command was changed"""
    course: Course
    """what is followed"""
    progress: float
    """m, arc length of its closest point"""
    change: Array
    """(3,) m/s, by which it was"""
    escaping: Escaping
    """the way to the goal, and around an obstacle"""
    random: np.random.Generator
    """for random walks"""

    @property
    def trapped(self) -> bool:
        """Whether a local minimum is being left."""
        return self.escaping.trapped


@dataclass(frozen=True)
class Potential:
    """Steer around obstacles by a potential field, and back to the course, in 2-D and 3-D.

    What the tracker asks for is the attraction: its velocity u. Each obstacle at the gap d beyond the vehicle's radius
    and the margin, in the direction n away from it, adds the repulsion of a potential field, as a velocity over the
    vehicle's response time T:

        v = u + T/(K_v K_d K_e) Σ η (1/d - 1/Q) w/d² R n,       |v| at most |u|.

    The factors of the attraction divide the repulsion, which gives the same direction and keeps the speed that the
    course is planned for. In a local minimum R turns the repulsion to a side, see `Escape`, or the obstacle is followed
    until the way left along the course is shorter than where that began. Then v loses what approaches an obstacle
    faster than the vehicle can stop within its gap,

        -n·v ≤ a (√(T² + 2 d/a) - T),

    and turns no faster than it can accelerate. A command that nothing changes is passed on as it is.

    Sources: Khatib 1986 (IJRR 5(1)); Krogh 1984 (SME RI/SME 84-484), what can be stopped; Ge and Cui 2000 (IEEE
    Trans. Robotics and Automation 16(5)), w; Li 2020 (ICAICE), K_v, K_d, K_e, the rotation.
    """

    guards = False

    repulsion: NonNegative = 0.4
    """m⁴/s² without a factor, η"""
    influence: Positive = 1.5
    """m, Q, the gap from which obstacles count, beside the way to brake"""
    margin: NonNegative = 0.1
    """m, kept free beyond the radius of the vehicle"""
    factor: Factor = "vehicle"
    """what repulsions are multiplied by a power of: `obstacle`, of the distance from the goal to the obstacle;
    `vehicle`, to the vehicle; both over Q and at most 1; or `none`"""
    exponent: Annotated[float, Ge(1)] = 2.0
    """1, that power"""
    approach: bool = True
    """whether the attraction grows as the approach to the goal slows down, K_v"""
    near_goal: NonNegative = 3.0
    """1, by how much the attraction grows near the goal, K_d - 1 at 0.5 m; 0 turns it off"""
    boost: Annotated[float, Ge(1)] = 1.0
    """1, K_e, a constant factor of the attraction"""
    escape: Literal["none", "rotate", "walk"] = "rotate"
    """how to leave a local minimum: turn the repulsion, or walk at random"""
    angle_deg: Annotated[float, Gt(0), Le(120)] = 60.0
    """degrees, by which the repulsion is turned"""
    side: Side = "chosen"
    """to which side"""
    keep: bool = True
    """whether an obstacle is followed on that side until the goal is nearer"""
    share: Annotated[float, Gt(0), Le(1)] = 0.8
    """of the speed asked for, the approach to the goal under which the vehicle counts as trapped"""
    held_up: Annotated[float, Gt(0), Le(1)] = 0.2
    """likewise, under which it counts as held up, and keeps to a side"""
    held: Positive = 0.3
    """m, gap beyond radius and margin at which an obstacle is followed"""
    window: Positive = 1.0
    """s, over which the approach is averaged, and that a random walk lasts"""
    braking: bool = True
    """whether the approach to obstacles is held to what can be stopped"""
    seed: Annotated[int, Ge(0)] = 0
    """of random walks"""

    @cached_property
    def terms(self) -> Terms:
        """The field; its goal is the end of the course."""
        return Terms(
            attraction=1.0,
            repulsion=self.repulsion / (1.0 if self.factor == "none" else self.influence**self.exponent),
            influence=self.influence,
            factor=self.factor,
            exponent=self.exponent,
            far=self.influence,
            approach=self.approach,
            near_goal=self.near_goal,
            boost=self.boost,
        )

    @cached_property
    def way_out(self) -> Escape:
        """What to do in a local minimum."""
        return Escape(self.escape, self.angle_deg, self.side, self.keep, self.share, self.held_up, self.window)

    def start(self, course: Course, around: Surroundings, state: State) -> PotentialMemory:
        """Begin at the entry of the course."""
        remaining = left(course, course.entry, state.position)
        free = Escaping(closing=float(course.speed(course.entry)), remaining=remaining)
        return PotentialMemory(False, course, course.entry, np.zeros(3), free, np.random.default_rng(self.seed))

    def step(
        self, memory: PotentialMemory, command: Command, state: State, around: Surroundings, duration: float
    ) -> tuple[Command, PotentialMemory]:
        """Return the command, or the velocity to fly instead for the next `duration` (s), and the new memory."""
        if not isinstance(command, Setpoint):
            return command, memory
        memory = self.advanced(memory, state, duration)
        asked = attracted(command, state, memory.course.envelope)
        wanted, memory = self.velocity(memory, asked, state, around, duration)
        change = wanted - asked
        if norm(change) <= UNCHANGED:
            return command, replace(memory, intervening=False, change=np.zeros(3))
        memory = replace(memory, intervening=True, change=change)
        return Setpoint(velocity=wanted, yaw=command.yaw, yaw_rate=command.yaw_rate), memory

    def advanced(self, memory: PotentialMemory, state: State, duration: float) -> PotentialMemory:
        """Return the memory with the way left along the course, and how fast it has become shorter."""
        course, reach = memory.course, norm(state.velocity) * duration + 0.5
        progress = course.path.project(state.position, memory.progress, reach)
        remaining = left(course, progress, state.position)
        escaping = memory.escaping.approached(remaining, duration, self.window)
        return replace(memory, progress=progress, escaping=escaping)

    def velocity(
        self, memory: PotentialMemory, asked: Array, state: State, around: Surroundings, duration: float
    ) -> tuple[Array, PotentialMemory]:
        """Return the velocity (3,) m/s to fly, and the new memory."""
        envelope = memory.course.envelope
        ability, speed = able(envelope), max(norm(asked), SLOWEST)
        near, approach = self.surrounded(around, state, speed, envelope)
        felt = near.within(self.influence)
        wanted, memory = self.deflected(memory, asked, felt, state, around, speed, duration)
        wanted = asked + memory.change + limited(wanted - asked - memory.change, ability.turning * duration)
        if norm(wanted - asked) <= UNCHANGED and len(near.gaps) == 0:
            return asked, memory
        limits = walls(around.obstacles, state.position, 3)
        limits = limits[0] - envelope.radius - self.margin, limits[1]
        relaxed = [min(0.0, allowed(g, *ability.stop) + float(n @ asked)) for g, n in zip(*limits, strict=True)]
        if not self.braking:
            near, approach = NOTHING, np.empty(0)
        gaps, away = np.append(near.gaps, limits[0]), np.concatenate([near.away, limits[1]])
        return held_back(wanted, gaps, away, np.append(approach, relaxed), *ability.stop), memory

    def deflected(
        self,
        memory: PotentialMemory,
        asked: Array,
        near: Near,
        state: State,
        around: Surroundings,
        speed: float,
        duration: float,
    ) -> tuple[Array, PotentialMemory]:
        """Return the velocity (3,) m/s that attraction and repulsion give, and the new memory."""
        course, escaping = memory.course, memory.escaping
        way = course.path(course.path.length) - state.position
        pushes = near.facing[:, None] ** FLANK * repulsions(way, near.gaps, near.away, self.terms.numbers)[:, 1:]
        strength = self.terms.strengthened(norm(way), speed, escaping.closing)
        pushes = each_limited(course.envelope.response_time / strength * pushes, speed)
        push = pushes.sum(axis=0)
        at = Situation(
            position=state.position,
            way=direction(asked),
            push=direction(push),
            near=near,
            speed=speed,
            held=self.held,
            reach=self.influence,
            planar=False,
            clear=clear(around, course.envelope.radius + self.margin),
        )
        if norm(asked) > UNCHANGED:
            escaping = decided(self.way_out, escaping, at, duration, memory.random)
        memory = replace(memory, escaping=escaping)
        if not escaping.trapped:
            return limited(asked + push, speed), memory
        if self.escape == "walk":
            return speed * escaping.axis, memory
        if escaping.following:
            way_on = along(escaping.axis, escaping.away, escaping.gap, self.held)
            on_axis = dot(asked, escaping.axis) * escaping.axis
            return limited(speed * way_on + on_axis, speed), memory
        push = turned_all(pushes, near.away, at.way, escaping.axis, self.way_out.angle, self.side == "chosen")
        return limited(asked + push, speed), memory

    def surrounded(self, around: Surroundings, state: State, speed: float, envelope: Envelope) -> tuple[Near, Array]:
        """Return what may matter, with gaps beyond radius and margin, and how fast (n,) m/s it comes by itself."""
        thickness = envelope.radius + self.margin
        braking, delay = able(envelope).stop
        flown = max(speed, norm(state.velocity))
        reach = thickness + max(self.influence, flown * delay + 0.5 * flown**2 / braking)
        still = near_map(around.obstacles, state.position, reach)
        moving, velocity = near_others(around.others, state.position, reach)
        gaps, away = np.append(still.gaps, moving.gaps), np.concatenate([still.away, moving.away])
        faced = np.append(still.facing, moving.facing)
        approach = np.append(np.zeros(len(still.gaps)), (velocity * moving.away).sum(axis=1))
        order = np.argsort(gaps, kind="stable")
        return Near(gaps[order], away[order], faced[order]).grown(thickness), approach[order]


@dataclass(frozen=True)
class Ability:
    """How a vehicle turns and stops."""

    turning: float
    """m/s², the most that a change of velocity may take"""
    stop: tuple[float, float]
    """m/s² and s, what it brakes with, and when that begins"""


def able(envelope: Envelope) -> Ability:
    """Return how a vehicle turns and stops, counted on in every direction."""
    most = min(envelope.acceleration, envelope.acceleration_vertical, ACCELERATION_MOST)
    level = min(envelope.acceleration, ACCELERATION_MOST)
    return Ability(TURNING * level, (BRAKING * most, DELAY * envelope.response_time + SURE))


def clear(around: Surroundings, thickness: float) -> Clear:
    """Return what says how much room there is beyond a radius (m); -inf under the ground and out of bounds."""
    world = around.obstacles

    def room(points: Array) -> Array:
        inside = points[:, 2] >= world.ground + thickness
        if world.bounds is not None:
            inside = inside & ((points >= world.bounds[0]) & (points <= world.bounds[1])).all(axis=1)
        return np.where(inside, world.distance(points) - thickness, -np.inf)

    return room


def each_limited(pushes: Array, most: float) -> Array:
    """Return pushes (n, 3), each shortened to a length where it is longer."""
    length = np.linalg.norm(pushes, axis=1, keepdims=True)
    return np.asarray(pushes * np.minimum(1.0, most / np.maximum(length, most)))


def attracted(command: Setpoint, state: State, envelope: Envelope) -> Array:
    """Return the velocity (3,) m/s that a command asks for, with that towards its position where it has one."""
    velocity = np.nan_to_num(command.velocity) + LEAD * np.nan_to_num(command.acceleration)
    if np.isnan(command.position).all():
        return velocity
    offset = np.nan_to_num(command.position - state.position)
    return limited(velocity + RETURN * offset, envelope.speed)


def left(course: Course, progress: float, position: Array) -> float:
    """Return the way (m) to the end of a course: along it, and back to it."""
    return course.path.length - progress + float(np.linalg.norm(course.path(progress) - position))
