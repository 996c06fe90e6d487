"""Calls about the server and its clock."""

import math
from collections.abc import Callable
from typing import Any

from crosstrack.airsim.server.clock import FRAME
from crosstrack.airsim.server.errors import Refused
from crosstrack.airsim.server.simulator import Simulator

VERSION = 1
"""of server and clients, as AirSim has it"""


def ping(simulator: Simulator) -> bool:
    """Return true."""
    return True


def version(simulator: Simulator) -> int:
    """Return the version of the server, and of the oldest client that it serves."""
    return VERSION


def pause(simulator: Simulator, on: bool) -> None:
    """Stop the clock, or let it run."""
    simulator.pause(on)


def is_paused(simulator: Simulator) -> bool:
    """Return whether the clock is stopped."""
    return simulator.clock.paused


def continue_for_time(simulator: Simulator, seconds: float) -> Any:
    """Let the clock run for a time (s) and pause then; the answer comes when it does."""
    if math.isnan(seconds):
        raise Refused("simContinueForTime takes a number of seconds, not NaN")
    return simulator.run_for(seconds)


def continue_for_frames(simulator: Simulator, frames: int) -> Any:
    """Let the clock run for so many frames of a sixtieth of a second and pause then."""
    return simulator.run_for(frames * FRAME)


def reset(simulator: Simulator) -> None:
    """Put every vehicle back to where it started."""
    simulator.reset()


HANDLERS: dict[str, Callable[..., Any]] = {
    "ping": ping,
    "getServerVersion": version,
    "getMinRequiredClientVersion": version,
    "simPause": pause,
    "simIsPaused": is_paused,
    "simContinueForTime": continue_for_time,
    "simContinueForFrames": continue_for_frames,
    "reset": reset,
}
