"""A training as it stands, in a file of plain arrays: nothing in it is ever unpickled."""

import json
import os
import random
import zipfile
from collections import deque
from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.base_class import BaseAlgorithm

from crosstrack.errors import InputError, Problem
from crosstrack.learn.stable import StableVector

NAME = "checkpoint.npz"
TREE = "tree"
"""the array that holds everything that is no array, as JSON"""
COUNTERS = (
    "num_timesteps", "_n_updates", "_episode_num", "_n_calls", "exploration_rate", "_current_progress_remaining",
)  # fmt: skip
"""attributes of models that change while they learn, where they have them"""
KEPT = ("_last_obs", "_last_episode_starts", "_last_original_obs", "_last_lstm_states", "log_ent_coef")
"""likewise, arrays"""
REPLAYED = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")
"""arrays of a replay buffer"""


def write(folder: Path, model: BaseAlgorithm, env: StableVector, document: dict[str, Any]) -> None:
    """Write a training as it stands after an update; a file that is there is replaced at once, or not at all.

    Args:
        folder: of the training
        model: what learns
        env: where it flies
        document: whatever else the training wants back, as JSON has it
    """
    arrays: dict[str, Any] = {}
    tree = pack(
        {
            "document": document,
            "parameters": model.get_parameters(),
            "counters": {name: getattr(model, name) for name in COUNTERS if hasattr(model, name)},
            "kept": {name: getattr(model, name) for name in KEPT if hasattr(model, name)},
            "replay": replay_of(model),
            "env": env.env.memory(),
            "episodes": list(model.ep_info_buffer or ()),
            "chance": chance(model),
        },
        arrays,
    )
    arrays[TREE] = np.frombuffer(json.dumps(tree).encode(), np.uint8)
    path = folder / NAME
    part = path.with_suffix(f".{os.getpid()}.part")
    with part.open("wb") as file:
        np.savez(file, **arrays)
        file.flush()
        os.fsync(file.fileno())
    part.replace(path)


def read(folder: Path) -> dict[str, Any]:
    """Return what a checkpoint holds.

    Raises:
        InputError: there is none, or it cannot be read.
    """
    path = folder / NAME
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as held:
            tree = json.loads(held[TREE].tobytes())
            found: dict[str, Any] = unpack(tree, held)
            return found
    except FileNotFoundError:
        raise InputError(str(path), [Problem("", "no such checkpoint: there is nothing to go on from")]) from None
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
        raise InputError(str(path), [Problem("", f"is no checkpoint that can be read: {error}")]) from None


def restore(model: BaseAlgorithm, env: StableVector, held: dict[str, Any]) -> None:
    """Put a model and its environment back to where a checkpoint was written."""
    model.set_parameters(held["parameters"])
    for name, value in held["counters"].items():
        setattr(model, name, value)
    for name, value in held["kept"].items():
        if name == "log_ent_coef" and value is not None:
            model.log_ent_coef.data.copy_(value)  # of SAC, where it is learned
        elif name == "_last_lstm_states" and value is not None:
            states = type(model._last_lstm_states)  # of RecurrentPPO
            setattr(model, name, states(*(tuple(part) for part in value)))
        else:
            setattr(model, name, value)
    if held["replay"]:
        refill(model, held["replay"])
    env.env.recall(held["env"])
    model.ep_info_buffer = deque(held["episodes"], maxlen=model._stats_window_size)
    model.ep_success_buffer = deque(maxlen=model._stats_window_size)
    rechance(model, held["chance"])


def replay_of(model: BaseAlgorithm) -> dict[str, Any]:
    """Return the part of a replay buffer that is filled; nothing where there is none."""
    buffer = getattr(model, "replay_buffer", None)
    if buffer is None:
        return {}
    filled = buffer.buffer_size if buffer.full else buffer.pos
    return {
        "pos": int(buffer.pos),
        "full": bool(buffer.full),
        **{name: getattr(buffer, name)[:filled] for name in REPLAYED},
    }


def refill(model: BaseAlgorithm, held: dict[str, Any]) -> None:
    """Fill a replay buffer."""
    buffer = model.replay_buffer  # of those that have one
    buffer.pos, buffer.full = held["pos"], held["full"]
    for name in REPLAYED:
        getattr(buffer, name)[: len(held[name])] = held[name]


def chance(model: BaseAlgorithm) -> dict[str, Any]:
    """Return the states of all random numbers that training draws from."""
    kind, keys, place, has_gauss, gauss = np.random.get_state()  # noqa: NPY002 - what Stable-Baselines3 draws from
    version, state, following = random.getstate()
    return {
        "torch": torch.get_rng_state(),
        "numpy": [kind, keys, place, has_gauss, gauss],
        "python": [version, np.array(state, np.int64), following],
        "actions": model.action_space.np_random.bit_generator.state,
    }


def rechance(model: BaseAlgorithm, held: dict[str, Any]) -> None:
    """Put all random numbers back."""
    torch.set_rng_state(held["torch"])
    np.random.set_state(tuple(held["numpy"]))  # noqa: NPY002 - what Stable-Baselines3 draws from
    version, state, following = held["python"]
    random.setstate((version, tuple(int(value) for value in state), following))
    model.action_space.np_random.bit_generator.state = held["actions"]


def pack(value: Any, arrays: dict[str, Any]) -> Any:
    """Return a tree of plain values as JSON has it; arrays and tensors go aside, and leave their names."""
    if isinstance(value, torch.Tensor):
        return {"tensor": pack(value.detach().cpu().numpy(), arrays)}
    if isinstance(value, np.ndarray):
        name = f"a{len(arrays)}"
        arrays[name] = value
        return {"array": name}
    if isinstance(value, dict):
        return {"pairs": [[key, pack(inner, arrays)] for key, inner in value.items()]}
    if isinstance(value, list | tuple | deque):
        return {"list": [pack(inner, arrays) for inner in value]}
    if isinstance(value, np.generic):
        return {"plain": value.item()}
    return {"plain": value}


def unpack(tree: Any, arrays: Any) -> Any:
    """Return what `pack` was given; tuples come back as lists."""
    ((kind, value),) = tree.items()
    if kind == "tensor":
        return torch.from_numpy(np.array(unpack(value, arrays)))
    if kind == "array":
        return arrays[value]
    if kind == "pairs":
        return {key: unpack(inner, arrays) for key, inner in value}
    if kind == "list":
        return [unpack(inner, arrays) for inner in value]
    return value
