"""Drawing a flight into AirSim's world while it is flown: the path, the points chased, the trail."""

from typing import TYPE_CHECKING

import numpy as np

from crosstrack.airsim.client.errors import RemoteError
from crosstrack.errors import LinkLost
from crosstrack.flight.effort import Effort
from crosstrack.flight.observer import Observer, Sample
from crosstrack.flight.plan import Plan
from crosstrack.frames import ned_from_enu
from crosstrack.types import Array, Outcome
from crosstrack.vehicles.airsim.vehicle import AirSim

if TYPE_CHECKING:
    from crosstrack.airsim.client.blocking import Client

ASKED, PLANNED, CHASED, FLOWN = (0.0, 1.0, 0.0, 1.0), (0.2, 0.4, 1.0, 1.0), (1.0, 0.6, 0.0, 1.0), (1.0, 0.0, 0.0, 1.0)
"""red, green, blue, opacity: of the waypoints, the course, the point chased, the trail"""
THICK, POINT, WAYPOINT = 5.0, 12.0, 25.0
"""of lines and points, in AirSim's units"""
SPACING = 0.2
"""m, between the points of the course that are drawn"""
MOST = 2000
OFTEN = 0.1
"""s, between two chased points"""
TIMEOUT = 1.5
"""s"""


class Drawing(Observer):
    """Draw one flight over a connection of its own; where that breaks, nothing more is drawn."""

    def __init__(self, vehicle: AirSim) -> None:
        self.vehicle = vehicle
        self.client: Client | None = None
        self.plan: Plan | None = None
        self.due = 0.0

    def begin(self, plan: Plan) -> None:
        """Take note of what is planned; it is drawn when the vehicle is there."""
        self.plan = plan

    def draw(self, plan: Plan) -> None:
        """Draw what is planned."""
        from crosstrack.airsim.client.blocking import Client  # noqa: PLC0415 - takes long to import, and few missions need it

        self.client = Client(self.vehicle.host, self.vehicle.port, timeout=TIMEOUT)
        points = ned_from_enu(plan.route.points)
        self.client.plot_points(list(points), ASKED, WAYPOINT, -1.0, True)
        self.line(sampled(plan), PLANNED)
        self.client.set_trace_line(FLOWN, THICK, plan.scenario.name or self.vehicle.name)

    def sample(self, row: Sample) -> None:
        """Draw the point chased, and a new course."""
        plan, self.plan = self.plan, None
        try:
            if plan is not None:
                self.draw(plan)
            if row.course is not None:
                self.line(row.course, PLANNED)
            if self.client is not None and row.time >= self.due:
                self.due = row.time + OFTEN
                self.client.plot_points([ned_from_enu(row.aim)], CHASED, POINT, OFTEN, False)
        except (LinkLost, RemoteError):
            self.close()

    def end(self, outcome: Outcome, effort: Effort) -> None:
        """Close the connection."""
        self.close()

    def close(self) -> None:
        """Draw no more."""
        if self.client is not None:
            self.client.close()
            self.client = None

    def line(self, points: Array, colour: tuple[float, float, float, float]) -> None:
        """Draw a line through points (n, 3) m, to stay."""
        if self.client is not None and len(points) > 1:
            self.client.plot_line_strip(list(ned_from_enu(points)), colour, THICK, -1.0, True)


def sampled(plan: Plan) -> Array:
    """Return points (n, 3) m along the course."""
    path = plan.course.path
    return path(np.linspace(0.0, path.length, min(MOST, 2 + round(path.length / SPACING))))


def drawing(plan: Plan) -> list[Observer]:
    """Return what draws a flight, where its vehicle has something to draw in and is asked to."""
    return [Drawing(plan.vehicle)] if isinstance(plan.vehicle, AirSim) and plan.vehicle.draw else []
