"""Calls about what is drawn into the scene."""

from collections.abc import Sequence

from numpy.typing import ArrayLike

from crosstrack.airsim.client.call import Call, query
from crosstrack.airsim.structs import Pose

RED = (1.0, 0.0, 0.0, 1.0)


class Markers:
    """Calls about what is drawn into the scene."""

    @query
    def flush_persistent_markers(self) -> Call[None]:
        """Take away all that was drawn to stay."""
        return Call("simFlushPersistentMarkers")

    @query
    def plot_points(
        self,
        points: ArrayLike,
        color: ArrayLike = RED,
        size: float = 10.0,
        duration: float = -1.0,
        persistent: bool = False,
    ) -> Call[None]:
        """Draw points (n, 3) m."""
        return Call("simPlotPoints", points, color, size, duration, persistent)

    @query
    def plot_line_strip(
        self,
        points: ArrayLike,
        color: ArrayLike = RED,
        thickness: float = 5.0,
        duration: float = -1.0,
        persistent: bool = False,
    ) -> Call[None]:
        """Draw a line through points (n, 3) m."""
        return Call("simPlotLineStrip", points, color, thickness, duration, persistent)

    @query
    def plot_line_list(
        self,
        points: ArrayLike,
        color: ArrayLike = RED,
        thickness: float = 5.0,
        duration: float = -1.0,
        persistent: bool = False,
    ) -> Call[None]:
        """Draw lines between points (2 n, 3) m, two by two."""
        return Call("simPlotLineList", points, color, thickness, duration, persistent)

    @query
    def plot_arrows(
        self,
        starts: ArrayLike,
        ends: ArrayLike,
        color: ArrayLike = RED,
        thickness: float = 5.0,
        head: float = 2.0,
        duration: float = -1.0,
        persistent: bool = False,
    ) -> Call[None]:
        """Draw arrows between points (n, 3) m."""
        return Call("simPlotArrows", starts, ends, color, thickness, head, duration, persistent)

    @query
    def plot_strings(
        self,
        strings: Sequence[str],
        positions: ArrayLike,
        scale: float = 5.0,
        color: ArrayLike = RED,
        duration: float = -1.0,
    ) -> Call[None]:
        """Write texts at points (n, 3) m."""
        return Call("simPlotStrings", strings, positions, scale, color, duration)

    @query
    def plot_transforms(
        self,
        poses: Sequence[Pose],
        scale: float = 5.0,
        thickness: float = 5.0,
        duration: float = -1.0,
        persistent: bool = False,
    ) -> Call[None]:
        """Draw the axes of poses."""
        return Call("simPlotTransforms", poses, scale, thickness, duration, persistent)

    @query
    def plot_transforms_with_names(
        self,
        poses: Sequence[Pose],
        names: Sequence[str],
        scale: float = 5.0,
        thickness: float = 5.0,
        text_scale: float = 10.0,
        text_color: ArrayLike = RED,
        duration: float = -1.0,
    ) -> Call[None]:
        """Draw the axes of poses, with names."""
        return Call("simPlotTransformsWithNames", poses, names, scale, thickness, text_scale, text_color, duration)
