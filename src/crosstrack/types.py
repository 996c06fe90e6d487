"""The values that pass between the roles: world ENU, body FLU, SI units, radians, quaternions xyzw."""

import math
from dataclasses import dataclass, field
from enum import Enum
from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Gt, Le, Lt
from numpy.typing import NDArray

Array = NDArray[np.float64]
Finite = Annotated[float, Gt(-math.inf), Lt(math.inf)]
Positive = Annotated[float, Gt(0), Lt(math.inf)]
NonNegative = Annotated[float, Ge(0), Lt(math.inf)]
Vector = tuple[Finite, Finite, Finite]


GRAVITY = 9.80665
"""m/s², standard"""


def unset() -> Array:
    """Return a vector of NaN, shape (3,): a component left to the vehicle, or not measured."""
    return np.full(3, np.nan)


@dataclass(frozen=True, slots=True)
class State:
    """What is known of a vehicle at one instant."""

    time: float
    """s, on the vehicle's own clock"""
    position: Array
    """(3,) m, world"""
    velocity: Array
    """(3,) m/s, world"""
    attitude: Array
    """(4,) unit quaternion xyzw, body to world"""
    rate: Array
    """(3,) rad/s, body"""
    acceleration: Array = field(default_factory=unset)
    """(3,) m/s², world; NaN where not measured"""
    rotor_speeds: Array = field(default_factory=lambda: np.empty(0))
    """(rotors,) rad/s; empty where not known"""


@dataclass(frozen=True, slots=True)
class Setpoint:
    """Ask for a motion in the world frame; a NaN component is left to the vehicle.

    Velocity beside a position, and acceleration beside a velocity, are feed-forward.
    """

    position: Array = field(default_factory=unset)
    """(3,) m"""
    velocity: Array = field(default_factory=unset)
    """(3,) m/s"""
    acceleration: Array = field(default_factory=unset)
    """(3,) m/s², gravity excluded: zero at hover"""
    yaw: float = np.nan
    """rad, counter-clockwise from east"""
    yaw_rate: float = np.nan
    """rad/s"""


@dataclass(frozen=True, slots=True)
class AttitudeSetpoint:
    """Ask for an attitude and a collective thrust."""

    attitude: Array
    """(4,) unit quaternion xyzw, body to world"""
    thrust: float
    """m/s², collective thrust over mass, along body z: 9.81 hovers"""


@dataclass(frozen=True, slots=True)
class RateSetpoint:
    """Ask for body rates and a collective thrust."""

    rate: Array
    """(3,) rad/s, body"""
    thrust: float
    """m/s², collective thrust over mass, along body z: 9.81 hovers"""


Command = Setpoint | AttitudeSetpoint | RateSetpoint


@dataclass(frozen=True, slots=True)
class Scan:
    """Ranges seen along rays from the vehicle at one instant."""

    time: float
    """s"""
    origin: Array
    """(3,) m, body"""
    directions: Array
    """(rays, 3) unit vectors, body"""
    ranges: Array
    """(rays,) m; inf where nothing was hit, NaN where nothing was measured"""
    max_range: float
    """m, what an unhit ray has seen to be free"""
    rows: int = 1
    """of the picture that the rays form, row by row; 1 where they form none"""


@dataclass(frozen=True, slots=True)
class Others:
    """What moves around a vehicle at one instant, as balls: other vehicles and moving obstacles."""

    position: Array
    """(n, 3) m, world"""
    velocity: Array
    """(n, 3) m/s, world"""
    radius: Array
    """(n,) m"""
    avoids: NDArray[np.bool_]
    """(n,) whether it gives way too, as other vehicles do"""


ALONE = Others(np.empty((0, 3)), np.empty((0, 3)), np.empty(0), np.empty(0, dtype=bool))
"""nothing moves"""


