"""How a vehicle in AirSim gets to the start of a flight, and what becomes of it afterwards."""

import numpy as np

from crosstrack.airsim.client.errors import RemoteError
from crosstrack.errors import InputError, Problem
from crosstrack.protocols import Scenario
from crosstrack.types import Array, Setpoint, State
from crosstrack.vehicles.airsim.link import Link

SETTLED = 0.05
"""m and m/s, within which the vehicle is at its start"""
OFTEN = 10
"""states in a row that must say so"""
LONGEST = 60.0
"""s that each way to or from a flight may take"""
TAKEOFF, LANDING = 20.0, 120.0
"""s that AirSim is given for them"""
NO_END = 3600.0
"""s of the wall, for calls that AirSim ends itself"""
LEVEL = 0.01
"""m, above the ground, up to which a start is on it"""
LOW = 1.5
"""m, above the ground, from where AirSim lands by itself, slowly"""
SINKING = 1.5
"""m/s, down to there"""
STILL = 0.2
"""m/s"""


def go_to_start(link: Link, scenario: Scenario, put: bool, lift: bool) -> None:
    """Bring the vehicle to the start of a flight, at rest: hovering there, or standing on the ground.

    Args:
        link: to it
        scenario: of the flight
        put: whether it is put there, or flown straight
        lift: whether it takes off first where the start is on the ground: AirSim's velocity loop alone does not

    Raises:
        LinkLost: AirSim no longer answers.
        InputError: it does not get there.
    """
    start, ground = scenario.position, scenario.world.ground
    if put:
        link.put(start)
    if start[2] <= ground + LEVEL:
        if lift:
            take_off(link)
        return
    if not put and link.state()[1].position[2] < ground + LOW:
        take_off(link)
    reach(link, start, scenario.period)


def take_off(link: Link) -> None:
    """Have AirSim take off; a vehicle that moves already need not."""
    try:
        link.client.takeoff(TAKEOFF, link.name).join(NO_END)
    except RemoteError as error:
        if "moving" not in str(error):
            raise


def reach(link: Link, place: Array, period: float) -> None:
    """Fly to a place (3,) m and come to rest there.

    Raises:
        InputError: it does not get there.
    """
    goal, settled = Setpoint(position=place, yaw=link.yaw), 0
    for _ in range(round(LONGEST / period)):
        state = link.hold(goal, period)
        settled = settled + 1 if off(state, place) < SETTLED else 0
        if settled == OFTEN:
            return
    message = f"the vehicle does not get there within {LONGEST:g} s: it is at {np.round(state.position, 2).tolist()}"
    raise InputError("vehicle airsim", [Problem("start.position", message)])


def off(state: State, place: Array) -> float:
    """Return how far a vehicle is from being at rest at a place (3,) m: m or m/s."""
    return float(max(np.linalg.norm(state.position - place), np.linalg.norm(state.velocity)))


def leave(link: Link, scenario: Scenario, land: bool) -> None:
    """Bring the vehicle to rest, then, where asked, to the ground, disarmed, and give the control back."""
    client, period = link.client, scenario.period
    stop = Setpoint(velocity=np.zeros(3), yaw=link.yaw)
    state = link.state()[1]
    for _ in range(round(LONGEST / period)):
        if np.linalg.norm(state.velocity) < STILL:
            break
        state = link.hold(stop, period)
    if land:
        sink = Setpoint(velocity=np.array([0.0, 0.0, -SINKING]), yaw=link.yaw)
        low = scenario.world.ground + LOW
        for _ in range(round(LONGEST / period)):
            if state.position[2] < low:
                break
            state = link.hold(sink, period)
        client.land(LANDING, link.name).join(NO_END)
        client.arm_disarm(False, link.name)
        client.enable_api_control(False, link.name)
    else:
        client.hover(link.name).join(NO_END)  # control is kept: without it, and without sticks, the vehicle would fall
