"""What all sensors have in common."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from crosstrack.airsim.scene.poses import from_angles, onto
from crosstrack.airsim.scene.section import Mounted, Section
from crosstrack.airsim.scene.sensors.history import History
from crosstrack.airsim.scene.sensors.timing import Sampling, Timing
from crosstrack.airsim.structs import Pose
from crosstrack.frames import Origin
from crosstrack.types import Array


class Enabled(Section):
    """A sensor of settings.json."""

    enabled: bool = False
    """a sensor that is listed must be enabled there"""


class Sight(Protocol):
    """What sensors look at: the scene without the vehicle that carries them."""

    def cast(self, origin: Array, directions: Array, reach: float) -> tuple[Array, NDArray[np.int64]]:
        """Return ranges (n,) m, inf beyond the reach, and numbers (n,) of what rays hit, -1 for nothing.

        Args:
            origin: (3,) m, NED
            directions: (n, 3) unit vectors, NED
            reach: m
        """


@dataclass(frozen=True)
class Moment:
    """What a sensor may know when it is read."""

    now: int
    """ns"""
    age: int
    """ns, since the sensors were restarted"""
    history: History
    """true states, relative to the start of the vehicle"""
    start: Array
    """(3,) m, world NED, of the vehicle"""
    origin: Origin
    """where the world's (0, 0, 0) lies on the Earth"""
    sight: Sight
    """what it looks at"""

    def world_pose(self, time: int, relative: Pose) -> Pose:
        """Return where in the world (NED) something on the vehicle was at a time (ns)."""
        state = self.history.at(time)
        return onto(Pose(state.position + self.start, state.orientation), relative)


def mounting(settings: Mounted) -> Pose:
    """Return the pose of a sensor on its vehicle; what was left out is 0."""
    position = np.nan_to_num([settings.x, settings.y, settings.z])
    return Pose(position, from_angles(settings.yaw, settings.pitch, settings.roll))


class Sensor(ABC):
    """A sensor that samples at instants of its own and shows the newest sample that is old enough."""

    def __init__(self, timing: Timing, random: np.random.Generator) -> None:
        self.sampling = Sampling(timing)
        self.random = random
        self.shown: tuple[int, Any] | None = None

    def restart(self) -> None:
        """Start anew, as after a reset."""
        self.shown = None

    def read(self, moment: Moment) -> Any:
        """Return what the sensor shows."""
        count = self.sampling.shown(moment.age)
        if count is None:
            return self.blank()
        if self.shown is None or self.shown[0] != count:
            before = 0 if self.shown is None else self.shown[0]
            time = moment.now - moment.age + self.sampling.when(count)
            self.shown = count, self.sample(moment, time, count, count - before)
        return self.shown[1]

    @abstractmethod
    def blank(self) -> Any:
        """Return what is shown before the first sample."""

    @abstractmethod
    def sample(self, moment: Moment, time: int, count: int, steps: int) -> Any:
        """Return a sample.

        Args:
            moment: what is known
            time: ns, of the sample
            count: which sample since the restart
            steps: how many after the one that was shown last
        """
