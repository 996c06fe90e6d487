"""Missions flown through AirSim's protocol, against the server, beside the same missions in the embedded simulator."""

import json
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from served import serving, serving_mission

import crosstrack as ct
from crosstrack import mission as missions
from crosstrack.airsim import Client
from crosstrack.airsim.firmware.rows import DISARMED
from crosstrack.airsim.server.serve import Server
from crosstrack.airsim.server.settings import parse
from crosstrack.cli.app import run
from crosstrack.errors import InputError, LinkLost
from crosstrack.flight.flight import Flight
from crosstrack.flight.recording import read_log
from crosstrack.flight.summary import summary
from crosstrack.mission.airsim import airsim_settings
from crosstrack.mission.mission import Mission
from crosstrack.sense.depth_camera import DepthCamera
from crosstrack.sense.distance_ring import DistanceRing
from crosstrack.sense.lidar import Lidar
from crosstrack.types import Outcome, Scan, Setpoint
from crosstrack.vehicles.airsim.vehicle import AirSim

EXAMPLES = Path(__file__).parents[2] / "examples"
HOP = """
start: {position: [0, 0, 4], yaw: 0.5}
route: [[6, 0, 4], [6, 5, 5]]
speed: 3
"""


def in_airsim(mission: Mission, server: Server, **options: Any) -> Mission:
    """Return the mission with the one word changed, and where the server is."""
    return replace(mission, vehicle=AirSim(port=server.port, after="hover", **options))


def both(mission: Mission, how: dict[str, Any] | None = None, **options: Any) -> tuple[Flight, Flight]:
    """Fly a mission in the embedded simulator and in AirSim."""
    with serving_mission(mission, **(how or {})) as server:
        return ct.fly(mission), ct.fly(in_airsim(mission, server, **options))


def check(embedded: Flight, flown: Flight) -> None:
    """Hold a flight to what the embedded one does."""
    mine, theirs = summary(flown), summary(embedded)
    assert flown.outcome is Outcome.ARRIVED
    assert mine["flight_time_s"] == pytest.approx(theirs["flight_time_s"], rel=0.1)
    assert mine["cross_track_rms_m"] <= 1.5 * theirs["cross_track_rms_m"] + 0.05


LONGER = ["figure_eight", "airsim_path", "jerk_eight", "rooms", "spiral", "survey", "city"]


@pytest.mark.parametrize(
    "name",
    ["square", "snap_slalom", "learned_forest", *(pytest.param(name, marks=pytest.mark.slow) for name in LONGER)],
)
def test_missions_fly_as_in_the_embedded_simulator(name: str) -> None:
    """Routes with corners, a figure that crosses itself, trajectories by the clock, an image map, a learned policy."""
    check(*both(missions.load(EXAMPLES / f"{name}.yaml")))


def test_an_unknown_forest_is_flown_by_what_airsim_s_lidar_sees() -> None:
    """The demonstration: planned, replanned for what is on no map, guarded; all through the protocol."""
    embedded, flown = both(missions.load(EXAMPLES / "demo.yaml"))
    check(embedded, flown)
    numbers = summary(flown)
    assert numbers["min_clearance_m"] >= 0.2
    assert numbers["replans"] >= 1
    assert len(flown.seen) > 20


def test_trackers_that_command_rates_and_attitudes_fly_too() -> None:
    for kind in ("cascaded_pid", "mpc"):
        mission = missions.load(EXAMPLES / "snap_slalom.yaml", [f"tracker={{kind: {kind}}}"])
        embedded, flown = both(mission)
        assert flown.outcome is Outcome.ARRIVED
        assert summary(flown)["tracking_rms_m"] <= 1.5 * summary(embedded)["tracking_rms_m"] + 0.1


def test_airsim_s_own_velocity_loop_gets_there_less_closely() -> None:
    embedded, flown = both(missions.load(EXAMPLES / "airsim_path.yaml"), level="velocity")
    assert flown.outcome is Outcome.ARRIVED
    assert summary(embedded)["cross_track_rms_m"] < summary(flown)["cross_track_rms_m"] < 0.3


