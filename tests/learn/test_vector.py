"""Many vehicles at once fly as one does, and are judged as they should be."""

from dataclasses import replace
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from hypothesis import given, settings
from hypothesis import strategies as st

from crosstrack.campaign.avoidance.families import Arena
from crosstrack.learn import tasks
from crosstrack.learn.agents import ARRIVED, COLLIDED, LEFT_BOUNDS, TIMED_OUT
from crosstrack.learn.avoid import Avoid
from crosstrack.learn.randomise import NOMINAL
from crosstrack.learn.rewards import TERMS, Rewards
from crosstrack.learn.single import Single
from crosstrack.learn.vector import Vector
from crosstrack.policy.action import CLIMB

CALM = Avoid(randomise=NOMINAL, noise=0.0, maps=4)
FINE = 0.0025
OPEN = Arena("open", 0, (0.0, 0.0, 1.5), (10.0, 0.0, 1.5), {"bounds": [[-5, -5, 0], [20, 5, 3]], "shapes": []})
WALL = replace(OPEN, world={**OPEN.world, "shapes": [{"box": {"min": [4, -9, 0], "max": [4.2, 9, 3]}}]})
AHEAD = np.array([[1.0, 0.0, 0.0]])


def ended(env: Vector, action: Any, most: int = 700) -> tuple[int, dict[str, Any]]:
    """Fly one action until the episode of the first vehicle ends; return after how many steps, and its account."""
    for k in range(most):
        _, _, _, _, infos = env.step(np.repeat(action, env.num_envs, axis=0))
        if infos and infos["_episode"][0]:
            account = {name: values[0] for name, values in infos["episode"].items()}
            return k + 1, account | {"final": infos["final_obs"][0]}
    raise AssertionError("no end")


@pytest.mark.parametrize("name", tasks.TASKS)
def test_the_environments_are_sound(name: str) -> None:
    options: dict[str, Any] = {} if name == "hover" else {"maps": 4}
    env = gymnasium.make(f"crosstrack/{name.title()}-v0", **options)
    check_env(env.unwrapped, skip_render_check=True)
    many = gymnasium.make_vec(f"crosstrack/{name.title()}-v0", num_envs=3, **options)
    seen, _ = many.reset(seed=1)
    assert seen in many.observation_space
    assert many.metadata["autoreset_mode"] is gymnasium.vector.AutoresetMode.SAME_STEP


@pytest.mark.parametrize(
    "task",
    [
        CALM,
        replace(CALM, action="stick"),
        replace(CALM, action="attitude", observation="depth"),
        tasks.find("hover")(randomise=NOMINAL),
        tasks.find("follow")(randomise=NOMINAL, maps=4),
        tasks.find("follow")(randomise=replace(NOMINAL, mass=0.3, drag=0.5, motor_time=0.3, wind=4.0), maps=4),
    ],
    ids=["avoid", "sticks", "depth", "hover", "follow", "windy"],
)
def test_one_vehicle_of_many_flies_as_a_single_one(task: Any) -> None:
    single, many = Single(task), Vector(task, 3, step=FINE)
    many.agents["random"][0] = 0
    one, _ = single.reset(seed=5)
    many.reset(seed=5)
    many.agents["random"][1] = Vector(task, 1, 5).agents["random"][0]
    many.begin(np.array([1]))
    many.look()
    np.testing.assert_allclose(many.observations[1], one, atol=1e-6)
    rng = np.random.default_rng(0)
    for _ in range(60):
        action = int(rng.integers(27)) if task.action == "stick" else rng.uniform(-0.3, 0.3, single.action_space.shape)
        one, reward, terminated, truncated, _ = single.step(action)
        seen, rewards, ends, cuts, _ = many.step(np.stack([np.asarray(action)] * 3))
        assert (terminated, truncated) == (ends[1], cuts[1])
        assert reward == pytest.approx(rewards[1], abs=1e-9)
        if terminated or truncated:
            break
        np.testing.assert_allclose(seen[1], one, atol=2e-6)
        np.testing.assert_allclose(many.rows["state"][1, :13], single.core.rows["state"][0, :13], atol=1e-9)


