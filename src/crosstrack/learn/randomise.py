"""What differs from episode to episode, so that a policy does not count on one vehicle in one weather."""

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from annotated_types import Ge, Le, Lt

from crosstrack.compiled import compiled
from crosstrack.learn.agents import Agents, between, normal, uniform
from crosstrack.sim.fleet import Fleet
from crosstrack.sim.turbulence import INTENSITY, flown
from crosstrack.types import GRAVITY, Array, NonNegative

Share = Annotated[float, Ge(0), Lt(1)]


@dataclass(frozen=True)
class Randomise:
    """How far an episode may differ from the nominal one, evenly."""

    mass: Share = 0.1
    """share of the mass, more or less"""
    drag: Share = 0.2
    """share of the drag, more or less"""
    motor_time: Share = 0.2
    """share of the time constant of the motors, more or less"""
    wind: NonNegative = 2.0
    """m/s, strongest mean wind, from any side"""
    gusts: Annotated[float, Ge(0), Le(1)] = 0.0
    """share of the episodes with light gusts"""
    delay: Annotated[float, Ge(0), Le(0.05)] = 0.02
    """s, longest time from an action to its command"""
    position: NonNegative = 0.0
    """m, greatest standard deviation of the estimated position on each axis"""
    velocity: NonNegative = 0.05
    """m/s, likewise of the velocity"""

    @property
    def numbers(self) -> Array:
        """For compiled code."""
        return np.array(
            [self.mass, self.drag, self.motor_time, self.wind, self.gusts, self.delay, self.position, self.velocity]
        )


NOMINAL = Randomise(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
LIGHT = INTENSITY["light"]


@compiled
def draw(p: Fleet, nominal: Fleet, agent: Agents, spread: Array, outer: float) -> None:
    """Give a vehicle another body, weather and delay.

    Args:
        p: row, changed
        nominal: row of the airframe
        agent: changed
        spread: of `Randomise`
        outer: s, of which a delay is a multiple
    """
    p.mass = nominal.known_mass * (1 + spread[0] * (2 * uniform(agent) - 1))
    p.inverse_mass = 1 / p.mass
    agent.drag = 1 + spread[1] * (2 * uniform(agent) - 1)
    for k in range(3):
        p.body_drag[k] = agent.drag * nominal.known_body_drag[k]
        p.rotor_drag[k] = agent.drag * nominal.known_rotor_drag[k]
    p.motor_time = nominal.motor_time * (1 + spread[2] * (2 * uniform(agent) - 1))
    force, side = spread[3] * uniform(agent), 2 * math.pi * uniform(agent)
    agent.mean[0], agent.mean[1], agent.mean[2] = force * math.cos(side), force * math.sin(side), 0.0
    agent.intensity = LIGHT if uniform(agent) < spread[4] else 0.0
    for k in range(5):
        agent.filters[k] = normal(agent) if agent.intensity > 0 else 0.0
    agent.delay = int(spread[5] / outer * uniform(agent) + 0.5)
    agent.noise[0], agent.noise[1] = between(agent, 0.0, spread[6]), between(agent, 0.0, spread[7])
    for k in range(3):
        p.wind[k] = agent.mean[k]


@compiled
def put(p: Fleet, agent: Agents, position: Array, yaw: float) -> None:
    """Put a vehicle at rest and level at a position (3,) m, with rotors at hover speed, told to hold it."""
    state = p.state
    for k in range(17):
        state[k] = 0.0
    for k in range(3):
        state[k] = agent.position[k] = position[k]
        p.expected[k] = 0.0
    state[8], state[9] = math.sin(0.5 * yaw), math.cos(0.5 * yaw)
    spin = math.sqrt(0.25 * p.mass * GRAVITY / p.thrust)
    state[13] = state[14] = state[15] = state[16] = spin
    p.yaw, p.impact, p.level, agent.level = yaw, 0.0, 0, 0
    for k in range(11):
        p.command[k] = agent.pending[k] = 0.0 if 3 <= k < 6 else math.nan
    agent.asked[0] = agent.asked[1] = agent.asked[2] = 0.0
    agent.asked[3] = yaw
    for k in range(4):
        agent.action[k] = 0.0
    for k in range(6):
        p.error[k] = 0.0
    agent.steps, agent.outcome, agent.flown, agent.change = 0, 0, 0.0, 0.0
    agent.least = agent.clearance = math.inf
    for k in range(agent.rewards.shape[0]):
        agent.rewards[k] = 0.0


@compiled
def disturb(p: Fleet, agent: Agents, duration: float, noise: Array) -> None:
    """Blow gusts and blur the estimate after a time (s).

    Args:
        p: row, changed
        agent: changed
        duration: s
        noise: (5,) room to work in
    """
    if agent.intensity > 0:
        for k in range(5):
            noise[k] = normal(agent)
        state = p.state
        height = state[2] - p.ground
        gust, filters = flown(agent.filters, agent.mean, state[3:6], agent.intensity, height, duration, noise)
        for k in range(3):
            p.wind[k] = agent.mean[k] + gust[k]
        for k in range(5):
            agent.filters[k] = filters[k]
    for k in range(6):
        deviation = agent.noise[k // 3]
        p.error[k] = deviation * normal(agent) if deviation > 0 else 0.0
