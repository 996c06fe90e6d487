"""Gains of the cascaded autopilot."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Gains:
    """One gain for each loop of the cascade, from the outermost in."""

    position: float
    """1/s, position error to velocity"""
    velocity: float
    """1/s, velocity error to acceleration"""
    disturbance: float
    """1/s, how fast the estimate of a steady disturbance follows it"""
    attitude: float
    """1/s, tilt error to body rate"""
    yaw: float
    """1/s, yaw error to body rate"""
    rate: float
    """1/s, roll and pitch rate error to angular acceleration"""
    rate_yaw: float
    """1/s, yaw rate error to angular acceleration"""
    max_rate: float
    """rad/s, the most that the attitude loop asks for in roll and pitch"""
    max_rate_yaw: float
    """rad/s, the most that the attitude loop asks for in yaw"""
