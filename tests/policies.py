"""Policies with weights at random, of every kind of network."""

from dataclasses import replace

import numpy as np

from crosstrack.policy.card import Card, Continuous, Discrete, Layer, Observation
from crosstrack.policy.network import Floats
from crosstrack.policy.policy import Policy

CARD = Card(
    task="avoid",
    options={"density": 0.1},
    observation=Observation(5, (("goal", 3), ("velocity", 2))),
    action=Continuous(3),
    algorithm="ppo",
    network="mlp",
    architecture=(Layer("a", "dense", "tanh"), Layer("b", "dense")),
    training={"steps": 1000, "seed": 1, "seconds": 1.5, "command": "crosstrack train avoid"},
    measured={"success": 0.5},
)
PICTURE = Observation(11 * 9 + 4, (("picture", 99), ("goal", 4)), (11, 9))
DUELING = (
    Layer("a", "dense", "relu"),
    Layer("v", "dense", "relu", stream="value"),
    Layer("w", "dense", stream="value"),
    Layer("x", "dense", "relu", stream="advantage"),
    Layer("y", "dense", stream="advantage"),
)
CONVOLUTIONS = (Layer("c", "convolution", "relu", 2), Layer("d", "convolution", "tanh"))
CARDS = {
    "mlp": CARD,
    "squashed": replace(CARD, architecture=(Layer("a", "dense", "relu"), Layer("b", "dense", "tanh"))),
    "dueling": replace(CARD, action=Discrete(7), network="dueling", architecture=DUELING),
    "cnn": replace(CARD, observation=PICTURE, network="cnn", architecture=(*CONVOLUTIONS, *CARD.architecture)),
    "recurrent": replace(
        CARD, network="recurrent", architecture=(Layer("l.0", "lstm"), Layer("l.1", "lstm"), *CARD.architecture)
    ),
    "dueling cnn": replace(
        CARD,
        action=Discrete(4),
        observation=PICTURE,
        network="cnn",
        architecture=(*CONVOLUTIONS, *DUELING[1:]),
    ),
}
"""one of every kind"""
WIDTH, UNITS, CHANNELS, KERNEL = 6, 4, 3, (3, 2)


def weights(card: Card, seed: int = 0) -> dict[str, Floats]:
    """Return weights at random for a card."""
    draw = np.random.default_rng(seed)
    arrays: dict[str, Floats] = {}
    picture, total = card.observation.picture, card.observation.size
    deep = picture is not None and card.architecture[0].kind == "convolution"
    size = [1, *picture] if picture and deep else [total]  # of what leaves the trunk
    entries = total - picture[0] * picture[1] if picture else 0
    inner: dict[str, list[int]] = {}
    last = {layer.stream: layer for layer in card.architecture}
    for layer in card.architecture:
        before = inner.get(layer.stream, size)
        if layer.kind == "convolution":
            shapes = {"weight": (CHANNELS, before[0], *KERNEL), "bias": (CHANNELS,)}
            after = [CHANNELS, *((n - k) // layer.stride + 1 for n, k in zip(before[1:], KERNEL, strict=True))]
        else:
            inputs = before[0] if len(before) == 1 else int(np.prod(before)) + entries
            ends = layer is last[layer.stream] and (layer.stream != "trunk" or len(last) == 1)
            outputs = (1 if layer.stream == "value" else card.outputs) if ends else WIDTH
            shapes, after = {"weight": (outputs, inputs), "bias": (outputs,)}, [outputs]
            if layer.kind == "lstm":
                shapes = {"input": (4 * UNITS, inputs), "hidden": (4 * UNITS, UNITS), "bias": (4 * UNITS,)}
                after = [UNITS]
        for part, shape in shapes.items():
            arrays[f"{layer.name}.{part}"] = draw.normal(0, 0.5, shape).astype(np.float32)
        if layer.stream == "trunk":
            size = after
        else:
            inner[layer.stream] = after
    return arrays


def policy(kind: str, seed: int = 0) -> Policy:
    """Return a policy of one kind of network."""
    return Policy(CARDS[kind], weights(CARDS[kind], seed))


def observations(card: Card, count: int, seed: int = 1) -> Floats:
    """Return observations at random, (count, size)."""
    return np.random.default_rng(seed).normal(size=(count, card.observation.size)).astype(np.float32)
