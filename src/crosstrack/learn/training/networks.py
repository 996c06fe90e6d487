"""Networks beside those of Stable-Baselines3: two streams for values, convolutions over a depth picture."""

from collections.abc import Sequence
from typing import Any

import torch
from gymnasium import spaces
from stable_baselines3.common.torch_layers import BaseFeaturesExtractor, create_mlp
from stable_baselines3.dqn.policies import DQNPolicy, QNetwork
from torch import nn

ACTIVATIONS: dict[str, type[nn.Module]] = {"relu": nn.ReLU, "tanh": nn.Tanh}


class Dueling(QNetwork):
    """Values of actions from two streams: Q = V + A - mean A.

    The layers before the last are a common trunk; the last is there twice, for V and for A. Wang et al., Dueling
    network architectures for deep reinforcement learning, 2016, equation 9.
    """

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        *common, last = self.net_arch
        width = common[-1] if common else self.features_dim
        count = int(self.action_space.n)
        self.q_net = nn.Identity()  # in place of the one stream that is not used
        self.trunk = nn.Sequential(*create_mlp(self.features_dim, -1, common, self.activation_fn))
        self.value = nn.Sequential(*create_mlp(width, 1, [last], self.activation_fn))
        self.advantage = nn.Sequential(*create_mlp(width, count, [last], self.activation_fn))

    def forward(self, obs: Any) -> torch.Tensor:
        """Return the values of all actions, (n, actions)."""
        shared = self.trunk(self.extract_features(obs, self.features_extractor))
        advantage = self.advantage(shared)
        joined: torch.Tensor = self.value(shared) + advantage - advantage.mean(dim=1, keepdim=True)
        return joined


class DuelingPolicy(DQNPolicy):
    """A policy of DQN whose network has two streams."""

    def make_q_net(self) -> Dueling:
        """Return a new network; it is asked for twice, the second being the target's."""
        options = self._update_features_extractor(self.net_args, features_extractor=None)
        made: Dueling = Dueling(**options).to(self.device)
        return made


class Picture(BaseFeaturesExtractor):
    """Convolutions over the picture at the head of a flat observation, joined with the entries after it.

    Args:
        observation_space: flat, picture first, row by row
        picture: (height, width) px
        channels: of each convolution
        kernel: px, the side of each
        stride: px, of each
    """

    def __init__(
        self, observation_space: spaces.Box, picture: tuple[int, int], channels: Sequence[int], kernel: int, stride: int
    ) -> None:
        layers: list[nn.Module] = []
        for before, after in zip((1, *channels), channels, strict=False):
            layers += [nn.Conv2d(before, after, kernel, stride), nn.ReLU()]
        body = nn.Sequential(*layers, nn.Flatten())
        rest = observation_space.shape[0] - picture[0] * picture[1]
        with torch.no_grad():
            size = body(torch.zeros(1, 1, *picture)).shape[1]
        super().__init__(observation_space, size + rest)
        self.body, self.picture = body, picture

    def forward(self, observations: torch.Tensor) -> torch.Tensor:
        """Return the features, (n, features): those of the picture, then the state's entries."""
        height, width = self.picture
        image = observations[:, : height * width].reshape(-1, 1, height, width)
        return torch.cat([self.body(image), observations[:, height * width :]], dim=1)
