"""What a training is told: the fields of its file, their units and defaults."""

from dataclasses import asdict, dataclass, field
from typing import Annotated, Any, Literal

from annotated_types import Ge, Gt, Le, Len

from crosstrack.types import NonNegative, Positive

Count = Annotated[int, Ge(1), Le(10**12)]
Share = Annotated[float, Ge(0), Le(1)]
Seed = Annotated[int, Ge(0), Le(2**32 - 1)]
Widths = Annotated[tuple[Annotated[int, Ge(1), Le(4096)], ...], Len(1, 8)]
Name = Literal["dqn", "double-dqn", "ppo", "sac", "a2c"]
NetworkName = Literal["mlp", "dueling", "cnn", "recurrent"]
Coefficient = Annotated[float, Ge(0), Le(100)]

NETWORKS: dict[str, tuple[str, ...]] = {
    "dqn": ("mlp", "dueling", "cnn"),
    "double-dqn": ("mlp", "dueling", "cnn"),
    "ppo": ("mlp", "cnn", "recurrent"),
    "sac": ("mlp", "cnn"),
    "a2c": ("mlp", "cnn"),
}
"""networks that each algorithm can train"""


@dataclass(frozen=True)
class Dqn:
    """Deep Q-learning (Mnih et al. 2015), of actions that are counted."""

    learning_rate: Positive = 5e-4
    """of Adam"""
    final_learning_rate: NonNegative | None = None
    """reached in a straight line at the end; by default the rate stays as it is"""
    gamma: Share = 0.99
    """discount per decision"""
    buffer_size: Count = 400_000
    """decisions that are remembered"""
    learning_starts: Annotated[int, Ge(0)] = 20_000
    """decisions at random before the first update"""
    batch_size: Count = 512
    """decisions per update"""
    train_freq: Count = 1
    """steps of all vehicles between updates"""
    gradient_steps: Count = 8
    """updates then"""
    n_steps: Annotated[int, Ge(1), Le(100)] = 3
    """decisions whose rewards are added up before the target network is asked"""
    target_update_interval: Count = 10_000
    """decisions between copies to the target network"""
    exploration_initial_eps: Share = 1.0
    """probability of an action at random, at first"""
    exploration_final_eps: Share = 0.02
    """and in the end"""
    exploration_fraction: Annotated[float, Gt(0), Le(1)] = 0.15
    """of the training, over which it falls in a straight line"""
    exploration_factor: Annotated[float, Gt(0), Le(1)] | None = None
    """by which it falls at every update instead"""
    max_grad_norm: Positive = 10.0
    """longer gradients are shortened to this"""


@dataclass(frozen=True)
class Ppo:
    """Proximal policy optimisation (Schulman et al. 2017)."""

    learning_rate: Positive = 5e-4
    """of Adam"""
    final_learning_rate: NonNegative | None = None
    """reached in a straight line at the end; by default the rate stays as it is"""
    n_steps: Annotated[int, Ge(2), Le(100_000)] = 64
    """decisions of each vehicle between updates"""
    batch_size: Annotated[int, Ge(2)] = 8192
    """decisions per minibatch"""
    n_epochs: Annotated[int, Ge(1), Le(100)] = 4
    """times that each decision is learned from"""
    gamma: Share = 0.99
    """discount per decision"""
    gae_lambda: Share = 0.95
    """of the generalised advantage (Schulman et al. 2016)"""
    clip_range: Positive = 0.2
    """by how much a probability may change at once, as a share"""
    ent_coef: Coefficient = 0.0
    """weight of the entropy"""
    vf_coef: Coefficient = 0.5
    """weight of the value's error"""
    max_grad_norm: Positive = 0.5
    """longer gradients are shortened to this"""
    target_kl: Positive | None = None
    """divergence from the old policy at which an update ends early"""


@dataclass(frozen=True)
class A2c:
    """Advantage actor-critic (Mnih et al. 2016), synchronous."""

    learning_rate: Positive = 7e-4
    """of RMSprop"""
    final_learning_rate: NonNegative | None = None
    """reached in a straight line at the end; by default the rate stays as it is"""
    n_steps: Annotated[int, Ge(1), Le(100_000)] = 16
    """decisions of each vehicle between updates"""
    gamma: Share = 0.99
    """discount per decision"""
    gae_lambda: Share = 0.95
    """of the generalised advantage; 1 for the paper's"""
    ent_coef: Coefficient = 0.0
    """weight of the entropy"""
    vf_coef: Coefficient = 0.5
    """weight of the value's error"""
    max_grad_norm: Positive = 0.5
    """longer gradients are shortened to this"""
    normalize_advantage: bool = True
    """to mean 0 and deviation 1 over each update"""


