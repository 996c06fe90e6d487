"""When sensors sample: AirSim asks at every tick whether their interval is over."""

import math

import numpy as np

from crosstrack.airsim.scene.section import AtLeast, Section

TICK = 3_000_000
"""ns, of the clock that sensors see"""


class Timing(Section):
    """When a sensor samples, and how late it says so."""

    update_latency: AtLeast = 0.0
    """s"""
    update_frequency: AtLeast = 50.0
    """Hz; 0 for never"""
    startup_delay: AtLeast = 0.0
    """s, before the first sample"""


def ticks(seconds: float) -> int:
    """Return the first tick (ns) at which an interval (s) is over; in singles, as AirSim compares them."""
    return max(1, math.ceil(float(np.float32(seconds)) * 1e9 / TICK - 1e-6)) * TICK


class Sampling:
    """The instants at which a sensor samples since it was restarted."""

    def __init__(self, timing: Timing) -> None:
        self.period = ticks(1.0 / timing.update_frequency) if timing.update_frequency > 0.0 else 1 << 62
        self.first = ticks(timing.startup_delay) if timing.startup_delay > 0.0 else self.period
        self.latency = round(timing.update_latency * 1e9)

    def count(self, age: int) -> int:
        """Return how many samples there were in a time (ns) since the restart, the one at the restart left out."""
        return 0 if age < self.first else 1 + (age - self.first) // self.period

    def when(self, count: int) -> int:
        """Return the time (ns) since the restart of a sample; 0 is the one at the restart."""
        return 0 if count <= 0 else self.first + (count - 1) * self.period

    def shown(self, age: int) -> int | None:
        """Return the sample that is shown some time (ns) after the restart; None where there is none yet.

        What is shown changes at samples only, to the newest one that is as old as the latency then.
        """
        latest = self.count(age)
        if latest == 0:
            return 0 if self.latency == 0 else None
        return self.count(max(self.when(latest) - self.latency, 0))
