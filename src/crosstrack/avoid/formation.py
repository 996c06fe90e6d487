"""Flying in formation by potentials between the vehicles, without a leader."""

import math
from dataclasses import dataclass, replace

import numpy as np

from crosstrack.avoid.formation_field import formed, from_others
from crosstrack.avoid.formation_shapes import Shape, slots
from crosstrack.protocols import Course, Surroundings
from crosstrack.types import Array, Command, Others, Positive, Setpoint, State
from crosstrack.vectors import limited, norm

GAIN = 1.5
"""1/s, from the way to a position asked for to the velocity wanted"""
BEYOND = 1.2
"""over cruise, the fastest that a vehicle that has fallen behind flies"""
CHANGED = 1e-3
"""m/s, of the velocity: more is a change"""


@dataclass(frozen=True)
class FormationMemory:
    """What it remembers."""

    course: Course
    cruise: float
    """m/s, the fastest of the course"""
    places: Array
    """(count, 3) m, the slots from their middle"""
    intervening: bool = False
    """whether it changed the last command"""

    @property
    def goal(self) -> Array:
        """(3,) m, end of the course"""
        return self.course.path(self.course.path.length)


@dataclass(frozen=True)
class Formation:
    """Keep a slot in a formation; give the shape up for obstacles, and regain it behind them.

    Every vehicle has a course of its own, the common one displaced by its slot. With the slots s and all vehicles at p,
    the middle of the formation is the mean c of p - s: nobody leads. To the velocity V w of the course come the
    attraction to the slot and repulsions of the other vehicles and of the nearest obstacle,

        v = V w + (1 - σ) k (c + s - p) + V Σ σ_j n_j + V σ n,     σ(d) = (1/d - 1/d0) / (1/r - 1/d0),

    where σ is 1 at the sum of the radii r and 0 from the reach d0 on, n points away, and of V w what leads into an
    obstacle is turned along it. So near an obstacle the attraction ends, and the shape is given up. Nearer to the goal
    than the spacing it fades too: every vehicle has its own place to hold.

    The potentials alone promise no distance: put `safety` behind it.

    Sources: Khatib 1986 (Real-time obstacle avoidance for manipulators and mobile robots, IJRR 5(1)); formations by
    potentials: Leonard, Fiorelli 2001 (Virtual leaders, artificial potentials and coordinated control of groups, CDC).
    """

    guards = False

    shape: Shape = "v"
    """line abreast, v with its tip ahead, or circle; slots go to the vehicles in the order of the mission"""
    spacing: Positive = 2.0
    """m, between neighbours along the shape"""
    stiffness: Positive = 0.8
    """1/s, k, velocity over the way to the slot"""
    obedience: Positive = 0.5
    """of cruise, the most that is spent on the shape"""
    reach: Positive = 1.5
    """m, d0, between a vehicle and obstacles that repel it"""
    apart: Positive = 1.0
    """m, d0, between vehicles that repel one another"""

    def start(self, course: Course, around: Surroundings, state: State) -> FormationMemory:
        """Begin with the slots for the heading of the course, from its entry to its end."""
        along = course.path(course.path.length) - course.path(course.entry)
        heading = math.atan2(along[1], along[0])
        cruise = float(np.max(course.speed(np.linspace(0.0, course.path.length, 50))))
        return FormationMemory(course, cruise, slots(self.shape, around.count, self.spacing, heading))

    def step(
        self, memory: FormationMemory, command: Command, state: State, around: Surroundings, duration: float
    ) -> tuple[Command, FormationMemory]:
        """Return the velocity that keeps the slot too, and the new memory."""
        if not isinstance(command, Setpoint):
            return command, memory
        position, radius, others = state.position, memory.course.envelope.radius, around.others
        wanted = np.nan_to_num(command.velocity) + GAIN * np.nan_to_num(command.position - position)
        wanted = limited(wanted, memory.cruise)
        to_slot = way_to_slot(memory.places, around.index, position, others)
        to_slot = to_slot * min(1.0, norm(memory.goal - position) / self.spacing)
        push = from_others(position, others.position, others.radius, radius, self.apart)
        distance = float(around.obstacles.distance(position))
        normal = np.asarray(around.obstacles.gradient(position))
        rule = (self.stiffness, self.obedience, self.reach, BEYOND * memory.cruise)
        velocity = formed(wanted, to_slot, push, normal, distance, radius, rule)
        changed = norm(velocity - wanted) > CHANGED
        memory = replace(memory, intervening=changed)
        if not changed:
            return command, memory
        return replace(command, position=np.full(3, np.nan), velocity=velocity), memory


def way_to_slot(places: Array, index: int, position: Array, others: Others) -> Array:
    """Return the way (3,) m from a vehicle to its slot; none where not all of the formation fly.

    Args:
        places: (count, 3) m, the slots from their middle
        index: which of the vehicles it is
        position: (3,) m
        others: the others of the formation, in order, and what else moves
    """
    team = others.position[others.avoids]
    if len(team) != len(places) - 1:
        return np.zeros(3)
    middle = np.insert(team, index, position, axis=0) - places
    way: Array = middle.mean(axis=0) + places[index] - position
    return way
