"""The server's quadrotor against moves of the real AirSim, recorded and published."""

from collections.abc import Callable
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from aloft import AS_IT_IS, NEVER, Aloft, P, Q, T, V, hovering, on_ground

from crosstrack.airsim.server.moves import attitude, path, rotate, velocity, vertical
from crosstrack.airsim.server.moves.polling import Move
from crosstrack.airsim.server.vehicle import ServedVehicle
from crosstrack.types import Array

SQUARE = [(20.0, 0.0, -10.0), (20.0, 20.0, -10.0), (0.0, 20.0, -10.0), (0.0, 0.0, -10.0)]
Maker = Callable[[ServedVehicle], Move]


@cache
def recordings() -> dict[str, Array]:
    """Return moves of the real AirSim by name: time, position, velocity (NED), attitude wxyz."""
    file = Path(__file__).parents[1] / "data" / "airsim_moves.npz"
    with np.load(file) as found:
        return {name: found[name].astype(float) for name in found}


def square(speed: float) -> Maker:
    return lambda v: path.move_on_path(v, SQUARE, speed, 300, 0, AS_IT_IS, -1, 1)


MOVES: dict[str, tuple[Maker, float, bool]] = {
    "vz5": (lambda v: velocity.move_by_velocity_z(v, 5, 0, -10, 15, 0, AS_IT_IS), 15.02, True),
    "vel_5_0_0": (lambda v: velocity.move_by_velocity(v, 5, 0, 0, 12, 0, AS_IT_IS), 12.02, True),
    "vel_0_0_2": (lambda v: velocity.move_by_velocity(v, 0, 0, 2, 3, 0, AS_IT_IS), 3.01, True),
    "sq20_v2": (square(2.0), 44.03, True),
    "sq20_v5": (square(5.0), 18.60, True),
    "z_up": (lambda v: path.move_to_z(v, -20, 3, NEVER, AS_IT_IS, -1, 1), 3.50, True),
    "rpyz": (lambda v: attitude.move_by_roll_pitch_yaw_z(v, 0.1, 0, 0, -10, 5), 5.03, True),
    "takeoff": (lambda v: vertical.take_off(v, 20), 3.42, False),
    "land": (lambda v: vertical.land(v, 60), 25.29, True),
    "yaw90": (lambda v: rotate.rotate_to_yaw(v, 90, NEVER, 5), 2.89, True),
}
"""the move, how long the real one took (s), and its answer"""


def begun(name: str) -> Aloft:
    """Return a vehicle as it was before a recorded move."""
    return on_ground() if name == "takeoff" else hovering(-5.0 if name == "land" else -10.0)


def angles(a: Array, b: Array) -> Array:
    """Return the angles (rad) between attitudes (n, 4) xyzw."""
    found: Array = 2 * np.arccos(np.clip(np.abs((a * b).sum(axis=1)), 0, 1))
    return found


@cache
def pair(name: str) -> tuple[Array, Array, float, bool]:
    """Fly a move; return it at the instants of the recording, the recording, how long it took, and its answer."""
    recorded = recordings()[name]
    log, took, answer = begun(name).logged(MOVES[name][0], after=5.0)
    recorded = recorded[(recorded[:, T] >= 0) & (recorded[:, T] <= log[-1, T])]
    recorded[:, Q] = recorded[:, [8, 9, 10, 7]]
    flown = np.stack([np.interp(recorded[:, T], log[:, T], column) for column in log.T], axis=1)
    flown[:, Q] /= np.linalg.norm(flown[:, Q], axis=1, keepdims=True)
    return flown, recorded, took, answer


@pytest.mark.parametrize("name", [name for name in MOVES if name != "yaw90"])
def test_positions_are_those_recorded_at_every_instant(name: str) -> None:
    flown, recorded, _, _ = pair(name)
    largest = np.linalg.norm(recorded[:, P] - recorded[0, P], axis=1).max()
    assert np.linalg.norm(flown[:, P] - recorded[:, P], axis=1).max() < 0.01 * largest


@pytest.mark.parametrize("name", list(MOVES))
def test_attitudes_are_those_recorded_at_every_instant(name: str) -> None:
    flown, recorded, _, _ = pair(name)
    largest = angles(recorded[:, Q], recorded[:1, Q]).max()
    # The recorded call reached the firmware some 10 ms after its time 0, which is degrees in a fast turn.
    assert angles(flown[:, Q], recorded[:, Q]).max() < max(0.08 * largest, 1e-3)


@pytest.mark.parametrize("name", list(MOVES))
def test_velocities_are_those_recorded(name: str) -> None:
    flown, recorded, _, _ = pair(name)
    error = np.linalg.norm(flown[:, V] - recorded[:, V], axis=1)
    # Not at every instant: near half a metre from the height of the path the vertical goal switches back and forth.
    assert np.sqrt(np.mean(error**2)) < max(0.05 * np.linalg.norm(recorded[:, V], axis=1).max(), 0.02)


@pytest.mark.parametrize("name", list(MOVES))
def test_moves_take_as_long_and_answer_the_same(name: str) -> None:
    _, _, took, answer = pair(name)
    assert took == pytest.approx(MOVES[name][1], rel=0.01, abs=0.05)
    assert answer is MOVES[name][2]


def test_a_goal_within_the_lookahead_moves_nothing() -> None:
    aloft = hovering()
    log, took, answer = aloft.logged(
        lambda v: path.move_to_position(v, 0.5, 0, -10, 2, NEVER, 0, AS_IT_IS, -1, 1), after=5.0
    )
    assert (took, answer) == (0.0, False)
    assert np.abs(log[:, P] - log[0, P]).max() < 1e-3


