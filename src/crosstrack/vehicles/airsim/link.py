"""A vehicle in AirSim under our control: where it is, and what it is told."""

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from crosstrack.airsim.client.blocking import Client, Pending
from crosstrack.airsim.server.settings import uncommented
from crosstrack.airsim.structs import Pose, YawMode
from crosstrack.errors import InputError, Problem
from crosstrack.frames import (
    attitude_enu_from_ned,
    attitude_ned_from_enu,
    enu_from_ned,
    flu_from_frd,
    ned_from_enu,
)
from crosstrack.protocols import Scenario
from crosstrack.types import Air, Array, AttitudeSetpoint, Command, RateSetpoint, Setpoint, State
from crosstrack.vehicles.airsim.outer import Outer, angles_of, degrees_of, rates_of, velocity_of

PATIENCE = 1.5
"""s of the wall, beyond what a call may take, after which the link counts as lost"""
SLOWEST = 150.0
"""s of the wall that a second of AirSim's may take, as with its clock at a hundredth of real time"""
LEVEL = np.array([0.0, 0.0, 0.0, 1.0])


class Link:
    """A vehicle in AirSim under our control.

    Args:
        client: connected to AirSim
        name: of the vehicle, empty for the first; one that is not there is added
        scenario: of the flight

    Raises:
        LinkLost: AirSim does not answer, or no longer.
        InputError: the vehicle is not there and cannot be added.
    """

    def __init__(self, client: Client, name: str, scenario: Scenario) -> None:
        self.client, self.yaw = client, scenario.yaw
        vehicles: dict[str, Any] = json.loads(uncommented(client.get_settings_string()) or "{}").get("Vehicles", {})
        known = client.list_vehicles()
        self.name = name or next(iter(known), "")
        if self.name not in known:
            vehicles[self.name] = self.add(known, scenario)
        self.settings: Mapping[str, Any] = vehicles.get(self.name, {})
        self.home = enu_from_ned([float(self.settings.get(key) or 0.0) for key in "XYZ"])
        """(3,) m, world, where the vehicle's own frame begins"""
        client.pause(False)
        if not scenario.name:
            client.reset()  # whatever the last flight left; with several, the others fly already
        client.enable_api_control(True, self.name)
        client.arm_disarm(True, self.name)
        here = client.get_ground_truth_environment(self.name)
        self.outer = Outer(scenario, Air(temperature=here.temperature, pressure=here.air_pressure))

    def add(self, known: Sequence[str], scenario: Scenario) -> dict[str, float]:
        """Have AirSim add the vehicle below its start; return where that is, as AirSim's settings have it."""
        place = ned_from_enu([*scenario.position[:2], scenario.world.ground])
        if not self.client.add_vehicle(self.name, "simpleflight", Pose(place, LEVEL)):
            message = f"{self.name!r} is not there, and AirSim adds none; there are {', '.join(known)}"
            raise InputError("vehicle airsim", [Problem("name", message)])
        return dict(zip("XYZ", place.tolist(), strict=True))

    def state(self) -> tuple[int, State]:
        """Return AirSim's time stamp (ns), and the state, whose time is left at zero."""
        found = self.client.get_multirotor_state(self.name)
        rotors = self.client.get_rotor_states(self.name).rotors
        motion = found.kinematics_estimated
        return found.timestamp, State(
            0.0,
            enu_from_ned(motion.position) + self.home,
            enu_from_ned(motion.linear_velocity),
            attitude_enu_from_ned(motion.orientation),
            flu_from_frd(motion.angular_velocity),
            rotor_speeds=np.array([rotor.speed for rotor in rotors]),
        )

    def put(self, place: Array) -> None:
        """Put the vehicle at a place (3,) m, level."""
        level = np.array([0.0, 0.0, math.sin(0.5 * self.yaw), math.cos(0.5 * self.yaw)])
        pose = Pose(ned_from_enu(place - self.home), attitude_ned_from_enu(level))
        self.client.set_vehicle_pose(pose, True, self.name)

    def fly(self, command: Command, state: State, duration: float, held: float) -> Pending[bool]:
        """Send a command; a motion by body rates and throttle.

        Args:
            command: to fly
            state: of the vehicle, as known
            duration: s, until the next command
            held: s, until AirSim gives the command up
        """
        client, name = self.client, self.name
        self.outer.know(state)
        if isinstance(command, AttitudeSetpoint):
            throttle = self.outer.throttle(command.thrust)
            return client.move_by_roll_pitch_yaw_throttle(*angles_of(command), throttle, held, name)
        rates = command if isinstance(command, RateSetpoint) else self.outer.turned(command, duration)
        return client.move_by_angle_rates_throttle(*rates_of(rates), self.outer.throttle(rates.thrust), held, name)

    def fly_velocity(self, command: Setpoint, state: State, held: float) -> Pending[bool]:
        """Send a motion as a velocity, see `fly`."""
        wanted = velocity_of(command, state, self.outer.gain)
        return self.client.move_by_velocity(*wanted, held, 0, self.facing(command), self.name)

    def facing(self, setpoint: Setpoint) -> YawMode:
        """Return what a setpoint says of yaw, as AirSim has it; the last yaw is kept where it says nothing."""
        if math.isnan(setpoint.yaw) and not math.isnan(setpoint.yaw_rate):
            return YawMode(True, -math.degrees(setpoint.yaw_rate))
        if not math.isnan(setpoint.yaw):
            self.yaw = setpoint.yaw
        return YawMode(False, degrees_of(self.yaw))

    def hold(self, setpoint: Setpoint, period: float) -> State:
        """Fly a setpoint for a period (s) and return the state after it."""
        _, state = self.state()
        self.fly(setpoint, state, period, period).join(PATIENCE + SLOWEST * period)
        return self.state()[1]
