"""The forward pass of a network in numpy: float32, rows of observations at once."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from crosstrack.policy.card import Layer

Floats = NDArray[np.float32]
Arrays = Mapping[str, Floats]
Memory = tuple[Floats, ...]
"""of every LSTM in turn what it gave and its cells, each (n, units); empty where there is none"""


def start(layers: Sequence[Layer], arrays: Arrays, count: int) -> Memory:
    """Return the memory of `count` vehicles at the start of an episode: zeros."""
    units = [arrays[f"{layer.name}.hidden"].shape[1] for layer in layers if layer.kind == "lstm" for _ in range(2)]
    return tuple(np.zeros((count, size), np.float32) for size in units)


def outputs(
    layers: Sequence[Layer], arrays: Arrays, picture: tuple[int, int] | None, observations: Floats, memory: Memory
) -> tuple[Floats, Memory]:
    """Return what a network gives for observations (n, size), and its memory after them.

    With two streams that is Q = V + A - mean A (Wang et al., Dueling network architectures for deep reinforcement
    learning, 2016, equation 9).
    """
    value, entries = split(layers, picture, observations)
    later: Memory = ()
    streams: dict[str, Floats] = {}
    for layer in layers:
        before = streams.get(layer.stream, value)
        if layer.kind == "dense":
            weight, bias = arrays[f"{layer.name}.weight"], arrays[f"{layer.name}.bias"]
            after = activated(layer.activation, joined(before, entries) @ weight.T + bias)
        elif layer.kind == "convolution":
            weight, bias = arrays[f"{layer.name}.weight"], arrays[f"{layer.name}.bias"]
            after = activated(layer.activation, convolved(before, weight, bias, layer.stride))
        else:
            after, cells = lstm(layer, arrays, joined(before, entries), *memory[len(later) : len(later) + 2])
            later += (after, cells)
        if layer.stream == "trunk":
            value = after
        else:
            streams[layer.stream] = after
    if streams:
        advantage = streams["advantage"]
        value = streams["value"] + advantage - advantage.mean(axis=1, keepdims=True)
    return value, later


def split(
    layers: Sequence[Layer], picture: tuple[int, int] | None, observations: Floats
) -> tuple[Floats, Floats | None]:
    """Return pictures (n, 1, height, width) and the entries after them, where convolutions come first; else all."""
    if picture is None or layers[0].kind != "convolution":
        return observations, None
    pixels = picture[0] * picture[1]
    return observations[:, :pixels].reshape(-1, 1, *picture), observations[:, pixels:]


def joined(value: Floats, entries: Floats | None) -> Floats:
    """Return what enters a layer that takes rows of numbers: channels are flattened, other entries put after them."""
    if value.ndim == 2 or entries is None:
        return value
    return np.concatenate([value.reshape(len(value), -1), entries], axis=1)


def activated(activation: str, value: Floats) -> Floats:
    """Return a layer's numbers behind its activation, in place."""
    if activation == "relu":
        np.maximum(value, 0, out=value)
    elif activation == "tanh":
        np.tanh(value, out=value)
    return value


def convolved(value: Floats, weight: Floats, bias: Floats, stride: int) -> Floats:
    """Return the cross-correlation of pictures (n, channels, height, width) with kernels, at every `stride` px.

    Args:
        value: the pictures
        weight: (channels after, channels, kernel height, kernel width)
        bias: (channels after,)
        stride: px, along both sides
    """
    windows = sliding_window_view(value, weight.shape[2:], axis=(2, 3))[:, :, ::stride, ::stride]
    count, _, rows, columns = windows.shape[:4]
    patches = windows.transpose(0, 2, 3, 1, 4, 5).reshape(count * rows * columns, -1)
    made = patches @ weight.reshape(len(weight), -1).T + bias
    return made.reshape(count, rows, columns, -1).transpose(0, 3, 1, 2)


def lstm(layer: Layer, arrays: Arrays, value: Floats, given: Floats, cells: Floats) -> tuple[Floats, Floats]:
    """Return what an LSTM gives, and its cells, after one step (Hochreiter and Schmidhuber 1997, with forget gates).

    c' = σ(f) c + σ(i) tanh(g), h' = σ(o) tanh(c'), where (i, f, g, o) = W x + U h + b.

    Args:
        layer: which
        arrays: by name
        value: x (n, inputs)
        given: h (n, units), what it gave the step before
        cells: c (n, units)
    """
    weight, recurrent, bias = (arrays[f"{layer.name}.{part}"] for part in ("input", "hidden", "bias"))
    i, f, g, o = np.split(value @ weight.T + given @ recurrent.T + bias, 4, axis=1)
    later = sigmoid(f) * cells + sigmoid(i) * np.tanh(g)
    return activated(layer.activation, sigmoid(o) * np.tanh(later)), later


def sigmoid(value: Floats) -> Floats:
    """Return 1 / (1 + exp(-x)), as a tanh, which does not overflow."""
    half = np.float32(0.5)
    made: Floats = half + half * np.tanh(half * value)
    return made
