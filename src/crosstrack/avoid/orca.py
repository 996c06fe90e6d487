"""Optimal reciprocal collision avoidance in three dimensions, for vehicles that take time to change their velocity."""

import math
from dataclasses import dataclass, replace

import numpy as np

from crosstrack.avoid.orca_choice import Hold, choose
from crosstrack.avoid.orca_walls import walls_around
from crosstrack.compiled import compiled
from crosstrack.protocols import Course, Surroundings
from crosstrack.types import Array, Command, NonNegative, Positive, Setpoint, State
from crosstrack.vectors import limited, norm

GAIN = 1.5
"""1/s, from the way to a position asked for to the velocity preferred"""
ON_COURSE, ASTRAY = 0.3, 1.0
"""m, from the course: up to the first it is flown as its tracker says, from the second on it is rejoined ahead"""
AHEAD = 2.0
"""over the distance to the course: how far ahead it is rejoined"""
BRISK = 0.67
"""of the speed that the acceleration takes away within the horizon: the fastest among others"""
LEAD = 0.5
"""s, how far the velocity asked for may be ahead of the one flown"""
CHANGED = 1e-3
"""m/s, of the velocity preferred: more is a change"""


@dataclass(frozen=True)
class OrcaMemory:
    """What it remembers."""

    course: Course
    progress: float
    """m, arc length of the closest point of the course"""
    cruise: float
    """m/s, the fastest of the course"""
    velocity: Array
    """(3,) m/s, asked for last"""
    hold: Hold
    """how the vehicle has been held up"""
    intervening: bool = False
    """whether it changed the last command"""

    @property
    def radius(self) -> float:
        """m, of the vehicle"""
        return self.course.envelope.radius

    def remaining(self, state: State) -> float:
        """m, to the end of the course: along it, or straight where that is longer"""
        path = self.course.path
        return max(path.length - self.progress, norm(path(path.length) - state.position))


@dataclass(frozen=True)
class Orca:
    """Give way to whatever moves, by half where it gives way too; keep clear of what stands.

    Of all velocities that stay clear of every other vehicle for the horizon, if each does its share, it flies the one
    nearest to the velocity preferred: that of the tracker on the course, and towards a point of the course ahead where
    the vehicle was driven off. Where none is left, it flies the one that misses the fewest m/s of any half-space. One
    that is held up turns its preference to its right, the more the longer: so vehicles that meet pass on the same
    side, and a crowd turns as a roundabout. One that has stalled even so tries its left.

    What is asked for changes no faster than `acceleration`, and the acceleration itself is passed on, so that the
    vehicle follows at once. Among others it flies no faster than it can brake within two thirds of the horizon, and no
    faster to its goal than it gets there within the horizon.

    Sources: van den Berg, Guy, Lin, Manocha 2011 (Reciprocal n-body collision avoidance, Springer Tracts in Advanced
    Robotics 70); that velocities do not change at once: van den Berg, Snape, Guy, Manocha 2011 (Reciprocal collision
    avoidance with acceleration-velocity obstacles, ICRA). Turning right while held up is ours.
    """

    guards = False

    horizon: Positive = 2.0
    """s, for how long no collision is to be ahead"""
    margin: NonNegative = 0.1
    """m, beside the radii, that vehicles keep between them where there is room"""
    acceleration: Positive = 2.5
    """m/s², how fast the velocity asked for changes; at most what the vehicle has"""
    climb: NonNegative = 0.0
    """m/s, how fast it may leave the height of its course to avoid; at 0 it stops a climb at most"""

    def start(self, course: Course, around: Surroundings, state: State) -> OrcaMemory:
        """Begin where the vehicle is, held up by nothing."""
        along = np.linspace(0.0, course.path.length, 50)
        cruise = float(np.max(course.speed(along)))
        return OrcaMemory(course, course.entry, cruise, state.velocity, (0.0, 1.0, 0.0))

    def step(
        self, memory: OrcaMemory, command: Command, state: State, around: Surroundings, duration: float
    ) -> tuple[Command, OrcaMemory]:
        """Return the command itself where it is free, else the velocity and acceleration to fly, and the new memory."""
        if not isinstance(command, Setpoint):
            return command, memory
        path, others = memory.course.path, around.others
        error = norm(path(memory.progress) - state.position)
        progress = path.project(state.position, memory.progress, 1.0 + error)
        foot, ahead = path(progress), path(progress + AHEAD * error)
        wanted = blended(command.velocity, command.position, state.position, foot, ahead, memory.cruise)
        memory = replace(memory, progress=progress)
        walls = walls_around(around.obstacles, state.position, memory.radius, self.horizon * memory.cruise)
        moving = (state.position, others.position, others.velocity, others.radius)
        crowded = near(*moving, self.horizon, memory.cruise)
        if not len(walls) and not crowded:
            return command, replace(memory, velocity=wanted, intervening=False)
        most = min(self.acceleration, memory.course.envelope.acceleration)
        last = reference(memory.velocity, state.velocity, LEAD * most)
        calm = limited(wanted, self.pace(memory, state, most)) if crowded else wanted
        velocity, hold = self.choice(memory, last, calm, state, around, walls, duration)
        if crowded or norm(velocity - wanted) > CHANGED:
            velocity = slewed(last, velocity, duration * most)
        memory = replace(memory, velocity=velocity, hold=hold, intervening=norm(velocity - wanted) > CHANGED)
        return (asked(command, last, velocity, duration) if memory.intervening else command), memory

    def pace(self, memory: OrcaMemory, state: State, most: float) -> float:
        """Return the fastest (m/s) to fly among others with an acceleration of at most `most` m/s²."""
        return min(BRISK * most * self.horizon, memory.remaining(state) / self.horizon)

    def choice(
        self,
        memory: OrcaMemory,
        last: Array,
        wanted: Array,
        state: State,
        around: Surroundings,
        walls: Array,
        duration: float,
    ) -> tuple[Array, Hold]:
        """Return the velocity chosen (3,) m/s, and how the vehicle has been held up."""
        others = around.others
        rule = (memory.radius, self.margin, self.horizon, max(memory.cruise, norm(wanted)), self.climb)
        moving = (others.position, others.velocity, others.radius, others.avoids)
        chosen, hold = choose(state.position, last, wanted, memory.hold, walls, *moving, rule, duration)
        return np.array(chosen), hold


