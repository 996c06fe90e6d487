"""Quadrotors that meet, flown: nobody touches, everybody arrives, at one height, by one law."""

import math
from typing import Any

import numpy as np
import pytest

import crosstrack as ct
from crosstrack.flight.flight import Flight
from crosstrack.mission.flying import fly_together
from crosstrack.types import Outcome

RADIUS, CRUISE = 10.0, 2.0
STRAIGHT = 2 * RADIUS / CRUISE + CRUISE / 8
"""s, 20 m at cruise, with the accelerations of the vehicle at either end"""


def swap(count: int, kick: float = 0.0, **more: Any) -> list[Flight]:
    """Fly from places on a circle, displaced by up to a kick (m), to those across it."""
    rng = np.random.default_rng(count)
    angles = 2 * math.pi * np.arange(count) / count
    start = RADIUS * np.column_stack([np.cos(angles), np.sin(angles)]) + rng.uniform(-kick, kick, (count, 2))
    vehicles = [
        {"name": f"v{k}", "start": {"position": [float(x), float(y), 3.0]}, "route": [[float(-x), float(-y), 3.0]]}
        for k, (x, y) in enumerate(start)
    ]
    document = {
        "vehicles": vehicles,
        "speed": CRUISE,
        "avoid": [{"kind": "orca"}],
        "replan": "never",
        "timing": {"timeout": 60},
        **more,
    }
    return fly_together(ct.from_document(document))


def check(flights: list[Flight]) -> None:
    assert {flight.outcome for flight in flights} == {Outcome.ARRIVED}
    assert max(flight.record.time[-1] for flight in flights) <= 4 * STRAIGHT
    assert min(np.min(flight.record.separation) for flight in flights) >= 0.4
    for flight in flights:
        assert np.abs(flight.record.position[:, 2] - 3.0).max() <= 0.1


def test_two_that_meet_pass_on_their_right() -> None:
    flights = swap(2)
    check(flights)
    # Seen along its way, each leaves the middle on its left.
    for flight in flights:
        way = flight.record.position[-1] - flight.record.position[0]
        right = np.array([way[1], -way[0], 0]) / np.linalg.norm(way)
        assert (flight.record.position @ right).max() >= 0.2


def test_eight_swap_places() -> None:
    check(swap(8))


def test_three_in_wind_with_noise_swap_places() -> None:
    flights = swap(3, kick=0.05, wind={"mean": [1.0, 0, 0], "gusts": "light"}, noise={"position": 0.01})
    assert {flight.outcome for flight in flights} == {Outcome.ARRIVED}
    assert min(np.min(flight.record.separation) for flight in flights) >= 0.4


@pytest.mark.slow
@pytest.mark.parametrize("count", [20, 50, 100])
def test_many_swap_places(count: int) -> None:
    check(swap(count))


@pytest.mark.slow
def test_twenty_from_uneven_places_swap() -> None:
    check(swap(20, kick=0.1))