@pytest.mark.parametrize("stepping", ["running", "paused"])
def test_other_clocks_are_handled(stepping: str) -> None:
    """A clock that runs on by itself, faster than real time, and one that is stopped between two commands."""
    _, flown = both(missions.loads(HOP), {"lockstep": False, "clock_speed": 3.0}, stepping=stepping)
    assert flown.outcome is Outcome.ARRIVED
    # A clock that runs on while commands are late on a busy machine: the vehicle holds its place meanwhile.
    assert summary(flown)["cross_track_rms_m"] < (0.15 if stepping == "paused" else 0.6)


@pytest.mark.parametrize("rate", [10, 25, 100])
def test_any_rate_of_commands_will_do(rate: int) -> None:
    embedded, flown = both(missions.loads(HOP + f"timing: {{rate: {rate}}}\n"))
    check(embedded, flown)


def test_it_can_be_flown_to_the_start() -> None:
    mission = missions.loads("start: {position: [4, 3, 5]}\nroute: [[8, 3, 5]]\n")
    with serving() as server:
        flown = ct.fly(in_airsim(mission, server, begin="fly"))
    assert flown.outcome is Outcome.ARRIVED
    np.testing.assert_allclose(flown.record.position[0], [4, 3, 5], atol=0.06)


def test_a_flight_begins_on_the_ground_where_the_mission_says_so() -> None:
    mission = missions.loads("start: {position: [2, 1, 3], takeoff: true}\nroute: [[6, 1, 3]]\n")
    embedded, flown = both(mission)
    check(embedded, flown)
    assert flown.record.position[0, 2] < 0.2


def test_wind_is_told_and_withstood() -> None:
    mission = missions.loads(HOP + "wind: {mean: [3, -4, 0], gusts: light}\n")
    with serving() as server:
        flown = ct.fly(in_airsim(mission, server))
        assert not server.simulator.wind.any()
    assert flown.outcome is Outcome.ARRIVED
    assert summary(flown)["cross_track_rms_m"] < 0.3
    assert np.std(flown.record.wind, axis=0).max() > 0.1


def test_a_vehicle_that_hovers_after_a_flight_stays_where_it_is() -> None:
    """With the clock running on: it is still told to hold its place."""
    with serving(lockstep=False) as server:
        assert ct.fly(in_airsim(missions.loads(HOP), server)).outcome is Outcome.ARRIVED
        place = server.simulator.vehicle("").kinematics().position
        time.sleep(1.5)
        np.testing.assert_allclose(server.simulator.vehicle("").kinematics().position, place, atol=0.3)


def test_several_vehicles_fly_together_and_are_added_where_airsim_has_none() -> None:
    text = """
avoid: [{kind: orca}]
speed: 2
vehicles:
  - {name: a, start: {position: [-4, 0, 5]}, route: [[4, 0, 5]]}
  - {name: b, start: {position: [4, 0.2, 5]}, route: [[-4, 0.2, 5]]}
  - {name: c, start: {position: [0, -4, 5]}, route: [[0, 4, 5]]}
"""
    with serving(radius=0.2) as server:
        mission = in_airsim(missions.loads(text), server)
        flights = ct.fly_together(mission)
        assert {"a", "b", "c"} <= set(server.simulator.vehicles)
    assert [flight.outcome for flight in flights] == [Outcome.ARRIVED] * 3
    for flight in flights:
        assert np.diff(flight.record.time).max() < 0.05  # each gets its commands in time
        assert flight.record.separation.min() > 0.4


def test_after_a_flight_the_vehicle_stands_disarmed_on_the_ground() -> None:
    with serving() as server:
        mission = replace(missions.loads(HOP), vehicle=AirSim(port=server.port))
        assert ct.fly(mission).outcome is Outcome.ARRIVED
        vehicle = server.simulator.vehicle("")
        assert vehicle.kinematics().position[2] > -0.1
        assert np.linalg.norm(vehicle.kinematics().linear_velocity) < 0.1
        assert vehicle.quadrotor["armed"] == DISARMED


