"""How moves wait: they look every 20 ms of the clock, until they are done, out of time or cancelled."""

from collections.abc import Callable, Generator
from typing import Protocol

from crosstrack.airsim.firmware.quadrotor import Four, Modes, Quadrotor

Move = Generator[float, bool, bool]
"""A move under way: it yields the time (s) to sleep, is sent whether it may go on, and returns its answer."""
PERIOD = 0.02
"""s, between two looks of a move"""


class Flown(Protocol):
    """A vehicle as moves see it."""

    @property
    def quadrotor(self) -> Quadrotor:
        """Body and firmware."""

    @property
    def now(self) -> int:
        """ns, the simulator's clock"""

    @property
    def ideal(self) -> bool:
        """Whether to fly without AirSim's known mistakes."""


def command(vehicle: Flown, goal: Four, mode: Modes) -> None:
    """Tell the firmware its goals and what they mean."""
    vehicle.quadrotor.command(goal, mode, vehicle.now // 1_000_000)


class Polling:
    """The wait of a move, from when it is made.

    Args:
        vehicle: whose clock counts
        timeout: s
    """

    def __init__(self, vehicle: Flown, timeout: float) -> None:
        self.vehicle, self.timeout = vehicle, timeout
        self.start = vehicle.now

    def over(self) -> bool:
        """Return whether the time is up."""
        return (self.vehicle.now - self.start) * 1e-9 >= self.timeout

    def sleep(self) -> Move:
        """Wait until the next look; return false where the time is up or the move is cancelled."""
        return False if self.over() else (yield PERIOD)


def keep(vehicle: Flown, act: Callable[[], None], duration: float) -> Move:
    """Do something at every look for a duration (s); return whether it lasted that long."""
    polling = Polling(vehicle, duration)
    going = True
    while going:
        act()
        going = yield from polling.sleep()
    return polling.over()


def until(vehicle: Flown, done: Callable[[], bool], timeout: float) -> Move:
    """Do something at every look until it says that it is done; return whether it did within a timeout (s)."""
    polling = Polling(vehicle, timeout)
    going = timeout > 0
    while going:
        if done():
            return True
        going = yield from polling.sleep()
    return False
