"""The server's quadrotor against more moves of the real AirSim, none of them published.

The reference is AirSim's own AirLib, compiled without Unreal and stepped in lockstep, so that times agree exactly.
"""

from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from aloft import AS_IT_IS, NEVER, Aloft, P, Q, T, hovering, on_ground

from crosstrack.airsim.server.handlers import flight
from crosstrack.airsim.server.moves import attitude, manual, path, rotate, velocity, vertical
from crosstrack.airsim.server.moves.polling import Move
from crosstrack.airsim.server.vehicle import ServedVehicle
from crosstrack.airsim.structs import RCData, YawMode
from crosstrack.types import Array

Step = Callable[[Aloft], object]
NORTH, FORWARD = YawMode(False, 0.0), 1


@cache
def references() -> dict[str, Array]:
    """Return moves of the real AirSim by name: time, position, velocity (NED), attitude xyzw, every 0.21 s."""
    with np.load(Path(__file__).parents[1] / "data" / "airsim_further_moves.npz") as found:
        return {name: found[name].astype(float) for name in found}


def fly(move: Callable[[ServedVehicle], Move]) -> Step:
    return lambda aloft: aloft.fly(move(aloft.vehicle))


def idle(seconds: float) -> Step:
    return lambda aloft: aloft.idle(seconds)


def call(name: str, *arguments: object) -> Step:
    return lambda aloft: flight.HANDLERS[name](aloft.simulator, *arguments, "")


def wind(*components: float) -> Step:
    return lambda aloft: setattr(aloft.simulator, "wind", np.array(components))


def along(
    speed: float,
    *points: tuple[float, float, float],
    nose: tuple[int, YawMode] = (0, AS_IT_IS),
    look: tuple[float, float] = (-1, 1),
) -> Step:
    return fly(lambda v: path.move_on_path(v, points, speed, 300, *nose, *look))


def at(vx: float, vy: float, vz: float, seconds: float, nose: tuple[int, YawMode] = (0, AS_IT_IS)) -> Step:
    return fly(lambda v: velocity.move_by_velocity(v, vx, vy, vz, seconds, *nose))


def at_height(vx: float, vy: float, z: float, seconds: float) -> Step:
    return fly(lambda v: velocity.move_by_velocity_z(v, vx, vy, z, seconds, 0, AS_IT_IS))


def to(x: float, y: float, z: float, speed: float) -> Step:
    return fly(lambda v: path.move_to_position(v, x, y, z, speed, NEVER, 0, AS_IT_IS, -1, 1))


def turn(degrees: float, margin: float) -> Step:
    return fly(lambda v: rotate.rotate_to_yaw(v, degrees, 60, margin))


def gains(which: str, *values: float) -> Step:
    return call(f"set{which}ControllerGains", values[:3], values[3:6], values[6:])