def test_path_aims_and_trail_are_drawn() -> None:
    with serving() as server:
        ct.fly(in_airsim(missions.loads(HOP), server))
        drawn = server.simulator.scene.markers.drawn
        assert "SimpleFlight" in server.simulator.scene.markers.traces
    lines = [mark for mark in drawn if type(mark).__name__ == "LineStrip" or getattr(mark, "kind", "") == "line_strip"]
    assert lines or drawn
    with serving() as server:
        ct.fly(in_airsim(missions.loads(HOP), server, draw=False))
        assert not server.simulator.scene.markers.drawn


def test_moving_obstacles_are_there_and_gone_afterwards() -> None:
    mission = missions.loads(
        "start: {position: [0, 0, 2]}\nroute: [[8, 0, 2]]\nspeed: 2\n"
        "world: {moving: [{shape: {sphere: {center: [4, 8, 2], radius: 0.5}}, velocity: [0, -1, 0]}]}\n"
    )
    where = []
    with serving() as server:
        plan = in_airsim(mission, server).build()
        session = plan.vehicle.launch(plan.scenario)
        for _ in range(50):
            session.advance(Setpoint(velocity=np.zeros(3)), 0.02)
            ball = server.simulator.scene.things["crosstrack_ball_0"]
            where.append([session.truth().time, *ball.pose.position])
        session.close()
        assert "crosstrack_ball_0" not in server.simulator.scene.things
    time, north, east, down = np.array(where).T
    np.testing.assert_allclose(north, 8 - time, atol=1e-3)
    np.testing.assert_allclose(east, 4, atol=1e-3)
    np.testing.assert_allclose(down, -2, atol=1e-3)


def test_what_is_hit_ends_the_flight() -> None:
    mission = missions.loads(HOP + "world: {shapes: [{box: {min: [4, -2, 0], max: [4.5, 2, 6]}}]}\n")
    _, flown = both(mission)
    assert flown.outcome is Outcome.COLLIDED


def test_sensors_that_airsim_does_not_have_are_named_with_what_to_write() -> None:
    mission = missions.loads(HOP + "sensors: [{kind: lidar}]\nmap: unknown\n")
    with serving() as server, pytest.raises(InputError, match=r"Sensors\.Lidar0: is missing; write .*NumberOfChannels"):
        ct.fly(in_airsim(mission, server))
    wrong = parse('{"Vehicles": {"A": {"VehicleType": "SimpleFlight", "Sensors": {"Lidar0": {"SensorType": 6}}}}}')
    with serving(settings=wrong) as server, pytest.raises(InputError, match="NumberOfChannels"):
        ct.fly(in_airsim(mission, server))


SEEING = """
start: {position: [0, 0, 3], yaw: 0.4}
route: [[1, 0, 3]]
world: {shapes: [{box: {min: [6, -3, 0], max: [7, 5, 8]}}, {sphere: {center: [2, 7, 4], radius: 2}},
  {cylinder: {center: [-5, -2], radius: 1, z: [0, 9]}}]}
"""


def seen(sensor: Any, change: Callable[[dict[str, Any]], None] = lambda _: None) -> tuple[Scan, Scan]:
    """Return what a sensor of AirSim sees, and what the mission's own sees from the same place."""
    mission = replace(missions.loads(SEEING), sensors=(sensor,))
    document = airsim_settings(mission)
    change(document["Vehicles"]["SimpleFlight"])
    with serving(mission.obstacles, parse(json.dumps(document)), radius=0.2) as server:
        plan = in_airsim(mission, server).build()
        session = plan.vehicle.launch(plan.scenario)
        (scan,) = session.scans()
        own = sensor.look(mission.obstacles, session.truth(), np.random.default_rng(1))
        session.close()
    return scan, own


def inertial(vehicle: dict[str, Any]) -> None:
    vehicle["Sensors"]["Lidar0"]["DataFrame"] = "VehicleInertialFrame"


def planar(vehicle: dict[str, Any]) -> None:
    vehicle["Cameras"]["Depth0"]["CaptureSettings"][0]["ImageType"] = 1


