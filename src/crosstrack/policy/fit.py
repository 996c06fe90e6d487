"""Whether the arrays of a policy are what its card says."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crosstrack.errors import Problem
from crosstrack.policy.card import Card, Discrete, Layer, disagreements

PARTS = {"dense": ("weight", "bias"), "convolution": ("weight", "bias"), "lstm": ("input", "hidden", "bias")}
"""names of the arrays of a layer"""
STREAMS = ("trunk", "value", "advantage")
Size = tuple[int, ...] | None
"""of what passes between layers: (numbers,) or (channels, height, width); None where that cannot be told"""
Arrays = Mapping[str, NDArray[Any]]


def faults(card: Card, arrays: Arrays) -> list[Problem]:
    """Return everything in which arrays and card do not fit each other."""
    if wrong := disagreements(card):
        return wrong
    layers = card.architecture
    trunk, value, advantage = ([layer for layer in layers if layer.stream == name] for name in STREAMS)
    found = [*numbers(arrays), *order(card, value, advantage), *strays(layers, arrays)]
    size, entries = entering(card)
    size, wrong = through(trunk, size, entries, arrays)
    found += wrong
    if not value:
        return [*found, *end(trunk, size, card.outputs)]
    for stream, outputs in ((value, 1), (advantage, card.outputs)):
        last, wrong = through(stream, size, entries, arrays)
        found += [*wrong, *end(stream, last, outputs)]
    return found


def entering(card: Card) -> tuple[Size, int]:
    """Return the size of what enters the first layer, and how many numbers join later, behind convolutions."""
    picture, total = card.observation.picture, card.observation.size
    if picture and card.architecture[0].kind == "convolution":
        return (1, *picture), total - picture[0] * picture[1]
    return (total,), 0


def end(stream: Sequence[Layer], size: Size, outputs: int) -> list[Problem]:
    """Return whether a stream ends in another size than it must."""
    if not stream or size is None or size == (outputs,):
        return []
    return [Problem(f"{stream[-1].name}.bias", f"must be of shape {(outputs,)}, for the card's action; found {size}")]


def numbers(arrays: Arrays) -> list[Problem]:
    """Return which arrays do not hold finite float32."""
    found = []
    for name, array in arrays.items():
        if array.dtype != np.float32:
            found.append(Problem(name[:80], f"must be float32, found {array.dtype}"))
        elif not np.isfinite(array).all():
            found.append(Problem(name[:80], f"must be finite, found {array[~np.isfinite(array)][0]}"))
    return found


def strays(layers: Sequence[Layer], arrays: Arrays) -> list[Problem]:
    """Return which arrays are missing or belong to no layer."""
    wanted = [f"{layer.name}.{part}" for layer in layers for part in PARTS[layer.kind]]
    twice = sorted({name for name in wanted if wanted.count(name) > 1})
    return [
        *(Problem("architecture", f"two layers have the array {name!r}") for name in twice),
        *(Problem(name, "is missing") for name in wanted if name not in arrays),
        *(
            Problem(name[:80], "belongs to no layer of the card's architecture")
            for name in arrays
            if name not in wanted
        ),
    ]


def order(card: Card, value: Sequence[Layer], advantage: Sequence[Layer]) -> list[Problem]:
    """Return where layers stand that cannot be there."""
    found, before = list[Problem](), ""
    for index, layer in enumerate(card.architecture):
        place = f"architecture[{index}]"
        if layer.kind == "convolution":
            if not card.observation.picture:
                found.append(Problem(place, "a convolution needs a picture in the observation"))
            if before not in {"", "convolution"} or layer.stream != "trunk":
                found.append(Problem(place, "convolutions come before all other layers"))
        if layer.kind == "lstm" and layer.stream != "trunk":
            found.append(Problem(place, "an LSTM belongs in the trunk"))
        if layer.stream == "trunk" and any(other.stream != "trunk" for other in card.architecture[:index]):
            found.append(Problem(place, "the trunk comes before the two streams"))
        before = layer.kind
    if bool(value) != bool(advantage) or (value and not isinstance(card.action, Discrete)):
        found.append(Problem("architecture", "value and advantage go together, and with a discrete action"))
    if card.architecture[-1].kind != "dense":
        found.append(Problem("architecture", "the last layer must be dense"))
    return found


def through(layers: Sequence[Layer], size: Size, entries: int, arrays: Arrays) -> tuple[Size, list[Problem]]:
    """Return the size of what leaves a stream, and what does not fit on the way.

    Args:
        layers: of the stream
        size: of what enters
        entries: of the observation, which join what the convolutions give
        arrays: by name
    """
    found = list[Problem]()
    for layer in layers:
        if layer.kind != "convolution" and size is not None and len(size) == 3:
            size = (size[0] * size[1] * size[2] + entries,)
        size, wrong = passed(layer, size, arrays)
        found += wrong
    return size, found


def passed(layer: Layer, size: Size, arrays: Arrays) -> tuple[Size, list[Problem]]:
    """Return the size of what leaves a layer, and which of its arrays do not fit what enters."""
    names = {part: f"{layer.name}.{part}" for part in PARTS[layer.kind]}
    bias = arrays.get(names["bias"])
    if size is None or bias is None or any(name not in arrays for name in names.values()):
        return None, []
    count = len(bias) if bias.ndim == 1 else 0
    if not count or (layer.kind == "lstm" and count % 4):
        units = "(4 units,)" if layer.kind == "lstm" else "(outputs,)"
        return None, [Problem(names["bias"], f"must be of shape {units}, found {bias.shape}")]
    wanted, after = shapes(layer, size, count, arrays[names[PARTS[layer.kind][0]]].shape)
    found = [
        Problem(names[part], f"must be of shape {shape}, found {arrays[names[part]].shape}")
        for part, shape in wanted.items()
        if arrays[names[part]].shape != shape
    ]
    if after is not None and min(after) < 1:
        found.append(Problem(names["weight"], f"must be no larger than what enters, {size[1]} x {size[2]}"))
    return (None if found else after), found


def shapes(layer: Layer, size: tuple[int, ...], count: int, own: tuple[int, ...]) -> tuple[dict[str, Any], Size]:
    """Return the shapes that the weights of a layer must have, and the size of what leaves it.

    Args:
        layer: which
        size: of what enters
        count: numbers of its bias
        own: shape of its weights, which says how large a convolution is
    """
    if layer.kind == "lstm":
        return {"input": (count, *size), "hidden": (count, count // 4)}, (count // 4,)
    if layer.kind == "dense":
        return {"weight": (count, *size)}, (count,)
    kernel = own[2:] if len(own) == 4 else (1, 1)
    if len(size) != 3 or min(kernel) < 1:
        return {"weight": (count, size[0], "height", "width")}, None
    rows, columns = ((full - part) // layer.stride + 1 for full, part in zip(size[1:], kernel, strict=True))
    return {"weight": (count, size[0], *kernel)}, (count, rows, columns)
