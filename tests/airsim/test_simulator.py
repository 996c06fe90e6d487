"""The simulator behind the AirSim server: vehicles, tasks, contacts, and the calls that tell of them."""

import asyncio
import math
import time
from collections.abc import Coroutine
from typing import Any

import numpy as np
import pytest
from aloft import AS_IT_IS, NEVER, Aloft, hovering, on_ground

from crosstrack.airsim.firmware.airframe import RADIUS
from crosstrack.airsim.scene.scene import Scene
from crosstrack.airsim.server.clock import LATE, TICK, Clock
from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.handlers import clock, flight, state
from crosstrack.airsim.server.moves import path, velocity, vertical
from crosstrack.airsim.server.moves.polling import Move
from crosstrack.airsim.server.simulator import Simulator
from crosstrack.airsim.server.vehicle import ServedVehicle
from crosstrack.airsim.structs import KinematicsState, Pose, RCData, YawMode
from crosstrack.frames import Origin
from crosstrack.world.shapes import Box
from crosstrack.world.world import World

CALLS = {**flight.HANDLERS, **state.HANDLERS, **clock.HANDLERS}
WALL = World((Box((-5.0, 5.0, 0.0), (5.0, 7.0, 10.0)),))
"""ENU: from 5 to 7 m north of the start, 10 m high"""


def call(simulator: Simulator, name: str, *arguments: Any) -> Any:
    return CALLS[name](simulator, *arguments)


def served(count: int = 1, **options: Any) -> Simulator:
    """Return a simulator in lockstep with vehicles in a row, the API in control."""
    simulator = Simulator(Scene(World()), Clock(lockstep=True), **options)
    for index in range(count):
        simulator.add_vehicle(f"drone_{index}", Pose(np.array([0.0, 3.0 * index, 0.0])))
        call(simulator, "enableApiControl", True, f"drone_{index}")
    return simulator


def running(simulator: Simulator, script: Coroutine[Any, Any, Any]) -> Any:
    """Run a script beside a simulator."""

    async def both() -> Any:
        driver = asyncio.create_task(simulator.run())
        try:
            return await asyncio.wait_for(script, 60)
        finally:
            driver.cancel()

    return asyncio.run(both())


def velocity_of(simulator: Simulator, vx: float, seconds: float, name: str = "") -> Any:
    return call(simulator, "moveByVelocity", vx, 0.0, -1.0, seconds, 0, AS_IT_IS, name)


def test_a_new_move_supersedes_the_one_under_way() -> None:
    simulator = served()

    async def script() -> tuple[bool, bool, int]:
        first = velocity_of(simulator, 1.0, 50.0)
        second = velocity_of(simulator, -1.0, 0.5)
        answer = await first
        return answer, await second, simulator.now

    first, second, now = running(simulator, script())
    assert (first, second) == (False, True)
    assert now < 1e9


def test_a_cancelled_task_answers_false_and_nothing_else_runs() -> None:
    simulator = served()

    async def script() -> bool:
        task = velocity_of(simulator, 1.0, 50.0)
        call(simulator, "cancelLastTask", "")
        assert not simulator.waiting()
        answer: bool = await task
        return answer

    assert running(simulator, script()) is False


def test_a_move_that_cannot_be_flown_cancels_the_one_under_way_and_is_refused() -> None:
    simulator = served()

    async def script() -> bool:
        task = velocity_of(simulator, 1.0, 50.0)
        bad = call(simulator, "moveToPosition", 5.0, 0.0, -5.0, 3.0, NEVER, 0, AS_IT_IS, 0.0, 1.0, "")
        with pytest.raises(Refused, match="lookahead distance cannot be 0"):
            await bad
        answer: bool = await task
        return answer

    assert running(simulator, script()) is False


def test_vehicles_fly_side_by_side() -> None:
    simulator = served(2)

    async def script() -> None:
        await asyncio.gather(velocity_of(simulator, 2.0, 6.0, "drone_0"), velocity_of(simulator, -1.0, 5.0, "drone_1"))

    running(simulator, script())
    a, b = (vehicle.kinematics() for vehicle in simulator.vehicles.values())
    assert a.linear_velocity[0] == pytest.approx(2.0, abs=0.1)
    assert b.position[0] < -2.0
    assert b.position[1] == pytest.approx(0.0, abs=1e-3)
    assert simulator.vehicle("drone_1").pose().position[1] == pytest.approx(3.0, abs=1e-3)


