"""What is drawn against time: one panel for every quantity, the same in the report and in the pictures."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from crosstrack.flight.flight import Flight
from crosstrack.flight.metrics import tilt
from crosstrack.show.avoiding import interventions
from crosstrack.show.style import ALARM, PALETTE, ROTORS
from crosstrack.types import Array

Role = Literal["flown", "planned", "asked", "limit"]
HEADROOM = 0.1
"""above the largest value, of the range of all"""


@dataclass(frozen=True)
class Series:
    """One line of a panel."""

    label: str
    values: Array
    """(n,) a value for every sample, NaN where there is none"""
    role: Role = "flown"
    """how the line is drawn"""
    color: str | None = None
    """None: the next of the palette"""


@dataclass(frozen=True)
class Panel:
    """One quantity against time. Its first series is the one that flights are compared by."""

    title: str
    unit: str
    series: tuple[Series, ...]
    from_zero: bool = True
    """whether the axis begins at zero"""
    span: float = 0.0
    """least range of the axis: variations far below it are no news"""
    names: tuple[str, ...] = ()
    """of the values 1, 2, ..., where the values stand for something"""

    @property
    def heading(self) -> str:
        """The title with the unit, where there is one"""
        return f"{self.title} ({self.unit})" if self.unit else self.title

    @property
    def colors(self) -> tuple[str, ...]:
        """Return the colour of every series."""
        colors = ROTORS if len(self.series) > 4 else PALETTE
        return tuple(series.color or color for series, color in zip(self.series, colors, strict=False))

    def headroom(self) -> list[float]:
        """Return the value above all others that an axis takes in, so that none runs along its end; or nothing."""
        values = self.finite()
        return [float(values.max() + HEADROOM * np.ptp(values))] if len(values) else []

    def finite(self) -> Array:
        """Return the finite values of all series, (n,)."""
        values = np.concatenate([series.values for series in self.series])
        finite: Array = values[np.isfinite(values)]
        return finite

    def range(self) -> tuple[float, float] | None:
        """Return the range of an axis of names, or of one that its values would leave below `span`; None elsewhere."""
        if self.names:
            return 0.4, len(self.names) + 0.6
        values = self.finite()
        if self.span == 0.0 or not len(values) or np.ptp(values) >= self.span:
            return None
        middle = float(values.min() + values.max()) / 2
        return middle - self.span / 2, middle + self.span / 2


def panels(flight: Flight, error: Array) -> list[Panel]:
    """Return the panels of a flight, given its cross-track error (n,) m."""
    return [
        Panel("Cross-track error", "m", (Series("cross-track error", error),)),
        *tracked(flight),
        speed(flight),
        height(flight),
        *accelerated(flight),
        *tilted(flight),
        *commanded(flight),
        *rotors(flight),
        *clearance(flight),
        *separation(flight),
        *avoided(flight),
        *wind(flight),
    ]


def tracked(flight: Flight) -> Iterator[Panel]:
    """Yield the distance to where the trajectory is by then, where there is one."""
    if flight.plan.course.trajectory is not None:
        error = np.where(first_course(flight), flight.tracking, np.nan)
        yield Panel("Distance to the trajectory's point", "m", (Series("tracking error", error),))


def first_course(flight: Flight) -> NDArray[np.bool_]:
    """Return which samples (n,) lie before the first course that was planned in flight, if any."""
    time = flight.record.time
    return time < flight.replans[0].time if flight.replans else np.ones(len(time), dtype=bool)


def by_then(flight: Flight, order: int) -> Array | None:
    """Return a derivative of the trajectory at every sample, (n, 3), NaN on later courses; None without one."""
    trajectory, time = flight.plan.course.trajectory, flight.record.time
    if trajectory is None:
        return None
    return np.where(first_course(flight)[:, None], trajectory(time - time[0], order), np.nan)


def speed(flight: Flight) -> Panel:
    """Return the speed flown, planned, and asked for; without a trajectory planned is the profile at the progress."""
    record, velocity = flight.record, by_then(flight, 1)
    if velocity is None:
        planned = np.where(first_course(flight), flight.plan.course.speed(record.progress), np.nan)
    else:
        planned = np.linalg.norm(velocity, axis=1)
    asked = np.linalg.norm(record.command_velocity, axis=1)
    series = [
        Series("flown", np.linalg.norm(record.velocity, axis=1)),
        Series("planned", planned, "planned"),
    ]
    if np.isfinite(asked).any():
        series.append(Series("asked for", asked, "asked"))
    return Panel("Speed", "m/s", tuple(series))


def height(flight: Flight) -> Panel:
    """Return the height flown, and of the trajectory or else of the course at the progress."""
    record, position = flight.record, by_then(flight, 0)
    planned = (flight.plan.course.path(record.progress) if position is None else position)[:, 2]
    planned = np.where(first_course(flight), planned, np.nan)
    series = (Series("flown", record.position[:, 2]), Series("course", planned, "planned"))
    return Panel("Height", "m", series, from_zero=False, span=1.0)


def accelerated(flight: Flight) -> Iterator[Panel]:
    """Yield the acceleration flown, between samples, and planned, where there is a trajectory."""
    record, acceleration = flight.record, by_then(flight, 2)
    if acceleration is None or len(record.time) < 2:
        return
    flown = np.linalg.norm(np.gradient(record.velocity, record.time, axis=0), axis=1)
    series = (Series("flown", flown), Series("planned", np.linalg.norm(acceleration, axis=1), "planned"))
    yield Panel("Acceleration", "m/s²", series)


def tilted(flight: Flight) -> Iterator[Panel]:
    """Yield the tilt, where the vehicle tilts."""
    angle = np.degrees(tilt(flight.record.attitude))
    if (angle > 0).any():
        yield Panel("Tilt", "°", (Series("tilt", angle),))


def commanded(flight: Flight) -> Iterator[Panel]:
    """Yield the thrust and the body rate asked for, where the tracker asks for them."""
    record = flight.record
    if np.isfinite(record.command_thrust).any():
        yield Panel("Thrust over mass", "m/s²", (Series("asked for", record.command_thrust, "asked"),))
    asked = np.linalg.norm(record.command_rate, axis=1)
    if np.isfinite(asked).any():
        flown = np.linalg.norm(record.rate, axis=1)
        yield Panel("Body rate", "rad/s", (Series("flown", flown), Series("asked for", asked, "asked")))


def rotors(flight: Flight) -> Iterator[Panel]:
    """Yield the speed of every rotor and their mean, where the vehicle has rotors."""
    speeds = flight.record.rotor_speeds
    if speeds.shape[1]:
        each = [Series(f"rotor {index + 1}", column) for index, column in enumerate(speeds.T)]
        yield Panel("Rotor speed", "rad/s", (Series("mean", speeds.mean(axis=1), "planned"), *each), from_zero=False)


def clearance(flight: Flight) -> Iterator[Panel]:
    """Yield the distance to the nearest obstacle, where there are any."""
    distance = flight.record.clearance
    if np.isfinite(distance).any():
        yield Panel("Clearance", "m", (Series("clearance", distance),))


def separation(flight: Flight) -> Iterator[Panel]:
    """Yield the distance to the nearest other vehicle, where there are any, and that at which two alike would touch."""
    distance = flight.record.separation
    if np.isfinite(distance).any():
        touch = np.full(len(distance), 2 * flight.plan.vehicle.radius)
        series = (Series("separation", distance), Series("sum of the radii", touch, "limit", ALARM))
        yield Panel("Distance to the nearest vehicle, between centres", "m", series)


def avoided(flight: Flight) -> Iterator[Panel]:
    """Yield when each avoider stepped in, where there are any: its number, over the time from sample to sample."""
    found = interventions(flight)
    if found:
        series = []
        for number, each in enumerate(found, 1):
            held = each.rows | np.append(each.rows[1:], False)
            series.append(Series(each.name, np.where(held, float(number), np.nan), color=each.color))
        yield Panel("Avoiders that stepped in", "", tuple(series), names=tuple(each.name for each in found))


def wind(flight: Flight) -> Iterator[Panel]:
    """Yield the wind speed, where there is wind."""
    strength = np.linalg.norm(flight.record.wind, axis=1)
    if (strength > 0).any():
        yield Panel("Wind", "m/s", (Series("wind", strength),))
