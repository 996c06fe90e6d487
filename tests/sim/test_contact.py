"""Feet on the ground: rest, friction, no energy from nowhere."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from crosstrack.sim.airframe import AIRFRAMES, GENERIC, RACER, Airframe
from crosstrack.sim.contact import DAMPING_RATIO, FRICTION, SAG
from crosstrack.sim.dynamics import step
from crosstrack.sim.fleet import fleet
from crosstrack.sim.kernel import STEP
from crosstrack.types import GRAVITY, Air, Array, Limits

every = pytest.mark.parametrize("airframe", AIRFRAMES.values(), ids=AIRFRAMES)
GROUND = 2.0


def dropped(airframe: Airframe, body: Array, duration: float, h: float = STEP) -> Array:
    """Return the bodies (n, 13) of a vehicle whose rotors stand still, step by step."""
    rows = fleet(airframe, Air(), Limits(), ground=GROUND)
    now: Any = tuple(float(value) for value in body)
    rotors = (0.0, 0.0, 0.0, 0.0)
    found = [now]
    for _ in range(round(duration / h)):
        now, rotors = step(now, rotors, rotors, (0.0, 0.0, 0.0), rows[0], h, 1.0)
        found.append(now)
    return np.array(found)


def placed(height: float, velocity: tuple[float, float, float], tilt: tuple[float, float, float]) -> Array:
    attitude = Rotation.from_rotvec(tilt).as_quat()
    return np.concatenate([[0, 0, GROUND + height], velocity, attitude, [0, 0, 0]])


def energy(airframe: Airframe, bodies: Array) -> Array:
    """Return kinetic and potential energy over mass (J/kg), without that in the feet."""
    spin = bodies[:, 10:] ** 2 @ np.array(airframe.inertia) / airframe.mass
    return np.asarray(0.5 * (bodies[:, 3:6] ** 2).sum(axis=1) + GRAVITY * bodies[:, 2] + 0.5 * spin)


def tilt(bodies: Array) -> Array:
    """Return the angle (rad) between body z and up."""
    return np.asarray(np.arccos(np.clip(1 - 2 * (bodies[..., 6] ** 2 + bodies[..., 7] ** 2), -1, 1)))


def test_standing_still_needs_no_step() -> None:
    body = placed(GENERIC.gear - SAG, (0, 0, 0), (0, 0, 0))
    bodies = dropped(GENERIC, body, 0.5)
    np.testing.assert_allclose(bodies - body, 0, atol=1e-12)


@every
def test_dropped_vehicle_comes_to_rest_level_on_its_feet(airframe: Airframe) -> None:
    start = placed(airframe.gear + 0.3, (0.4, -0.3, 0), (0.15, 0.2, 0.5))
    bodies = dropped(airframe, start, 4.0)
    end = bodies[-1]
    assert end[2] == pytest.approx(GROUND + airframe.gear - SAG, abs=1e-4)
    assert tilt(end) < 1e-3
    np.testing.assert_allclose(end[3:6], 0, atol=2e-3)
    np.testing.assert_allclose(end[10:], 0, atol=2e-2)


@every
@settings(max_examples=10)
@given(
    height=st.floats(0.0, 0.5),
    velocity=st.tuples(st.floats(-2, 2), st.floats(-2, 2), st.floats(-2, 0)),
    lean=st.tuples(st.floats(-0.4, 0.4), st.floats(-0.4, 0.4), st.floats(-3, 3)),
)
def test_ground_gives_no_energy(
    airframe: Airframe,
    height: float,
    velocity: tuple[float, float, float],
    lean: tuple[float, float, float],
) -> None:
    arm = max(math.hypot(x, y) for x, y, _ in airframe.rotor_positions)
    start = placed(airframe.gear + arm + height, velocity, lean)  # every foot is in the air
    found = energy(airframe, dropped(airframe, start, 1.5))
    assert np.all(np.isfinite(found))
    assert found.max() <= found[0] + 1e-3 * abs(found[0])


@pytest.mark.parametrize("airframe", [GENERIC, RACER], ids=["generic", "racer"])
def test_friction_stops_a_slide_within_its_length(airframe: Airframe) -> None:
    speed = 1.0
    bodies = dropped(airframe, placed(airframe.gear - SAG, (speed, 0, 0), (0, 0, 0)), 1.5)
    stopping = speed**2 / (2 * FRICTION * GRAVITY)
    assert bodies[-1, 0] == pytest.approx(stopping, rel=0.1)
    assert abs(bodies[-1, 3]) < 2e-3
    slid = bodies[: int(0.5 * speed / (FRICTION * GRAVITY) / STEP), 3]
    np.testing.assert_allclose(np.diff(slid).mean() / STEP, -FRICTION * GRAVITY, rtol=0.1)


def test_free_fall_ends_where_the_feet_touch() -> None:
    height = 1.0
    bodies = dropped(RACER, placed(RACER.gear + height, (0, 0, 0), (0, 0, 0)), 1.0)
    times = np.arange(len(bodies)) * STEP
    touch = times[np.argmax(bodies[:, 2] < GROUND + RACER.gear)]
    assert touch == pytest.approx(math.sqrt(2 * height / GRAVITY), rel=0.02)
    # Restitution of a spring and damper that never pulls (Schwager and Pöschel 2007); weight takes a little.
    damped = math.sqrt(1 - DAMPING_RATIO**2)
    release = math.pi - math.atan2(2 * DAMPING_RATIO * damped, 1 - 2 * DAMPING_RATIO**2)
    restitution = math.exp(-DAMPING_RATIO / damped * release)
    rebound = bodies[:, 5].max() / math.sqrt(2 * GRAVITY * height)
    assert 0.75 * restitution < rebound <= restitution
    assert bodies[:, 2].min() > GROUND


def test_feet_stand_where_the_vehicle_stands() -> None:
    here = placed(GENERIC.gear + 0.1, (0.2, 0.1, -0.5), (0.1, 0, 0))
    there = here.copy()
    there[:2] += 1000.0, -500.0
    one, other = dropped(GENERIC, here, 1.0)[-1], dropped(GENERIC, there, 1.0)[-1]
    np.testing.assert_allclose(other[2:], one[2:], atol=1e-9)