def test_a_vehicle_added_in_flight_leaves_the_others_as_they_are() -> None:
    simulator = served()
    vehicle = simulator.vehicle("")
    simulator.fly(vehicle, velocity.move_by_velocity(vehicle, 1, 0, -1, 2, 0, AS_IT_IS))
    before = vehicle.kinematics()
    other = simulator.add_vehicle("late", Pose(np.array([1.0, 2.0, 0.0])))
    assert np.array_equal(vehicle.kinematics().position, before.position)
    simulator.fly(vehicle, velocity.move_by_velocity(vehicle, 1, 0, -1, 2, 0, AS_IT_IS))
    assert vehicle.kinematics().position[0] > before.position[0] + 1
    assert not other.kinematics().position[:2].any()
    assert call(simulator, "listVehicles") == ["drone_0", "late"]


@pytest.mark.parametrize(("name", "kind"), [("getMultirotorState", "API"), ("simGetVehiclePose", "Sim-API")])
def test_unknown_vehicles_are_refused_in_airsims_words(name: str, kind: str) -> None:
    words = (
        f"Vehicle {kind} for 'nobody' is not available. This could either because this is simulation-only API or this"
    )
    with pytest.raises(Refused, match=f"^{words} vehicle does not exist$"):
        call(served(), name, "nobody")


@pytest.mark.parametrize(
    ("name", "arguments"),
    [
        ("moveByVelocity", (math.nan, 0.0, 0.0, 1.0, 0, AS_IT_IS, "")),
        ("moveByVelocity", (math.inf, 0.0, 0.0, 1.0, 0, AS_IT_IS, "")),
        ("moveByVelocity", (1.0, 0.0, 0.0, math.nan, 0, AS_IT_IS, "")),
        ("moveByVelocity", (1.0, 0.0, 0.0, 1.0, 0, YawMode(True, math.nan), "")),
        ("moveOnPath", ([np.array([0.0, math.nan, 0.0])], 1.0, 1.0, 0, AS_IT_IS, -1.0, 1.0, "")),
        ("moveByRC", (RCData(pitch=math.nan, is_valid=True), "")),
        ("setVelocityControllerGains", ([math.nan, 1.0, 1.0], [0.0] * 3, [0.0] * 3, "")),
        ("setVelocityControllerGains", ([1.0], [0.0] * 3, [0.0] * 3, "")),
        ("simSetVehiclePose", (Pose(np.array([0.0, math.inf, 0.0])), True, "")),
        ("simSetVehiclePose", (Pose(np.zeros(3), np.zeros(4)), True, "")),
        ("simSetKinematics", (KinematicsState(linear_velocity=np.full(3, math.nan)), True, "")),
        ("simContinueForTime", (math.nan,)),
        ("setSafety", (1, 1.0, 0, 1.0, np.zeros(3), 1.0, 1.0, 1.0, "")),
        ("simSetExtForce", (np.full(3, math.nan),)),
    ],
)
def test_what_would_poison_the_state_is_refused(name: str, arguments: tuple[Any, ...]) -> None:
    with pytest.raises(Refused):
        call(served(), name, *arguments)


def test_huge_but_finite_goals_are_flown() -> None:
    aloft = hovering()
    for value in (1e30, -3e38):
        aloft.fly(velocity.move_by_velocity(aloft.vehicle, value, value, value, 1, 0, AS_IT_IS))
        aloft.fly(path.move_to_position(aloft.vehicle, value, 0, -value, 3, 1.0, 0, AS_IT_IS, -1, 1))
    assert np.isfinite(aloft.vehicle.quadrotor.position).all()


def test_the_state_tells_what_the_vehicle_does() -> None:
    simulator = served()
    assert call(simulator, "getMultirotorState", "").landed_state == 0
    vehicle = simulator.vehicle("")
    simulator.fly(vehicle, vertical.take_off(vehicle, 20))
    found = call(simulator, "getMultirotorState", "")
    assert found.landed_state == 1
    assert found.timestamp == simulator.now
    assert found.gps_location.altitude == pytest.approx(122 - found.kinematics_estimated.position[2])
    air = call(simulator, "simGetGroundTruthEnvironment", "")
    assert air.air_density == pytest.approx(1.211, rel=2e-3)
    assert air.gravity.tolist() == [0, 0, 9.80665]
    rotors = call(simulator, "getRotorStates", "").rotors
    assert sum(rotor.thrust for rotor in rotors) == pytest.approx(9.80665 * 1.0117, rel=0.1)
    assert [math.copysign(1, rotor.torque_scaler) for rotor in rotors] == [-1, -1, 1, 1]
    home = call(simulator, "getHomeGeoPoint", "")
    assert (home.latitude, home.longitude, home.altitude) == pytest.approx((47.641468, -122.140165, 122))


