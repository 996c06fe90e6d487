"""The grid of a comparison, checked as a whole before anything flies."""

from dataclasses import replace
from pathlib import Path

import pytest

import crosstrack as ct
from crosstrack import registry
from crosstrack.campaign.grid import MOST, fitting, grid
from crosstrack.campaign.task import state
from crosstrack.errors import InputError
from crosstrack.mission.load import from_document
from crosstrack.types import Wind
from crosstrack.vehicles.point import Point

HOP = ct.loads("{name: hop, start: {position: [0, 0, 5]}, route: [[4, 0], [4, 4]], speed: 3, vehicle: {kind: point}}")
NED = ct.loads(
    "{name: ned, frame: ned, start: {position: [0, 0, -5]}, route: [[4, 0, -5]], seed: 7, wind: {mean: [1, 2, 3]},"
    " tracker: {kind: carrot, lookahead: 2}}"
)
PLANNED = ct.loads(
    "{name: planned, start: {position: [0, 0, 5]}, route: [[9, 0], [9, 9]], planner: {kind: minimum_snap, guide: 0}}"
)


def test_every_mission_flies_with_every_tracker_in_every_wind_from_every_seed() -> None:
    tasks = grid([HOP, NED], ["mission", "carrot:lookahead=3", "mission"], ["mission", "1,0,0,light"], 3)
    assert len(tasks) == len({task.key for task in tasks}) == 2 * 2 * 2 * 3
    for task in tasks:
        labels, document = task.payload["labels"], task.payload["document"]
        flown, own = from_document(document), HOP if labels["mission"] == "hop" else NED
        kept = replace(flown, tracker=own.tracker, wind=own.wind, seed=own.seed)
        assert kept == own
        assert flown.seed == labels["seed"]
        assert flown.seed - own.seed in range(3)
        lookahead = own.document()["tracker"]["lookahead"] if labels["tracker"] == "mission" else 3
        assert document["tracker"]["lookahead"] == lookahead
        wind = own.enu.wind if labels["wind"] == "mission" else Wind((1, 0, 0), "light")
        assert flown.enu.wind == wind


def test_a_bare_name_is_the_tracker_with_its_defaults() -> None:
    (task,) = grid([NED], ["carrot"], ["calm"])
    assert from_document(task.payload["document"]).tracker == registry.find("tracker", "carrot")()


def test_a_task_changes_with_the_source_of_a_part_from_another_package(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    package = tmp_path / "elsewhere"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "mine.py").write_text(
        "from dataclasses import dataclass\n"
        "from crosstrack.follow.carrot import Carrot\n"
        "@dataclass(frozen=True)\n"
        "class Mine(Carrot):\n"
        "    pass\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setitem(registry.table("tracker"), "mine", "elsewhere.mine:Mine")
    keys = []
    for source in ("", "# changed", ""):
        (package / "gains.py").write_text(source)
        state.cache_clear()
        keys.append([task.key for task in grid([HOP], ["mine", "carrot"], ["calm"])])
    assert keys[0] == keys[2]
    assert keys[0][0] != keys[1][0]
    assert keys[0][1] == keys[1][1]


def test_all_that_is_wrong_is_said_at_once() -> None:
    words = ["carrot:lookahead=-1", "feed_forward", "carot", "carrot:lokahead=1"]
    with pytest.raises(InputError) as caught:
        grid([HOP, PLANNED], words, ["calm"])
    told = {(problem.place, problem.message.partition(":")[0]) for problem in caught.value.problems}
    assert told == {
        ("hop with carrot:lookahead=-1", "tracker.lookahead"),
        ("hop with feed_forward", "tracker"),
        ("hop with carot", "tracker.kind"),
        ("hop with carrot:lokahead=1", "tracker.lokahead"),
        ("planned with carrot:lookahead=-1", "tracker.lookahead"),
        ("planned with carot", "tracker.kind"),
        ("planned with carrot:lokahead=1", "tracker.lokahead"),
    }
    assert "did you mean 'carrot'?" in str(caught.value)


def test_words_and_sizes_are_wrong_whatever_the_missions() -> None:
    with pytest.raises(InputError) as caught:
        grid([HOP, HOP, replace(NED, seed=2**63 - 1)], ["carrot:lookahead"], ["windy", "gusty"], 2)
    places = [problem.place for problem in caught.value.problems]
    assert sorted(places) == ["carrot:lookahead", "gusty", "hop", "ned", "windy"]


@pytest.mark.parametrize(
    ("missions", "trackers", "seeds", "message"),
    [
        ([], ["carrot"], 1, "missions: at least one is needed"),
        ([HOP], [], 1, "trackers: at least one is needed"),
        ([HOP], ["carrot"], 0, "seeds: must be at least 1, found 0"),
        ([HOP], ["carrot"], MOST + 1, f"these are {MOST + 1} flights"),
    ],
)
def test_empty_and_endless_grids_are_refused(
    missions: list[ct.Mission], trackers: list[str], seeds: int, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        grid(missions, trackers, ["calm"], seeds)


def test_a_mission_that_cannot_be_planned_is_named() -> None:
    restless = replace(PLANNED, name="restless", vehicle=Point())
    with pytest.raises(InputError, match="restless: planner: plans from rest to rest"):
        grid([HOP, restless], ["carrot"], ["calm"])


def test_without_a_choice_every_tracker_that_fits_all_missions_is_compared() -> None:
    assert "feed_forward" not in fitting([HOP, PLANNED])
    assert {"carrot", "feed_forward"} <= set(fitting([PLANNED]))
    assert "mission" not in fitting([HOP]), "its own tracker is the registered one with its defaults"
    assert fitting([HOP, NED])[0] == "mission"
    assert fitting([HOP, PLANNED])[0] == "mission", "feed_forward is not among those that fit both"
