"""Moves along a path of straight legs: AirSim's own carrot chaser.

At every look the carrot lies the lookahead ahead of the progress made, along the path; the vehicle is asked to fly
straight at it. Progress is the way made towards the carrot, taken along the path, never back. With `adaptive`, the
distance beside the line to the carrot, times `adaptive`, is added to the lookahead.

**Mistakes of the original, kept** unless the vehicle is `ideal`:

- The speed is the same to the end: it overshoots corners and the goal, and where it comes to rest is up to the hold
  that follows.
- A height within half a metre of the carrot's is never corrected.
- The answer is true only where the carrot and the progress are at the very same point.
- A goal nearer than the lookahead is reached before it is begun: nothing moves, and the answer is false.

Here AirSim goes by chance, and this does not: a vehicle that has all but stopped short of the goal creeps on towards
it (some millimetres a second, for minutes, as its firmware forgets), unless it overshot by as little. Here such
creeping ends after seconds.

An ideal vehicle slows down in proportion to what is left of the way, goes on to the last point itself, whatever its
distance, and answers true there.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.moves import yaw
from crosstrack.airsim.server.moves.polling import PERIOD, Flown, Move, Polling
from crosstrack.airsim.server.moves.velocity import steer
from crosstrack.airsim.structs import YawMode

Point = tuple[float, float, float]

ACCURACY = 0.5
"""m, nearer than which a point is taken to be reached"""
FIXED_PERIODS, ADAPTIVE_PERIODS = 40, 30
"""lookahead, as looks at full speed, where the caller leaves it to the server"""
LEAST_LOOKAHEAD = 1.5 * ACCURACY
"""m, likewise"""
FAST, SLOW = 3.0, 1.0
"""m/s: faster than the first, the speed is the second once no way is left"""
CREEP = 1e-4
"""m, of progress between two looks, up to which it creeps"""
PATIENCE = 240
"""looks in a row, some five seconds, for which creeping towards the end goes on"""
BRAKING = 0.4
"""1/s, speed over what is left of the way, of an ideal vehicle"""
ARRIVED = 0.05
"""m, from the last point, and m/s, at which an ideal vehicle is there"""


@dataclass(frozen=True, slots=True)
class Place:
    """A place on the path."""

    leg: int
    """the last one is a leg of no length at the last point"""
    offset: float
    """m, along the leg"""
    point: Point
    """m, NED"""


class Legs:
    """Straight legs from point to point.

    Args:
        points: m, NED, at least two
    """

    def __init__(self, points: Sequence[Point]) -> None:
        self.points = points
        pairs = list(pairwise(points))
        self.lengths = [math.dist(a, b) for a, b in pairs]
        self.directions = [
            tuple((q - p) / length for p, q in zip(a, b, strict=True)) if length > 0 else (0.0, 0.0, 0.0)
            for (a, b), length in zip(pairs, self.lengths, strict=True)
        ]
        self.total = sum(self.lengths)

    def start(self) -> Place:
        """Return where it begins."""
        return Place(0, 0.0, self.points[0])

    def ahead(self, place: Place, distance: float) -> Place:
        """Return the place a distance (m) farther; at most the end. Legs of no length are passed."""
        leg, offset = place.leg, place.offset
        while leg < len(self.lengths):
            length = self.lengths[leg]
            if length > 0 and length >= distance + offset:
                x, y, z = self.points[leg]
                dx, dy, dz = self.directions[leg]
                s = distance + offset
                return Place(leg, s, (x + s * dx, y + s * dy, z + s * dz))
            distance -= length - offset
            leg, offset = leg + 1, 0.0
        return Place(leg, 0.0, self.points[leg])

    def left(self, place: Place) -> float:
        """Return the way (m) from a place to the end."""
        return self.total - sum(self.lengths[: place.leg]) - place.offset

    def ended(self, place: Place) -> bool:
        """Return whether a place is the end."""
        return place.leg >= len(self.lengths)


def auto_lookahead(speed: float, adaptive: float) -> float:
    """Return the lookahead (m) where the caller leaves it to the server."""
    return max(speed * PERIOD * (ADAPTIVE_PERIODS if adaptive > 0 else FIXED_PERIODS), LEAST_LOOKAHEAD)


def checked_lookahead(lookahead: float, speed: float, adaptive: float) -> float:
    """Return the lookahead (m) to use.

    Raises:
        Refused: it is zero, or too short for the speed.
    """
    if lookahead == 0:
        raise Refused("lookahead distance cannot be 0")
    if lookahead < 0:
        return auto_lookahead(speed, adaptive)
    least = speed * PERIOD
    if least > lookahead:
        raise Refused(
            f"lookahead value {lookahead:f} is too small for velocity {speed:f}. It must be at least {least:f}"
        )
    if lookahead < ACCURACY:
        raise Refused(f"lookahead value {lookahead:f} is smaller than drone's distance accuracy {ACCURACY:f}.")
    return lookahead


def fly_at(vehicle: Flown, target: Point, speed: float, drivetrain: int, mode: YawMode) -> None:
    """Ask for a velocity straight at a point (m, NED)."""
    x, y, z = vehicle.quadrotor.position.tolist()
    dx, dy, dz = target[0] - x, target[1] - y, target[2] - z
    distance = math.sqrt(dx * dx + dy * dy + dz * dz)
    mode = yaw.along(dx, dy, dz, drivetrain, mode)
    near = distance < (1e-9 if vehicle.ideal else ACCURACY)
    scale = 0.0 if near else min(speed, distance / PERIOD) / distance
    level = abs(dz) <= ACCURACY and not vehicle.ideal
    steer(vehicle, scale * dx, scale * dy, 0.0 if level else scale * dz, mode)


@dataclass(slots=True)
class Chase:
    """The carrot and what it follows."""

    legs: Legs
    lookahead: float
    """m"""
    adaptive: float
    progress: Place
    carrot: Place
    made: float = 0.0
    """m, towards the carrot since the last look; negative away from it"""
    error: float = 0.0
    """m, what the lookahead is longer by"""
    crept: int = 0
    """looks in a row with next to no progress, the carrot at the end"""
    complete: bool = False
    """whether the progress has come to the carrot itself"""

    def look(self, position: Sequence[float]) -> None:
        """Take in where the vehicle is (m, NED), and move the carrot."""
        base = self.progress.point
        gx, gy, gz = (g - b for g, b in zip(self.carrot.point, base, strict=True))
        reach = math.sqrt(gx * gx + gy * gy + gz * gz)
        if reach > 0:
            ax, ay, az = (p - b for p, b in zip(position, base, strict=True))
            self.made = (ax * gx + ay * gy + az * gz) / reach
            if self.adaptive:
                part = self.made / reach
                self.error = math.hypot(ax - part * gx, ay - part * gy, az - part * gz) * self.adaptive
        else:
            self.made = self.error = 0.0
            self.complete = True
        if self.made >= 0:
            self.progress = self.legs.ahead(self.progress, self.made)
        self.carrot = self.legs.ahead(self.progress, self.lookahead + self.error)
        self.crept = self.crept + 1 if self.made < CREEP and self.legs.ended(self.carrot) else 0

    @property
    def ended(self) -> bool:
        """Whether the carrot is at the end, and the vehicle no longer gets nearer."""
        return self.legs.ended(self.carrot) and (self.made <= 0 or self.crept > PATIENCE)


def move_on_path(
    vehicle: Flown,
    path: Sequence[Sequence[float]],
    speed: float,
    timeout: float,
    drivetrain: int,
    mode: YawMode,
    lookahead: float,
    adaptive: float,
) -> Move:
    """Fly through points (m, NED) at a speed (m/s).

    Raises:
        Refused: nose first with a yaw rate, or a lookahead that cannot be used.
    """
    if not len(path):
        return True
    if drivetrain == yaw.FORWARD_ONLY and mode.is_rate:
        raise Refused("Yaw cannot be specified as rate if drivetrain is ForwardOnly")
    lookahead = checked_lookahead(lookahead, speed, adaptive)
    points = [tuple(vehicle.quadrotor.position.tolist())] + [(float(x), float(y), float(z)) for x, y, z in path]
    if any(math.isnan(part) for point in points for part in point):
        raise Refused("dest vector cannot have NaN: the path has one")
    legs = Legs(points)
    chase = Chase(legs, lookahead, adaptive, legs.start(), legs.ahead(legs.start(), lookahead))
    fly = arrive if vehicle.ideal else chase_carrot
    return (yield from fly(vehicle, chase, speed, Polling(vehicle, timeout), drivetrain, mode))


def chase_carrot(vehicle: Flown, chase: Chase, speed: float, polling: Polling, drivetrain: int, mode: YawMode) -> Move:
    """Fly at the carrot until it and the vehicle have come to the end."""
    legs = chase.legs
    while not polling.over() and not chase.ended:
        late = speed > FAST and legs.ended(chase.progress)
        fly_at(vehicle, chase.carrot.point, SLOW if late else speed, drivetrain, mode)
        if not (yield from polling.sleep()):
            return False
        chase.look(vehicle.quadrotor.position.tolist())
    return chase.complete


def arrive(vehicle: Flown, chase: Chase, speed: float, polling: Polling, drivetrain: int, mode: YawMode) -> Move:
    """Fly at the carrot, slower and slower, until the vehicle rests at the last point."""
    goal = chase.legs.points[-1]
    while not polling.over():
        position = vehicle.quadrotor.position.tolist()
        left = max(chase.legs.left(chase.progress), math.dist(goal, position))
        if left < ARRIVED and math.hypot(*vehicle.quadrotor.velocity.tolist()) < ARRIVED:
            return True
        fly_at(vehicle, chase.carrot.point, min(speed, BRAKING * left), drivetrain, mode)
        if not (yield from polling.sleep()):
            return False
        chase.look(vehicle.quadrotor.position.tolist())
    return False


def move_to_position(
    vehicle: Flown,
    x: float,
    y: float,
    z: float,
    speed: float,
    timeout: float,
    drivetrain: int,
    mode: YawMode,
    lookahead: float,
    adaptive: float,
) -> Move:
    """Fly straight to a point (m, NED) at a speed (m/s)."""
    return move_on_path(vehicle, [(x, y, z)], speed, timeout, drivetrain, mode, lookahead, adaptive)


def move_to_z(
    vehicle: Flown, z: float, speed: float, timeout: float, mode: YawMode, lookahead: float, adaptive: float
) -> Move:
    """Fly straight up or down to a height z (m, down) at a speed (m/s)."""
    x, y, _ = vehicle.quadrotor.position.tolist()
    return move_on_path(vehicle, [(x, y, z)], speed, timeout, 0, mode, lookahead, adaptive)
