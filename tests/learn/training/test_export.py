"""Policies decide as the models of Stable-Baselines3 that they come from, and as their ONNX does."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from policies import CARDS, observations, policy

from crosstrack.errors import InputError
from crosstrack.policy.card import Kind, Observation
from crosstrack.policy.file import from_bytes, to_bytes
from crosstrack.policy.network import Floats
from crosstrack.policy.policy import Policy

pytestmark = pytest.mark.slow

KINDS: dict[str, Kind] = {
    "mlp": "mlp",
    "dueling": "dueling",
    "cnn": "cnn",
    "recurrent": "recurrent",
    "dueling cnn": "cnn",
}
HEIGHT, WIDTH, REST = 24, 32, 6
FLAT = Observation(12, (("state", 12),))
DEEP = Observation(HEIGHT * WIDTH + REST, (("picture", HEIGHT * WIDTH), ("state", REST)), (HEIGHT, WIDTH))


def world(observation: Observation, choices: int = 0) -> Any:
    """Return an environment with these observations, and with actions that are counted or three numbers."""
    import gymnasium

    class World(gymnasium.Env[Any, Any]):
        """Reward for nothing in particular."""

        observation_space = gymnasium.spaces.Box(-np.inf, np.inf, (observation.size,), np.float32)
        action_space: Any = (
            gymnasium.spaces.Discrete(choices) if choices else gymnasium.spaces.Box(-1, 1, (3,), np.float32)
        )

        def reset(self, *, seed: int | None = None, options: Any = None) -> tuple[Floats, dict[str, Any]]:
            super().reset(seed=seed)
            return self.seen(), {}

        def step(self, action: Any) -> tuple[Floats, float, bool, bool, dict[str, Any]]:
            return self.seen(), float(np.mean(action)), bool(self.np_random.random() < 0.1), False, {}

        def seen(self) -> Floats:
            return self.np_random.normal(size=observation.size).astype(np.float32)

    return World()


def made(algorithm: str, network: str, choices: int, activation: str) -> tuple[Any, Observation]:
    """Return a model that has learned a little, so that all of its weights have moved."""
    import sb3_contrib
    import stable_baselines3 as sb3

    from crosstrack.learn.training.networks import ACTIVATIONS, DuelingPolicy, Picture

    observation = DEEP if network in {"cnn", "dueling cnn"} else FLAT
    options: dict[str, Any] = {"net_arch": [16, 8], "activation_fn": ACTIVATIONS[activation]}
    if observation.picture:
        options["features_extractor_class"] = Picture
        options["features_extractor_kwargs"] = {
            "picture": observation.picture,
            "channels": (4, 6),
            "kernel": 4,
            "stride": 2,
        }
    kind: Any = DuelingPolicy if network.startswith("dueling") else "MlpPolicy"
    common: dict[str, Any] = {"policy_kwargs": options, "seed": 3, "device": "cpu"}
    env = world(observation, choices)
    if network == "recurrent":
        options |= {"lstm_hidden_size": 10, "n_lstm_layers": 2}
        model: Any = sb3_contrib.RecurrentPPO("MlpLstmPolicy", env, n_steps=32, batch_size=32, **common)
    elif algorithm == "ppo":
        model = sb3.PPO(kind, env, n_steps=32, batch_size=32, **common)
    elif algorithm == "a2c":
        model = sb3.A2C(kind, env, **common)
    else:
        model = {"dqn": sb3.DQN, "sac": sb3.SAC}[algorithm](kind, env, learning_starts=20, buffer_size=100, **common)
    return model.learn(64), observation


def exported(model: Any, observation: Observation, algorithm: str, network: str) -> Policy:
    from crosstrack.learn.export import policy_of

    return policy_of(
        model,
        task="avoid",
        options={},
        observation=observation,
        algorithm=algorithm,
        network=KINDS[network],
        training={"steps": 64},
        measured={},
    )


CASES = [
    ("ppo", "mlp", 0, "tanh"),
    ("ppo", "mlp", 5, "relu"),
    ("ppo", "cnn", 0, "relu"),
    ("ppo", "recurrent", 0, "tanh"),
    ("ppo", "recurrent", 5, "relu"),
    ("a2c", "mlp", 0, "tanh"),
    ("a2c", "cnn", 4, "tanh"),
    ("sac", "mlp", 0, "relu"),
    ("sac", "cnn", 0, "tanh"),
    ("dqn", "mlp", 27, "relu"),
    ("dqn", "dueling", 27, "relu"),
    ("dqn", "cnn", 4, "relu"),
    ("dqn", "dueling cnn", 4, "tanh"),
]


def outputs_of(model: Any, seen: Floats, state: Any) -> Floats:
    """Return the numbers from which a model takes its action, by its own torch modules."""
    import torch

    rows = torch.as_tensor(seen)
    policy: Any = model.policy
    with torch.no_grad():
        if hasattr(policy, "q_net"):
            result = policy.q_net(rows)
        elif hasattr(policy, "actor"):
            result = policy.actor(rows, deterministic=True)
        elif hasattr(policy, "lstm_actor"):
            states = tuple(torch.as_tensor(part) for part in state)
            result, _ = policy.get_distribution(rows, states, torch.zeros(len(rows)))
        else:
            result = policy.get_distribution(rows)
        if hasattr(result, "distribution"):
            of = result.distribution
            result = of.mean if hasattr(of, "loc") else of.logits - of.logits.mean(dim=1, keepdim=True)
    numbers: Floats = np.asarray(result)
    return numbers


@pytest.mark.parametrize(("algorithm", "network", "choices", "activation"), CASES)
def test_a_policy_decides_as_its_model(algorithm: str, network: str, choices: int, activation: str) -> None:
    model, observation = made(algorithm, network, choices, activation)
    flown = from_bytes("best.npz", to_bytes(exported(model, observation, algorithm, network)))
    memory, state = flown.start(6), None
    if network == "recurrent":
        state = (np.zeros((2, 6, 10), np.float32), np.zeros((2, 6, 10), np.float32))
    for step in range(5):
        seen = observations(flown.card, 6, step)
        wanted, values = outputs_of(model, seen, state), flown.values(seen, memory)[0]
        if algorithm != "dqn" and choices:  # logits are known but for a number that is common to all
            values = values - values.mean(axis=1, keepdims=True)
        np.testing.assert_allclose(values, wanted, atol=1e-5, rtol=1e-5)
        actions, memory = flown.decide_many(seen, memory)
        predicted, state = model.predict(seen, state, deterministic=True)
        np.testing.assert_allclose(actions, predicted, atol=1e-5)


def test_what_is_learned_later_does_not_change_a_policy() -> None:
    model, observation = made("ppo", "mlp", 0, "tanh")
    before = exported(model, observation, "ppo", "mlp")
    held = {name: array.copy() for name, array in before.arrays.items()}
    model.learn(64)
    for name, array in before.arrays.items():
        np.testing.assert_array_equal(array, held[name])
    after = exported(model, observation, "ppo", "mlp")
    assert any((after.arrays[name] != array).any() for name, array in held.items())


def modules(*others: Callable[[], Any]) -> Any:
    """Return a model whose network has modules that policies have not."""
    from torch import nn

    model, observation = made("dqn", "mlp", 4, "relu")
    model.policy.q_net.q_net = nn.Sequential(nn.Linear(observation.size, 4), *(other() for other in others))
    return model


def test_networks_that_no_policy_has_are_refused() -> None:
    from torch import nn

    for other in (nn.GELU, lambda: nn.LayerNorm(4), lambda: nn.Linear(4, 4, bias=False)):
        with pytest.raises(InputError, match=r"q_net\.1: no policy has a layer such as"):
            exported(modules(other), FLAT, "dqn", "mlp")
    padded = modules()
    padded.policy.q_net.q_net = nn.Sequential(nn.Conv2d(1, 2, 3, padding=1))
    with pytest.raises(InputError, match=r"q_net\.0: no policy has a layer such as Conv2d"):
        exported(padded, FLAT, "dqn", "mlp")


def test_actions_beyond_one_are_refused() -> None:
    import gymnasium

    from crosstrack.learn.export import action_of

    for space in (
        gymnasium.spaces.Box(-2, 2, (3,)),
        gymnasium.spaces.Box(-1, 1, (3, 2)),
        gymnasium.spaces.MultiDiscrete([3, 3, 3]),
        gymnasium.spaces.Discrete(3, start=1),
    ):
        with pytest.raises(InputError, match=r"one of so many or a vector in \[-1, 1\]"):
            action_of(space)


@pytest.mark.parametrize("kind", CARDS)
def test_onnx_decides_as_numpy(kind: str, tmp_path: Path) -> None:
    import onnxruntime

    from crosstrack.learn.onnx_graph import to_onnx

    flown = policy(kind)
    to_onnx(flown, tmp_path / "best.onnx")
    session = onnxruntime.InferenceSession(tmp_path / "best.onnx", providers=["CPUExecutionProvider"])
    assert session.get_modelmeta().custom_metadata_map["card"] == flown.card.to_json()
    memory = flown.start(4)
    names = [name for k in range(len(memory) // 2) for name in (f"given_{k}", f"cells_{k}")]
    assert [one.name for one in session.get_inputs()] == ["observation", *names]
    held = dict(zip(names, memory, strict=True))
    for step in range(5):
        seen = observations(flown.card, 4, step)
        actions, memory = flown.decide_many(seen, memory)
        wanted = ["action", *(f"next_{name}" for name in names)]
        found, *later = session.run(wanted, {"observation": seen, **held})
        np.testing.assert_allclose(found, actions, atol=1e-5)
        for own, other in zip(memory, later, strict=True):
            np.testing.assert_allclose(other, own, atol=1e-5)
        held = dict(zip(names, later, strict=True))
