"""What is told of a policy in worlds held out is what happened there."""

import io

import numpy as np
from rich.console import Console

from crosstrack.cli.learning_curve import Curve
from crosstrack.learn.agents import ARRIVED, COLLIDED, TIMED_OUT
from crosstrack.learn.avoid import Avoid
from crosstrack.learn.measuring import CHOOSING, Range, summary
from crosstrack.learn.training.config import Training
from crosstrack.learn.training.reading import Asked, training
from crosstrack.policy.file import load
from crosstrack.show.learning import learning_curve


def test_shares_and_means_are_those_of_the_episodes() -> None:
    found = summary(
        {
            "outcome": np.array([ARRIVED, ARRIVED, COLLIDED, TIMED_OUT]),
            "speed": np.array([2.0, 4.0, 9.0, 9.0]),
            "t": np.array([10.0, 20.0, 1.0, 30.0]),
            "clearance": np.array([0.5, 0.3, 0.1, 0.2]),
            "r": np.array([1.0, 2.0, -5.0, 0.0]),
        }
    )
    assert (found.success, found.collided, found.timed_out, found.left_bounds) == (0.5, 0.25, 0.25, 0.0)
    assert (found.speed, found.time, found.clearance, found.reward) == (3.0, 15.0, 0.3, -0.5)
    nothing = summary({name: np.array([value]) for name, value in ACCOUNT.items()})
    assert (nothing.success, nothing.speed, nothing.clearance) == (0.0, None, None)


ACCOUNT = {"outcome": COLLIDED, "speed": 3.0, "t": 1.0, "clearance": 0.1, "r": -1.0}


def test_a_policy_does_the_same_in_the_same_worlds_and_is_chosen_by_others() -> None:
    policy = load("avoid-dqn")
    task = Avoid(action="stick", speed=policy.card.options["speed"])
    arena = Range(task, 20)
    first, second = arena.measure(policy), arena.measure(policy)
    assert first == second
    assert first.success >= 0.6
    worlds = {world.shapes for world in arena.env.field.worlds}
    assert worlds.isdisjoint({world.shapes for world in Range(task, 20, CHOOSING).env.field.worlds})


def test_progress_is_told_without_a_terminal_and_drawn(tmp_path: object) -> None:
    out = io.StringIO()
    asked = training("avoid", Asked("ppo"))
    assert isinstance(asked, Training)
    row = {"steps": 1000, "seconds": 2.0, "success": 0.25, "collided": 0.5, "speed": None}

    class Now:
        steps, seconds, recent, history = 1000, 2.0, {"success": 0.2, "reward": 1.0}, [row, row | {"speed": 3.0}]

    with Curve(Console(file=out, width=90), asked) as curve:
        curve.show(Now)
        curve.show(Now)
    assert out.getvalue().count("success 25.0%") == 2
    shown = Console(file=io.StringIO(), width=90, force_terminal=True, record=True)
    with Curve(shown, asked) as curve:
        curve.show(Now)
    assert "1,000 of 8,000,000" in shown.export_text()


def test_the_learning_curve_is_a_picture(tmp_path: object) -> None:
    row = {"episodes": 10, "success": 0.1, "collided": 0.8, "left_bounds": 0.0, "timed_out": 0.1, "reward": -1.0}
    history = [row | {"steps": k * 1e6, "seconds": 60.0 * k, "success": 0.1 * k} for k in range(1, 6)]
    path = f"{tmp_path}/curve.png"
    learning_curve(history, path, "avoid by ppo")
    with open(path, "rb") as file:
        assert file.read(4) == b"\x89PNG"
