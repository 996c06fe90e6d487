"""The samples of a flight."""

from dataclasses import dataclass

from crosstrack.types import Array


@dataclass(frozen=True)
class Record:
    """The samples of a flight, one row at the start and one after every command: n rows."""

    time: Array
    """(n,) s"""
    position: Array
    """(n, 3) m, true"""
    velocity: Array
    """(n, 3) m/s, true"""
    attitude: Array
    """(n, 4) xyzw, true"""
    rate: Array
    """(n, 3) rad/s, true, body"""
    rotor_speeds: Array
    """(n, rotors) rad/s"""
    estimate: Array
    """(n, 3) m, position as the tracker saw it"""
    command_velocity: Array
    """(n, 3) m/s, velocity asked for until this row; NaN where left to the vehicle"""
    command_acceleration: Array
    """(n, 3) m/s², acceleration asked for until this row; NaN where left to the vehicle"""
    command_attitude: Array
    """(n, 4) xyzw, attitude asked for until this row; NaN where left to the vehicle"""
    command_rate: Array
    """(n, 3) rad/s, body rate asked for until this row; NaN where left to the vehicle"""
    command_thrust: Array
    """(n,) m/s², thrust over mass asked for until this row; NaN where left to the vehicle"""
    aim: Array
    """(n, 3) m, the point chased until this row"""
    progress: Array
    """(n,) m, arc length along the course"""
    wind: Array
    """(n, 3) m/s at the vehicle"""
    clearance: Array
    """(n,) m, least swept distance to an obstacle since the row before; inf without obstacles"""
    separation: Array
    """(n,) m, least distance to the centre of another vehicle since the row before; inf alone"""
    interventions: Array
    """(n,) sum of 2^k over the avoiders k of the chain that changed the command flown until this row"""
