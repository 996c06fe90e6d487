"""The embedded quadrotor: rotor-level physics under a cascaded autopilot."""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from crosstrack.errors import InputError, Problem
from crosstrack.protocols import Scenario
from crosstrack.sim import estimate, turbulence
from crosstrack.sim.airframe import AIRFRAMES, SEA_LEVEL_DENSITY, Airframe
from crosstrack.sim.autopilot import LEAST_LIFT, MOST_THRUST
from crosstrack.sim.fleet import ATTITUDE, MOTION, RATE, fleet, place
from crosstrack.sim.kernel import STEP, fly
from crosstrack.sim.watch import Watch
from crosstrack.types import (
    GRAVITY,
    Array,
    AttitudeSetpoint,
    Command,
    Envelope,
    Limits,
    Model,
    Positive,
    Scan,
    Setpoint,
    State,
)

HARD_LANDING = 1.5
"""m/s, sinking speed at touchdown from which the ground is hit, not landed on"""

SIDEWAYS, UPWARDS = 0.8, 0.5
"""of the acceleration that tilt and thrust give, which drag may take at the top speed"""


def terminal(square: float, linear: float, acceleration: float) -> float:
    """Return the speed v (m/s) whose drag is an acceleration (m/s²): square v² + linear v; inf without drag."""
    if square == 0 and linear == 0:
        return math.inf
    return float(2 * acceleration / (linear + math.sqrt(linear**2 + 4 * square * acceleration)))


def drag_of(airframe: Airframe, density: float) -> tuple[Array, Array]:
    """Return the drag over mass that grows with the airspeed, at hover (1/s), and with its square (1/m), (3,) each."""
    ratio = density / SEA_LEVEL_DENSITY
    linear = np.multiply(airframe.rotor_drag, ratio * 4 * airframe.rotor_speed_hover / airframe.mass)
    return linear, np.multiply(airframe.body_drag, density / airframe.mass)


def model_of(airframe: Airframe, density: float, limits: Limits) -> Model:
    """Return what a tracker may know of an airframe in air of a density (kg/m³)."""
    linear, square = drag_of(airframe, density)
    factor = airframe.thrust_coefficient * density / SEA_LEVEL_DENSITY / airframe.mass
    return Model(
        drag=linear,
        drag_quadratic=square,
        thrust_min=LEAST_LIFT * GRAVITY,
        thrust_max=MOST_THRUST * 4 * factor * airframe.rotor_speed_max**2,
        thrust_factor=factor,
        rate_time=1 / airframe.gains.rate + airframe.motor_time,
        attitude_time=1 / airframe.gains.attitude,
        thrust_time=airframe.motor_time,
        rate_max=airframe.gains.max_rate,
        tilt_max=math.radians(limits.tilt_deg),
    )


@dataclass(frozen=True)
class Quadrotor:
    """A quadrotor of the embedded simulator."""

    airframe: Literal["generic", "crazyflie", "racer"] = "generic"
    """which airframe"""
    radius: Positive = 0.2
    """m, of the sphere that must stay free"""

    @property
    def stand_in(self) -> "Quadrotor":
        """Itself."""
        return self

    def envelope(self, scenario: Scenario) -> Envelope:
        """Return what its thrust and the tilt limit allow while it holds its height, and up and down.

        The top speed v is the one whose drag takes the share SIDEWAYS of what the tilt gives, or UPWARDS of what
        the thrust gives: k v² + c v = share a.

        Raises:
            InputError: the air is too thin to hover with thrust to spare.
        """
        airframe, limits, density = AIRFRAMES[self.airframe], scenario.limits, scenario.air.density
        ratio = density / SEA_LEVEL_DENSITY
        lift = MOST_THRUST * airframe.thrust_to_weight * ratio
        if lift <= 1:
            message = f"{density:.3g} kg/m³ is too thin for {self.airframe}: thrust to weight {lift / MOST_THRUST:.2f}"
            raise InputError("air", [Problem("pressure", f"{message}, above {1 / MOST_THRUST:.2f} is needed")])
        sideways = GRAVITY * min(math.tan(math.radians(limits.tilt_deg)), math.sqrt(lift**2 - 1))
        upwards = min(limits.acceleration, GRAVITY * min(lift - 1, 1 - LEAST_LIFT))
        linear, square = drag_of(airframe, density)
        gains = airframe.gains
        response = 1 / gains.attitude + 1 / gains.rate + airframe.motor_time
        return Envelope(
            speed=min(limits.speed, terminal(max(square[:2]), max(linear[:2]), SIDEWAYS * sideways)),
            speed_vertical=min(limits.speed, terminal(square[2], linear[2], UPWARDS * upwards)),
            acceleration=min(limits.acceleration, sideways),
            acceleration_vertical=(1 - UPWARDS) * upwards,
            response_time=response + scenario.noise.delay,
            radius=self.radius,
            model=model_of(airframe, density, limits),
        )

    def launch(self, scenario: Scenario) -> "QuadrotorSession":
        """Put it at rest at the start: hovering in the air, or with rotors at idle on the ground."""
        return QuadrotorSession(AIRFRAMES[self.airframe], scenario)

    def arrived(self, before: State, now: State, goal: Array, remaining: float) -> bool:
        """Judge it arrived within 0.2 m of the goal at less than 0.3 m/s, with no path left."""
        if remaining > 0.2:
            return False
        return bool(np.linalg.norm(now.position - goal) <= 0.2 and np.linalg.norm(now.velocity) < 0.3)


