"""A quadrotor in AirSim, or behind `crosstrack serve`: the same mission, flown over AirSim's own protocol."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Literal

from annotated_types import Ge, Le

from crosstrack.protocols import Scenario
from crosstrack.types import Air, Array, Envelope, Positive, State
from crosstrack.vehicles.quadrotor import Quadrotor

if TYPE_CHECKING:
    from crosstrack.vehicles.airsim.session import AirSimSession

AIRSIM_AIR = Air(temperature=287.36, pressure=99868.0)
"""at the height of AirSim's usual home, 122 m"""
COMMAND_TIME = 0.04
"""s, from a state to the command that follows from it, of a command that is held for 20 ms"""


@dataclass(frozen=True)
class AirSim:
    """A quadrotor of AirSim, or of `crosstrack serve`, under its simple_flight autopilot."""

    host: str = "127.0.0.1"
    """where AirSim runs"""
    port: Annotated[int, Ge(1), Le(65535)] = 41451
    """its API"""
    name: str = ""
    """of the vehicle in AirSim; by default its first, or with several in a mission those of the same names"""
    level: Literal["rates", "velocity"] = "rates"
    """what a motion is flown by: rates, body rates and throttle, from loops of our own, or velocity, by AirSim's"""
    stepping: Literal["paused", "running"] = "paused"
    """whether AirSim's clock stands still between two commands, while they are made up, or runs all the time"""
    begin: Literal["place", "fly"] = "place"
    """how it gets to the start of the mission: put there, or flown there straight"""
    after: Literal["land", "hover"] = "land"
    """what it does when the mission is over"""
    draw: bool = True
    """whether path, chased points and trail are drawn in AirSim"""
    radius: Positive = 0.2
    """m, of the sphere that must stay free"""

    @property
    def stand_in(self) -> Quadrotor:
        """What flies in its place where only the code is to be warmed up."""
        return Quadrotor(radius=self.radius)

    def envelope(self, scenario: Scenario) -> Envelope:
        """Return what it can do: as the embedded quadrotor of the same airframe, and a command later."""
        known = self.stand_in.envelope(replace(scenario, air=AIRSIM_AIR))
        return replace(known, response_time=known.response_time + COMMAND_TIME)

    def launch(self, scenario: Scenario) -> "AirSimSession":
        """Connect, take control, arm, and bring it to the start, hovering there or standing on the ground.

        Raises:
            LinkLost: nothing answers at the address, or no longer.
            InputError: AirSim's settings do not fit the mission.
        """
        from crosstrack.vehicles.airsim.session import AirSimSession  # noqa: PLC0415 - takes long to import, and few missions need it

        return AirSimSession(self, scenario)

    def arrived(self, before: State, now: State, goal: Array, remaining: float) -> bool:
        """Judge it arrived within 0.2 m of the goal at less than 0.3 m/s, with no path left."""
        return self.stand_in.arrived(before, now, goal, remaining)
