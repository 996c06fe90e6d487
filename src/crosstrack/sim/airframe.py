"""Airframes as data: body FLU, rotors in the order front right, rear left, front left, rear right."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from crosstrack.sim.gains import Gains
from crosstrack.types import GRAVITY, Array, Vector

SEA_LEVEL_DENSITY = 1.225
"""kg/m³, of the air in which rotor coefficients are given"""

Rotors = tuple[Vector, Vector, Vector, Vector]


@dataclass(frozen=True)
class Airframe:
    """A quadrotor: its weight, how its rotors pull, how the air holds it back, how tightly it is flown."""

    name: str
    mass: float
    """kg"""
    inertia: Vector
    """kg m², about the body axes"""
    rotor_positions: Rotors
    """(4, 3) m, body"""
    spins: tuple[float, float, float, float]
    """(4,) +1 where the rotor turns clockwise, so that its drag torque turns the body counter-clockwise"""
    rotor_radius: float
    """m"""
    thrust_coefficient: float
    """N/(rad/s)², thrust over squared speed in air of 1.225 kg/m³"""
    torque_ratio: float
    """m, drag torque over thrust"""
    rotor_speed_min: float
    """rad/s, idle"""
    rotor_speed_max: float
    """rad/s"""
    motor_time: float
    """s, time constant of the first-order lag of the rotor speeds"""
    body_drag: Vector
    """m², drag force over air density and squared airspeed, along each body axis"""
    rotor_drag: Vector
    """N/((rad/s) (m/s)), drag force over airspeed and the sum of the rotor speeds, in air of 1.225 kg/m³"""
    gear: float
    """m, from the centre of mass down to the feet, which stand under the rotors"""
    gains: Gains

    @property
    def rotor_speed_hover(self) -> float:
        """rad/s, at which the rotors carry the weight in air of 1.225 kg/m³."""
        return math.sqrt(self.mass * GRAVITY / (4 * self.thrust_coefficient))

    @property
    def thrust_to_weight(self) -> float:
        """Greatest thrust over weight in air of 1.225 kg/m³."""
        return (self.rotor_speed_max / self.rotor_speed_hover) ** 2

    @property
    def radius(self) -> float:
        """m, of the smallest upright cylinder around the rotor discs."""
        return max(math.hypot(x, y) for x, y, _ in self.rotor_positions) + self.rotor_radius

    @cached_property
    def allocation(self) -> Array:
        """(4, 4) rotor thrusts (N) from thrust (N) and body torques (N m): f = allocation @ (T, τ).

        The inverse of T = Σ f_i and τ = Σ (y_i f_i, -x_i f_i, spin_i κ f_i).
        """
        x, y, _ = np.asarray(self.rotor_positions).T
        return np.linalg.inv(np.array([np.ones(4), y, -x, self.torque_ratio * np.asarray(self.spins)]))


def cross(arm: float, height: float) -> Rotors:
    """Return the rotor positions of an X frame with arms (m) at 45° and rotors at a height (m)."""
    a = arm * math.sqrt(0.5)
    return (a, -a, height), (-a, a, height), (a, a, height), (-a, -a, height)


SPINS = (-1.0, -1.0, 1.0, 1.0)
"""Front right and rear left turn counter-clockwise, so their drag turns the body clockwise."""

GENERIC = Airframe(
    name="generic",
    mass=1.0,
    inertia=(0.0067212, 0.0080407, 0.0142789),
    rotor_positions=cross(0.2275, -0.025),
    spins=SPINS,
    rotor_radius=0.1143,
    thrust_coefficient=9.31438e-6,
    torque_ratio=0.0132941,
    rotor_speed_min=211.8,
    rotor_speed_max=669.86,
    motor_time=0.005,
    body_drag=(0.0053831, 0.0058381, 0.1099301),
    rotor_drag=(0.0, 0.0, 0.0),
    gear=0.1,
    gains=Gains(
        position=1.6,
        velocity=4.0,
        disturbance=2.0,
        attitude=15.0,
        yaw=3.0,
        rate=60.0,
        rate_yaw=12.0,
        max_rate=8.0,
        max_rate_yaw=2.0,
    ),
)
"""AirSim's generic quadrotor (Shah et al. 2017): a box of 0.18 x 0.11 x 0.04 m and four motors of 55 g.

Propellers of 0.2286 m with C_T = 0.109919, C_P = 0.040164, at most 6396.667 rpm; drag of the box and the
discs with coefficient 0.325, none in proportion to rotor speed. There the lag of 5 ms is of the thrust. Idle
is its least throttle while armed, 0.1. The gear is ours: AirSim takes it from a mesh.
"""

CRAZYFLIE = Airframe(
    name="crazyflie",
    mass=0.028,
    inertia=(16.571710e-6, 16.655602e-6, 29.261652e-6),
    rotor_positions=cross(0.046, 0.01),
    spins=SPINS,
    rotor_radius=0.0225,
    thrust_coefficient=2.17e-8,
    torque_ratio=0.005964552,
    rotor_speed_min=500.0,
    rotor_speed_max=2516.0,
    motor_time=0.05,
    body_drag=(0.0, 0.0, 0.0),
    rotor_drag=(9.1785e-7, 9.1785e-7, 10.311e-7),
    gear=0.015,
    gains=Gains(
        position=1.5,
        velocity=3.5,
        disturbance=2.0,
        attitude=7.0,
        yaw=3.0,
        rate=25.0,
        rate_yaw=10.0,
        max_rate=8.0,
        max_rate_yaw=2.0,
    ),
)
"""Bitcraze's Crazyflie 2 as identified by Förster (System identification of the Crazyflie 2.0, ETH, 2015).

Inertia, torque ratio and rotor drag are his. The thrust coefficient is that of Bitcraze's own measurement
near hover, 28.6 g at 17174 rpm; the highest speed leaves a thrust to weight of 2. His motors have a time
constant of 0.065 s (a pole of 0.9695 at 500 Hz); 0.05 s stands for fresh ones. Drag in the square of the
speed is left out.
"""

RACER = Airframe(
    name="racer",
    mass=0.752,
    inertia=(2.5e-3, 2.1e-3, 4.3e-3),
    rotor_positions=cross(0.125, 0.0),
    spins=SPINS,
    rotor_radius=0.0648,
    thrust_coefficient=1.56e-6,
    torque_ratio=0.022,
    rotor_speed_min=150.0,
    rotor_speed_max=2431.0,
    motor_time=0.033,
    body_drag=(0.005, 0.006, 0.015),
    rotor_drag=(9.4e-5, 6.7e-5, 0.0),
    gear=0.04,
    gains=Gains(
        position=2.0,
        velocity=4.5,
        disturbance=2.0,
        attitude=9.0,
        yaw=4.0,
        rate=35.0,
        rate_yaw=10.0,
        max_rate=12.0,
        max_rate_yaw=4.0,
    ),
)
"""A research racer with propellers of 5 inches, after Agilicious (Foehn et al., Science Robotics 7, 2022).

Rotor drag is that of Faessler, Franchi and Scaramuzza (RA-L 3(2), 2018), 0.544/s and 0.386/s times the speed,
at the hover speed of these rotors. Body drag is our estimate: 0.01 m² seen from the front, a drag coefficient
near 1.
"""

AIRFRAMES = {airframe.name: airframe for airframe in (GENERIC, CRAZYFLIE, RACER)}
