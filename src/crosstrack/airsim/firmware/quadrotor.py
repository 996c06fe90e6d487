"""One served vehicle as Python sees it: the fields of its row, and what its firmware can be told."""

from collections.abc import Sequence
from typing import Any

from crosstrack.airsim.firmware import rows as table
from crosstrack.airsim.firmware.rows import ARMED, ARMING, DISARMED, RATE_MODE, UNSET, Rows
from crosstrack.airsim.firmware.sticks import IDLE
from crosstrack.types import Array

Four = tuple[float, float, float, float]
Modes = tuple[int, int, int, int]


class Quadrotor:
    """A row of a table of vehicles, whose fields are arrays into it.

    Args:
        rows: (n,) of `crosstrack.airsim.firmware.rows.ROW`
        index: which of them
    """

    def __init__(self, rows: Rows, index: int) -> None:
        self.bind(rows, index)

    def bind(self, rows: Rows, index: int) -> None:
        """Look at a row of another table."""
        self.rows, self.index = rows, index
        self.row: Any = rows[index : index + 1]
        self.position, self.velocity = rows["position"][index], rows["velocity"][index]
        self.attitude, self.rate = rows["attitude"][index], rows["rate"][index]
        self.acceleration, self.spin_up = rows["acceleration"][index], rows["spin_up"][index]
        self.output = rows["output"][index]
        self._goal, self._mode = rows["goal"][index], rows["mode"][index]

    def __getitem__(self, name: str) -> Any:
        """Return a field of the row."""
        return self.row[name][0]

    def __setitem__(self, name: str, value: object) -> None:
        """Set a field of the row."""
        self.row[name][0] = value

    def reset(self, time: int, armed: int) -> None:
        """Put it back to where it started, north, with its firmware as switched on at a time (ms)."""
        table.reset(self.rows, self.index, time, armed)

    def command(self, goal: Four, mode: Modes, time: int) -> None:
        """Set goals and what they mean, in the firmware's order of axes, at a time (ms); ignored without control."""
        row = self.row
        if row["controlled"][0]:
            self._goal[:], self._mode[:] = goal, mode
            row["goal_time"][0], row["timed_out"][0] = time, False

    def take_control(self, on: bool) -> None:
        """Give control to the API, or back to the sticks; it begins with the goals of the sticks."""
        self["controlled"] = on
        if on:
            self._goal[:], self._mode[:] = self["stick_goal"], self["stick_mode"]

    def arm(self, on: bool) -> bool:
        """Arm or disarm; return whether that was possible: the API must be in control, and the state fit.

        Goals are taken disarmed as well, and fly the vehicle: only the sticks need it armed.
        """
        armed = self["armed"]
        fit = armed != ARMING if on else armed in (ARMED, ARMING)
        if not self["controlled"] or not fit:
            return False
        if not on or armed != ARMED:
            self["armed"] = ARMED if on else DISARMED
            self._goal[:], self._mode[:] = (0.0, 0.0, 0.0, IDLE if on else 0.0), RATE_MODE
        return True

    def set_gains(self, loop: int, gains: Array) -> None:
        """Set proportional, integral and derivative gains of a loop, (3, 4), and start all loops again."""
        self["gains"][:, loop] = gains
        self["active"] = UNSET

    def sticks(self, channels: Sequence[float], connected: bool) -> None:
        """Move the sticks: roll, pitch, yaw, throttle, switches 0 and 1; or take them away."""
        self["connected"] = connected
        if connected:
            self["channels"] = channels
