"""Obstacles seen from above, as an image: as cheap for a hundred thousand triangles as for ten."""

import base64
import io

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from crosstrack.flight.scene import Scene
from crosstrack.show.style import FOOTPRINT
from crosstrack.types import Array

PIXELS = 1600
"""of the longer side"""
OUTLINE = 5
"""pixels, so that a wall thinner than one is seen"""


def footprint(scene: Scene, box: Array, color: str = FOOTPRINT) -> Image.Image:
    """Return the obstacles over the x and y of a box (2, 3) m, clear where there are none, north up."""
    sides = (box[1] - box[0])[:2]
    scale = PIXELS / float(sides.max())
    width, height = np.ceil(sides * scale).astype(int).tolist()
    image = Image.new("P", (width, height), 0)
    image.putpalette([255, 255, 255, *bytes.fromhex(color[1:])])
    image.info["transparency"] = 0
    pen = ImageDraw.Draw(image)
    for _, vertices, triangles in scene.meshes:
        across = (vertices[:, :2] - box[0, :2]) * scale
        corners = np.column_stack([across[:, 0], height - across[:, 1]])[triangles]
        for corner in corners[facing_up(vertices[triangles])].reshape(-1, 6).tolist():
            pen.polygon(corner, fill=1, outline=1, width=OUTLINE)
    return image


def facing_up(corners: Array) -> NDArray[np.bool_]:
    """Return which triangles (n, 3, 3) m face upward, (n,) bool: walls have no extent from above."""
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.asarray(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0] > 1e-12)


def address(image: Image.Image) -> str:
    """Return an image as an address that holds it."""
    file = io.BytesIO()
    image.save(file, "PNG", optimize=False)
    return "data:image/png;base64," + base64.b64encode(file.getvalue()).decode()