def test_a_point_of_the_earth_is_flown_to() -> None:
    simulator = Simulator(Scene(World()), Clock(lockstep=True), Origin(47.0, 8.0, 500.0))
    vehicle = simulator.add_vehicle("", Pose())
    vehicle.quadrotor.take_control(True)
    simulator.fly(vehicle, vertical.take_off(vehicle, 20))
    metre = 180 / (math.pi * 6378137.0)

    async def script() -> None:
        await call(simulator, "moveToGPS", 47.0 + 30 * metre, 8.0, 510.0, 3.0, NEVER, 0, AS_IT_IS, -1.0, 1.0, "")

    running(simulator, script())
    # Single precision keeps latitudes to 0.4 m, and the flight overshoots.
    assert vehicle.quadrotor.position == pytest.approx([30, 0, -10], abs=1.5)


def test_a_vehicle_is_put_somewhere_else_and_keeps_its_motion() -> None:
    aloft = hovering()
    aloft.fly(velocity.move_by_velocity(aloft.vehicle, 3, 0, 0, 4, 0, AS_IT_IS))
    before = aloft.vehicle.kinematics().linear_velocity
    pose = Pose(np.array([5.0, 6.0, -30.0]), np.array([0.0, 0.0, 2.0, 2.0]))
    call(aloft.simulator, "simSetVehiclePose", pose, True, "")
    found = call(aloft.simulator, "simGetVehiclePose", "")
    assert found.position.tolist() == [5, 6, -30]
    assert np.linalg.norm(found.orientation) == pytest.approx(1)
    assert aloft.vehicle.kinematics().linear_velocity == pytest.approx(before)
    moving = KinematicsState(position=np.array([0.0, 0.0, -5.0]), linear_velocity=np.array([1.0, 2.0, 3.0]))
    call(aloft.simulator, "simSetKinematics", moving, True, "")
    assert call(aloft.simulator, "simGetGroundTruthKinematics", "").linear_velocity.tolist() == [1, 2, 3]


def test_a_reset_brings_everything_back() -> None:
    simulator = served()
    simulator.vehicle("").start.position[:] = 0.0
    resets: list[int] = []
    simulator.resetters.append(lambda: resets.append(simulator.now))

    async def script() -> bool:
        task = velocity_of(simulator, 1.0, 50.0)
        await velocity_of(simulator, 2.0, 2.0)
        task = velocity_of(simulator, 1.0, 50.0)
        call(simulator, "reset")
        answer: bool = await task
        return answer

    assert running(simulator, script()) is False
    assert not call(simulator, "isApiControlEnabled", "")
    assert not simulator.vehicle("").kinematics().position.any()
    assert len(resets) == 1
    assert simulator.now > 1.9e9


def test_a_vehicle_starts_on_the_ground_level_with_its_heading() -> None:
    simulator = Simulator(Scene(World()), Clock(lockstep=True))
    tilted = np.array([0.1, 0.0, math.sin(0.5), math.cos(0.5)])
    vehicle = simulator.add_vehicle("", Pose(np.array([1.0, 2.0, 0.0]), tilted / np.linalg.norm(tilted)))
    simulator.idle(1.0)
    assert vehicle.quadrotor["grounded"]
    assert vehicle.collision.object_name == "Ground"
    assert vehicle.kinematics().position == pytest.approx(np.zeros(3), abs=1e-9)
    assert 2 * math.atan2(vehicle.quadrotor.attitude[2], vehicle.quadrotor.attitude[3]) == pytest.approx(1.0, abs=0.02)


def test_a_vehicle_that_starts_in_the_air_falls_and_lands() -> None:
    simulator = Simulator(Scene(World()), Clock(lockstep=True))
    vehicle = simulator.add_vehicle("", Pose(np.array([0.0, 0.0, -4.0])))
    simulator.idle(3.0)
    assert vehicle.pose().position[2] == pytest.approx(0.0, abs=1e-6)
    assert vehicle.quadrotor["grounded"]


def towards_wall(aloft: Aloft) -> Move:
    return velocity.move_by_velocity(aloft.vehicle, 3, 0, 0, 4, 0, AS_IT_IS)


