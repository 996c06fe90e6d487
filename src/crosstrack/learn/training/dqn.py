"""Deep Q-learning for many vehicles at once."""

from typing import Any

import numpy as np
import torch
from stable_baselines3 import DQN
from stable_baselines3.common.type_aliases import ReplayBufferSamples
from torch.nn import functional


class Explorer(DQN):
    """DQN whose vehicles explore each on its own: with probability epsilon, an action at random.

    That of Stable-Baselines3 draws once for all, so that either every vehicle explores or none does.

    Args:
        exploration_factor: what epsilon is multiplied by at every update, down to its final value; None to lower it in
            a straight line instead, over the first `exploration_fraction` of the training
    """

    def __init__(self, *args: Any, exploration_factor: float | None = None, **options: Any) -> None:
        self.exploration_factor = exploration_factor
        super().__init__(*args, **options)

    def _on_step(self) -> None:
        super()._on_step()
        if self.exploration_factor is not None:
            decayed = self.exploration_initial_eps * self.exploration_factor**self._n_updates
            self.exploration_rate = max(self.exploration_final_eps, decayed)

    def predict(
        self,
        observation: Any,
        state: Any = None,
        episode_start: Any = None,
        deterministic: bool = False,
    ) -> tuple[Any, Any]:
        """Return the actions of best value, some replaced at random unless `deterministic`."""
        actions, state = self.policy.predict(observation, state, episode_start, deterministic=True)
        if not deterministic:
            explores = np.random.rand(len(actions)) < self.exploration_rate  # noqa: NPY002 - seeded with all else
            drawn = np.random.randint(0, int(self.action_space.n), len(actions))  # noqa: NPY002
            actions = np.where(explores, drawn, actions)
        return actions, state


class DoubleDQN(Explorer):
    """DQN whose targets are the target network's values of the actions that the online network would take.

    The greatest of noisy values is too great on average; to choose by one network and value by another is not. Van
    Hasselt et al., Deep reinforcement learning with double Q-learning, 2016, equation 4.
    """

    def train(self, gradient_steps: int, batch_size: int = 100) -> None:
        """Improve the network by so many minibatches."""
        self.policy.set_training_mode(True)
        self._update_learning_rate(self.policy.optimizer)
        buffer: Any = self.replay_buffer
        losses = [self.improve(buffer.sample(batch_size)) for _ in range(gradient_steps)]
        self._n_updates += gradient_steps
        self.logger.record("train/n_updates", self._n_updates, exclude="tensorboard")
        self.logger.record("train/loss", np.mean(losses))

    def improve(self, batch: ReplayBufferSamples) -> float:
        """Take one step down the Huber loss of a minibatch, and return the loss."""
        values = self.q_net(batch.observations).gather(1, batch.actions.long())
        loss = functional.smooth_l1_loss(values, self.targets(batch))
        self.policy.optimizer.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(self.policy.parameters(), self.max_grad_norm)
        self.policy.optimizer.step()
        value: float = loss.item()
        return value

    @torch.no_grad()
    def targets(self, batch: ReplayBufferSamples) -> torch.Tensor:
        """Return what the values of a minibatch should be, (n, 1)."""
        chosen = self.q_net(batch.next_observations).argmax(dim=1, keepdim=True)
        later = self.q_net_target(batch.next_observations).gather(1, chosen)
        discounts: Any = batch.discounts if batch.discounts is not None else self.gamma
        targets: torch.Tensor = batch.rewards + (1 - batch.dones) * discounts * later
        return targets