@pytest.mark.parametrize("change", [lambda _: None, inertial])
def test_airsim_s_lidar_sees_what_the_mission_s_would(change: Callable[[dict[str, Any]], None]) -> None:
    scan, own = seen(Lidar(noise=0.0, rings=16, columns=180, position=(0.1, 0.0, 0.05), yaw_deg=20.0), change)
    both_hit = np.isfinite(scan.ranges) & np.isfinite(own.ranges)
    assert both_hit.mean() > 0.3
    assert (np.isfinite(scan.ranges) == np.isfinite(own.ranges)).mean() > 0.95
    # Rays that graze an edge or a slope differ: those of AirSim are up to half a beam beside ours.
    assert np.median(np.abs(scan.ranges[both_hit] - own.ranges[both_hit])) < 0.03
    np.testing.assert_allclose(scan.origin, own.origin, atol=1e-3)


@pytest.mark.parametrize("options", [{"fov_deg": 90.0, "columns": 90}, {"rate": 2.5, "columns": 72}, {"columns": 57}])
def test_no_beam_of_a_lidar_in_a_closed_room_is_empty(options: dict[str, Any]) -> None:
    """Whatever its field of view, rate and columns: an empty beam would count as free space."""
    walls = "world: {shapes: [{box: {min: [5, -9, -1], max: [6, 9, 9]}}, {box: {min: [-6, -9, -1], max: [-5, 9, 9]}}, "
    walls += "{box: {min: [-6, 5, -1], max: [6, 6, 9]}}, {box: {min: [-6, -6, -1], max: [6, -5, 9]}}]}\n"
    sensor = Lidar(noise=0.0, rings=4, lowest_deg=-10.0, highest_deg=10.0, **options)
    mission = replace(missions.loads("start: {position: [0, 0, 4]}\nroute: [[1, 0, 4]]\n" + walls), sensors=(sensor,))
    with serving_mission(mission) as server:
        plan = in_airsim(mission, server).build()
        session = plan.vehicle.launch(plan.scenario)
        scans = list(session.scans())
        for _ in range(60):
            session.advance(Setpoint(velocity=np.zeros(3)), 0.02)
            scans += session.scans()
        session.close()
    assert len(scans) >= 3
    for scan in scans:
        assert np.isfinite(scan.ranges).all()


@pytest.mark.parametrize("change", [lambda _: None, planar])
def test_airsim_s_depth_images_see_what_the_mission_s_camera_would(change: Callable[[dict[str, Any]], None]) -> None:
    scan, own = seen(DepthCamera(noise=0.0, width=64, height=48, position=(0.2, 0.0, 0.0), pitch_deg=10.0), change)
    both_hit = np.isfinite(scan.ranges) & np.isfinite(own.ranges)
    assert both_hit.mean() > 0.3
    assert (np.isfinite(scan.ranges) == np.isfinite(own.ranges)).mean() > 0.99
    assert np.quantile(np.abs(scan.ranges[both_hit] - own.ranges[both_hit]), 0.99) < 0.02
    np.testing.assert_allclose(scan.origin, own.origin, atol=1e-3)


def test_airsim_s_distance_sensors_see_what_the_mission_s_ring_would() -> None:
    scan, own = seen(DistanceRing(noise=0.0, range=12.0, count=12))
    near = np.isfinite(own.ranges) & (own.ranges < 11.0)
    assert near.sum() >= 3
    assert np.abs(scan.ranges[near] - own.ranges[near]).max() < 1.0  # AirSim's sensors are 0.2 m off in the mean
    assert not np.isfinite(scan.ranges[own.ranges == np.inf]).any()


