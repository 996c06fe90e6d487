"""Cards: written, read back, and refused with everything that is wrong."""

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from policies import CARD, CARDS

from crosstrack.errors import InputError
from crosstrack.policy.card import LONGEST, Continuous, Discrete, from_json

WORDS = st.text(min_size=1, max_size=20)
NUMBERS = st.integers(-(2**60), 2**60) | st.floats(allow_nan=False, allow_infinity=False)
PLAIN = st.recursive(
    st.none() | st.booleans() | NUMBERS | st.text(max_size=10),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(WORDS, inner, max_size=3),
    max_leaves=10,
)
MAPPINGS = st.dictionaries(WORDS, PLAIN, max_size=4)


@settings(max_examples=100)
@given(st.sampled_from(sorted(CARDS)), WORDS, WORDS, MAPPINGS, MAPPINGS, MAPPINGS)
def test_cards_are_read_as_they_were_written(
    kind: str, task: str, algorithm: str, options: dict[str, Any], training: dict[str, Any], measured: dict[str, Any]
) -> None:
    card = replace(CARDS[kind], task=task, algorithm=algorithm, options=options, training=training, measured=measured)
    assert from_json("card", card.to_json()) == card


def test_a_card_is_json_with_a_version() -> None:
    document = json.loads(CARDS["cnn"].to_json())
    assert document["version"] == 1
    assert document["observation"] == {"size": 103, "slices": [["picture", 99], ["goal", 4]], "picture": [11, 9]}
    assert document["action"] == {"kind": "continuous", "size": 3}
    assert json.loads(CARDS["dueling"].to_json())["action"] == {"kind": "discrete", "count": 7}


def test_outputs_are_counted_by_the_action() -> None:
    assert replace(CARD, action=Discrete(27)).outputs == 27
    assert replace(CARD, action=Continuous(4)).outputs == 4


@pytest.mark.parametrize("value", [float("nan"), float("inf"), {1, 2}, object()])
def test_values_that_json_has_not_are_not_written(value: Any) -> None:
    with pytest.raises(InputError, match="card"):
        replace(CARD, measured={"speed": value}).to_json()


def test_a_card_that_could_not_be_read_is_not_written() -> None:
    with pytest.raises(InputError, match="must add up to the size, 5; found 4"):
        replace(CARD, observation=replace(CARD.observation, slices=(("goal", 4),))).to_json()


Change = Callable[[dict[str, Any]], Any]
WRONG: dict[str, tuple[Change, list[str]]] = {
    "no version": (lambda card: card.pop("version"), ["version: must be 1"]),
    "a later version": (lambda card: card.update(version=2, more=1), ["version: must be 1", "found 2"]),
    "true for a version": (lambda card: card.update(version=True), ["version: must be 1", "found true"]),
    "missing": (lambda card: card.pop("task"), ["task: is required"]),
    "extra": (lambda card: card.update(reward=1), ["reward: unknown"]),
    "extra inside": (lambda card: card["action"].update(low=1), ["action.low: unknown"]),
    "text for a number": (lambda card: card["observation"].update(size="5"), ["observation.size", "integer", '"5"']),
    "a number for text": (lambda card: card.update(task=5), ["task", "string", "found 5"]),
    "a fraction": (lambda card: card["action"].update(size=1.5), ["action.size", "integer", "1.5"]),
    "too few": (lambda card: card["action"].update(size=0), ["action.size", "greater than or equal to 1", "found 0"]),
    "a list for a mapping": (lambda card: card.update(options=[]), ["options", "found []"]),
    "an action of no kind": (lambda card: card["action"].pop("kind"), ["action", "discrete or continuous"]),
    "an action of another kind": (
        lambda card: card["action"].update(kind="both"),
        ["action", "discrete or continuous"],
    ),
    "a network of another kind": (lambda card: card.update(network="gru"), ["network", "recurrent", "gru"]),
    "a layer of another kind": (
        lambda card: card["architecture"][1].update(kind="pooling"),
        ["architecture[1].kind", "pooling"],
    ),
    "a layer without a name": (lambda card: card["architecture"][0].pop("name"), ["architecture[0].name: is required"]),
    "a layer whose name is a path": (
        lambda card: card["architecture"][0].update(name="../a"),
        ["architecture[0].name", "../a"],
    ),
    "no layers": (lambda card: card.update(architecture=[]), ["architecture", "must be 1 to 64 layers, found 0"]),
    "too many layers": (
        lambda card: card.update(architecture=65 * card["architecture"][:1]),
        ["architecture: must be 1 to 64 layers, found 65"],
    ),
    "a slice without a count": (
        lambda card: card["observation"].update(slices=[["goal"]]),
        ["observation.slices[0][1]: is required"],
    ),
    "slices that are too few": (
        lambda card: card["observation"].update(slices=[["goal", 3]]),
        ["observation.slices: must add up to the size, 5; found 3"],
    ),
    "a picture that is too large": (
        lambda card: card["observation"].update(picture=[2, 3]),
        ["observation.picture: must have at most 5 pixels", "2 x 3"],
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_cards_are_refused_with_the_place(name: str) -> None:
    change, words = WRONG[name]
    document = json.loads(CARD.to_json())
    change(document)
    with pytest.raises(InputError) as caught:
        from_json("best.npz", json.dumps(document))
    assert caught.value.source == "best.npz"
    assert len(caught.value.problems) == 1, str(caught.value)
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_all_problems_are_told_at_once() -> None:
    document = json.loads(CARD.to_json())
    document.update(task=5, reward=1)
    del document["algorithm"]
    document["architecture"][0]["stride"] = "wide"
    with pytest.raises(InputError) as caught:
        from_json("card", json.dumps(document))
    places = {problem.place for problem in caught.value.problems}
    assert places == {"task", "reward", "algorithm", "architecture[0].stride"}


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("", "not JSON"),
        ("[1]", "must be a mapping"),
        ('{"version": 1, "version": 1}', "given twice"),
        ('{"version": NaN}', "not a finite number"),
        ('{"version": 1e999}', "not a finite number"),
        ("[" * 100_000, "not JSON"),
        ('{"version": ' + "1" * 5000 + "}", "not JSON"),
        (" " * LONGEST + "{}", f"at most {LONGEST}"),
    ],
)
def test_text_that_is_no_card_is_refused(text: str, word: str) -> None:
    with pytest.raises(InputError) as caught:
        from_json("card", text)
    assert word in str(caught.value)
    assert len(str(caught.value)) < 400
