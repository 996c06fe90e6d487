"""What every method does, by its name: a function of the simulator and the arguments of the call."""

from collections.abc import Callable
from typing import Any

from crosstrack.airsim.server.handlers import (
    cameras,
    clock,
    environment,
    flight,
    images,
    lenses,
    markers,
    objects,
    recording,
    sensing,
    state,
)

THEMES = (cameras, clock, environment, flight, images, lenses, markers, objects, recording, sensing, state)
HANDLERS: dict[str, Callable[..., Any]] = {
    name: handler for theme in THEMES for name, handler in vars(theme)["HANDLERS"].items()
}
"""a long call returns the future of its result"""
