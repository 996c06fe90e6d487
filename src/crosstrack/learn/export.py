"""From models of Stable-Baselines3 to policies."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from gymnasium import spaces
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.torch_layers import FlattenExtractor
from stable_baselines3.dqn import DQN
from stable_baselines3.sac import SAC
from torch import nn

from crosstrack.errors import InputError, Problem
from crosstrack.learn.training.networks import Dueling, Picture
from crosstrack.policy.card import Card, Continuous, Discrete, Kind, Layer, Observation
from crosstrack.policy.network import Floats
from crosstrack.policy.policy import Policy

ACTIVATIONS: dict[type[nn.Module], Literal["relu", "tanh"]] = {nn.ReLU: "relu", nn.Tanh: "tanh"}
TRANSPARENT = (nn.Flatten, nn.Identity, FlattenExtractor)
"""modules that change no number"""


@dataclass(frozen=True)
class Drawn:
    """A layer and its arrays, by the names of `card.Layer`'s parts."""

    layer: Layer
    parts: Mapping[str, Floats]


def policy_of(
    model: BaseAlgorithm,
    *,
    task: str,
    options: dict[str, Any],
    observation: Observation,
    algorithm: str,
    network: Kind,
    training: dict[str, Any],
    measured: dict[str, Any],
) -> Policy:
    """Return the policy that a model has learned, which takes its best action always.

    Args:
        model: PPO, A2C, SAC, DQN or RecurrentPPO, trained on float32 vectors
        task: name of what it was trained for
        options: of the task
        observation: what it sees
        algorithm: its name
        network: what kind it is called
        training: how it came about
        measured: how well it does

    Raises:
        InputError: its network has something that policies have not, or its actions are not in [-1, 1].
    """
    drawn = list(layers_of(model))
    arrays = {f"{one.layer.name}.{part}": values for one in drawn for part, values in one.parts.items()}
    architecture = tuple(one.layer for one in drawn)
    action = action_of(model.action_space)
    card = Card(task, options, observation, action, algorithm, network, architecture, training, measured)
    return Policy(card, arrays)


def action_of(space: spaces.Space[Any]) -> Discrete | Continuous:
    """Return what an action space is on a card.

    Raises:
        InputError: it is neither one of so many nor a vector in [-1, 1].
    """
    if isinstance(space, spaces.Discrete) and space.start == 0:
        return Discrete(int(space.n))
    if isinstance(space, spaces.Box) and len(space.shape) == 1 and (space.low == -1).all() and (space.high == 1).all():
        return Continuous(space.shape[0])
    raise InputError("export", [Problem("action", f"must be one of so many or a vector in [-1, 1], found {space}")])


def layers_of(model: BaseAlgorithm) -> Iterator[Drawn]:
    """Yield the layers through which a model decides, in order."""
    policy: Any = model.policy
    if isinstance(model, DQN):
        yield from values_of(policy.q_net)
    elif isinstance(model, SAC):
        actor = policy.actor
        yield from extractor(actor.features_extractor)
        yield from dense("latent_pi", actor.latent_pi)
        yield from squashed(policy, dense("mu", nn.Sequential(actor.mu)))
    else:
        yield from extractor(policy.pi_features_extractor)
        if hasattr(policy, "lstm_actor"):
            yield from lstm("lstm_actor", policy.lstm_actor)
        yield from dense("policy_net", policy.mlp_extractor.policy_net)
        yield from squashed(policy, dense("action_net", nn.Sequential(policy.action_net)))


def values_of(network: Any) -> Iterator[Drawn]:
    """Yield the layers of a network of values."""
    yield from extractor(network.features_extractor)
    if isinstance(network, Dueling):
        yield from dense("trunk", network.trunk)
        for stream in ("value", "advantage"):
            for drawn in dense(stream, getattr(network, stream)):
                yield Drawn(replace(drawn.layer, stream=stream), drawn.parts)
    else:
        yield from dense("q_net", network.q_net)


def squashed(policy: Any, layers: Iterator[Drawn]) -> Iterator[Drawn]:
    """Yield the last layers, behind a tanh where the policy bounds its actions with one."""
    for drawn in layers:
        yield Drawn(replace(drawn.layer, activation="tanh"), drawn.parts) if policy.squash_output else drawn


def extractor(module: nn.Module) -> Iterator[Drawn]:
    """Yield the layers of a features extractor."""
    if isinstance(module, Picture):
        yield from dense("picture", module.body)
    elif not isinstance(module, TRANSPARENT):
        raise unknown("features_extractor", module)


def dense(name: str, modules: nn.Module) -> Iterator[Drawn]:
    """Yield the layers of modules that follow one another, each with the activation behind it."""
    last: Drawn | None = None
    for index, module in enumerate(modules.children()):
        place = f"{name}.{index}"
        if type(module) in ACTIVATIONS and last is not None and last.layer.activation == "none":
            last = Drawn(replace(last.layer, activation=ACTIVATIONS[type(module)]), last.parts)
        elif isinstance(module, nn.Linear | nn.Conv2d):
            if last is not None:
                yield last
            last = Drawn(layer(place, module), {part: array(value) for part, value in module.state_dict().items()})
        elif not isinstance(module, TRANSPARENT):
            raise unknown(place, module)
    if last is not None:
        yield last


def layer(name: str, module: nn.Module) -> Layer:
    """Return what a linear layer or a convolution is on a card.

    Raises:
        InputError: it has no bias; or it is a convolution with padding, dilation, groups or unequal strides.
    """
    if module.bias is None:
        raise unknown(name, module)
    if not isinstance(module, nn.Conv2d):
        return Layer(name, "dense")
    plain = (module.padding, module.dilation, module.groups) == ((0, 0), (1, 1), 1)
    if not plain or len(set(module.stride)) > 1:
        raise unknown(name, module)
    return Layer(name, "convolution", stride=module.stride[0])


def lstm(name: str, module: nn.LSTM) -> Iterator[Drawn]:
    """Yield the layers of an LSTM; its two biases, which are only ever added, become one."""
    if module.bidirectional or module.proj_size or not module.bias:
        raise unknown(name, module)
    held = module.state_dict()
    for index in range(module.num_layers):
        weight, recurrent, first, second = (
            array(held[f"{kind}_l{index}"]) for kind in ("weight_ih", "weight_hh", "bias_ih", "bias_hh")
        )
        parts = {"input": weight, "hidden": recurrent, "bias": first + second}
        yield Drawn(Layer(f"{name}.{index}", "lstm"), parts)


def array(tensor: Any) -> Floats:
    """Return the numbers of a tensor, copied: training goes on with those of the tensor."""
    copied: Floats = tensor.detach().cpu().numpy().astype(np.float32, copy=True)
    return copied


def unknown(place: str, module: nn.Module) -> InputError:
    """Return the error about a module that has no counterpart in a policy."""
    return InputError("export", [Problem(place, f"no policy has a layer such as {module!r:.200}")])