def test_a_holding_vehicle_leans_into_the_wind_as_recorded() -> None:
    aloft = hovering()
    aloft.simulator.wind = np.array([4.0, 0.0, 0.0])
    aloft.idle(20.0)
    before = aloft.vehicle.quadrotor.position.copy()
    assert not aloft.fly(vertical.hover(aloft.vehicle))
    aloft.idle(20.0)
    recorded = recordings()["wind4_hover"][-1]
    assert aloft.vehicle.quadrotor.attitude[1] == pytest.approx(recorded[9], rel=0.005)
    assert aloft.vehicle.quadrotor.position == pytest.approx(before, abs=1e-3)


def step_response(log: Array) -> tuple[float, float, float]:
    """Return the steady speed north (m/s) of a step, and when (s) it reached 63 % and 90 % of it."""
    steady = log[-20:, 4].mean()
    rise = log[: log[:, 4].argmax() + 1]
    t63, t90 = np.interp([0.632, 0.9], rise[:, 4] / steady, rise[:, T])
    return float(steady), float(t63), float(t90)


@pytest.mark.parametrize(
    ("speed", "steady", "t63", "t90"), [(1.0, 0.99, 1.88, 4.20), (5.0, 4.72, 1.88, 4.02), (10.0, 8.99, 1.82, 3.74)]
)
def test_steps_at_a_height(speed: float, steady: float, t63: float, t90: float) -> None:
    log, _, _ = hovering().logged(lambda v: velocity.move_by_velocity_z(v, speed, 0, -10, 15, 0, AS_IT_IS))
    found = step_response(log)
    assert found[0] == pytest.approx(steady, rel=0.02)
    assert found[1:] == pytest.approx((t63, t90), rel=0.05)


def test_steps_with_a_vertical_velocity() -> None:
    log, _, _ = hovering().logged(lambda v: velocity.move_by_velocity(v, 5, 0, 0, 12, 0, AS_IT_IS))
    steady, t63, t90 = step_response(log)
    assert steady == pytest.approx(4.86, rel=0.02)
    assert (t63, t90) == pytest.approx((0.84, 1.73), rel=0.05)


@pytest.mark.parametrize(("z", "t63", "t90"), [(-2.5, 1.16, 2.37), (-10.0, 1.80, 3.95), (-40.0, 4.03, 8.55)])
def test_the_height_slows_a_step_down(z: float, t63: float, t90: float) -> None:
    log, _, _ = hovering(z).logged(lambda v: velocity.move_by_velocity_z(v, 5, 0, z, 15, 0, AS_IT_IS))
    assert step_response(log)[1:] == pytest.approx((t63, t90), rel=0.05)


def cross_track(points: Array, corners: Array) -> Array:
    """Return the distances (m) of points (n, 3) from a polyline."""
    found = np.full(len(points), np.inf)
    for a, b in pairwise(corners):
        share = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        found = np.minimum(found, np.linalg.norm(points - a - share[:, None] * (b - a), axis=1))
    return found


@pytest.mark.parametrize(
    ("speed", "duration", "error", "overshoot"), [(2.0, 44.03, 0.49, 0.80), (5.0, 18.60, 1.12, 1.75)]
)
def test_squares(speed: float, duration: float, error: float, overshoot: float) -> None:
    log, took, answer = hovering().logged(square(speed))
    corners = np.array([log[0, P], *SQUARE])
    assert answer
    assert took == pytest.approx(duration, rel=0.03)
    assert np.sqrt(np.mean(cross_track(log[:, P], corners) ** 2)) == pytest.approx(error, rel=0.10)
    assert max(log[:, 1].max(), log[:, 2].max()) - 20 == pytest.approx(overshoot, rel=0.15)


def test_takeoff_ends_short_of_its_height() -> None:
    aloft = on_ground()
    assert not aloft.fly(vertical.take_off(aloft.vehicle, 20))
    aloft.idle(5.0)
    assert aloft.vehicle.quadrotor.position[2] == pytest.approx(-1.53, abs=0.05)


def test_landing_ends_on_the_ground() -> None:
    aloft = hovering(-3.06)  # which ends at 2.6 m
    _, took, answer = aloft.logged(lambda v: vertical.land(v, 60))
    assert answer
    assert took == pytest.approx(12.9, rel=0.05)
    assert aloft.vehicle.quadrotor.position[2] == pytest.approx(0.0, abs=0.05)


def test_landing_is_over_at_once_in_mid_air_where_the_vehicle_still_climbs() -> None:
    aloft = hovering()
    aloft.fly(velocity.move_by_velocity(aloft.vehicle, 0, 0, -2, 2, 0, AS_IT_IS))
    log, took, answer = aloft.logged(lambda v: vertical.land(v, 60), after=3.0)
    assert answer
    assert took < 1.0
    assert log[-1, 3] < -10


@pytest.mark.parametrize("place", [(10.0, 10.0, -10.0), (10.0, 0.0, -9.9), (14.0, 0.0, -5.0), (0.0, 0.0, -14.0)])
def test_the_way_home_ends_half_a_metre_above_the_start(place: tuple[float, float, float]) -> None:
    aloft = hovering(-3.0)
    aloft.fly(path.move_to_position(aloft.vehicle, *place, 3, NEVER, 0, AS_IT_IS, -1, 1))
    aloft.idle(4.0)
    far = float(np.linalg.norm(aloft.vehicle.quadrotor.position))
    _, took, _ = aloft.logged(lambda v: vertical.go_home(v, NEVER), after=5.0)
    assert took == pytest.approx(far / 0.5, abs=15.0)  # to creep to a stop takes seconds
    assert aloft.vehicle.quadrotor.position[2] == pytest.approx(-0.48, abs=0.05)
