"""One vehicle of a task as an environment of gymnasium, flown by any vehicle a mission can name."""

from dataclasses import replace
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from crosstrack.campaign.avoidance.families import Arena
from crosstrack.learn.agents import OUTCOMES
from crosstrack.learn.rewards import TERMS
from crosstrack.learn.stepping import take
from crosstrack.learn.tasks import find
from crosstrack.learn.vector import LIMITS, Floats, Vector
from crosstrack.protocols import Scenario, Session, Vehicle
from crosstrack.sim.fleet import MOTION
from crosstrack.sim.kernel import OUTER
from crosstrack.types import Air, AttitudeSetpoint, Command, Mismatch, Noise, Setpoint, State, Wind
from crosstrack.vehicles.quadrotor import Quadrotor
from crosstrack.world.world import World


class Single(gymnasium.Env[Floats, Any]):
    """One vehicle that learns a task: the laws are those of `Vector`, the flight and the sensors are the vehicle's."""

    metadata = {"render_modes": []}  # noqa: RUF012  # as gymnasium has it

    def __init__(
        self, task: Any = "avoid", vehicle: Vehicle | None = None, arena: Arena | None = None, **options: Any
    ) -> None:
        """Make a vehicle.

        Args:
            task: what to do, or its name
            vehicle: what flies; the embedded quadrotor by default
            arena: the one world to fly in, for a simulator whose world is given; drawn for every episode by default
            options: fields of the task that differ from its own
        """
        task = replace(find(task)() if isinstance(task, str) else task, **options)
        self.core = Vector(task, 1, arenas=None if arena is None else [arena])
        self.vehicle = vehicle or Quadrotor(task.airframe)
        self.observation_space, self.action_space = self.core.single_observation_space, self.core.single_action_space
        self.session: Session | None = None
        self.before: Command = Setpoint()

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Floats, dict[str, Any]]:
        """Begin an episode: the same one for the same seed."""
        super().reset(seed=seed)
        self.close()
        self.core.reset(seed=seed)
        self.session = self.vehicle.launch(self.scenario())
        self.before = self.command()
        self.sense()
        self.core.look()
        return self.seen(), {}

    def step(self, action: Any) -> tuple[Floats, float, bool, bool, dict[str, Any]]:
        """Fly an action for a decision."""
        core, session, task = self.core, self.session, self.core.task
        if session is None:
            raise gymnasium.error.ResetNeeded("begin an episode with `reset` first")
        numbers = np.asarray(action, dtype=float).reshape(-1)
        take(core.kind, numbers, core.rows[0], core.agents[0], task.period)
        late, command = float(core.agents["delay"][0]) * OUTER * core.step_time, self.command()
        if late > 0:
            session.advance(self.before, late)
        session.advance(command, task.period - late)
        self.before = command
        self.sense()
        terminated, truncated = core.assess()
        over, infos = bool(terminated[0] or truncated[0]), dict[str, Any]()
        if over:
            account = core.agents[0]
            outcome = OUTCOMES[account["outcome"]]
            infos = {"outcome": outcome.name.lower() if outcome else "", "flown": float(account["flown"])}
            infos |= {f"reward_{name}": float(account["rewards"][k]) for k, name in enumerate(TERMS)}
        return self.seen(), float(core.rewards[0]), bool(terminated[0]), bool(truncated[0]), infos

    def close(self) -> None:
        """Leave the vehicle safe."""
        if self.session is not None:
            self.session.close()
            self.session = None

    def scenario(self) -> Scenario:
        """Return what the episode drawn puts the vehicle into."""
        core, agent, row = self.core, self.core.agents[0], self.core.rows[0]
        task, worlds = core.task, core.field.worlds
        _, _, z, w = row["state"][6:10]
        sensor = getattr(task, "sensor", None)
        world: World = worlds[agent["arena"] % len(worlds)]
        return Scenario(
            position=row["state"][:3].copy(),
            yaw=2 * float(np.arctan2(z, w)),
            world=world,
            cruise=task.speed,
            limits=LIMITS,
            wind=Wind(tuple(agent["mean"].tolist()), "light" if agent["intensity"] > 0 else "none"),
            air=Air(),
            noise=Noise(float(agent["noise"][0]), float(agent["noise"][1])),
            period=task.period,
            seed=int(agent["random"] >> np.uint64(32)),
            mismatch=Mismatch(
                float(row["mass"] / row["known_mass"]),
                float(agent["drag"]),
                float(row["motor_time"] / core.nominal["motor_time"][0]),
            ),
            sensors=() if sensor is None else (sensor,),
        )

    def command(self) -> Command:
        """Return the pending command."""
        agent = self.core.agents[0]
        numbers: NDArray[np.float64] = agent["pending"].copy()
        if agent["level"] == MOTION:
            return Setpoint(velocity=numbers[3:6], yaw=float(numbers[9]))
        return AttitudeSetpoint(numbers[:4], float(numbers[4]))

    def sense(self) -> None:
        """Take over what the vehicle knows of itself, and what is true."""
        assert self.session is not None
        state, estimate, row = self.session.truth(), self.session.sense(), self.core.rows[0]
        row["state"][:13] = packed(state)
        row["error"][:3] = estimate.position - state.position
        row["error"][3:] = estimate.velocity - state.velocity
        row["impact"] = np.inf if self.session.touched() else 0.0
        self.ranges: Floats | None = None
        for scan in self.session.scans():
            share = np.nan_to_num(scan.ranges, nan=np.inf) / scan.max_range
            self.ranges = np.minimum(share, 1.0).astype(np.float32)

    def seen(self) -> Floats:
        """Return the observation, with what the sensors of the vehicle have seen."""
        observation: Floats = self.core.observations[0].copy()
        if self.ranges is not None:
            observation[: len(self.ranges)] = self.ranges
        return observation


def packed(state: State) -> NDArray[np.float64]:
    """Return a state as (13,) numbers: position, velocity, attitude, rate."""
    return np.concatenate([state.position, state.velocity, state.attitude, state.rate])