def test_twice_the_step_changes_a_steady_flight_by_centimetres() -> None:
    coarse, fine = (Vector(CALM, 4, 1, step=step) for step in (0.005, FINE))
    coarse.reset(seed=2)
    fine.reset(seed=2)
    action = np.random.default_rng(3).uniform(-1, 1, (4, 3)) * [1, 1, 0.3]
    for _ in range(40):
        ends = [env.step(action)[2] for env in (coarse, fine)]
        if np.any(ends):
            break
    away = np.linalg.norm(coarse.rows["state"][:, :3] - fine.rows["state"][:, :3], axis=1)
    assert 0 < away.max() < 0.05


def test_the_same_seed_gives_the_same_episodes_and_what_is_recalled_goes_on_the_same() -> None:
    task = Avoid(maps=4)
    one, two = Vector(task, 5, 7), Vector(task, 5, 7)
    np.testing.assert_array_equal(one.reset(seed=3)[0], two.reset(seed=3)[0])
    assert not np.array_equal(one.reset(seed=4)[0], two.reset(seed=3)[0])
    for _ in range(5):
        one.step(np.ones((5, 3)))
    np.testing.assert_array_equal(one.reset(seed=3)[0], two.reset(seed=3)[0])
    rng = np.random.default_rng(0)
    for _ in range(30):
        action = rng.uniform(-1, 1, (5, 3))
        np.testing.assert_array_equal(one.step(action)[0], two.step(action)[0])
    other = Vector(task, 5, 7)
    other.recall(one.memory())
    for _ in range(300):
        action = rng.uniform(-0.2, 1, (5, 3))
        for a, b in zip(one.step(action)[:4], other.step(action)[:4], strict=True):
            np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize(
    ("arena", "action", "outcome"),
    [
        (OPEN, AHEAD, ARRIVED),
        (WALL, AHEAD, COLLIDED),
        (OPEN, np.array([[0.0, 0.0, 1.0]]), LEFT_BOUNDS),
        (OPEN, np.zeros((1, 3)), TIMED_OUT),
    ],
)
def test_episodes_end_as_they_should(arena: Arena, action: Any, outcome: int) -> None:
    task = replace(CALM, timeout=6.0, rewards=Rewards(progress=2.0, arrival=3.0, failure=7.0))
    env = Vector(task, 2, arenas=[arena])
    env.reset()
    steps, account = ended(env, action)
    assert account["outcome"] == outcome
    assert account["t"] == pytest.approx(steps * task.period)
    remains = 5 / account["final"][task.rays + 2] - 5
    assert account["reward_progress"] == pytest.approx(2.0 * (10 - remains), abs=0.25)
    assert remains == pytest.approx({ARRIVED: 1.5, COLLIDED: 6.2, TIMED_OUT: 10.0}.get(outcome, remains), abs=0.25)
    assert account["reward_arrival"] == (3.0 if outcome == ARRIVED else 0.0)
    assert account["reward_failure"] == (-7.0 if outcome in {COLLIDED, LEFT_BOUNDS} else 0.0)
    assert account["r"] == pytest.approx(sum(account[f"reward_{name}"] for name in TERMS))
    assert (env.agents["steps"] == 0).all(), "the next episode has begun"
    if outcome == COLLIDED:
        assert account["clearance"] < task.radius


def test_what_was_seen_last_is_passed_on() -> None:
    env = Vector(CALM, 2, arenas=[OPEN])
    env.reset()
    while True:
        seen, _, terminated, _, infos = env.step(np.repeat(AHEAD, 2, axis=0))
        if terminated.any():
            break
    near, far = infos["final_obs"][0][CALM.rays + 2], seen[0][CALM.rays + 2]
    assert near == pytest.approx(5 / 6.5, abs=0.02)
    assert far == pytest.approx(5 / 15, abs=1e-6)