@dataclass(frozen=True)
class Sac:
    """Soft actor-critic (Haarnoja et al. 2018), of actions that are continuous."""

    learning_rate: Positive = 5e-4
    """of Adam"""
    final_learning_rate: NonNegative | None = None
    """reached in a straight line at the end; by default the rate stays as it is"""
    gamma: Share = 0.99
    """discount per decision"""
    buffer_size: Count = 400_000
    """decisions that are remembered"""
    learning_starts: Annotated[int, Ge(0)] = 20_000
    """decisions at random before the first update"""
    batch_size: Count = 512
    """decisions per update"""
    train_freq: Count = 1
    """steps of all vehicles between updates"""
    gradient_steps: Count = 8
    """updates then"""
    n_steps: Annotated[int, Ge(1), Le(100)] = 1
    """decisions whose rewards are added up before the target network is asked"""
    tau: Annotated[float, Gt(0), Le(1)] = 0.005
    """share of the target network that every update replaces"""
    ent_coef: Positive | Literal["auto"] = "auto"
    """weight of the entropy; `auto` learns it"""


Learning = Dqn | Ppo | A2c | Sac
LEARNING: dict[str, type[Learning]] = {"dqn": Dqn, "double-dqn": Dqn, "ppo": Ppo, "sac": Sac, "a2c": A2c}
"""what each algorithm is told"""


@dataclass(frozen=True)
class Shape:
    """What the network is like."""

    layers: Widths = (64, 64)
    """units of each layer"""
    activation: Literal["relu", "tanh"] = "tanh"
    """of each layer"""
    log_std: Annotated[float, Ge(-5), Le(2)] = -0.5
    """logarithm of the deviation of continuous actions of ppo and a2c, at first"""
    memory: Annotated[int, Ge(1), Le(4096)] = 64
    """units of the LSTM of `recurrent`, which comes before the layers"""
    channels: Widths = (16, 32)
    """of each convolution of `cnn`, whose picture comes before the layers"""
    kernel: Annotated[int, Ge(1), Le(32)] = 4
    """px, the side of each convolution"""
    stride: Annotated[int, Ge(1), Le(32)] = 2
    """px, of each convolution"""


@dataclass(frozen=True)
class Stage:
    """Easier episodes, for a while."""

    level: dict[str, float]
    """what they are like, such as `{density: 0.02}`"""
    success: Share = 0.8
    """of the last episodes; from there on the next stage is flown"""
    steps: Count | None = None
    """decisions after which the next is flown in any case; by default there is no such limit"""


@dataclass(frozen=True)
class Evaluating:
    """How the policy is measured while it is trained, on maps that training does not see."""

    every: Count = 1_000_000
    """decisions from one evaluation to the next"""
    episodes: Annotated[int, Ge(1), Le(100_000)] = 200


@dataclass(frozen=True)
class Training:
    """A training, whole."""

    task: str
    """`avoid`, `follow` or `hover`"""
    algo: Name
    """`dqn`, `double-dqn`, `ppo`, `sac` or `a2c`"""
    learning: Learning
    """what the algorithm is told"""
    network: NetworkName = "mlp"
    """`mlp`, `dueling`, `cnn` or `recurrent`"""
    preset: str = "tuned"
    """what it began from"""
    options: dict[str, Any] = field(default_factory=dict)
    """of the task, where they are not its defaults"""
    steps: Count = 10_000_000
    """decisions"""
    envs: Annotated[int, Ge(1), Le(65_536)] = 512
    """vehicles that fly at once"""
    seed: Seed = 1
    until: Annotated[float, Gt(0), Le(1)] | None = None
    """success rate of an evaluation that ends the training"""
    minutes: Positive | None = None
    """after which the training ends"""
    threads: Annotated[int, Ge(1), Le(1024)] = 1
    """of the processor, for the network; a resumed training equals one that was not broken off with one alone"""
    checkpoint_every: NonNegative = 60.0
    """s from one checkpoint to the next"""
    evaluating: Evaluating = field(default_factory=Evaluating)
    curriculum: tuple[Stage, ...] = ()
    """easier episodes to begin with; after them come those of the task's options"""
    shape: Shape = field(default_factory=Shape)

    def document(self) -> dict[str, Any]:
        """Return this as plain values for JSON, in the order of the fields."""
        plain: dict[str, Any] = listed(asdict(self))
        return plain


def listed(value: Any) -> Any:
    """Return plain values with lists in place of tuples."""
    if isinstance(value, dict):
        return {name: listed(inner) for name, inner in value.items()}
    return [listed(inner) for inner in value] if isinstance(value, list | tuple) else value
