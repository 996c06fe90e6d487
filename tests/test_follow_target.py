"""The example that follows a moving target."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest
from PIL import Image

SCRIPT = Path(__file__).parents[1] / "examples" / "follow_target.py"


@pytest.fixture(scope="module")
def example() -> ModuleType:
    spec = importlib.util.spec_from_file_location("follow_target", SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["follow_target"] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


def test_it_stays_clear_and_in_its_band(example: ModuleType, tmp_path: Path) -> None:
    world, flown = example.follow(duration=14)
    numbers = flown.numbers()
    assert numbers["least clearance (m)"] >= example.PURSUIT.clearance
    assert numbers["distance to the target, least (m)"] >= example.BAND[0]
    assert numbers["distance to the target, largest (m)"] <= example.BAND[1]
    example.picture(world, flown, tmp_path / "followed.png")
    with Image.open(tmp_path / "followed.png") as image:
        assert min(image.size) > 600
