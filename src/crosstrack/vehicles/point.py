"""A point that flies at constant speed and turns at once: the kinematic vehicle of the carrot-chasing papers."""

import math
from dataclasses import dataclass

import numpy as np

from crosstrack.errors import InputError, Problem
from crosstrack.protocols import Scenario
from crosstrack.sim import estimate, turbulence
from crosstrack.sim.watch import Watch
from crosstrack.types import Array, Command, Envelope, NonNegative, Positive, Scan, Setpoint, State

NEAR = 0.2
"""m, from the last point: a point that passes it no farther has arrived"""

SMALL = 1e-9
"""sine of an angle that is none"""

SKIM = 0.01
"""m, below the ground, that is still gliding along it"""


@dataclass(frozen=True)
class Point:
    """A kinematic vehicle of constant airspeed."""

    radius: Positive = 0.2
    """m, of the sphere that must stay free"""
    lag: NonNegative = 0.0
    """s, time constant of the first-order lag of its course; 0 for none"""
    acceleration: Positive | None = None
    """m/s², the most that it turns with, speed times turn rate; none for no limit"""

    @property
    def stand_in(self) -> "Point":
        """Itself."""
        return self

    def envelope(self, scenario: Scenario) -> Envelope:
        """Return what it can do: fly at the mission's speed, always."""
        most = self.acceleration or math.inf
        speed = scenario.limits.speed
        return Envelope(speed, speed, most, most, self.lag, self.radius, stops=False)

    def launch(self, scenario: Scenario) -> "PointSession":
        """Put it at the start, flying at the mission's speed along its yaw."""
        return PointSession(self, scenario)

    def arrived(self, before: State, now: State, goal: Array, remaining: float) -> bool:
        """Judge it arrived when it has passed the goal within 0.2 m, with no path left."""
        flown = now.position - before.position
        length = float(flown @ flown)
        u = min(1.0, max(0.0, float((goal - before.position) @ flown) / length)) if length > 0 else 0.0
        passed = u < 1.0 or remaining <= 0
        return bool(passed and np.linalg.norm(before.position + u * flown - goal) <= NEAR and remaining <= NEAR)


class PointSession:
    """One flight of a point; the velocity it asks for holds through the air, and the wind adds to it."""

    def __init__(self, vehicle: Point, scenario: Scenario) -> None:
        self.vehicle, self.speed, self.ground = vehicle, scenario.cruise, scenario.world.ground
        self.rng = np.random.default_rng(scenario.seed)
        self.mean = np.array(scenario.wind.mean)
        self.airspeed = self.speed * np.array([math.cos(scenario.yaw), math.sin(scenario.yaw), 0.0])
        self.gusts = turbulence.start(scenario.wind, self.rng)
        self.moving_air = self.mean
        self.state = self.stated(0.0, scenario.position.copy())
        self.blow(0.0)
        self.estimator = estimate.start(scenario.noise, self.state)
        self.estimated, self.estimator = estimate.step(self.estimator, self.state, self.rng)
        self.watch = Watch(scenario)
        self.watch.step(self.state)

    def stated(self, time: float, position: Array) -> State:
        """Return the state at a place: it looks where it flies."""
        yaw = math.atan2(self.airspeed[1], self.airspeed[0])
        attitude = np.array([0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)])
        return State(time, position, self.airspeed + self.moving_air, attitude, np.zeros(3))

    def blow(self, duration: float) -> None:
        """Set the wind for the next step, after flying through it for a time."""
        height = self.state.position[2] - self.ground
        gust, self.gusts = turbulence.step(self.gusts, self.state.velocity, height, duration, self.rng)
        self.moving_air = self.mean + gust

    def sense(self) -> State:
        """Return the state as estimated."""
        return self.estimated

    def truth(self) -> State:
        """Return the true state."""
        return self.state

    def scans(self) -> list[Scan]:
        """Return what its sensors have seen since this was last asked."""
        return self.watch.take()

    def wind(self) -> Array:
        """Return the wind at the vehicle, (3,) m/s."""
        return self.moving_air

    def touched(self) -> bool:
        """Return whether it is below the ground; it may glide along it."""
        return bool(self.state.position[2] < self.ground - SKIM)

    def begin(self, command: Command, duration: float) -> None:
        """Need no notice: its clock is its own."""

    def advance(self, command: Command, duration: float) -> None:
        """Fly for a time (s) in the direction of the velocity asked for, turned by the acceleration asked for."""
        if not isinstance(command, Setpoint):
            raise InputError("vehicle", [Problem("kind", "point flies velocities; this tracker gives attitudes")])
        acceleration = np.nan_to_num(command.acceleration)
        asked = np.nan_to_num(command.velocity) + acceleration * duration
        before, now = self.airspeed, self.turned(asked, duration)
        position = self.state.position + (0.5 * (before + now) if self.slow else now) * duration
        self.airspeed = now
        self.state = self.stated(self.state.time + duration, position + self.moving_air * duration)
        self.estimated, self.estimator = estimate.step(self.estimator, self.state, self.rng)
        self.blow(duration)
        self.watch.step(self.state)

    @property
    def slow(self) -> bool:
        """Whether it takes time to turn."""
        return self.vehicle.lag > 0 or self.vehicle.acceleration is not None

    def turned(self, asked: Array, duration: float) -> Array:
        """Return the velocity through the air a time later, turned the short way towards the one asked for.

        Of an angle θ it turns by θ (1 - exp(-t / lag)), at most by acceleration · t / speed; half round, by the left.
        """
        vehicle, course = self.vehicle, self.airspeed / self.speed
        norm = math.sqrt(asked @ asked)
        if norm == 0:
            return self.airspeed
        wanted = asked / norm
        along = float(wanted @ course)
        across = wanted - along * course
        sine = math.sqrt(across @ across)
        if not self.slow or (sine < SMALL and along > 0):
            return self.speed * wanted
        if sine < SMALL:
            across = np.array([-course[1], course[0], 0.0]) if course[:2].any() else np.array([1.0, 0.0, 0.0])
        angle = math.atan2(sine, along)
        if vehicle.lag > 0:
            angle *= 1 - math.exp(-duration / vehicle.lag)
        if vehicle.acceleration is not None:
            angle = min(angle, vehicle.acceleration * duration / self.speed)
        velocity = math.cos(angle) * course + math.sin(angle) / math.sqrt(across @ across) * across
        return velocity * (self.speed / math.sqrt(velocity @ velocity))

    def close(self) -> None:
        """Nothing is left to make safe."""
