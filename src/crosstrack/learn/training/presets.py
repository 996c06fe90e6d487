"""What trainings begin from."""

from typing import Any

WIDE: dict[str, Any] = {"layers": [128, 128], "activation": "relu"}
SMOOTH: dict[str, Any] = {"layers": [128, 128], "activation": "tanh"}
Q_LEARNING: dict[str, Any] = {
    "steps": 3_000_000,
    "envs": 256,
    "shape": WIDE,
    "evaluating": {"every": 250_000, "episodes": 400},
    "learning": {
        "learning_rate": 3e-4,
        "batch_size": 1024,
        "gradient_steps": 4,
        "buffer_size": 1_000_000,
        "learning_starts": 50_000,
        "target_update_interval": 20_000,
        "exploration_fraction": 0.25,
        "exploration_final_eps": 0.03,
    },
}
TUNED: dict[str, dict[str, Any]] = {
    "dqn": Q_LEARNING,
    "double-dqn": Q_LEARNING,
    "ppo": {
        "steps": 8_000_000,
        "envs": 1024,
        "shape": SMOOTH,
        "evaluating": {"every": 1_000_000, "episodes": 400},
        "learning": {"learning_rate": 1e-3, "final_learning_rate": 0.0, "n_steps": 32, "n_epochs": 5},
    },
    "sac": {
        "steps": 1_800_000,
        "envs": 256,
        "shape": WIDE,
        "evaluating": {"every": 150_000, "episodes": 400},
        "learning": {
            "learning_rate": 7e-4,
            "final_learning_rate": 1e-4,
            "batch_size": 256,
            "gradient_steps": 4,
            "buffer_size": 1_000_000,
            "n_steps": 3,
            "ent_coef": 0.003,
        },
    },
    "a2c": {
        "steps": 20_000_000,
        "envs": 128,
        "shape": SMOOTH,
        "evaluating": {"every": 1_000_000, "episodes": 400},
        "learning": {"learning_rate": 1e-3, "final_learning_rate": 1e-4, "n_steps": 32},
    },
}
"""found by trying, by algorithm"""

STAGED: dict[str, Any] = TUNED["a2c"] | {
    "curriculum": [{"level": {"density": density}, "success": 0.8} for density in (0.0, 0.03, 0.06)]
}
"""`avoid`, from an empty world to the forest: else this learns that staying is better than colliding"""

ARTICLE: dict[str, Any] = {
    "steps": 1_000_000,
    "envs": 1,
    "shape": {"layers": [24, 24], "activation": "relu"},
    "evaluating": {"every": 100_000},
    "learning": {
        "learning_rate": 1e-3,
        "gamma": 0.95,
        "buffer_size": 2000,
        "learning_starts": 32,
        "batch_size": 32,
        "train_freq": 1,
        "gradient_steps": 1,
        "n_steps": 1,
        "target_update_interval": 1,
        "exploration_initial_eps": 1.0,
        "exploration_final_eps": 0.01,
        "exploration_factor": 0.995,
    },
}
"""the DQN of a tutorial that many have copied: a small network without a target network, a memory of 2000 decisions"""

PRESETS: dict[str, dict[str, dict[str, Any]]] = {
    "tuned": TUNED,
    "staged": {"a2c": STAGED},
    "article": {"dqn": ARTICLE},
}
"""by name and algorithm"""
