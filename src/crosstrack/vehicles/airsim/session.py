"""One flight of a vehicle in AirSim, from taking control to giving it back."""

from contextlib import ExitStack, suppress
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from crosstrack.airsim.client.blocking import Client, Pending
from crosstrack.airsim.client.errors import RemoteError
from crosstrack.errors import LinkLost
from crosstrack.frames import enu_from_ned, ned_from_enu
from crosstrack.protocols import Scenario
from crosstrack.sim import estimate, turbulence
from crosstrack.types import Array, Command, Scan, Setpoint, State, Wind
from crosstrack.vehicles.airsim.link import PATIENCE, SLOWEST, Link
from crosstrack.vehicles.airsim.movers import Balls
from crosstrack.vehicles.airsim.safe import go_to_start, leave
from crosstrack.vehicles.airsim.sensing import Sensing

if TYPE_CHECKING:
    from crosstrack.vehicles.airsim.vehicle import AirSim

CALM = Wind()
PART = 0.02
"""s, after which our loops ask anew; as often as AirSim takes commands"""
HARD = 1.5
"""m/s, sinking speed from which touching the ground is hitting it"""
FLAT = 0.7
"""cosine of the slope up to which what is touched is ground"""


class AirSimSession:
    """A vehicle in AirSim. Its clock is AirSim's, and begins with the first command."""

    def __init__(self, vehicle: "AirSim", scenario: Scenario) -> None:
        self.vehicle, self.scenario = vehicle, scenario
        self.random = np.random.default_rng(scenario.seed)
        self.mean = np.array(scenario.wind.mean)
        self.gusts = turbulence.start(scenario.wind, self.random)
        self.pending: Pending[bool] | None = None
        self.began: int | None = None
        self.hit = self.paused = False
        self.ratio = 1.0
        """what AirSim is asked to go on for, over how long it is to go on"""
        with ExitStack() as undo:
            self.client = Client(vehicle.host, vehicle.port, timeout=PATIENCE)
            undo.callback(self.client.close)
            self.link = Link(self.client, scenario.name or vehicle.name, scenario)
            undo.callback(self.make_safe)
            self.sensing = Sensing(self.link, scenario.sensors)
            self.balls = Balls(self.client, scenario.traffic, alone=not scenario.name)
            undo.callback(self.balls.clear)
            go_to_start(self.link, scenario, vehicle.begin == "place", vehicle.level == "velocity")
            self.client.get_collision_info(self.link.name)  # what was touched before does not count
            self.stamp, state = self.link.state()
            self.state = replace(state, acceleration=np.zeros(3))
            self.blow(0.0)
            self.estimator = estimate.start(scenario.noise, self.state)
            self.estimated, self.estimator = estimate.step(self.estimator, self.state, self.random)
            undo.pop_all()

    def sense(self) -> State:
        """Return the state as estimated: AirSim's, late and noisy as the mission says."""
        return self.estimated

    def truth(self) -> State:
        """Return AirSim's own state, which simple_flight knows exactly."""
        return self.state

    def scans(self) -> list[Scan]:
        """Return what its sensors have seen since this was last asked."""
        return self.sensing.scans(self.state, self.stamp)

    def wind(self) -> Array:
        """Return the wind that AirSim was told of, (3,) m/s."""
        return self.moving_air

    def touched(self) -> bool:
        """Return whether it hit something: an obstacle, or the ground harder than a landing."""
        return self.hit

    def begin(self, command: Command, duration: float) -> None:
        """Send a command to fly for a time (s), without waiting for it."""
        if self.began is None:
            if self.vehicle.stepping == "paused":
                self.paused = True
                self.client.pause(True)
            self.began = self.stamp = self.link.state()[0]  # others may have been launched since
        duration /= self.parts(command, duration)
        held = duration if not self.paused else 2 * duration
        if isinstance(command, Setpoint) and self.vehicle.level == "velocity":
            self.pending = self.link.fly_velocity(command, self.estimated, held)
        else:
            self.pending = self.link.fly(command, self.estimated, duration, held)

    def advance(self, command: Command, duration: float) -> None:
        """Fly a command for a time (s) of AirSim's clock, in parts as long as our own loops may wait.

        Raises:
            LinkLost: AirSim no longer answers.
        """
        parts = self.parts(command, duration)
        for _ in range(parts):
            self.fly(command, duration / parts)

    def parts(self, command: Command, duration: float) -> int:
        """Return in how many parts a command is flown for a time (s)."""
        looped = isinstance(command, Setpoint) and self.vehicle.level == "rates"
        return max(1, round(duration / PART)) if looped else 1

    def fly(self, command: Command, duration: float) -> None:
        """Fly a part of a command, for a time (s)."""
        if self.pending is None:
            self.begin(command, duration)
        pending, self.pending = self.pending, None
        assert pending is not None  # it was just begun
        before, stamp = self.state, self.stamp
        if not self.paused:
            pending.join(PATIENCE + SLOWEST * duration)
        elif not self.gone_on(duration):
            self.client.continue_for_time(self.ratio * duration).join(PATIENCE + SLOWEST * duration)
        if pending.done():
            pending.join()  # what was refused is said
        self.stamp, now = self.link.state()
        assert self.began is not None  # by the command
        time = 1e-9 * (self.stamp - self.began)
        passed = time - before.time
        acceleration = (now.velocity - before.velocity) / passed if passed > 0 else before.acceleration
        self.state = replace(now, time=time, acceleration=acceleration)
        if self.paused and self.stamp > stamp:
            self.ratio *= 1e9 * duration / (self.stamp - stamp)
        self.estimated, self.estimator = estimate.step(self.estimator, self.state, self.random)
        self.look_for_contact(before)
        self.blow(passed)
        self.balls.move(time)

    def gone_on(self, duration: float) -> bool:
        """Return whether another vehicle of this flight has had the clock go on for a time (s) already."""
        return bool(self.scenario.name) and 1e-9 * (self.link.state()[0] - self.stamp) > 0.5 * duration

    def look_for_contact(self, before: State) -> None:
        """Take down whether the vehicle hit something since a state."""
        touch = self.client.get_collision_info(self.link.name)
        if touch.has_collided:
            flat = enu_from_ned(touch.normal)[2] >= FLAT
            self.hit |= bool(not flat or -before.velocity[2] > HARD)

    def blow(self, duration: float) -> None:
        """Set the wind for the next command, after flying through it for a time (s)."""
        if duration > 0.0 and self.scenario.wind.gusts == "none":
            return
        height = self.state.position[2] - self.scenario.world.ground
        gust, self.gusts = turbulence.step(self.gusts, self.state.velocity, height, duration, self.random)
        self.moving_air = self.mean + gust
        self.client.set_wind(ned_from_enu(self.moving_air))

    def close(self) -> None:
        """Leave the vehicle safe: at rest in the air, then, unless told otherwise, on the ground and disarmed."""
        try:
            self.balls.clear()
        finally:
            self.make_safe()
            self.client.close()

    def make_safe(self) -> None:
        """Stop and land, over a new connection where the old one is broken; where that fails, nothing can be done."""
        with suppress(LinkLost, RemoteError):
            try:
                self.leave()
            except (LinkLost, RemoteError):
                self.client.close()
                self.client = self.link.client = Client(self.vehicle.host, self.vehicle.port, timeout=PATIENCE)
                self.leave()

    def leave(self) -> None:
        """Have the clock run, and leave the vehicle."""
        if self.paused:
            self.client.pause(False)
            self.paused = False
        if self.scenario.wind != CALM:
            self.client.set_wind(np.zeros(3))
        leave(self.link, self.scenario, self.vehicle.after == "land")
