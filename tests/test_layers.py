"""Imports run one way, and nothing heavy is loaded before it is needed."""

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import crosstrack

ROOT = Path(crosstrack.__file__).parent
BASE = {"types", "protocols", "errors", "frames", "compiled", "registry", "lazy", "locks", "vectors", "npz"}
ROLES = {
    "world",
    "path",
    "search",
    "sense",
    "trajectory",
    "plan",
    "follow",
    "track",
    "avoid",
    "sim",
    "vehicles",
    "airsim",
    "policy",
}
EDGES = {
    ("vehicles", "sim"),
    ("vehicles", "airsim"),
    ("vehicles", "sense"),
    ("airsim", "world"),
    ("sim", "world"),
    ("follow", "path"),
    ("avoid", "policy"),
    ("follow", "policy"),
    ("track", "path"),
    ("trajectory", "path"),
    ("plan", "trajectory"),
    ("plan", "search"),
}
ABOVE = ["flight", "mission", "campaign", "learn", "show", "cli"]
"""each may import all before it, the roles and the base"""


def modules() -> Iterator[tuple[str, str, str]]:
    """Yield (file, unit, imported unit) of every import of the package within itself."""
    for path in sorted(ROOT.rglob("*.py")):
        unit = path.relative_to(ROOT).parts[0].removesuffix(".py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom):
                assert node.level == 0, f"{path}: relative import"
                same = [f"{node.module}.{alias.name}" for alias in node.names]
                names = same if node.module == "crosstrack" else [node.module or ""]
            for name in names:
                if name.startswith("crosstrack."):
                    yield str(path.relative_to(ROOT)), unit, name.split(".")[1]


def allowed(unit: str, imported: str) -> bool:
    """Return whether one unit of the package may import another."""
    if unit == imported or imported in BASE:
        return unit not in BASE or imported in BASE
    if unit in ROLES:
        return (unit, imported) in EDGES
    if unit in ABOVE:
        return imported in ROLES or imported in ABOVE[: ABOVE.index(unit)]
    return False


def test_imports_run_one_way() -> None:
    free = {"__init__", "__main__"}  # the public names and the command's door
    wrong = [
        f"{file} imports {imported}"
        for file, unit, imported in modules()
        if unit not in free and imported != "__version__" and not allowed(unit, imported)
    ]
    assert wrong == []


@pytest.mark.parametrize("statement", ["import crosstrack", "import crosstrack.cli"])
def test_nothing_heavy_is_loaded_at_the_start(statement: str) -> None:
    heavy = ["numpy", "numba", "scipy", "pydantic", "plotly", "matplotlib", "yaml", "jinja2"]
    code = f"{statement}; import sys; print(*[name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_public_names_are_all_there_and_lazy_ones_are_listed() -> None:
    for name in crosstrack.__all__:
        assert getattr(crosstrack, name) is not None
    assert set(crosstrack.__all__) <= set(dir(crosstrack))
    with pytest.raises(AttributeError, match="no attribute 'flie'"):
        _ = crosstrack.flie
