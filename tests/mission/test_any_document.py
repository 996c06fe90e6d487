"""Whatever a document holds, it is a mission or it is refused."""

import copy
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosstrack.errors import InputError
from crosstrack.mission import from_document, loads

BASE: dict[str, Any] = {
    "name": "x",
    "start": {"position": [0, 0, 10], "yaw": 0},
    "route": [[20, 0, 10], [20, 20, 10]],
    "world": {
        "bounds": [[-60, -60, 0], [90, 90, 60]],
        "ground": 0,
        "shapes": [
            {"box": {"min": [1, 1, 1], "max": [2, 2, 2]}},
            {"prism": {"polygon": [[5, 5], [6, 5], [6, 6]], "z": [0, 1]}},
        ],
        "image": None,
        "generate": {"kind": "forest", "seed": 1, "size": [3, 3, 3], "origin": [50, 50]},
    },
    "vehicle": {"kind": "quadrotor"},
    "tracker": {"kind": "carrot", "lookahead": 1.5},
    "timing": {"rate": 50},
    "origin": {"latitude": 3},
    "avoid": [],
}
ODD = st.sampled_from(
    [None, True, -1, 10**400, 10**25, float("nan"), float("-inf"), 1e308, 5e-324, b"x", np.eye(2), "", "x", "a/b",
     "\ud800", "\0", [], [1], [[1]], {}, {"": 1}, {1: 2}, {"kind": 1}, {"kind": ["a"]}, {"kind": "gap", "z": 1},
     {"file": "/etc/passwd"}, {"file": "\0"}]
)  # fmt: skip


def holds(value: Any, key: Any) -> bool:
    return key in value if isinstance(value, dict) else isinstance(value, list) and key in range(len(value))


def places(value: Any, place: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [place, *(found for key, child in inner for found in places(child, (*place, key)))]


@settings(max_examples=150)
@given(st.lists(st.tuples(st.sampled_from(places(BASE)[1:]), ODD), min_size=1, max_size=3))
def test_whatever_is_put_anywhere_the_mission_is_refused_or_can_be_built(
    changes: list[tuple[tuple[Any, ...], Any]],
) -> None:
    document = copy.deepcopy(BASE)
    for (*outer, last), value in changes:
        target: Any = document
        for key in outer:
            target = target[key] if holds(target, key) else None
        if holds(target, last):
            target[last] = copy.deepcopy(value)
    try:
        mission = from_document(document)
    except InputError:
        return
    assert mission.build().route.length > 0


@given(st.text())
def test_any_text_is_a_mission_or_refused(text: str) -> None:
    with pytest.raises(InputError):
        loads(text)
