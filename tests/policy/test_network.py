"""What networks compute: against closed forms, scalar loops and scipy."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import ArrayLike
from policies import CARD, CARDS, observations, policy, weights
from scipy.signal import correlate

from crosstrack.policy.card import Continuous, Discrete, Layer, Observation
from crosstrack.policy.network import Arrays, Floats, convolved, lstm, sigmoid
from crosstrack.policy.policy import Policy


def floats(values: ArrayLike) -> Floats:
    return np.array(values, np.float32)


def test_relu_layers_give_what_is_computed_by_hand() -> None:
    card = replace(
        CARD,
        observation=Observation(2, (("both", 2),)),
        action=Discrete(2),
        architecture=(Layer("a", "dense", "relu"), Layer("b", "dense")),
    )
    arrays = {
        "a.weight": floats([[1, -2], [3, 1], [-1, -1]]),
        "a.bias": floats([0.5, -1, 0]),
        "b.weight": floats([[1, 2, 3], [0, -1, 5]]),
        "b.bias": floats([10, 20]),
    }
    made = Policy(card, arrays)
    # of (2, 1): relu(0.5, 6, -3) = (0.5, 6, 0), then (22.5, 14)
    # of (-1, 0): relu(-0.5, -4, 1) = (0, 0, 1), then (13, 25)
    values, memory = made.values(floats([[2, 1], [-1, 0]]), made.start(2))
    np.testing.assert_array_equal(values, [[22.5, 14], [13, 25]])
    assert memory == ()
    assert made.decide(floats([2, 1]), ()) == (0, ())
    assert made.decide(floats([-1, 0]), ()) == (1, ())


def test_continuous_actions_are_bounded() -> None:
    card = replace(CARD, observation=Observation(1, (("x", 1),)), architecture=(Layer("a", "dense"),))
    arrays = {"a.weight": floats([[1.0], [0.25], [-3.0]]), "a.bias": floats([0, 0, 0])}
    action, _ = Policy(card, arrays).decide(floats([2]), ())
    assert isinstance(action, np.ndarray)
    assert action.dtype == np.float64
    np.testing.assert_array_equal(action, [1, 0.5, -1])
    tanh = replace(card, architecture=(Layer("a", "dense", "tanh"),))
    action, _ = Policy(tanh, arrays).decide(floats([2]), ())
    np.testing.assert_allclose(action, [math.tanh(2), math.tanh(0.5), math.tanh(-6)], rtol=1e-6)


def test_streams_join_to_values_whose_mean_is_the_value() -> None:
    card = replace(
        CARD,
        observation=Observation(1, (("x", 1),)),
        action=Discrete(3),
        architecture=(
            Layer("a", "dense"),
            Layer("v", "dense", stream="value"),
            Layer("w", "dense", stream="advantage"),
        ),
    )
    arrays = {
        "a.weight": floats([[2]]),
        "a.bias": floats([1]),
        "v.weight": floats([[10]]),
        "v.bias": floats([0]),
        "w.weight": floats([[1], [2], [6]]),
        "w.bias": floats([0, 0, 3]),
    }
    # of 1: the trunk gives 3, V = 30, A = (3, 6, 21) with mean 10
    values, _ = Policy(card, arrays).values(floats([[1]]), ())
    np.testing.assert_array_equal(values, [[23, 26, 41]])


@settings(max_examples=60)
@given(
    st.integers(1, 3),
    st.integers(1, 3),
    st.tuples(st.integers(1, 4), st.integers(1, 4)),
    st.tuples(st.integers(0, 6), st.integers(0, 6)),
    st.integers(1, 3),
    st.integers(0, 2**32 - 1),
)
def test_convolutions_are_cross_correlations(
    before: int, after: int, kernel: tuple[int, int], more: tuple[int, int], stride: int, seed: int
) -> None:
    draw = np.random.default_rng(seed)
    shape = (2, before, kernel[0] + more[0], kernel[1] + more[1])
    value = draw.normal(size=shape).astype(np.float32)
    weight = draw.normal(size=(after, before, *kernel)).astype(np.float32)
    bias = draw.normal(size=after).astype(np.float32)
    made = convolved(value, weight, bias, stride)
    for picture, result in zip(value.astype(float), made, strict=True):
        whole = [correlate(picture, one.astype(float), "valid")[0] for one in weight]
        wanted = np.array(whole)[:, ::stride, ::stride] + bias[:, None, None]
        np.testing.assert_allclose(result, wanted, atol=1e-4)


def scalar_lstm(
    arrays: Arrays, x: list[float], h: list[float], c: list[float], name: str = "l"
) -> tuple[list[float], list[float]]:
    """Return what an LSTM gives and its cells, by loops over numbers in double precision."""
    units = len(h)

    def gate(row: int) -> float:
        total = float(arrays[f"{name}.bias"][row])
        for k, value in enumerate(x):
            total += float(arrays[f"{name}.input"][row, k]) * value
        for k, value in enumerate(h):
            total += float(arrays[f"{name}.hidden"][row, k]) * value
        return total

    def squash(value: float) -> float:
        return 1 / (1 + math.exp(-value))

    later, given = [], []
    for k in range(units):
        i, f, g, o = (gate(k + part * units) for part in range(4))
        cell = squash(f) * c[k] + squash(i) * math.tanh(g)
        later.append(cell)
        given.append(squash(o) * math.tanh(cell))
    return given, later


@settings(max_examples=30)
@given(st.integers(1, 4), st.integers(1, 5), st.integers(0, 2**32 - 1))
def test_an_lstm_gives_what_loops_over_numbers_give(inputs: int, units: int, seed: int) -> None:
    draw = np.random.default_rng(seed)
    shapes = {"l.input": (4 * units, inputs), "l.hidden": (4 * units, units), "l.bias": (4 * units,)}
    arrays = {name: draw.normal(size=shape).astype(np.float32) for name, shape in shapes.items()}
    h, c = np.zeros((1, units), np.float32), np.zeros((1, units), np.float32)
    given, cells = [0.0] * units, [0.0] * units
    for x in draw.normal(size=(6, 1, inputs)).astype(np.float32):
        h, c = lstm(Layer("l", "lstm"), arrays, x, h, c)
        given, cells = scalar_lstm(arrays, x[0].tolist(), given, cells)
        np.testing.assert_allclose(h[0], given, atol=1e-5)
        np.testing.assert_allclose(c[0], cells, atol=1e-5)


def test_each_lstm_has_a_memory_of_its_own() -> None:
    made = policy("recurrent")
    memory, held = made.start(), {"l.0": ([0.0] * 4, [0.0] * 4), "l.1": ([0.0] * 4, [0.0] * 4)}
    for x in observations(made.card, 6):
        passed = x.tolist()
        for name, (h, c) in held.items():
            held[name] = scalar_lstm(made.arrays, passed, h, c, name)
            passed = held[name][0]
        _, memory = made.decide(x, memory)
        wanted = [part for name in ("l.0", "l.1") for part in held[name]]
        np.testing.assert_allclose([part[0] for part in memory], wanted, atol=1e-5)


def test_a_cell_whose_gates_are_shut_keeps_what_it_holds() -> None:
    arrays = {"l.input": np.zeros((4, 1), np.float32), "l.hidden": np.zeros((4, 1), np.float32)}
    arrays["l.bias"] = floats([-1e4, 1e4, 3, -1e4])  # nothing enters, nothing is forgotten, nothing is given
    x, h, c = floats([[7]]), floats([[0.3]]), floats([[0.7]])
    for _ in range(50):
        h, c = lstm(Layer("l", "lstm"), arrays, x, h, c)
    assert (h.item(), c.item()) == (0, float(np.float32(0.7)))


def test_the_sigmoid_is_sound_at_any_size() -> None:
    value = floats([-1e38, -100, -2, 0, 2, 100, 1e38])
    wanted = [0, 0, 1 / (1 + math.exp(2)), 0.5, 1 / (1 + math.exp(-2)), 1, 1]
    np.testing.assert_allclose(sigmoid(value), wanted, atol=1e-7)


@pytest.mark.parametrize("kind", CARDS)
def test_many_vehicles_decide_as_each_alone(kind: str) -> None:
    made = policy(kind)
    seen = np.stack([observations(made.card, 5, seed) for seed in range(4)])
    memory, alone = made.start(5), [made.start() for _ in range(5)]
    for row in seen:
        values, _ = made.values(row, memory)
        actions, memory = made.decide_many(row, memory)
        for vehicle in range(5):
            single, _ = made.values(row[vehicle : vehicle + 1], alone[vehicle])
            np.testing.assert_allclose(single[0], values[vehicle], atol=1e-5)
            action, alone[vehicle] = made.decide(row[vehicle], alone[vehicle])
            np.testing.assert_allclose(action, actions[vehicle], atol=1e-5)


@pytest.mark.parametrize("kind", CARDS)
def test_deciding_changes_nothing_that_was_passed(kind: str) -> None:
    made = policy(kind)
    seen, memory = observations(made.card, 3), made.decide_many(observations(made.card, 3, 2), made.start(3))[1]
    held = [seen.copy(), *(array.copy() for array in memory)]
    first, _ = made.decide_many(seen, memory)
    again, _ = made.decide_many(seen, memory)
    np.testing.assert_array_equal(first, again)
    for array, copy in zip([seen, *memory], held, strict=True):
        np.testing.assert_array_equal(array, copy)


def test_what_a_recurrent_policy_saw_before_matters_until_its_rows_are_cleared() -> None:
    made = policy("recurrent")
    seen = observations(made.card, 2)
    fresh, _ = made.values(seen, made.start(2))
    _, memory = made.decide_many(observations(made.card, 2, 5), made.start(2))
    for array in memory:
        array[0] = 0
    later, _ = made.values(seen, memory)
    np.testing.assert_array_equal(later[0], fresh[0])
    assert np.abs(later[1] - fresh[1]).max() > 1e-3


@pytest.mark.parametrize("kind", CARDS)
def test_actions_are_of_the_kind_that_the_card_says(kind: str) -> None:
    made = policy(kind, seed=3)
    actions, _ = made.decide_many(10 * observations(made.card, 200), made.start(200))
    if isinstance(made.card.action, Continuous):
        assert actions.shape == (200, made.card.action.size)
        assert (np.abs(actions) <= 1).all()
    else:
        assert actions.shape == (200,)
        assert set(actions.tolist()) <= set(range(made.card.action.count))
        assert len(set(actions.tolist())) > 1


def test_a_picture_without_convolutions_is_seen_as_numbers() -> None:
    observation = Observation(6, (("picture", 4), ("x", 2)), (2, 2))
    card = replace(CARD, observation=observation, action=Continuous(1), architecture=(Layer("a", "dense"),))
    arrays = {"a.weight": floats([[0.01, 0.02, 0.03, 0.04, 0.05, 0.06]]), "a.bias": floats([0])}
    action, _ = Policy(card, arrays).decide(floats([1, 2, 3, 4, 5, 6]), ())
    np.testing.assert_allclose(action, [0.91], rtol=1e-6)


def test_convolutions_see_rows_as_rows_and_entries_come_last() -> None:
    observation = Observation(8, (("picture", 6), ("x", 2)), (2, 3))
    layers = (Layer("c", "convolution"), Layer("a", "dense"))
    card = replace(CARD, observation=observation, network="cnn", action=Continuous(1), architecture=layers)
    arrays = {
        "c.weight": floats([[1, 10]]).reshape(1, 1, 1, 2),  # (2, 3) to (2, 2): p + 10 times its right neighbour
        "c.bias": floats([0]),
        "a.weight": floats([[1, 0, 0, 0, 0, 0]]),
        "a.bias": floats([0]),
    }
    found = []
    for place in range(6):
        arrays["a.weight"] = np.eye(6, dtype=np.float32)[place : place + 1]
        values, _ = Policy(card, arrays).values(floats([[1, 2, 3, 4, 5, 6, 7, 8]]), ())
        found.append(values.item())
    assert found == [21, 32, 54, 65, 7, 8]


def test_weights_at_random_fit_their_cards() -> None:
    for card in CARDS.values():
        assert Policy(card, weights(card)).card is card
