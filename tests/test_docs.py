"""Every code block of the README and the documentation runs, and every link leads somewhere."""

import os
import re
import shlex
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

import crosstrack as ct
from crosstrack import registry

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
BLOCKS = [
    pytest.param(kind, text, id=f"{page.stem}-{number}-{kind}")
    for page in PAGES
    for number, (kind, text) in enumerate(re.findall(r"^```(\w+)\n(.*?)^```", page.read_text("utf-8"), re.M | re.S))
]


@pytest.fixture
def workplace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(registry, "BUILT_IN", {role: dict(names) for role, names in registry.BUILT_IN.items()})
    registry.table.cache_clear()
    return tmp_path


@contextmanager
def serving(words: list[str]) -> Iterator[None]:
    """Run a command in the background until the block ends; it says when it serves."""
    process = subprocess.Popen([sys.executable, "-m", *words], stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    try:
        while "Serving" not in (line := process.stderr.readline()):
            assert line, f"{shlex.join(words)} has ended"
        yield
    finally:
        process.kill()
        process.wait()
        process.stderr.close()


@pytest.mark.parametrize(("kind", "text"), BLOCKS)
def test_a_block_runs(kind: str, text: str, workplace: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if kind == "python":
        (workplace / "block.py").write_text(text, "utf-8")
        monkeypatch.syspath_prepend(workplace)
        done = subprocess.run([sys.executable, "-m", "block"], check=False, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        assert done.stdout
    elif kind == "console":
        commands = [line.removeprefix("$ ") for line in text.splitlines()]
        with ExitStack() as background:
            for command in commands:
                words = shlex.split(command, comments=True)
                assert words[0] == "crosstrack"
                if words[-1] == "&":
                    background.enter_context(serving(words[:-1]))
                    continue
                done = subprocess.run(
                    [sys.executable, "-m", *words], check=False, capture_output=True, text=True, env=os.environ
                )
                assert done.returncode == 0, f"{command}\n{done.stderr}"
    elif kind == "yaml":
        assert ct.fly(ct.loads(text)).outcome is ct.Outcome.ARRIVED
    elif kind == "sh":
        targets = (ROOT / "Makefile").read_text("utf-8")
        for line in text.splitlines():
            target = line.split()[1]
            assert re.search(rf"^{target}:", targets, re.M), f"no target {target} in the Makefile"
    elif kind == "toml":
        assert tomllib.loads(text)
    else:
        assert kind == "text"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_links_lead_somewhere(page: Path) -> None:
    links = re.findall(r"\]\((?!https?:)([^)#]+)", page.read_text("utf-8"))
    missing = [link for link in links if not (page.parent / link).exists()]
    assert missing == []
