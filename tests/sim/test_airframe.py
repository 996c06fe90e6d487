"""Airframes against independent arithmetic."""

import math

import numpy as np
import pytest

from crosstrack.sim.airframe import AIRFRAMES, CRAZYFLIE, GENERIC, RACER, Airframe
from crosstrack.types import GRAVITY

every = pytest.mark.parametrize("airframe", AIRFRAMES.values(), ids=AIRFRAMES)


def wrench(airframe: Airframe, thrusts: np.ndarray) -> np.ndarray:
    """Sum r x f and the drag torques rotor by rotor."""
    total = np.zeros(4)
    for position, spin, thrust in zip(airframe.rotor_positions, airframe.spins, thrusts, strict=True):
        torque = np.cross(position, [0, 0, thrust]) + np.array([0, 0, spin * airframe.torque_ratio * thrust])
        total += [thrust, *torque]
    return total


@every
def test_rotors_at_hover_speed_carry_the_weight(airframe: Airframe) -> None:
    thrust = 4 * airframe.thrust_coefficient * airframe.rotor_speed_hover**2
    assert thrust == pytest.approx(airframe.mass * 9.80665, rel=1e-12)
    assert airframe.rotor_speed_min < 0.5 * airframe.rotor_speed_hover
    assert airframe.rotor_speed_hover < airframe.rotor_speed_max


@pytest.mark.parametrize(("airframe", "ratio"), [(GENERIC, 1.70), (CRAZYFLIE, 2.0), (RACER, 5.0)])
def test_thrust_to_weight(airframe: Airframe, ratio: float) -> None:
    most = 4 * airframe.thrust_coefficient * airframe.rotor_speed_max**2
    assert most / (airframe.mass * GRAVITY) == pytest.approx(ratio, abs=0.005)
    assert airframe.thrust_to_weight == pytest.approx(ratio, abs=0.005)


@every
def test_allocation_gives_the_thrust_and_torques_asked_for(airframe: Airframe) -> None:
    scale = np.array([airframe.mass * GRAVITY, 1, 1, airframe.torque_ratio]) * airframe.radius
    rng = np.random.default_rng(3)
    for asked in rng.normal(size=(20, 4)) * scale:
        np.testing.assert_allclose(
            wrench(airframe, airframe.allocation @ asked), asked, atol=1e-12 * np.abs(asked).max()
        )


@every
def test_rotors_stand_around_the_centre_in_the_stated_order(airframe: Airframe) -> None:
    sides = [(math.copysign(1, x), math.copysign(1, y)) for x, y, _ in airframe.rotor_positions]
    assert sides == [(1, -1), (-1, 1), (1, 1), (-1, -1)]
    places, spins = np.array(airframe.rotor_positions), np.array(airframe.spins)
    np.testing.assert_allclose(places.sum(axis=0)[:2], 0, atol=1e-15)
    # Opposite rotors turn the same way, so that yaw torque is free of roll and pitch.
    np.testing.assert_allclose(spins @ places[:, :2], 0, atol=1e-15)
    assert spins.sum() == 0


@every
def test_front_right_rotor_pushes_the_nose_up_rolls_left_and_yaws_clockwise(airframe: Airframe) -> None:
    _, roll, pitch, yaw = wrench(airframe, np.array([1.0, 0, 0, 0]))
    assert roll < 0  # the right side rises: roll to the left is negative about x forward
    assert pitch < 0  # the nose rises: negative about y left
    assert yaw < 0  # the rotor turns counter-clockwise, the body clockwise


@every
def test_inertia_is_that_of_some_body(airframe: Airframe) -> None:
    x, y, z = airframe.inertia
    assert x + y > z
    assert y + z > x
    assert z + x > y


@every
def test_feet_reach_below_the_rotors(airframe: Airframe) -> None:
    assert all(-airframe.gear < z for _, _, z in airframe.rotor_positions)
    arm = max(math.hypot(x, y) for x, y, _ in airframe.rotor_positions)
    # The dynamics look for contact below four gear heights: no foot reaches lower, however the vehicle lies.
    assert math.hypot(arm, airframe.gear) < 4 * airframe.gear
    assert airframe.radius > arm


def test_generic_has_the_mass_distribution_of_its_parts() -> None:
    box, motor, arm, height = 0.78, 0.055, 0.2275, 0.025
    assert GENERIC.mass == pytest.approx(box + 4 * motor)
    squared = (arm * math.cos(math.pi / 4)) ** 2
    expected = (
        box / 12 * (0.11**2 + 0.04**2) + 4 * motor * (squared + height**2),
        box / 12 * (0.18**2 + 0.04**2) + 4 * motor * (squared + height**2),
        box / 12 * (0.18**2 + 0.11**2) + 4 * motor * 2 * squared,
    )
    assert GENERIC.inertia == pytest.approx(expected, rel=1e-5)
    assert GENERIC.rotor_positions[2] == pytest.approx((0.160867, 0.160867, -0.025), rel=1e-5)


def test_generic_has_the_thrust_of_its_propellers() -> None:
    diameter, revolutions, density = 0.2286, 6396.667 / 60, 1.225
    thrust = 0.109919 * density * revolutions**2 * diameter**4
    torque = 0.040164 * density * revolutions**2 * diameter**5 / (2 * math.pi)
    assert GENERIC.rotor_speed_max == pytest.approx(2 * math.pi * revolutions, rel=1e-5)
    assert GENERIC.thrust_coefficient * GENERIC.rotor_speed_max**2 == pytest.approx(thrust, rel=2e-5)
    assert GENERIC.torque_ratio == pytest.approx(torque / thrust, rel=1e-5)
    # Thrust goes as the square of speed, and the least throttle while armed is 0.1.
    assert (GENERIC.rotor_speed_min / GENERIC.rotor_speed_max) ** 2 == pytest.approx(0.1, rel=1e-3)


def test_generic_has_the_drag_of_its_faces() -> None:
    diameter = 0.2286
    rim, disc = math.pi * diameter * 0.01, math.pi * diameter**2
    areas = (0.11 * 0.04 + 4 * rim, 0.18 * 0.04 + 4 * rim, 0.18 * 0.11 + 4 * disc)
    assert GENERIC.body_drag == pytest.approx([0.5 * 0.325 * area for area in areas], rel=1e-4)


def test_crazyflie_hovers_at_the_speed_measured_for_its_weight() -> None:
    # 28.6 g at 17174 rpm (Bitcraze 2015): speed goes as the root of the weight.
    expected = 17174 * math.sqrt(28 / 28.6) * 2 * math.pi / 60
    assert CRAZYFLIE.rotor_speed_hover == pytest.approx(expected, rel=2e-3)


def test_racer_has_the_rotor_drag_of_the_paper_at_hover() -> None:
    speed_sum = 4 * RACER.rotor_speed_hover
    per_mass = np.array(RACER.rotor_drag) * speed_sum / RACER.mass
    np.testing.assert_allclose(per_mass, [0.544, 0.386, 0], atol=0.005)
