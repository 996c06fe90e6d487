"""Dryden turbulence at low altitude (MIL-F-8785C, 3.7), a frozen field that the vehicle flies through.

Along the airspeed, with ξ the distance through the air over the scale length and n white noise, the gusts are

    u: (1 + d/dξ) u = √2 n                   spectrum 2L/π / (1 + (LΩ)²)
    v, w: (1 + d/dξ)² v = (1 + √3 d/dξ) n    spectrum L/π (1 + 3(LΩ)²) / (1 + (LΩ)²)²

each of unit variance before it is scaled. The second has two states, chosen here so that they are independent
and of unit variance: y = (gust, c) with dy/dξ = (N - 1) y + B n and N N = 0. A step of any length is
therefore exact:

    y ← e^-ξ (1 + ξ N) y + B w₁ + N B w₂,     cov(w₁, w₂) = [[q₀, q₁], [q₁, q₂]],     qₙ = ∫₀^ξ tⁿ e^-2t dt

u lies along the horizontal airspeed (east where there is none), v to the left of it, w up. The gust itself is
kept in the world frame, so a vehicle that turns or stops feels no jump: the two horizontal gusts have the
same variance. Only the second state of v stays with its axis.

With h the height above the ground in feet and W₂₀ the wind at 20 ft: σ_w = 0.1 W₂₀, L_w = h,
σ_u = σ_v = σ_w / (0.177 + 0.000823 h)^0.4, L_u = L_v = h / (0.177 + 0.000823 h)^1.2. The standard has these
for 10 to 1000 ft; lower than that the gusts are those at 10 ft, higher those at 1000 ft.
"""

import math
from dataclasses import dataclass

import numpy as np

from crosstrack.compiled import compiled
from crosstrack.types import Array, Wind

FOOT = 0.3048
"""m"""
LOWEST, HIGHEST = 10 * FOOT, 1000 * FOOT
"""m, heights between which the scales of the gusts change"""
KNOT = 1852 / 3600
"""m/s"""
INTENSITY = {"none": 0.0, "light": 15 * KNOT, "moderate": 30 * KNOT, "severe": 45 * KNOT}
"""m/s, W₂₀"""

B0, B1 = math.sqrt(3), 1.0
N00, N01, N10, N11 = -0.5, 1 - math.sqrt(3) / 2, -1 - math.sqrt(3) / 2, 0.5
NB0, NB1 = N00 * B0 + N01 * B1, N10 * B0 + N11 * B1


@dataclass(frozen=True)
class Turbulence:
    """The gusts where the vehicle is, and what the filters remember of the field."""

    mean: Array
    """(3,) m/s, world, the wind that carries the field"""
    intensity: float
    """m/s, W₂₀"""
    filters: Array
    """(5,) independent, unit variance: gust east, north, up over their deviation; second states of v, w"""


def start(wind: Wind, rng: np.random.Generator) -> Turbulence:
    """Return the memory to begin with: a place in a stationary field."""
    return Turbulence(np.array(wind.mean, float), INTENSITY[wind.gusts], rng.standard_normal(5))


def step(
    memory: Turbulence, velocity: Array, height: float, duration: float, rng: np.random.Generator
) -> tuple[Array, Turbulence]:
    """Return the gust after flying through the field for a time, and the new memory.

    Args:
        memory: from `start` or the step before
        velocity: (3,) m/s, world, of the vehicle over the ground
        height: m, above the ground
        duration: s; zero reads the gust where the vehicle is
        rng: five normal numbers are drawn from it unless there are no gusts

    Returns:
        the gust (3,) m/s, world, to be added to the mean wind; the new memory
    """
    if memory.intensity == 0:
        return np.zeros(3), memory
    gust, filters = flown(
        memory.filters, memory.mean, velocity, memory.intensity, height, duration, rng.standard_normal(5)
    )
    return gust, Turbulence(memory.mean, memory.intensity, filters)


@compiled
def scales(intensity: float, height: float) -> tuple[float, float, float, float]:
    """Return σ of the horizontal and the vertical gusts (m/s) and their scale lengths (m) at a height (m)."""
    h = min(HIGHEST, max(LOWEST, height)) / FOOT
    shape = 0.177 + 0.000823 * h
    vertical = 0.1 * intensity
    return vertical * shape**-0.4, vertical, FOOT * h * shape**-1.2, FOOT * h


@compiled
def moments(x: float) -> tuple[float, float, float]:
    """Return qₙ = ∫₀^x tⁿ e^-2t dt for n = 0, 1, 2, without cancellation."""
    decay = math.exp(-2 * x)
    if x > 1:
        q0 = 0.5 * (1 - decay)
        q1 = 0.5 * (q0 - x * decay)
        return q0, q1, q1 - 0.5 * x * x * decay
    q2 = term = x * x * x * decay / 3
    for k in range(4, 26):
        term *= 2 * x / k
        q2 += term
    q1 = 0.5 * (x * x * decay + 2 * q2)
    return x * decay + 2 * q1, q1, q2


@compiled
def lateral(gust: float, other: float, x: float, n1: float, n2: float) -> tuple[float, float]:
    """Return the two states of a gust across the airspeed after x scale lengths, from two normal numbers."""
    q0, q1, q2 = moments(x)
    root = math.sqrt(q0)
    w1 = root * n1
    w2 = q1 / root * n1 + math.sqrt(max(0.0, q2 - q1 * q1 / q0)) * n2
    decay = math.exp(-x)
    return (
        decay * (gust + x * (N00 * gust + N01 * other)) + B0 * w1 + NB0 * w2,
        decay * (other + x * (N10 * gust + N11 * other)) + B1 * w1 + NB1 * w2,
    )


@compiled
def flown(
    filters: Array,
    mean: Array,
    velocity: Array,
    intensity: float,
    height: float,
    duration: float,
    noise: Array,
) -> tuple[Array, Array]:
    """Return the gust (3,) m/s and the filters (5,) after a step, from five normal numbers."""
    sideways, upwards, length, length_up = scales(intensity, height)
    ax, ay, az = velocity[0] - mean[0], velocity[1] - mean[1], velocity[2] - mean[2]
    level = math.hypot(ax, ay)
    distance = math.sqrt(level * level + az * az) * duration
    east, north, up, second, second_up = filters[0], filters[1], filters[2], filters[3], filters[4]
    if distance > 0:
        c, s = (ax / level, ay / level) if level > 0 else (1.0, 0.0)
        x = distance / length
        u = (c * east + s * north) * math.exp(-x) + math.sqrt(-math.expm1(-2 * x)) * noise[0]
        v, second = lateral(c * north - s * east, second, x, noise[1], noise[2])
        east, north = c * u - s * v, s * u + c * v
        up, second_up = lateral(up, second_up, distance / length_up, noise[3], noise[4])
    gust = np.array([sideways * east, sideways * north, upwards * up])
    return gust, np.array([east, north, up, second, second_up])