class QuadrotorSession:
    """One flight of a quadrotor in the embedded simulator; its clock is the number of steps flown."""

    def __init__(self, airframe: Airframe, scenario: Scenario) -> None:
        self.rng = np.random.default_rng(scenario.seed)
        self.mean = np.array(scenario.wind.mean)
        self.rows = fleet(airframe, scenario.air, scenario.limits, scenario.world.ground, mismatch=scenario.mismatch)
        # A late estimate allows no more gain than one that the velocity loop can still follow.
        late = 1 / (1 + airframe.gains.velocity * scenario.noise.delay)
        for gain in ("gain_position", "gain_velocity", "gain_disturbance"):
            self.rows[gain] *= late
        position = scenario.position.copy()
        resting = scenario.world.ground + airframe.gear
        on_ground = position[2] <= resting + 0.01
        position[2] = max(position[2], resting)
        place(self.rows, position, scenario.yaw, spinning=not on_ground)
        self.ground = scenario.world.ground
        self.time = 0.0
        self.acceleration = np.zeros(3)
        self.state = self.read()
        self.estimator = estimate.start(scenario.noise, self.state)
        self.estimated, self.estimator = estimate.step(self.estimator, self.state, self.rng)
        self.gusts = turbulence.start(scenario.wind, self.rng)
        self.blow(0.0)
        self.watch = Watch(scenario)
        self.watch.step(self.state)

    def read(self) -> State:
        """Return the true state of the row."""
        row = self.rows["state"][0].copy()
        return State(self.time, row[:3], row[3:6], row[6:10], row[10:13], self.acceleration, row[13:])

    def blow(self, duration: float) -> None:
        """Set the wind for the next steps, after flying through it for a time."""
        height = self.state.position[2] - self.ground
        gust, self.gusts = turbulence.step(self.gusts, self.state.velocity, height, duration, self.rng)
        self.rows["wind"][0] = self.mean + gust

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
        return np.array(self.rows["wind"][0])

    def touched(self) -> bool:
        """Return whether it hit the ground harder than a landing."""
        return bool(self.rows["impact"][0] > HARD_LANDING)

    def begin(self, command: Command, duration: float) -> None:
        """Need no notice: its clock is its own."""

    def advance(self, command: Command, duration: float) -> None:
        """Fly a command for a time (s), in equal steps of at most STEP."""
        self.tell(command)
        steps = math.ceil(duration / STEP - 1e-9)
        before = self.state
        fly(self.rows, duration / steps, steps)
        self.time += duration
        velocity = self.rows["state"][0, 3:6]
        self.acceleration = (velocity - before.velocity) / duration
        self.state = self.read()
        self.estimated, self.estimator = estimate.step(self.estimator, self.state, self.rng)
        if self.estimated is not self.state:
            error = self.rows["error"][0]
            error[:3] = self.estimated.position - self.state.position
            error[3:] = self.estimated.velocity - self.state.velocity
        self.blow(duration)
        self.watch.step(self.state)

    def tell(self, command: Command) -> None:
        """Write a command into the row."""
        row = self.rows["command"][0]
        row[:] = np.nan
        if isinstance(command, Setpoint):
            self.rows["level"] = MOTION
            row[:3], row[3:6], row[6:9] = command.position, command.velocity, command.acceleration
            row[9], row[10] = command.yaw, command.yaw_rate
        elif isinstance(command, AttitudeSetpoint):
            self.rows["level"] = ATTITUDE
            row[:4], row[4] = command.attitude, command.thrust
        else:
            self.rows["level"] = RATE
            row[:3], row[3] = command.rate, command.thrust

    def close(self) -> None:
        """Nothing is left to make safe."""
