"""Simulated time: in fixed steps, as fast as wall time times the clock speed, or in lockstep with the client.

**In lockstep** the clock stands still while nothing is under way. It advances, as fast as the machine can, while a long
call waits for its answer and nothing is paused, and by what simContinueForTime asks for. The rest of a step by which
that was overrun is taken off the next time, so that many short steps add up.
"""

import math
import time

TICK = 3_000_000
"""ns, of one step of physics and firmware"""
LATE = 0.1
"""s of wall time by which the clock may lag behind and still catch up; what is more is lost"""
FRAME = 1 / 60
"""s, of one rendered frame, for simContinueForFrames"""
FOREVER = 2**62
"""ns"""


class Clock:
    """The time of a simulator.

    Args:
        speed: of simulated time; as in AirSim, a speed above one counts as a whole number, and below one the steps
            become shorter
        lockstep: whether it advances only as the client asks
        start: ns since 1970; None for the wall clock, or for zero in lockstep
    """

    def __init__(self, speed: float = 1.0, lockstep: bool = False, start: int | None = None) -> None:
        self.lockstep = lockstep
        self.speed = float(math.floor(speed)) if speed >= 1 else speed
        self.tick = TICK if speed >= 1 else round(TICK * speed)
        self.now = start if start is not None else (0 if lockstep else time.time_ns())
        self.paused = False
        self.until: int | None = None
        """ns, when to pause again; None where it is not running for a time"""
        self._overrun = 0
        self._anchor: tuple[float, int] | None = None

    def pause(self, on: bool) -> None:
        """Stop the clock, or let it run; either ends a run for a time."""
        self.paused, self.until, self._anchor = on, None, None
        if not on:
            self._overrun = 0

    def run_for(self, seconds: float) -> None:
        """Let it run for a time and pause then: simulated seconds in lockstep, seconds of wall time otherwise."""
        span = max(seconds, 0.0) * (1.0 if self.lockstep else self.speed)
        end = self.now + round(min(span * 1e9, FOREVER)) - self._overrun
        self.pause(False)
        self.until = end
        self.advance(0)

    def advance(self, steps: int) -> None:
        """Move on by steps; pause at the end of a run for a time."""
        self.now += steps * self.tick
        if self.until is not None and self.now >= self.until:
            overrun = self.now - self.until
            self.pause(True)
            self._overrun = overrun

    def running(self, waiting: bool) -> bool:
        """Return whether it advances, given whether a long call waits."""
        if self.paused:
            return False
        return not self.lockstep or waiting or self.until is not None

    def due(self, most: int) -> int:
        """Return how many steps are due by now, at most `most`."""
        if self.until is not None:
            most = min(most, max(-(-(self.until - self.now) // self.tick), 1))
        if self.lockstep:
            return most
        wall = time.monotonic()
        if self._anchor is None or self._lag(wall) > LATE:
            self._anchor = wall, self.now
        return min(most, max(int(self._lag(wall) * self.speed * 1e9 / self.tick), 0))

    def _lag(self, wall: float) -> float:
        assert self._anchor is not None
        began, then = self._anchor
        return (wall - began) - (self.now - then) * 1e-9 / self.speed

    def wait(self) -> float:
        """Return how long (s of wall time) until the next step is due."""
        if self.lockstep or self._anchor is None:
            return 0.0
        return max(self.tick * 1e-9 / self.speed - self._lag(time.monotonic()), 0.0)