@dataclass(frozen=True, slots=True)
class Model:
    """What a multirotor is taken to be by a tracker that commands attitude or rates: nominal, not as it is.

    With the specific thrust c along body z, and the airspeed u in body axes, the acceleration in the body is

        c e_z - (d_i √(c/g) + k_i |u_i|) u_i,     i = x, y, z,

    as the drag of the rotors grows with their speed.
    """

    drag: Array
    """(3,) 1/s, d, drag of the rotors at hover speed"""
    drag_quadratic: Array
    """(3,) 1/m, k, drag of the body"""
    thrust_min: float
    """m/s², least collective thrust over mass"""
    thrust_max: float
    """m/s², greatest collective thrust over mass that leaves room to roll and pitch"""
    thrust_factor: float
    """m/s²/(rad/s)², collective thrust over mass and the sum of the squared rotor speeds"""
    rate_time: float
    """s, from a body rate asked for to the body rate flown"""
    attitude_time: float
    """s, from an attitude asked for to the attitude flown"""
    thrust_time: float
    """s, from a thrust asked for to the thrust flown"""
    rate_max: float
    """rad/s, the most that roll and pitch may be asked for"""
    tilt_max: float
    """rad, largest angle between body z and world z that the mission allows"""


@dataclass(frozen=True, slots=True)
class Envelope:
    """What a vehicle can do, as the planners and followers may count on it."""

    speed: float
    """m/s, the fastest it may be asked to fly"""
    speed_vertical: float
    """m/s, the fastest it may be asked to climb or sink"""
    acceleration: float
    """m/s², the most it may be asked for sideways; inf when it turns at once"""
    acceleration_vertical: float
    """m/s², the most it may be asked for up or down"""
    response_time: float
    """s, from an acceleration asked for to the acceleration flown"""
    radius: float = 0.0
    """m, of the sphere around its centre that must stay free"""
    stops: bool = True
    """whether it can come to rest"""
    model: Model | None = None
    """what to know of it to command attitudes or rates; None where it takes none"""


class Outcome(Enum):
    """How a flight ended, as a sentence; `name.lower()` is its key."""

    ARRIVED = "Arrived at the last waypoint."
    COLLIDED = "Collided: the clearance fell below the vehicle's radius, or it hit the ground too hard."
    TIMED_OUT = "Ran out of time before the last waypoint."
    STUCK = "Made no progress along the path: obstacles, wind above its speed, or a turn tighter than it can fly."
    LEFT_BOUNDS = "Left the bounds of the world."
    LOST_CONTROL = "Lost control: the vehicle turned over, or its state is no longer finite."
    UNREACHABLE = "There is no way to the goal: obstacles enclose it, or leave no gap wide enough."
    LINK_LOST = "Lost the link to the vehicle."
    INTERRUPTED = "Interrupted before the last waypoint."
    FAILED = "Broken off by an error in the program."


@dataclass(frozen=True, slots=True)
class Wind:
    """Moving air: a steady wind and turbulence on top of it."""

    mean: Vector = (0.0, 0.0, 0.0)
    """m/s, world: the velocity of the air"""
    gusts: Literal["none", "light", "moderate", "severe"] = "none"
    """Dryden turbulence of MIL-F-8785C: wind at 6 m of 15, 30 or 45 knots"""


@dataclass(frozen=True, slots=True)
class Air:
    """Still air; its density is pressure / (287.053 temperature)."""

    temperature: Positive = 288.15
    """K"""
    pressure: Positive = 101325.0
    """Pa"""

    @property
    def density(self) -> float:
        """kg/m³"""
        return self.pressure / (287.053 * self.temperature)


@dataclass(frozen=True, slots=True)
class Noise:
    """What is wrong with the state estimate."""

    position: NonNegative = 0.0
    """m, standard deviation on each axis"""
    velocity: NonNegative = 0.0
    """m/s, standard deviation on each axis"""
    acceleration: NonNegative = 0.0
    """m/s², standard deviation on each axis"""
    delay: NonNegative = 0.0
    """s, age of the estimate"""


@dataclass(frozen=True, slots=True)
class Mismatch:
    """How the vehicle differs from what planner, tracker and autopilot take it to be: true over nominal."""

    mass: Positive = 1.0
    """of the mass; the rest is carried at its centre"""
    drag: NonNegative = 1.0
    """of the drag of body and rotors"""
    motor_time: Positive = 1.0
    """of the time constant of the motors"""


@dataclass(frozen=True, slots=True)
class Limits:
    """What the mission allows the vehicle to do."""

    speed: Positive = 12.0
    """m/s"""
    acceleration: Positive = 8.0
    """m/s²"""
    tilt_deg: Annotated[float, Gt(0), Le(80)] = 45.0
    """degrees from level"""
