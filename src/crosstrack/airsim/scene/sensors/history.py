"""What a vehicle did lately: sensors show the past."""

from bisect import bisect_right
from collections import deque

from crosstrack.airsim.structs import KinematicsState

KEPT = 256
"""instants: 5 s at the 20 ms at which they usually come"""


class History:
    """The last true states of a vehicle, relative to its start."""

    def __init__(self) -> None:
        self.times: deque[int] = deque(maxlen=KEPT)
        self.states: deque[KinematicsState] = deque(maxlen=KEPT)

    def clear(self) -> None:
        """Forget all."""
        self.times.clear()
        self.states.clear()

    def add(self, now: int, state: KinematicsState) -> None:
        """Take in the state at a time (ns), later than those before; one at the same time replaces the last."""
        if self.times and self.times[-1] >= now:
            self.times.pop()
            self.states.pop()
        self.times.append(now)
        self.states.append(state)

    def at(self, time: int) -> KinematicsState:
        """Return the state that is known nearest after a time (ns), or the last one."""
        place = bisect_right(self.times, time - 1)
        return self.states[min(place, len(self.states) - 1)]
