"""Trackers and winds as a command line has them."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosstrack.campaign.words import tracker_document, tracker_words, wind_of
from crosstrack.errors import InputError
from crosstrack.types import Wind

NAMES = st.from_regex(r"[a-z_]{1,12}", fullmatch=True)
VALUES = st.one_of(
    st.floats(allow_nan=False, allow_infinity=False), st.integers(), st.lists(st.integers(), min_size=1, max_size=4)
)
TRACKERS = st.tuples(NAMES.filter(lambda name: name != "mission"), st.dictionaries(NAMES, VALUES, max_size=3))


def test_a_list_of_trackers_is_split_where_one_begins() -> None:
    text = "carrot, carrot:lookahead=2,heading_gain=0.8,mission,lqr:weights=[1, 2,3],speed=1,nlgl"
    assert tracker_words(text) == [
        "carrot", "carrot:lookahead=2,heading_gain=0.8", "mission", "lqr:weights=[1, 2,3],speed=1", "nlgl",
    ]  # fmt: skip


@settings(max_examples=40)
@given(st.lists(TRACKERS, min_size=1, max_size=4))
def test_what_is_written_is_read(trackers: list[tuple[str, dict[str, object]]]) -> None:
    words = [
        name + (":" if fields else "") + ",".join(f"{field}={value!r}" for field, value in fields.items())
        for name, fields in trackers
    ]
    assert tracker_words(",".join(words)) == words
    assert [tracker_document(word) for word in words] == [{"kind": name} | fields for name, fields in trackers]


def test_the_mission_keeps_its_own() -> None:
    assert tracker_document("mission") is None
    assert wind_of("mission", "enu") is None


@pytest.mark.parametrize(
    ("word", "message"),
    [
        ("carrot:", "'' must be FIELD=VALUE"),
        ("carrot:lookahead", "'lookahead' must be FIELD=VALUE"),
        ("carrot:=2", "'=2' must be FIELD=VALUE"),
        ("carrot:lookahead=2,lookahead=3", "lookahead is given twice"),
        ("carrot:kind=nlgl", "kind is given twice"),
        ("carrot:lookahead=[1", r"carrot:lookahead=\[1: lookahead: not YAML"),
        ("carrot:lookahead=!!a 1", r"carrot:lookahead=!!a 1: lookahead: YAML tags are not used"),
        ("", "trackers: must be the name of a tracker"),
        (":lookahead=2", "must be the name of a tracker"),
    ],
)
def test_what_is_no_tracker_is_refused(word: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        tracker_document(word)


def test_winds_are_turned_into_the_frame_of_the_mission() -> None:
    assert wind_of("calm", "enu") == Wind()
    assert wind_of("3,-1,0.5", "enu") == Wind((3, -1, 0.5))
    assert wind_of("3, -1, 0.5, moderate", "ned") == Wind((-1, 3, -0.5), "moderate")


@pytest.mark.parametrize(
    "word", ["", "3", "3,1", "3,1,2,strong", "3,1,light", "1,2,3,4", "a,b,c", "nan,0,0", "inf,0,0", "1e10,0,0"]
)
def test_what_is_no_wind_is_refused(word: str) -> None:
    with pytest.raises(InputError, match=r"must be mission, calm, E,N,U or E,N,U,GUSTS.*none, light, moderate, severe"):
        wind_of(word, "enu")
