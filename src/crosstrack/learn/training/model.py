"""From what a training is told to a model of Stable-Baselines3."""

from dataclasses import asdict
from pathlib import Path
from typing import Any

from sb3_contrib import RecurrentPPO
from stable_baselines3 import A2C, PPO, SAC
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.buffers import NStepReplayBuffer, ReplayBuffer
from stable_baselines3.common.vec_env.base_vec_env import VecEnv

from crosstrack.learn.training.config import Training
from crosstrack.learn.training.dqn import DoubleDQN, Explorer
from crosstrack.learn.training.networks import ACTIVATIONS, DuelingPolicy, Picture

ALGORITHMS: dict[str, Any] = {"dqn": Explorer, "double-dqn": DoubleDQN, "ppo": PPO, "sac": SAC, "a2c": A2C}


def model_of(asked: Training, task: Any, env: VecEnv, logs: Path | None) -> BaseAlgorithm:
    """Return the model that a training improves.

    Args:
        asked: the training
        task: its task
        env: where it flies
        logs: folder of TensorBoard's logs; None for none
    """
    told = asdict(asked.learning)
    start, end = told.pop("learning_rate"), told.pop("final_learning_rate")
    told["learning_rate"] = start if end is None else lambda left: end + (start - end) * left
    if asked.algo in {"dqn", "double-dqn", "sac"}:
        told["train_freq"] = (told["train_freq"], "step")
        if told["n_steps"] == 1:
            del told["n_steps"]
            told["replay_buffer_class"] = ReplayBuffer
        else:
            steps = told.pop("n_steps")
            told["replay_buffer_class"] = NStepReplayBuffer
            told["replay_buffer_kwargs"] = {"n_steps": steps, "gamma": told["gamma"]}
    made: Any = RecurrentPPO if asked.network == "recurrent" else ALGORITHMS[asked.algo]
    return made(
        policy_of(asked),
        env,
        seed=asked.seed,
        device="cpu",
        tensorboard_log=None if logs is None else str(logs),
        policy_kwargs=network_of(asked, task),
        **told,
    )


def policy_of(asked: Training) -> Any:
    """Return the kind of network, as Stable-Baselines3 calls it."""
    if asked.network == "dueling":
        return DuelingPolicy
    return "MlpLstmPolicy" if asked.network == "recurrent" else "MlpPolicy"


def network_of(asked: Training, task: Any) -> dict[str, Any]:
    """Return what its network is told."""
    shape = asked.shape
    told: dict[str, Any] = {"net_arch": list(shape.layers), "activation_fn": ACTIVATIONS[shape.activation]}
    if asked.algo in {"ppo", "a2c"}:
        told["log_std_init"] = shape.log_std
    if asked.network == "recurrent":
        told["lstm_hidden_size"] = shape.memory
    if asked.network == "cnn":
        told["features_extractor_class"] = Picture
        told["features_extractor_kwargs"] = {
            "picture": tuple(task.picture),
            "channels": shape.channels,
            "kernel": shape.kernel,
            "stride": shape.stride,
        }
    return told
