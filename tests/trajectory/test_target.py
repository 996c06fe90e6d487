import numpy as np
import pytest

from crosstrack.errors import Infeasible, InputError
from crosstrack.trajectory.certified.extremes import largest_norm
from crosstrack.trajectory.limits import MotionLimits
from crosstrack.trajectory.target import Pursuit, Trail, free_tube, paced, predict, track_target
from crosstrack.types import Array
from crosstrack.world.shapes import Box, Cylinder
from crosstrack.world.world import World

TIMES = np.arange(0, 3.01, 0.1)
PURSUIT = Pursuit(distance=2.0, clearance=0.3, limits=MotionLimits(speed=4.0, acceleration=6.0))


def straight(times: Array) -> Array:
    """Return a target that runs east at 1.5 m/s, 1 m above the ground."""
    return np.stack([1.5 * times, 0 * times, 0 * times + 1], axis=1)


def at_rest(*position: float) -> Array:
    return np.array([position, [0, 0, 0], [0, 0, 0]], float)


def test_without_stiffness_a_cubic_is_predicted_exactly() -> None:
    def truth(t: Array) -> Array:
        return np.stack([t**3 - t, 2 + t**2, 0.5 * t], axis=-1)

    found = predict(TIMES, truth(TIMES), 3.1, Pursuit(stiffness=0, horizon=1.5))
    ahead = np.linspace(0, 1.5, 7)
    np.testing.assert_allclose(found(ahead), truth(3.1 + ahead), atol=1e-6)


def test_stiffness_keeps_noise_from_being_taken_for_acceleration() -> None:
    rng = np.random.default_rng(0)
    noisy = straight(TIMES) + rng.normal(scale=0.1, size=(len(TIMES), 3))
    ahead = np.linspace(0, 2, 5)
    wrong = [
        np.abs(predict(TIMES, noisy, 3.0, Pursuit(stiffness=stiffness))(ahead) - straight(3 + ahead)).max()
        for stiffness in (0.0, 0.05)
    ]
    assert wrong[1] < 0.4 < wrong[0]


def test_who_keeps_up_stays_behind_and_brakes_in_the_end() -> None:
    wanted = 1.5 * PURSUIT.moments
    moments, lengths = paced(wanted, 1.5, PURSUIT)
    np.testing.assert_allclose(lengths[:-1], wanted, atol=1e-9)
    assert lengths[-1] - lengths[-2] == pytest.approx(0.5 * 1.5 * (moments[-1] - moments[-2]))


@pytest.mark.parametrize("speed", [0.0, 1.0, 3.0])
@pytest.mark.parametrize("late", [-2.0, 0.0, 5.0])
def test_the_pace_keeps_within_what_limits_allow(speed: float, late: float) -> None:
    moments, lengths = paced(2 * PURSUIT.moments + late, speed, PURSUIT)
    speeds = np.diff(lengths) / np.diff(moments)
    assert (speeds >= -1e-12).all()
    assert (speeds <= 4.0).all()
    assert (np.abs(np.diff(speeds[:-1])) <= 6.0 * 0.4).all()
    if late:
        assert np.sign(lengths[-2] - lengths[0] - 2 * PURSUIT.horizon) == np.sign(late)


def test_a_vehicle_beside_the_trail_joins_it_ahead() -> None:
    predicted = predict(TIMES, straight(TIMES), 3.0, PURSUIT)
    joined = Trail.of(TIMES, straight(TIMES), 3.0, predicted, 0.0).joined(np.array([1.0, 0.5, 1]))
    np.testing.assert_allclose(joined.points[:2], [[1, 0.5, 1], [1.5, 0, 1]], atol=1e-6)
    assert joined.length(np.array([3.0]))[0] == pytest.approx(np.sqrt(0.5) + 3.0, abs=0.05)


def test_a_tube_is_free_and_ends_where_the_way_is_blocked() -> None:
    world = World(shapes=(Box((5, -5, 0), (5.2, 5, 3)),))
    waypoints = np.array([[x, 0, 1] for x in range(8)], float)
    kept, radii = free_tube(waypoints, world, 0.3)
    np.testing.assert_array_equal(kept[5:], np.repeat(kept[4:5], 3, axis=0))
    assert kept[-1, 0] == 4
    assert radii[3] == pytest.approx(0.7, abs=1e-3)
    with pytest.raises(Infeasible, match="waypoints\\[1\\]"):
        free_tube(waypoints[4:], world, 0.3)


@pytest.mark.parametrize("seed", range(5))
def test_a_plan_begins_where_the_vehicle_is_stays_free_and_ends_at_rest(seed: int) -> None:
    rng = np.random.default_rng(seed)
    trunks = [Cylinder((x, side * rng.uniform(0.7, 1.0)), 0.2, (0, 4)) for x in range(9) for side in (-1, 1)]
    world = World(shapes=tuple(trunks))
    state = np.array([[2.0, rng.uniform(-0.1, 0.1), 1], [1.0, 0.3, 0], [0.5, -0.5, 0]])
    plan = track_target(TIMES, straight(TIMES), 3.0, state, world, PURSUIT)
    curve = plan.trajectory
    np.testing.assert_allclose([curve(0.0, order) for order in range(3)], state, atol=1e-6)
    np.testing.assert_allclose([curve(curve.duration, order) for order in (1, 2)], 0, atol=1e-6)
    assert world.distance(curve(np.linspace(0, curve.duration, 2000))).min() >= PURSUIT.clearance
    assert largest_norm(curve, 1).value <= 4.0
    assert largest_norm(curve, 2).value <= 6.0


def test_it_waits_for_a_target_that_stands() -> None:
    standing = np.tile([3.0, 0, 1], (len(TIMES), 1)) + 0.01 * np.sin(9 * TIMES)[:, None]
    plan = track_target(TIMES, standing, 3.0, at_rest(2.9, 0.0, 1.0), World(), PURSUIT)
    assert np.linalg.norm(plan.trajectory(np.linspace(0, 2, 50)) - [2.9, 0, 1], axis=1).max() < 0.3


def test_all_that_is_wrong_is_told_at_once() -> None:
    with pytest.raises(InputError) as raised:
        track_target(TIMES[::-1], straight(TIMES), -1.0, np.zeros((2, 3)), World())
    assert {problem.place for problem in raised.value.problems} == {"times", "now", "state"}
