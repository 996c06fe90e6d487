"""A decision of many vehicles: from actions to where they are when the next is due."""

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.learn.agents import Agents
from crosstrack.learn.randomise import disturb
from crosstrack.policy.action import STICK, steer
from crosstrack.sim.fleet import Fleet
from crosstrack.sim.kernel import OUTER, fly
from crosstrack.types import Array


@compiled
def advance(
    kind: int, actions: Array, rows: Fleet, agents: Agents, duration: float, h: float, outer_steps: int
) -> None:
    """Fly actions, each after the delay of its vehicle; then blow gusts and blur estimates.

    Args:
        kind: of the actions, see `crosstrack.policy.action`
        actions: (n, size)
        rows: (n,) changed
        agents: (n,) changed
        duration: s, of the decision
        h: s, step of the simulation
        outer_steps: in which the outer loops of the autopilot are flown for a decision
    """
    noise = np.empty(5)
    for i in range(rows.shape[0]):
        agent = agents[i]
        take(kind, actions[i], rows[i], agent, duration)
        late = min(agent.delay, outer_steps)
        for part in range(2):
            steps = outer_steps - late if part else late
            if part:
                hand_over(rows[i], agent)
            if steps > 0:
                fly(rows[i : i + 1], h, OUTER * steps)
        disturb(rows[i], agent, duration, noise)


@compiled
def take(kind: int, action: Array, p: Fleet, agent: Agents, duration: float) -> None:
    """Turn an action (size,) into the pending command; one outside the space is taken at its edge."""
    agent.change = 0.0
    for k in range(len(action)):
        new = action[k] if kind == STICK else min(1.0, max(-1.0, action[k]))
        step = new - agent.action[k]
        agent.change += (1.0 if step != 0.0 else 0.0) if kind == STICK else step * step
        agent.action[k] = new
    agent.level = steer(kind, agent.action, p.state, agent.speed, duration, agent.asked, agent.pending)


@compiled
def hand_over(p: Fleet, agent: Agents) -> None:
    """Give the pending command to the autopilot."""
    p.level = agent.level
    for k in range(11):
        p.command[k] = agent.pending[k]
