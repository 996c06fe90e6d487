"""Worlds from a seed: forest, maze, city blocks, a wall with a gap, a trap."""

from crosstrack.world.generate.city import City
from crosstrack.world.generate.forest import Forest
from crosstrack.world.generate.gap import Gap
from crosstrack.world.generate.maze import Maze
from crosstrack.world.generate.trap import Trap

__all__ = ["City", "Forest", "Gap", "Maze", "Trap"]