SCRIPTS: dict[str, Sequence[Step]] = {
    "path_climbing": [
        along(5, (20, 0, -10), (20, 20, -15), (0, 20, -5), (0, 0, -10), nose=(FORWARD, NORTH)),
        idle(5),
    ],
    "path_fast": [along(10, (80, 0, -10), (80, 80, -10), (0, 80, -10), (0, 0, -10), look=(20, 1)), idle(5)],
    "path_fixed_lookahead": [along(8, (40, 10, -20), (60, -30, -12), look=(-1, 0)), idle(5)],
    "path_own_lookahead": [along(3, (10, 3, -14), (12, -9, -9), (0, 0, -10), look=(1.5, 0.5)), idle(4)],
    "path_slow": [along(0.4, (3, 0, -10), (3, 2, -10)), idle(4)],
    "there_and_back": [along(4, (15, 0, -10), (0, 0, -10)), idle(4)],
    "velocities": [at(3, 4, 0, 8, nose=(FORWARD, NORTH)), at(-3, 4, 0, 8, nose=(FORWARD, YawMode(False, 30))), idle(4)],
    "body_velocity": [
        turn(50, 3),
        fly(lambda v: velocity.move_by_velocity_body_frame(v, 4, 1, 0, 8, 0, YawMode(True, 15))),
        idle(4),
    ],
    "body_velocity_z": [
        turn(-120, 3),
        fly(lambda v: velocity.move_by_velocity_z_body_frame(v, 3, -2, -12, 8, 0, YawMode(False, 90))),
        idle(4),
    ],
    "attitude_throttle": [
        fly(lambda v: attitude.move_by_roll_pitch_yawrate_throttle(v, -0.1, 0.05, 0.6, 0.62, 3)),
        idle(5),
    ],
    "rates_z": [fly(lambda v: attitude.move_by_angle_rates_z(v, 0.05, 0.03, 0.5, -10, 3)), idle(5)],
    "motors": [fly(lambda v: attitude.move_by_motor_pwms(v, 0.62, 0.62, 0.6, 0.6, 0.7)), idle(6)],
    "turns": [turn(170, 5), turn(-20, 2), idle(5)],
    "gps": [fly(lambda v: flight.move_to_gps(v, 47.6417, -122.14, 140, 5, NEVER, 0, AS_IT_IS, -1, 1)), idle(5)],
    "gains": [
        gains("Velocity", 0.3, 0.15, 2.5, 0.01, 0, 1.5, 0.01, 0.02, 0),
        at(3, 2, -1, 6),
        idle(4),
        gains("Position", 0.4, 0.4, 0.3, 0, 0, 0, 0, 0, 0),
        to(10, 0, -12, 3),
        idle(5),
    ],
    "disarmed": [at(2, 0, -1, 2), call("armDisarm", False), idle(3)],
    "manual": [
        turn(45, 2),
        call("moveByRC", RCData(roll=2000, pitch=6000, is_valid=True)),
        fly(lambda v: manual.move_by_manual(v, 4, 5, 3, 5, FORWARD, YawMode(False, 10))),
        idle(3),
    ],
    "high": [at_height(5, 0, -80, 15), idle(5)],
    "below": [at_height(3, 1, -1, 10), idle(4)],
    "fast": [at(15, 0, 0, 10), at(-15, 3, 0, 5), idle(5)],
    "east_in_wind": [turn(90, 2), wind(5, 5, 0), idle(10)],
    "home": [to(10, 10, -10, 3), idle(3), fly(lambda v: vertical.go_home(v, 120)), idle(5)],
}


UNTIL = {"high": 5.0}
"""s, to compare: 80 m up moveByVelocityZ is unstable in AirSim too, and rounding grows tenfold in half a second"""


def begun(name: str) -> Aloft:
    """Return a vehicle as it was before a reference."""
    if name not in ("high", "below"):
        return hovering()
    aloft = on_ground()
    aloft.fly(vertical.take_off(aloft.vehicle, 20))
    if name == "high":
        aloft.fly(path.move_to_z(aloft.vehicle, -80, 5, NEVER, AS_IT_IS, -1, 1))
        aloft.fly(vertical.hover(aloft.vehicle))
        aloft.idle(8)
    return aloft


@pytest.mark.parametrize("name", list(SCRIPTS))
def test_unpublished_moves_are_flown_as_by_the_real_one(name: str) -> None:
    aloft, reference = begun(name), references()[name]
    quadrotor, start = aloft.vehicle.quadrotor, aloft.simulator.now
    rows: list[Array] = []

    def note() -> None:
        now = 1e-9 * (aloft.simulator.now - start)
        rows.append(np.concatenate([[now], quadrotor.position, quadrotor.velocity, quadrotor.attitude]))

    note()
    aloft.simulator.observers.append(note)
    for step in SCRIPTS[name]:
        step(aloft)
    log = np.array(rows)
    assert log[-1, T] == pytest.approx(reference[-1, T], abs=0.25)
    reference = reference[reference[:, T] <= UNTIL.get(name, np.inf)]
    flown = np.stack([np.interp(reference[:, T], log[:, T], column) for column in log.T], axis=1)
    far = np.linalg.norm(reference[:, P] - reference[0, P], axis=1).max()
    assert np.linalg.norm(flown[:, P] - reference[:, P], axis=1).max() < max(0.003 * far, 0.002)
    along_each = (flown[:, Q] * reference[:, Q]).sum(axis=1) / np.linalg.norm(flown[:, Q], axis=1)
    assert 2 * np.arccos(np.clip(np.abs(along_each), 0, 1)).max() < 0.03
