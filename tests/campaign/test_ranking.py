"""Rankings worked out by hand."""

import json
from typing import Any

import pytest

from crosstrack.campaign.compare import Comparison
from crosstrack.campaign.ranking import Loss, Spread, ranking


def flown(tracker: str, rms: float | None, arrived: bool = True, **more: Any) -> dict[str, Any]:
    numbers = {
        "arrived": arrived, "collided": False, "cross_track_rms_captured_m": rms,
        "cross_track_max_captured_m": None if rms is None else 3 * rms, "tracking_rms_m": None,
        "time_ratio": 1.1 if arrived else None,
    }  # fmt: skip
    labels = {"mission": more.pop("mission", "hop"), "tracker": tracker, "wind": "calm", "seed": 1}
    return {"labels": labels, "summary": numbers | more, "trace": {}, "route": []}


def test_arrivals_come_before_the_median_error() -> None:
    results = [
        *(flown("steady", rms) for rms in (0.5, 0.1, 0.9)),
        *(flown("precise", rms, arrived=rms < 0.03) for rms in (0.01, 0.02, 0.03)),
        *(flown("best", rms) for rms in (0.3, 0.2, 9.0)),
    ]
    rows = ranking(results)
    assert [row.tracker for row in rows] == ["best", "steady", "precise"]
    assert rows[0].cross_track_rms == Spread(0.3, 0.2, 9.0)
    assert rows[0].cross_track_max == 27.0
    assert [row.arrived for row in rows] == [3, 3, 2]
    assert rows[2].time_ratio == Spread(1.1, 1.1, 1.1)


def test_never_captured_is_worse_than_any_error_and_lost_flights_did_not_arrive() -> None:
    results = [flown("never", None), flown("wide", 50.0), flown("half", 0.1), flown("half", None), flown("shaky", 0.1)]
    rows = ranking(results, [Loss({"tracker": "shaky"}, "died"), Loss({"tracker": "gone"}, "died")])
    assert [row.tracker for row in rows] == ["wide", "never", "half", "shaky", "gone"]
    assert (rows[3].flights, rows[3].arrived, rows[3].lost) == (2, 1, 1)
    assert (rows[4].flights, rows[4].cross_track_rms, rows[4].time_ratio) == (1, None, None)


def test_equal_medians_are_ranked_by_tracking_error_then_in_order() -> None:
    results = [
        flown("b", 0.1),
        flown("a", 0.1),
        flown("c", 0.1, tracking_rms_m=0.5),
        flown("d", 0.1, tracking_rms_m=0.4),
    ]
    assert [row.tracker for row in ranking(results)] == ["d", "c", "b", "a"]


def test_where_all_fly_a_trajectory_its_error_decides() -> None:
    precise, wide = flown("precise", 0.2, tracking_rms_m=0.01), flown("wide", 0.1, tracking_rms_m=0.3)
    assert [row.tracker for row in ranking([wide, precise])] == ["precise", "wide"]
    assert [row.tracker for row in ranking([wide, precise, flown("untimed", 0.15)])] == ["wide", "untimed", "precise"]
    late = flown("precise", 0.2, arrived=False, tracking_rms_m=0.01)
    assert [row.tracker for row in ranking([precise, late, wide])] == ["wide", "precise"]


def test_a_comparison_ranks_every_mission_and_all_and_is_json() -> None:
    results = [
        flown("a", 0.1, mission="hop"), flown("b", 0.2, mission="hop"),
        flown("a", None, mission="eight"), flown("b", 0.2, mission="eight", collided=True, arrived=False),
    ]  # fmt: skip
    loss = Loss({"mission": "eight", "tracker": "c", "wind": "calm", "seed": 2}, "ValueError: no")
    document = Comparison(tuple(results), (loss,)).document()
    said = json.loads(json.dumps(document, allow_nan=False))
    assert [row["tracker"] for row in said["missions"]["hop"]] == ["a", "b"]
    assert [row["tracker"] for row in said["missions"]["eight"]] == ["a", "b", "c"]
    assert said["missions"]["eight"][0]["cross_track_rms"] == {"median": None, "least": None, "greatest": None}
    assert said["missions"]["eight"][1]["collided"] == 1
    assert said["lost"] == [{"labels": dict(loss.labels), "error": "ValueError: no"}]
    assert said["flights"] == 5


def test_nothing_ranks_nothing() -> None:
    assert ranking([]) == []
    assert Comparison(()).document() == {"flights": 0, "ranking": [], "missions": {}, "lost": []}


def test_the_table_has_a_row_for_every_flight(tmp_path: Any) -> None:
    loss = Loss({"mission": "hop", "tracker": "c:a=1,b=2", "wind": "1,0,0", "seed": 2}, 'broken: "x"\nand more')
    Comparison((flown("a", 0.1), flown("b", None)), (loss,)).write_csv(tmp_path / "results.csv")
    pandas_like = (tmp_path / "results.csv").read_text()
    assert pandas_like.splitlines()[0].startswith("mission,tracker,wind,seed,arrived,collided,")
    assert pytest.approx(0.1) == float(pandas_like.splitlines()[1].split(",")[6])
