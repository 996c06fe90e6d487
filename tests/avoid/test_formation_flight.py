"""A formation flown around a tree: nobody is touched, the shape is given up for it and regained."""

import numpy as np
import pytest

import crosstrack as ct
from crosstrack.avoid.formation_shapes import shape_error, slots
from crosstrack.mission.flying import fly_together
from crosstrack.types import Outcome


@pytest.mark.slow
def test_a_v_passes_a_tree_and_is_a_v_again() -> None:
    places = slots("v", 3, 2.0)
    vehicles = [
        {
            "name": f"v{k}",
            "start": {"position": (np.array([0.0, 0, 2]) + place).tolist()},
            "route": [(np.array([20.0, 0, 2]) + place).tolist()],
        }
        for k, place in enumerate(places)
    ]
    tree = {"cylinder": {"center": [8.0, 0.1], "radius": 0.4, "z": [0, 5]}}
    mission = ct.from_document(
        {
            "vehicles": vehicles,
            "speed": 2.0,
            "world": {"shapes": [tree]},
            "avoid": [{"kind": "formation", "shape": "v", "spacing": 2.0}, {"kind": "safety"}],
            "replan": "never",
            "timing": {"timeout": 60},
        }
    )
    flights = fly_together(mission)
    assert {flight.outcome for flight in flights} == {Outcome.ARRIVED}
    assert min(np.min(flight.record.clearance) for flight in flights) >= 0.2
    assert min(np.min(flight.record.separation) for flight in flights) >= 0.4
    count = min(len(flight.record.time) for flight in flights)
    positions = np.stack([flight.record.position[:count] for flight in flights], axis=1)
    error, middle = shape_error(positions, places), positions.mean(axis=1)[:, 0]
    assert error[middle < 4].max() < 0.2
    assert error.max() > 0.2
    assert error[(middle > 15) & (middle < 18)].max() < 0.3
