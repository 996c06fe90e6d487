"""Which ray of a scan went nearest to a direction, found in a picture of all directions."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crosstrack.compiled import compiled
from crosstrack.sense.pose import Turn
from crosstrack.types import Array

MOST_TEXELS = 4096
"""around, and half as many upwards"""
FINER = 3
"""texels across the usual angle between rays"""
SPREADS = 3
"""texels to each side that a ray answers for where no other does"""
Singles = NDArray[np.float32]
ZERO, TINY = np.float32(0.0), np.float32(1e-30)
QUARTER, HALF = np.float32(0.5 * math.pi), np.float32(math.pi)
"""rad, of a turn"""
A1, A3, A5 = np.float32(0.9998660), np.float32(-0.3302995), np.float32(0.1801410)
A7, A9 = np.float32(-0.0851330), np.float32(0.0208351)
"""of the polynomial of the arctangent"""


class RangeImage(NamedTuple):
    """The rays of a scan as a picture by bearing and elevation in the body."""

    directions: Array
    """(rays, 3) unit vectors, body"""
    rays: NDArray[np.int32]
    """(up, around) the ray nearest to each texel, -1 for none"""
    start: tuple[float, float]
    """rad, bearing and elevation where the first texel begins"""
    scale: tuple[float, float]
    """texels/rad, around and up"""
    rows: int
    """of the picture that the rays form"""
    scans: NDArray[np.int64]
    """(1,) that were compared with what is held"""


def image_of(directions: Array, rows: int) -> RangeImage:
    """Return the picture of rays (n, 3) in the body that form so many rows."""
    rows = rows if rows > 0 and len(directions) % rows == 0 else 1
    bearing, up = np.arctan2(directions[:, 1], directions[:, 0]), np.arcsin(np.clip(directions[:, 2], -1, 1))
    across = _step(np.diff(bearing.reshape(rows, -1), axis=1))
    above = _step(np.diff(up.reshape(rows, -1), axis=0)) if rows > 1 else across
    around = int(np.clip(round(FINER * 2 * np.pi / across), 8, MOST_TEXELS))
    high = int(np.clip(round(FINER * np.pi / above), 4, MOST_TEXELS // 2))
    scale = (around / (2 * math.pi), high / math.pi)
    start = (_before(bearing[0], -math.pi, scale[0]), _before(up[0], -math.pi / 2, scale[1]))
    rays = np.full((high + 2, around), -1, dtype=np.int32)
    rays[_texel(up, start[1], scale[1]), _texel(bearing, start[0], scale[0]) % around] = np.arange(len(directions))
    return RangeImage(np.ascontiguousarray(directions), _spread(rays), start, scale, rows, np.zeros(1, dtype=np.int64))


def _step(steps: Array) -> float:
    """Return the usual size of steps between neighbouring rays, rad."""
    steps = np.abs((steps + np.pi) % (2 * np.pi) - np.pi)
    steps = steps[steps > 1e-6]
    return float(np.median(steps)) if steps.size else 2 * np.pi / MOST_TEXELS


def _before(angle: float, low: float, scale: float) -> float:
    """Return where texels begin, at `low` (rad) or just below, so that an angle is in the middle of one."""
    return angle - (math.ceil((angle - low) * scale - 0.5) + 0.5) / scale


def _texel(angle: Array, start: float, scale: float) -> NDArray[np.int64]:
    return np.floor((angle - start) * scale).astype(np.int64)


def _spread(rays: NDArray[np.int32]) -> NDArray[np.int32]:
    """Fill texels without a ray from those beside them, all around, and above and below."""
    for _ in range(SPREADS):
        for axis, shift in ((1, 1), (1, -1), (0, 1), (0, -1)):
            beside = np.roll(rays, shift, axis=axis)
            if axis == 0:
                beside[0 if shift > 0 else -1] = -1
            rays = np.where(rays < 0, beside, rays)
    return np.ascontiguousarray(rays)


@compiled
def sights(image: RangeImage, turn: Turn, count: int, x: Singles, y: Singles, z: Singles) -> None:
    """Replace the first `count` of some vectors (n,) m in the world by where the picture has them, and their length, m.

    All is single precision without branches, so that the compiler does eight at once. Angles are right within 2e-5 rad.

    Args:
        image: of rays
        turn: from the body to the world
        count: how many of the vectors
        x: (n,) m; texels from the left edge of the picture, in the end
        y: (n,) m; texels from its lower edge, in the end, negative below it
        z: (n,) m; the length, in the end
    """
    start, low = np.float32(image.start[0]), np.float32(image.start[1])
    across, upward = np.float32(image.scale[0]), np.float32(image.scale[1])
    a, b, c = np.float32(turn[0]), np.float32(turn[1]), np.float32(turn[2])
    d, e, f = np.float32(turn[3]), np.float32(turn[4]), np.float32(turn[5])
    g, h, i = np.float32(turn[6]), np.float32(turn[7]), np.float32(turn[8])
    for k in range(count):
        ahead, left = a * x[k] + d * y[k] + g * z[k], b * x[k] + e * y[k] + h * z[k]
        above = c * x[k] + f * y[k] + i * z[k]
        square = ahead * ahead + left * left
        flat = np.sqrt(square)
        x[k] = (arctangent(left, ahead) - start) * across
        y[k] = (arctangent(above, flat) - low) * upward
        z[k] = np.sqrt(square + above * above)


@compiled
def nearest_rays(image: RangeImage, count: int, x: Singles, y: Singles, out: NDArray[np.int32]) -> None:
    """Set the rays (n,) nearest to the first `count` places in the picture, see `sights`; -1 for none."""
    rays, around, high = image.rays.ravel(), image.rays.shape[1], image.rays.shape[0]
    for k in range(count):
        i, j = int(x[k]), int(y[k])
        i = i - around if i >= around else i
        out[k] = rays[j * around + i] if y[k] >= 0.0 and j < high else -1


@compiled
def arctangent(y: np.float32, x: np.float32) -> np.float32:
    """Return the angle of a plane vector within 2e-5 rad.

    Source: M. Abramowitz and I. Stegun, Handbook of Mathematical Functions, 4.4.47.
    """
    ax, ay = abs(x), abs(y)
    a = min(ax, ay) / (max(ax, ay) + TINY)
    s = a * a
    angle = a * (A1 + s * (A3 + s * (A5 + s * (A7 + s * A9))))
    angle = QUARTER - angle if ay > ax else angle
    angle = HALF - angle if x < ZERO else angle
    return -angle if y < ZERO else angle


@compiled
def least_around(values: Array, rows: int) -> Array:
    """Return the least of each ray (n,) and the eight around it in its picture, which closes around."""
    columns = len(values) // rows
    beside, out = np.empty(len(values)), np.empty(len(values))
    for i in range(rows):
        at = i * columns
        last = at + columns - 1
        for j in range(at + 1, last):
            beside[j] = min(values[j - 1], values[j], values[j + 1])
        beside[at] = min(values[last], values[at], values[min(at + 1, last)])
        beside[last] = min(values[max(last - 1, at)], values[last], values[at])
    for i in range(rows):
        below, above = max(i - 1, 0) * columns, min(i + 1, rows - 1) * columns
        for j in range(columns):
            out[i * columns + j] = min(beside[i * columns + j], beside[below + j], beside[above + j])
    return out