def test_ctrl_c_in_mid_flight_lands_the_vehicle(tmp_path: Path) -> None:
    mission = tmp_path / "far.yaml"
    mission.write_text("start: {position: [0, 0, 4]}\nroute: [[400, 0, 4]]\nspeed: 3\n")
    with serving() as server:
        kind = f"vehicle={{kind: airsim, port: {server.port}}}"
        command = crosstrack("fly", mission, "--out", tmp_path, "--set", kind)
        flight = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        assert flight.stderr is not None
        while " s flown" not in (line := flight.stderr.readline()):
            assert line
        flight.send_signal(signal.SIGINT)
        flight.stderr.read()
        flight.stderr.close()
        assert flight.wait(60) == 130
        vehicle = server.simulator.vehicle("")
        assert vehicle.kinematics().position[2] > -0.1
        assert vehicle.quadrotor["armed"] == DISARMED
    assert '"outcome": "interrupted"' in (tmp_path / "summary.json").read_text()


def test_without_a_server_the_link_is_lost_at_once() -> None:
    mission = replace(missions.loads(HOP), vehicle=AirSim(port=1))
    began = time.monotonic()
    with pytest.raises(LinkLost, match=r"no server at 127\.0\.0\.1:1"):
        ct.fly(mission)
    assert time.monotonic() - began < 30.0


def crosstrack(*arguments: object) -> list[str]:
    return [sys.executable, "-m", "crosstrack", *map(str, arguments)]


@contextmanager
def started(*more: str) -> Iterator[tuple[Any, int]]:
    """Start the command's server on a free port."""
    command = crosstrack("serve", "--port", 0, *more)
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    try:
        line = ""
        while "Serving" not in line:
            line = process.stderr.readline()
            assert line, "the server has ended"
        yield process, int(line.split(":")[1].split(",")[0])
    finally:
        process.kill()
        process.wait()
        process.stderr.close()


def test_a_server_that_dies_in_mid_flight_leaves_log_and_report_and_another_one_flies_on(tmp_path: Path) -> None:
    mission = tmp_path / "far.yaml"
    mission.write_text("start: {position: [0, 0, 4]}\nroute: [[400, 0, 4]]\nspeed: 3\n")

    def flying(port: int) -> Any:
        kind = f"vehicle={{kind: airsim, port: {port}, after: hover}}"
        command = crosstrack("fly", mission, "--out", tmp_path, "--set", kind)
        return subprocess.Popen(command, stderr=subprocess.PIPE, text=True)

    with started() as (server, port):
        flight = flying(port)
        while not (told := re.search(r"([\d.]+) s flown", line := flight.stderr.readline())) or float(told[1]) < 1:
            assert line
        os.kill(server.pid, signal.SIGKILL)
        killed = time.monotonic()
        while "Lost the link" not in (line := flight.stderr.readline()):
            assert line
        lost = time.monotonic() - killed
        assert flight.wait(60) == 5
        flight.stderr.close()
    assert lost < 10.0  # two seconds on a machine that is free, see the benchmark
    assert (tmp_path / "report.html").stat().st_size > 1000
    assert '"outcome": "link_lost"' in (tmp_path / "summary.json").read_text()
    assert len(read_log(tmp_path / "flight.mcap").record.time) > 10
    mission.write_text(HOP)
    with started("--lockstep") as (_, port):
        again = flying(port)
        assert again.wait(120) == 0
        again.stderr.close()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--port", "70000"], "--port: must be from 0, any free one, to 65535; found 70000"),
        (["--clock-speed", "0"], "--clock-speed: must be from 0.01 to 1000; found 0"),
        (["--settings", "nowhere.json"], "nowhere.json"),
        (["--world", "nowhere.yaml"], "nowhere.yaml"),
    ],
)
def test_wrong_flags_are_named(arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["serve", *arguments]) == 2
    assert words in capsys.readouterr().err


def test_a_port_in_use_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    with serving() as server:
        assert run(["serve", "--port", str(server.port)]) == 2
    assert "in use" in capsys.readouterr().err


def test_settings_of_a_mission_can_be_written_and_served(tmp_path: Path) -> None:
    out = tmp_path / "settings.json"
    assert run(["export", str(EXAMPLES / "demo.yaml"), str(out)]) == 0
    given = parse(out.read_text())
    assert given.fleet()["SimpleFlight"].sensors["Lidar0"].sensor_type == 6
    with serving(settings=given) as server, Client(port=server.port) as client:
        assert client.get_lidar_data("Lidar0").time_stamp >= 0
