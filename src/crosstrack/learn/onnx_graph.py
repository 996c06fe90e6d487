"""Policies as ONNX, for runtimes other than numpy."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import onnx
from numpy.typing import NDArray
from onnx import TensorProto, helper, numpy_helper

from crosstrack.policy.card import Continuous, Layer
from crosstrack.policy.policy import Policy

OPSET, IR = 17, 8
"""old enough for runtimes of 2022"""
FLOAT = TensorProto.FLOAT
GATES = (0, 3, 1, 2)
"""of ONNX, input, output, forget, cell, among those of a policy, input, forget, cell, output"""
ACTIVATIONS = {"relu": "Relu", "tanh": "Tanh"}


def to_onnx(policy: Policy, path: str | Path) -> None:
    """Write a policy as an ONNX model.

    It takes `observation` (batch, size) float32 and gives `action`, int64 (batch,) or float32 (batch, size) in [-1, 1].
    The LSTM number k also takes `given_k` and `cells_k` (batch, units), zeros at first, and gives `next_given_k` and
    `next_cells_k`. The card is the model's metadata `card`.

    Raises:
        InputError: its card holds values that JSON has not.
        OSError: the file cannot be written.
    """
    onnx.save(model_of(policy), str(path))


def model_of(policy: Policy) -> Any:
    """Return the ONNX model of a policy."""
    card, draft = policy.card, Draft(policy.arrays)
    draft.takes("observation", card.observation.size)
    value = network(draft, card.architecture, card.observation.picture)
    if isinstance(card.action, Continuous):
        low, high = draft.constant(np.array(-1, np.float32)), draft.constant(np.array(1, np.float32))
        draft.add("Clip", [value, low, high], "action")
        draft.given.append(helper.make_tensor_value_info("action", FLOAT, ["batch", card.outputs]))
    else:
        draft.add("ArgMax", [value], "action", axis=1, keepdims=0)
        draft.given.append(helper.make_tensor_value_info("action", TensorProto.INT64, ["batch"]))
    graph = helper.make_graph(draft.nodes, "policy", draft.taken, draft.given, draft.constants)
    made = helper.make_model(graph, opset_imports=[helper.make_opsetid("", OPSET)], ir_version=IR)
    made.producer_name = "crosstrack"
    helper.set_model_props(made, {"card": card.to_json()})
    onnx.checker.check_model(made)
    return made


@dataclass
class Draft:
    """A graph that grows."""

    arrays: Any
    """of the policy, by name"""
    nodes: list[Any] = field(default_factory=list)
    constants: list[Any] = field(default_factory=list)
    taken: list[Any] = field(default_factory=list)
    given: list[Any] = field(default_factory=list)

    def add(self, kind: str, inputs: list[str], name: str = "", **attributes: Any) -> str:
        """Add a node, and return the name of what it gives."""
        name = name or f"value_{len(self.nodes)}"
        self.nodes.append(helper.make_node(kind, inputs, [name], **attributes))
        return name

    def constant(self, values: NDArray[Any]) -> str:
        """Add numbers, and return their name."""
        name = f"constant_{len(self.constants)}"
        self.constants.append(numpy_helper.from_array(np.ascontiguousarray(values), name))
        return name

    def whole(self, *numbers: int) -> str:
        """Add whole numbers, and return their name."""
        return self.constant(np.array(numbers, np.int64))

    def takes(self, name: str, size: int) -> str:
        """Add an input (batch, size), and return its name."""
        self.taken.append(helper.make_tensor_value_info(name, FLOAT, ["batch", size]))
        return name

    def part(self, layer: Layer, part: str) -> NDArray[np.float32]:
        """Return an array of a layer."""
        array: NDArray[np.float32] = self.arrays[f"{layer.name}.{part}"]
        return array


def network(draft: Draft, layers: tuple[Layer, ...], picture: tuple[int, int] | None) -> str:
    """Add all layers, and return the name of what they give; see `policy.network.outputs`."""
    value, entries = "observation", ""
    if picture and layers[0].kind == "convolution":
        value, entries = split(draft, picture)
    deep, memories = bool(entries), 0
    streams: dict[str, str] = {}
    for layer in layers:
        before = streams.get(layer.stream, value)
        if layer.kind != "convolution" and deep:
            value = before = draft.add("Concat", [draft.add("Flatten", [before], axis=1), entries], axis=1)
            deep = False
        after = lstm(draft, layer, before, memories) if layer.kind == "lstm" else weighed(draft, layer, before)
        memories += layer.kind == "lstm"
        after = draft.add(ACTIVATIONS[layer.activation], [after]) if layer.activation != "none" else after
        if layer.stream == "trunk":
            value = after
        else:
            streams[layer.stream] = after
    if not streams:
        return value
    mean = draft.add("ReduceMean", [streams["advantage"]], axes=[1], keepdims=1)
    return draft.add("Add", [streams["value"], draft.add("Sub", [streams["advantage"], mean])])


def split(draft: Draft, picture: tuple[int, int]) -> tuple[str, str]:
    """Add the parting of an observation, and return the names of picture and entries."""
    pixels, end, axis = draft.whole(picture[0] * picture[1]), draft.whole(np.iinfo(np.int64).max), draft.whole(1)
    flat = draft.add("Slice", ["observation", draft.whole(0), pixels, axis])
    entries = draft.add("Slice", ["observation", pixels, end, axis])
    return draft.add("Reshape", [flat, draft.whole(-1, 1, *picture)]), entries


def weighed(draft: Draft, layer: Layer, value: str) -> str:
    """Add a dense layer or a convolution, and return the name of what it gives."""
    inputs = [value, draft.constant(draft.part(layer, "weight")), draft.constant(draft.part(layer, "bias"))]
    if layer.kind == "dense":
        return draft.add("Gemm", inputs, transB=1)
    return draft.add("Conv", inputs, strides=[layer.stride, layer.stride])


def lstm(draft: Draft, layer: Layer, value: str, number: int) -> str:
    """Add an LSTM with its memory in and out, and return the name of what it gives."""
    units = draft.part(layer, "hidden").shape[1]
    bias = reordered(draft.part(layer, "bias"))
    weights = [reordered(draft.part(layer, part))[np.newaxis] for part in ("input", "hidden")]
    both = np.concatenate([bias, np.zeros_like(bias)])[np.newaxis]  # ONNX has two biases too
    axis = draft.whole(0)
    before = [draft.takes(f"{name}_{number}", units) for name in ("given", "cells")]
    sequence, given, cells = (draft.add("Unsqueeze", [name, axis]) for name in (value, *before))
    inputs = [sequence, *map(draft.constant, (*weights, both)), "", given, cells]
    later = [f"last_given_{number}", f"last_cells_{number}"]
    draft.nodes.append(helper.make_node("LSTM", inputs, ["", *later], hidden_size=units))
    for name, wide in zip(("given", "cells"), later, strict=True):
        draft.add("Squeeze", [wide, axis], f"next_{name}_{number}")
        draft.given.append(helper.make_tensor_value_info(f"next_{name}_{number}", FLOAT, ["batch", units]))
    return f"next_given_{number}"


def reordered(gates: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return rows of gates in the order of ONNX."""
    return gates.reshape(4, -1, *gates.shape[1:])[list(GATES)].reshape(gates.shape)
