"""The state as the vehicle estimates it: late and noisy."""

from bisect import bisect_right
from dataclasses import dataclass
from operator import attrgetter

import numpy as np

from crosstrack.types import Array, Noise, State


@dataclass(frozen=True)
class Estimator:
    """What is wrong with an estimate, and the true states it may still have to report."""

    noise: Noise
    past: tuple[State, ...]
    """true states, oldest first, as many as the delay spans"""


def start(noise: Noise, state: State) -> Estimator:
    """Return the memory to begin with, from the true state."""
    return Estimator(noise, (state,))


def step(memory: Estimator, state: State, rng: np.random.Generator) -> tuple[State, Estimator]:
    """Return the estimate at the time of a true state, and the new memory.

    The estimate is the truth `noise.delay` ago, or the first state while none is as old, interpolated
    linearly between the states given (the attitude along the chord, normalised), plus white noise on position,
    velocity and acceleration. It bears the time of `state`: the vehicle does not know that it is late.
    Without delay and noise it is `state` itself.

    Args:
        memory: from `start` or the step before
        state: true state, later than the one of the step before
        rng: drawn from only where there is noise
    """
    noise = memory.noise
    estimate = state
    if noise.delay > 0:
        past = memory.past
        then = state.time - noise.delay
        first = max(0, bisect_right(past, then, key=attrgetter("time")) - 1)
        memory = Estimator(noise, (*past[first:], state))
        estimate = recalled(memory.past, then, state.time)
    if noise.position > 0 or noise.velocity > 0 or noise.acceleration > 0:
        estimate = blurred(estimate, noise, rng)
    return estimate, memory


def recalled(past: tuple[State, ...], then: float, now: float) -> State:
    """Return the state at the time `then`, between the first two of `past`, with the time `now`."""
    before, after = past[0], past[1]
    share = (then - before.time) / (after.time - before.time) if then > before.time else 0.0

    def between(a: Array, b: Array) -> Array:
        return (1 - share) * a + share * b

    nearer = after.attitude if before.attitude @ after.attitude >= 0 else -after.attitude
    attitude = between(before.attitude, nearer)
    return State(
        time=now,
        position=between(before.position, after.position),
        velocity=between(before.velocity, after.velocity),
        attitude=attitude / np.sqrt(attitude @ attitude),
        rate=between(before.rate, after.rate),
        acceleration=between(before.acceleration, after.acceleration),
        rotor_speeds=between(before.rotor_speeds, after.rotor_speeds),
    )


def blurred(state: State, noise: Noise, rng: np.random.Generator) -> State:
    """Return the state with white noise on position, velocity and acceleration."""
    error = rng.standard_normal((3 if noise.acceleration > 0 else 2, 3))
    return State(
        time=state.time,
        position=state.position + noise.position * error[0],
        velocity=state.velocity + noise.velocity * error[1],
        attitude=state.attitude,
        rate=state.rate,
        acceleration=state.acceleration + noise.acceleration * error[2]
        if noise.acceleration > 0
        else state.acceleration,
        rotor_speeds=state.rotor_speeds,
    )
