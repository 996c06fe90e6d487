"""From a command of the library to one of AirSim's: which call, with which numbers, in its frames."""

import math

import numpy as np

from crosstrack.frames import attitude_ned_from_enu, frd_from_flu, heading_from_yaw, ned_from_enu
from crosstrack.protocols import Scenario
from crosstrack.sim.airframe import GENERIC
from crosstrack.sim.fleet import MOTION, fleet, place
from crosstrack.sim.outer import asked
from crosstrack.types import GRAVITY, Air, AttitudeSetpoint, RateSetpoint, Setpoint, State

VELOCITY_RESPONSE = GRAVITY * 0.2 * math.pi / 5.5
"""1/s, acceleration sideways over error of simple_flight's velocity loop: tilt 0.2 π/5.5 for each m/s, small angles"""
LATE = 0.03
"""s, from a state to the middle of the command that follows from it"""
TURN_GAIN = 7.0
"""1/s, of the attitude loop. AirSim's rate loop takes thrust away to follow steps in the rate, so these are small"""


class Outer:
    """Position, velocity and attitude loops of the embedded autopilot, for a vehicle behind AirSim's API.

    Args:
        scenario: of the flight
        air: where the vehicle is
    """

    def __init__(self, scenario: Scenario, air: Air) -> None:
        self.rows = fleet(GENERIC, air, scenario.limits, scenario.world.ground)
        self.rows["gain_attitude"] = TURN_GAIN
        # A late command allows no more gain than one that the velocity loop can still follow.
        late = 1 / (1 + GENERIC.gains.velocity * (LATE + scenario.noise.delay))
        for gain in ("gain_position", "gain_velocity", "gain_disturbance"):
            self.rows[gain] *= late
        self.rows["level"] = MOTION
        place(self.rows, scenario.position, scenario.yaw)
        self.full = float(4 * self.rows["thrust_max"][0] / self.rows["known_mass"][0])
        """m/s², thrust over mass at full throttle"""
        self.gain = float(self.rows["gain_position"][0])
        """1/s, of the position loop"""

    def know(self, state: State) -> None:
        """Take in where the vehicle is."""
        row = self.rows["state"][0]
        row[:3], row[3:6], row[6:10], row[10:13] = state.position, state.velocity, state.attitude, state.rate

    def throttle(self, thrust: float) -> float:
        """Return the throttle, 0 to 1, of a thrust over mass (m/s²), which is flown from now on."""
        share = min(1.0, max(0.0, thrust / self.full))
        # The rotors follow within milliseconds.
        self.rows["state"][0, 13:] = math.sqrt(share * self.rows["thrust_max"][0] / self.rows["thrust"][0])
        return share

    def turned(self, setpoint: Setpoint, duration: float) -> RateSetpoint:
        """Return the body rate and the thrust that a motion asks for."""
        row = self.rows["command"][0]
        row[:3], row[3:6], row[6:9] = setpoint.position, setpoint.velocity, setpoint.acceleration
        row[9], row[10] = setpoint.yaw, setpoint.yaw_rate
        found = asked(self.rows, duration)
        return RateSetpoint(found[:3], float(found[3]))


def velocity_of(setpoint: Setpoint, state: State, gain: float) -> tuple[float, float, float]:
    """Return the velocity (m/s, north, east, down) that AirSim's proportional velocity loop is to be asked for.

    v = v* + a_ff / k sideways, v* = v_ff + k_p (p* - p): of response k, the loop makes k (v - velocity) of it. Up and
    down its loop is fast and has an integral: v = v*.
    """
    wanted = np.nan_to_num(setpoint.velocity) + gain * np.nan_to_num(setpoint.position - state.position)
    open_loop = np.isnan(setpoint.velocity) & np.isnan(setpoint.position) & ~np.isnan(setpoint.acceleration)
    asked = np.where(open_loop, state.velocity, wanted)
    asked[:2] += np.nan_to_num(setpoint.acceleration[:2]) / VELOCITY_RESPONSE
    north, east, down = ned_from_enu(asked).tolist()
    return north, east, down


def angles_of(setpoint: AttitudeSetpoint) -> tuple[float, float, float]:
    """Return roll, pitch and yaw (rad) of an attitude as AirSim has them: right, nose up, clockwise from north."""
    x, y, z, w = attitude_ned_from_enu(setpoint.attitude).tolist()
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = math.asin(min(1.0, max(-1.0, 2 * (w * y - z * x))))
    return roll, pitch, math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def rates_of(setpoint: RateSetpoint) -> tuple[float, float, float]:
    """Return the body rates (rad/s) as AirSim has them."""
    forward, right, down = frd_from_flu(setpoint.rate).tolist()
    return forward, right, down


def degrees_of(yaw: float) -> float:
    """Return a yaw (rad, counter-clockwise from east) in degrees clockwise from north."""
    return math.degrees(float(heading_from_yaw(yaw)))