def asked(command: Setpoint, last: Array, velocity: Array, duration: float) -> Setpoint:
    """Return a command changed to a velocity (3,) m/s, with the acceleration from the last one on the level."""
    push = (velocity - last) / duration
    push[2] = 0.0
    return Setpoint(velocity=velocity, acceleration=push, yaw=command.yaw, yaw_rate=command.yaw_rate)


@compiled
def blended(asked: Array, target: Array, position: Array, foot: Array, ahead: Array, cruise: float) -> Array:
    """Return the velocity (3,) m/s to fly if nothing were in the way.

    It is what a setpoint asks for, no faster than cruise; the farther from the course, the more it is towards a point
    of the course ahead.

    Args:
        asked: (3,) m/s, of the setpoint
        target: (3,) m, likewise
        position: (3,) m
        foot: (3,) m, closest point of the course
        ahead: (3,) m, where the course is to be rejoined
        cruise: m/s
    """
    wanted, back, error = np.empty(3), np.empty(3), 0.0
    for k in range(3):
        pull = GAIN * (target[k] - position[k])
        wanted[k] = (0.0 if math.isnan(asked[k]) else asked[k]) + (0.0 if math.isnan(pull) else pull)
        back[k] = GAIN * (ahead[k] - position[k])
        error += (foot[k] - position[k]) ** 2
    astray = min(1.0, max(0.0, (math.sqrt(error) - ON_COURSE) / (ASTRAY - ON_COURSE)))
    return (1.0 - astray) * limited(wanted, cruise) + astray * limited(back, cruise)


@compiled
def near(position: Array, others: Array, motion: Array, radius: Array, horizon: float, speed: float) -> bool:
    """Return whether anything that moves can be met within the horizon (s) at a speed (m/s)."""
    for j in range(others.shape[0]):
        reach = 1.0 + radius[j] + horizon * (speed + norm(motion[j]))
        if norm(others[j] - position) < reach:
            return True
    return False


@compiled
def reference(last: Array, velocity: Array, lead: float) -> Array:
    """Return the velocity (3,) m/s asked for last, no farther than `lead` (m/s) from the one flown."""
    return velocity + limited(last - velocity, lead)


@compiled
def slewed(last: Array, velocity: Array, most: float) -> Array:
    """Return a velocity (3,) m/s that differs from the last by at most `most` sideways, and up or down."""
    out = velocity.copy()
    x, y, z = velocity[0] - last[0], velocity[1] - last[1], velocity[2] - last[2]
    size = math.sqrt(x * x + y * y)
    if size > most:
        out[0], out[1] = last[0] + most * x / size, last[1] + most * y / size
    out[2] = last[2] + min(most, max(-most, z))
    return out