def test_a_wall_is_hit_as_a_ball_does() -> None:
    aloft = hovering(-5.0, WALL)
    places: list[float] = []
    aloft.simulator.observers.append(lambda: places.append(float(aloft.vehicle.quadrotor.position[0])))
    aloft.fly(towards_wall(aloft))
    assert max(places) < 5.0 - RADIUS + 0.1
    found = call(aloft.simulator, "simGetCollisionInfo", "")
    assert found.has_collided
    assert found.object_name == "Box_1"
    assert found.normal == pytest.approx([-1, 0, 0], abs=1e-6)
    assert found.impact_point[0] == pytest.approx(5.0, abs=1e-3)
    assert found.position[0] == pytest.approx(5.0 - RADIUS, abs=0.05)
    assert 0 < found.time_stamp <= aloft.simulator.now


def test_without_collisions_walls_are_flown_through_and_the_ground_still_holds() -> None:
    class Ghost:
        enable_collisions = False

    simulator = Simulator(Scene(WALL), Clock(lockstep=True))
    vehicle = simulator.add_vehicle("", Pose(), settings=Ghost())
    vehicle.quadrotor.take_control(True)
    simulator.fly(vehicle, vertical.take_off(vehicle, 20))
    simulator.fly(vehicle, velocity.move_by_velocity(vehicle, 3, 0, 0, 5, 0, AS_IT_IS))
    assert vehicle.quadrotor.position[0] > 9
    simulator.idle(3.0)
    simulator.fly(vehicle, vertical.land(vehicle, 60))
    assert vehicle.quadrotor["grounded"]


def test_reading_a_collision_clears_that_there_was_one() -> None:
    aloft = hovering(-5.0, WALL)
    aloft.fly(towards_wall(aloft))
    aloft.fly(velocity.move_by_velocity(aloft.vehicle, -2, 0, 0, 3, 0, AS_IT_IS))
    first, second = (call(aloft.simulator, "simGetCollisionInfo", "") for _ in range(2))
    assert (first.has_collided, second.has_collided) == (True, False)
    assert first.object_name == second.object_name


def test_a_thing_that_appears_is_hit_although_the_way_was_free() -> None:
    aloft = hovering(-5.0)
    scene = aloft.simulator.scene
    walled = Scene(WALL)
    for thing in walled.things.values():
        scene.put(thing)
    aloft.fly(towards_wall(aloft))
    assert aloft.vehicle.quadrotor.position[0] < 5.0 - RADIUS + 0.1
    assert aloft.vehicle.collision.has_collided


def test_a_thin_wall_is_not_flown_through_at_speed() -> None:
    sheet = World((Box((-20.0, 29.99, 0.0), (20.0, 30.01, 40.0)),))
    aloft = hovering(-10.0, sheet)
    state_then = aloft.vehicle.kinematics()
    aloft.vehicle.set_kinematics(
        KinematicsState(state_then.position, state_then.orientation, np.array([80.0, 0.0, 0.0]))
    )
    aloft.idle(1.0)
    assert aloft.vehicle.quadrotor.position[0] < 30.0
    assert aloft.vehicle.collision.object_name == "Box_1"


def test_a_roof_is_landed_on_and_taken_off_from() -> None:
    roof = World((Box((-3.0, -3.0, 0.0), (3.0, 3.0, 2.0)),))
    simulator = Simulator(Scene(roof), Clock(lockstep=True))
    vehicle = simulator.add_vehicle("", Pose(np.array([0.0, 0.0, -4.0])))
    vehicle.quadrotor.take_control(True)
    simulator.idle(3.0)
    assert vehicle.quadrotor["grounded"]
    assert vehicle.pose().position[2] == pytest.approx(-2.0 - RADIUS, abs=0.02)
    simulator.fly(vehicle, vertical.take_off(vehicle, 20))
    assert vehicle.pose().position[2] < -3.5


def test_gains_slow_the_vehicle_down() -> None:
    found = []
    for kp in (0.2, 0.05):
        aloft = hovering()
        call(aloft.simulator, "setVelocityControllerGains", [kp, kp, 2.0], [0.0, 0.0, 2.0], [0.0] * 3, "")
        aloft.fly(velocity.move_by_velocity(aloft.vehicle, 2, 0, 0, 1, 0, AS_IT_IS))
        found.append(float(aloft.vehicle.quadrotor.velocity[0]))
    assert found[1] < 0.5 * found[0]


def test_an_external_force_pushes_until_it_is_taken_back() -> None:
    aloft = hovering()
    call(aloft.simulator, "simSetExtForce", np.array([0.0, 1.0, 0.0]))
    aloft.idle(10.0)
    roll = 2 * float(aloft.vehicle.quadrotor.attitude[0])
    assert roll == pytest.approx(-1.0 / 9.80665, abs=0.01)
    call(aloft.simulator, "simSetExtForce", np.zeros(3))
    aloft.idle(10.0)
    assert aloft.vehicle.quadrotor.attitude[0] == pytest.approx(0.0, abs=1e-3)


