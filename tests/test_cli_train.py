"""What `crosstrack train` says to what it cannot do."""

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from crosstrack.cli.app import run

Told = Callable[..., tuple[int, str]]


@pytest.fixture
def told(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Told:
    """What trains on a machine without torch, and returns the exit code and what is said on standard error."""
    monkeypatch.setitem(sys.modules, "torch", None)

    def command(*words: str) -> tuple[int, str]:
        return run(["train", *words]), capsys.readouterr().err

    return command


def test_without_torch_it_says_what_to_install(told: Told, tmp_path: Path) -> None:
    code, said = told("avoid", "--algo", "ppo", "--out", str(tmp_path / "out"))
    assert code == 2
    assert "crosstrack[rl]" in said
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("words", "parts"),
    [
        (["avoid"], ["algo: is required"]),
        (["avoid", "--algo", "pp"], ["algo", "'pp'"]),
        (["avoid", "--algo", "dqn", "--network", "recurrent"], ["network: dqn cannot train 'recurrent'", "ppo: mlp"]),
        (["avoid", "--algo", "ppo", "--preset", "article"], ["preset: 'article' is one of dqn"]),
        (
            ["avoid", "--algo", "ppo", "--steps", "0", "--set", "learning.gama=0.9", "--set", "learning.n_epochs=0"],
            ["steps", "learning.gama", "did you mean 'gamma'", "learning.n_epochs"],
        ),
        (["avoid", "--algo", "ppo", "--set", "gamma"], ["PATH=VALUE"]),
        (["avoid", "--algo", "ppo", "--config", "missing.yaml"], ["missing.yaml"]),
        (["avoid", "--algo", "ppo", "--resume", "--out", "nowhere"], ["nowhere"]),
    ],
)
def test_bad_input_is_told_whole(told: Told, words: list[str], parts: list[str]) -> None:
    code, said = told(*words)
    assert code == 2, said
    for part in parts:
        assert part in said
