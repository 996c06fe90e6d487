"""Maps drawn as pictures: dark pixels are walls."""

import struct
import warnings
import zlib
from dataclasses import dataclass
from io import BytesIO
from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Le
from numpy.typing import NDArray
from PIL import Image, ImageOps, UnidentifiedImageError

from crosstrack.types import Finite, Positive
from crosstrack.world.files import Files, read, refuse
from crosstrack.world.grids import MOST_CELLS, Occupied, Relief

Grey = NDArray[np.uint8]
Steps = Annotated[int, Ge(0), Le(1000)]
MODES = ("1", "L", "LA", "P", "RGB", "RGBA", "CMYK")


@dataclass(frozen=True)
class ImageMap:
    """A PNG or JPG as a map seen from above, north up: dark pixels stand as walls on the ground.

    A pixel is free when its grey is above the threshold. Then the free space is dilated and eroded, in this
    order, each step by a 3x3 square; what lies beyond the edge of the picture changes nothing. Eroding free
    space makes walls thicker. So `dilate: 1, erode: 4` is `dilate(map, iterations=1)` then `erode(map,
    iterations=4)` on white free space.
    """

    file: str
    """PNG or JPG of at most 16 million pixels, relative to the mission's folder; transparent is white"""
    resolution: Positive = 0.1
    """m, edge of a pixel"""
    threshold: Literal["otsu"] | Annotated[int, Ge(0), Le(255)] = "otsu"
    """grey up to which a pixel is a wall; `otsu` finds the one that separates dark from light best"""
    height: Positive = 3.0
    """m, of the walls above the ground"""
    erode: Steps = 0
    """times that the free space is eroded, after it was dilated"""
    dilate: Steps = 0
    """times that the free space is dilated"""
    origin: tuple[Finite, Finite] = (0.0, 0.0)
    """m, where the lower left corner of the picture lies"""

    def build(self, files: Files, ground: float = 0.0) -> Relief:
        """Read the picture and return its walls.

        Raises:
            InputError: the picture is missing, broken or too large, or is of one shade where Otsu's threshold
            is due.
        """
        grey = greys(self.file, read(files, self.file))
        if self.threshold == "otsu":
            level = otsu(np.bincount(grey.ravel(), minlength=256))
            if level is None:
                message = f"all pixels have grey {grey[0, 0]}: nothing to separate; give a threshold from 0 to 255"
                raise refuse(self.file, "threshold", message)
        else:
            level = self.threshold
        free = grow_and_shrink(grey > level, self.dilate, self.erode)
        return Relief(~free[::-1].T, self.origin, self.resolution, (ground, ground + self.height))


def greys(name: str, data: bytes) -> Grey:
    """Return the greys (rows, columns) of a picture, first row on top, by the weights of ITU-R BT.601."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            picture = Image.open(BytesIO(data), formats=("PNG", "JPEG"))
        if picture.width * picture.height > MOST_CELLS:
            size = f"{picture.width} x {picture.height}"
            raise refuse(name, "size", f"{size} pixels; at most {MOST_CELLS} in all")
        if picture.mode not in MODES:
            raise refuse(name, "mode", f"pixels are {picture.mode!r}; save it with 8 bits a channel")
        upright = ImageOps.exif_transpose(picture).convert("RGBA")
    except Image.DecompressionBombError as error:
        raise refuse(name, "size", f"far too many pixels; at most {MOST_CELLS}") from error
    except UnidentifiedImageError as error:
        raise refuse(name, "", "not a PNG or JPG") from error
    except (OSError, SyntaxError, ValueError, EOFError, struct.error, zlib.error) as error:
        raise refuse(name, "", f"not a PNG or JPG that can be read: {error}") from error
    paper = Image.new("RGBA", upright.size, "white")
    return np.asarray(Image.alpha_composite(paper, upright).convert("L"))


def otsu(histogram: NDArray[np.int64]) -> int | None:
    """Return the lowest grey that splits a histogram (256,) with the greatest variance between the parts.

    With w the share of pixels up to a grey, μ their part of the mean and M the mean, that variance is
    σ² = (M w - μ)² / (w (1 - w)); None when there is one grey only.

    Source: Otsu 1979, A threshold selection method from gray-level histograms, equation 18.
    """
    share = histogram / histogram.sum()
    weight, part = np.cumsum(share), np.cumsum(share * np.arange(len(share)))
    spread = weight * (1 - weight)
    split = np.flatnonzero((np.cumsum(histogram) > 0) & (np.cumsum(histogram) < histogram.sum()))
    if not split.size:
        return None
    between = (part[-1] * weight[split] - part[split]) ** 2 / spread[split]
    return int(split[np.argmax(between)])


def grow_and_shrink(free: Occupied, dilate: int, erode: int) -> Occupied:
    """Dilate, then erode free space by 3x3 squares."""
    from scipy.ndimage import binary_dilation, binary_erosion  # noqa: PLC0415 - takes long to import, and few missions need it

    square = np.ones((3, 3), dtype=bool)
    if dilate:
        free = binary_dilation(free, square, iterations=dilate)
    if erode:
        free = binary_erosion(free, square, iterations=erode, border_value=1)
    return free