def test_the_clock_keeps_wall_time_times_its_speed(monkeypatch: pytest.MonkeyPatch) -> None:
    wall = [100.0]
    monkeypatch.setattr(time, "monotonic", lambda: wall[0])
    for speed, counted in ((1.0, 1.0), (2.7, 2.0), (0.5, 0.5)):
        found = Clock(speed, start=0)
        assert found.due(7) == 0
        for _ in range(200):
            wall[0] += 0.01
            while steps := found.due(7):
                found.advance(steps)
        assert found.now == pytest.approx(2e9 * counted, abs=2 * TICK)


def test_a_clock_that_cannot_keep_up_falls_behind(monkeypatch: pytest.MonkeyPatch) -> None:
    wall = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: wall[0])
    found = Clock(start=0)
    assert found.due(7) == 0
    wall[0] += 10 * LATE
    assert found.due(7) == 0
    wall[0] += 0.5 * LATE
    assert found.due(1000) == int(0.5 * LATE * 1e9 / TICK)


def test_slow_clocks_take_shorter_steps() -> None:
    assert Clock(0.5).tick == TICK // 2
    assert Clock(3.9).tick == TICK
    assert Clock(3.9).speed == 3.0


def test_real_time_runs_without_any_call() -> None:
    simulator = Simulator(Scene(World()), Clock(20.0))
    simulator.add_vehicle("", Pose())
    start = simulator.now

    async def script() -> None:
        while simulator.now < start + 100 * TICK:
            await asyncio.sleep(0.001)
        call(simulator, "simPause", True)
        paused = simulator.now
        await asyncio.sleep(0.02)
        assert simulator.now == paused
        assert call(simulator, "simIsPaused")
        await call(simulator, "simContinueForTime", 0.01)
        assert simulator.now - paused == pytest.approx(20 * 0.01 * 1e9, abs=TICK)

    running(simulator, script())


def test_api_control_may_be_left_to_a_switch_of_the_sticks() -> None:
    class Guarded:
        allow_api_always = False

    simulator = Simulator(Scene(World()), Clock(lockstep=True))
    vehicle: ServedVehicle = simulator.add_vehicle("", Pose(), settings=Guarded())
    call(simulator, "enableApiControl", True, "")
    assert not call(simulator, "isApiControlEnabled", "")
    call(simulator, "moveByRC", RCData(switches=2, is_valid=True), "")
    call(simulator, "enableApiControl", True, "")
    assert call(simulator, "isApiControlEnabled", "")
    assert call(simulator, "armDisarm", True, "")
    assert vehicle.rc_data.switches == 2


def test_arming_needs_control_and_versions_are_airsims() -> None:
    simulator = served()
    call(simulator, "enableApiControl", False, "")
    assert not call(simulator, "armDisarm", True, "")
    assert call(simulator, "ping") is True
    assert call(simulator, "getServerVersion") == call(simulator, "getMinRequiredClientVersion") == 1


def test_standing_on_the_ground_is_no_collision_again_and_again() -> None:
    aloft = on_ground()
    before = aloft.vehicle.collision.time_stamp
    aloft.idle(2.0)
    assert aloft.vehicle.collision.time_stamp == before


def test_vehicles_that_meet_bounce_off_and_say_whom_they_met() -> None:
    simulator = Simulator(Scene(World()), Clock(lockstep=True))
    start = Pose(np.array([6.0, 0.0, 0.0]))
    first, second = simulator.add_vehicle("First", Pose()), simulator.add_vehicle("Second", start)
    gap: list[float] = []
    simulator.observers.append(
        lambda: gap.append(float(np.linalg.norm(first.pose().position - second.pose().position)))
    )
    for vehicle in (first, second):
        call(simulator, "enableApiControl", True, vehicle.name)
        simulator.fly(vehicle, vertical.take_off(vehicle, 20))
    first.slot.begin(velocity.move_by_velocity(first, 2, 0, 0, 4, 0, AS_IT_IS), simulator.now, lambda *_: None)
    simulator.fly(second, velocity.move_by_velocity(second, -2, 0, 0, 4, 0, AS_IT_IS))
    radius = simulator.scene.radius
    assert 2 * radius - 0.2 < min(gap) < 2 * radius
    assert first.pose().position[0] < second.pose().position[0]  # neither went through
    for vehicle, other in ((first, second), (second, first)):
        info = call(simulator, "simGetCollisionInfo", vehicle.name)
        assert info.has_collided
        assert info.object_name == other.name
    assert np.linalg.norm(second.kinematics().linear_velocity) < 5
