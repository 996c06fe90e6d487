"""The vector environment as Stable-Baselines3 wants it."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.vec_env.base_vec_env import VecEnv

from crosstrack.learn.vector import Floats, Vector

Indices = None | int | Sequence[int]


class StableVector(VecEnv):
    """Pass steps on; where an episode ended, what was seen last and whether it ran out of time."""

    def __init__(self, env: Vector) -> None:
        self.env = env
        self.actions: Any = None
        self.blank: list[dict[str, Any]] = [{} for _ in range(env.num_envs)]
        super().__init__(env.num_envs, env.single_observation_space, env.single_action_space)

    def reset(self) -> Floats:
        """Begin an episode of every vehicle, of the seed given to `seed` if any."""
        seed = self._seeds[0]
        self._reset_seeds()
        return self.env.reset(seed=seed)[0]

    def step_async(self, actions: NDArray[Any]) -> None:
        """Take the actions."""
        self.actions = actions

    def step_wait(self) -> tuple[Floats, Floats, NDArray[np.bool_], list[dict[str, Any]]]:
        """Fly them."""
        seen, reward, terminated, truncated, infos = self.env.step(self.actions)
        told = self.blank
        if infos:
            told = list(told)
            account = infos["episode"]
            for i in np.flatnonzero(infos["_episode"]):
                told[i] = {
                    "terminal_observation": infos["final_obs"][i],
                    "TimeLimit.truncated": bool(truncated[i]),
                    "episode": {name: values[i].item() for name, values in account.items()},
                }
        return seen, reward.astype(np.float32), terminated | truncated, told

    def close(self) -> None:
        """Nothing is left open."""

    def get_attr(self, attr_name: str, indices: Indices = None) -> list[Any]:
        """Return an attribute, the same for all vehicles."""
        return [getattr(self.env, attr_name)] * len(self._indices(indices))

    def set_attr(self, attr_name: str, value: Any, indices: Indices = None) -> None:
        """Refuse: the vehicles have no attributes of their own."""
        raise AttributeError(f"vehicles of a vector environment have no attribute of their own: {attr_name}")

    def env_method(self, method_name: str, *arguments: Any, indices: Indices = None, **options: Any) -> list[Any]:
        """Call a method of the vector environment once; return its result for each vehicle."""
        return [getattr(self.env, method_name)(*arguments, **options)] * len(self._indices(indices))

    def env_is_wrapped(self, wrapper_class: type, indices: Indices = None) -> list[bool]:
        """Say that it is not."""
        return [False] * len(self._indices(indices))

    def _indices(self, indices: Indices) -> Sequence[int]:
        """Return the indices meant."""
        if indices is None:
            return range(self.num_envs)
        return [indices] if isinstance(indices, int) else indices