FAR = replace(OPEN, start=(0.0, 0.0, 50.0), goal=(80.0, 0.0, 50.0), world={"bounds": [[-99] * 3, [99] * 3]})


@settings(max_examples=20)
@given(st.floats(-1, 1), st.floats(-1, 1))
def test_velocities_asked_for_are_flown(ahead: float, up: float) -> None:
    task = replace(CALM, timeout=60.0)
    env = Vector(task, 1, arenas=[FAR])
    env.reset()
    for _ in range(60):
        env.step(np.array([[max(ahead, -0.29), 0.0, up]]))
    wanted = [task.speed * max(ahead, -0.29), 0.0, CLIMB * up]
    np.testing.assert_allclose(env.rows["state"][0, 3:6], wanted, atol=0.15)


@pytest.mark.parametrize(("left", "turns"), [(1.0, 2.4), (-1.0, -2.4), (0.05, 1.0), (0.0, 0.0)])
def test_the_heading_turns_to_where_it_flies(left: float, turns: float) -> None:
    task = replace(CALM, timeout=60.0)
    env = Vector(task, 1, arenas=[FAR])
    env.reset()
    for _ in range(10):
        env.step(np.array([[1.0 if abs(left) < 1 else 0.0, left, 0.0]]))
    seconds = 10 * task.period
    assert abs(env.agents["asked"][0, 3]) <= 2.4 * seconds + 1e-9
    if abs(left) == 1:
        assert env.agents["asked"][0, 3] == pytest.approx(turns * seconds, rel=0.15)
    else:
        assert (env.agents["asked"][0, 3] > 1e-3) == (left > 0)


def test_sticks_move_by_notches_and_stay() -> None:
    task = replace(CALM, action="stick", timeout=60.0)
    env = Vector(task, 1, arenas=[FAR])
    env.reset()
    held, faster, turning = 13, 13 + 3, 13 + 1
    for action in [faster] * 4 + [turning] * 10 + [held] * 60:
        env.step(np.array([action]))
    assert env.agents["asked"][0, 0] == pytest.approx(4 * 2.5 * task.period)
    assert env.agents["asked"][0, 3] == pytest.approx(10 * 2.4 * task.period)
    speed, heading = task.speed * 0.5, 10 * 2.4 * task.period
    wanted = [speed * np.cos(heading), speed * np.sin(heading), 0.0]
    np.testing.assert_allclose(env.rows["state"][0, 3:6], wanted, atol=0.1)


def test_episodes_differ_as_far_as_they_may() -> None:
    task = Avoid(maps=4)
    spread = task.randomise
    env = Vector(task, 400)
    env.reset(seed=0)
    masses = env.rows["mass"] / env.rows["known_mass"]
    assert 1 - spread.mass <= masses.min() < 1 - 0.9 * spread.mass
    assert 1 + 0.9 * spread.mass < masses.max() <= 1 + spread.mass
    wind = np.linalg.norm(env.agents["mean"], axis=1)
    assert 0.9 * spread.wind < wind.max() <= spread.wind
    assert set(env.agents["delay"]) == {0, 1, 2}
    assert set(env.agents["arena"]) == {0, 1, 2, 3}
    assert abs(np.corrcoef(masses, wind)[0, 1]) < 0.15


def test_worlds_held_out_are_never_trained_in() -> None:
    task = Avoid(maps=4)
    kept, trained = (Vector(task, 4, 0, held_out=flag).field.worlds for flag in (True, False))
    assert {world.shapes for world in kept}.isdisjoint({world.shapes for world in trained})
    env = Vector(task, 4, 3, held_out=True)
    env.reset()
    assert env.agents["arena"].tolist() == [0, 1, 2, 3]
