"""Trajectories that are always there: from a motion to rest, and along straight legs from rest to rest.

Each piece is the polynomial of degree five with given position, velocity and acceleration at both ends. From rest to
rest over a length L in a time T it is at most 15/8 L/T fast, and accelerates with at most 10/√3 L/T².
"""

import math

import numpy as np

from crosstrack.protocols import Map
from crosstrack.trajectory import hermite
from crosstrack.trajectory.limits import MotionLimits
from crosstrack.trajectory.polynomial import PiecewisePolynomial
from crosstrack.trajectory.times.timing import along
from crosstrack.types import Array

PEAK_SPEED, PEAK_ACCELERATION = 15 / 8, 10 / math.sqrt(3)
SHORTEST = 0.2
"""s"""
STRETCHES = (1.0, 1.3, 0.8, 1.7, 0.6)
"""of the time that braking takes at the acceleration planned with, in the order they are tried"""
ASIDE = (0.0, 0.3, 0.6)
"""of the braking distance, by which it may end to a side"""
SIDES = 8
INSTANTS = 25


def piecewise(knots: Array, durations: Array) -> PiecewisePolynomial:
    """Return the curve with a position, velocity and acceleration at each knot.

    Args:
        knots: (n + 1, 3, 3) m, m/s, m/s²
        durations: (n,) s
    """
    powers = durations[:, None, None] ** np.arange(3)[:, None]
    ends = np.concatenate([knots[:-1] * powers, knots[1:] * powers], axis=1)
    unit = np.einsum("ij,njd->nid", hermite.coefficients(3), ends)
    return PiecewisePolynomial(durations, unit / durations[:, None, None] ** np.arange(6)[:, None])


def stop_and_go(way: Array, limits: MotionLimits) -> PiecewisePolynomial:
    """Return the trajectory along the legs of a way (n, 3) m that rests at each of its points."""
    steps = np.diff(way, axis=0)
    lengths = np.linalg.norm(steps, axis=1)
    fastest = along(steps, lengths, limits.speed, limits.speed_vertical)
    strongest = along(steps, lengths, limits.acceleration, limits.acceleration_vertical)
    durations = np.maximum(PEAK_SPEED * lengths / fastest, np.sqrt(PEAK_ACCELERATION * lengths / strongest))
    knots = np.zeros((len(way), 3, 3))
    knots[:, 0] = way
    return piecewise(knots, np.maximum(durations, SHORTEST))


def settled(position: Array, motion: Array, goal: Array, limits: MotionLimits) -> PiecewisePolynomial:
    """Return the trajectory from a motion to rest at a goal that is close."""
    speed, strongest = float(np.linalg.norm(motion[0])), limits.acceleration or np.inf
    away = float(np.linalg.norm(goal - position))
    duration = max(2.0 * speed / strongest, math.sqrt(PEAK_ACCELERATION * away / strongest), 1.0)
    knots = np.zeros((2, 3, 3))
    knots[0, 0], knots[0, 1:], knots[1, 0] = position, motion, goal
    return piecewise(knots, np.array([duration]))


def braking(world: Map, position: Array, motion: Array, clearance: float, limits: MotionLimits) -> PiecewisePolynomial:
    """Return a trajectory from a motion to rest: straight if that is free, else to a side, else the freest there is.

    Braking at a rate that rises and falls as a parabola takes T = 3 v / (2 a) from a speed v at a peak rate a, and ends
    v T / 2 ahead.

    Args:
        world: what is in the way
        position: (3,) m
        motion: (2, 3) m/s and m/s², velocity and acceleration to begin with
        clearance: m, wanted; what there is at the position less a little where that is less
        limits: of acceleration
    """
    speed, strongest = float(np.linalg.norm(motion[0])), limits.acceleration or np.inf
    usual = max(1.5 * speed / strongest, SHORTEST)
    offsets = sideways(motion[0])
    times: Array = np.maximum(np.array(STRETCHES) * usual, SHORTEST)
    durations = np.repeat(times, len(offsets))
    ends = position + 0.5 * durations[:, None] * motion[0] + durations[:, None] ** 2 / 12 * motion[1]
    ends = ends + np.tile(offsets, (len(STRETCHES), 1)) * 0.5 * durations[:, None] * speed
    knots = np.zeros((len(ends), 2, 3, 3))
    knots[:, 0, 0], knots[:, 0, 1:], knots[:, 1, 0] = position, motion, ends
    curves = [piecewise(pair, duration) for pair, duration in zip(knots, durations[:, None], strict=True)]
    shares = np.linspace(0.0, 1.0, INSTANTS)
    points = np.array([curve(shares * curve.duration) for curve in curves])
    gaps: Array = np.asarray(world.distance(points))
    free = gaps.min(axis=1)
    hard = np.array([np.linalg.norm(curve(shares * curve.duration, 2), axis=1).max() for curve in curves])
    wanted = min(clearance, float(gaps[0][0]) - 0.01)
    excess = np.maximum(hard / strongest - 1.1, 0.0)
    high = points[:, :, 2].min(axis=1) >= min(world.ground + clearance, position[2]) - 0.05
    fine = (free >= wanted) & (excess == 0.0) & high
    if fine.any():
        return curves[int(np.argmax(fine))]
    return curves[int(np.argmax(np.minimum(free - wanted, 0.0) - 0.3 * excess - ~high))]


def sideways(velocity: Array) -> Array:
    """Return unit-less offsets (n, 3) across a velocity, none first."""
    ahead = velocity / max(float(np.linalg.norm(velocity)), 1e-9)
    helper = np.eye(3)[int(np.argmin(np.abs(ahead)))]
    left = np.cross(ahead, helper)
    left /= max(float(np.linalg.norm(left)), 1e-9)
    up = np.cross(ahead, left)
    angles = np.arange(SIDES) * 2 * np.pi / SIDES
    ring = np.cos(angles)[:, None] * left + np.sin(angles)[:, None] * up
    return np.concatenate([np.zeros((1, 3)), *(size * ring for size in ASIDE[1:])])


def after(first: PiecewisePolynomial, second: PiecewisePolynomial) -> PiecewisePolynomial:
    """Return two curves, of which the second begins where the first ends, as one."""
    degree = max(first.degree, second.degree)
    parts = []
    for curve in (first, second):
        room = np.zeros((len(curve.durations), degree + 1, 3))
        room[:, : curve.degree + 1] = curve.coefficients
        parts.append(room)
    return PiecewisePolynomial(np.concatenate([first.durations, second.durations]), np.concatenate(parts))
