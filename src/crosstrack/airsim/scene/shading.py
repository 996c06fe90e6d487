"""Pictures of what rays hit, with one sun, without shadows."""

import math

import numpy as np
from numpy.typing import NDArray

from crosstrack.airsim.scene.trace import BEFORE, GROUND, SKY, Numbers, normal
from crosstrack.compiled import compiled
from crosstrack.types import Array
from crosstrack.world.table import Table

Bytes = NDArray[np.uint8]
SUN = (0.48, 0.36, 0.8)
"""unit vector towards it, ENU"""
AMBIENT = 0.45
"""of the light that comes from everywhere"""
HAZE = 400.0
"""m, over which distance takes two thirds of the colours away"""
TILE = 2.0
"""m, of the ground's pattern: something that flow and features can be measured on"""
FADE = 120.0
"""m, over which the pattern fades, as pixels get larger than its tiles"""
HORIZON, ZENITH = (200.0, 216.0, 232.0), (92.0, 146.0, 214.0)
"""red, green, blue of the sky"""
GRASS = (116.0, 128.0, 98.0)
"""red, green, blue of the ground"""


def colours(numbers: Numbers) -> Array:
    """Return a colour (n, 3) red, green, blue for each thing, from its number: of much the same brightness."""
    hue = (np.asarray(numbers) * 0.61803398875) % 1.0
    angle = 2 * np.pi * (hue[:, None] + np.array([0.0, 1 / 3, 2 / 3]))
    bright: Array = 150.0 + 70.0 * np.cos(angle)
    return bright


@compiled
def sky(dz: float) -> tuple[float, float, float]:
    """Return the colour of the sky along a ray that climbs so much per metre."""
    up = math.sqrt(max(dz, 0.0))
    return (
        HORIZON[0] + up * (ZENITH[0] - HORIZON[0]),
        HORIZON[1] + up * (ZENITH[1] - HORIZON[1]),
        HORIZON[2] + up * (ZENITH[2] - HORIZON[2]),
    )


@compiled
def pattern(x: float, y: float, far: float) -> float:
    """Return how bright the ground is at a point of the plane (m), seen from some way (m)."""
    odd = (math.floor(x / TILE) + math.floor(y / TILE)) % 2.0
    return 1.0 + (0.16 * odd - 0.08) * math.exp(-far / FADE)


@compiled
def shade(
    table: Table,
    balls: Array,
    origin: Array,
    directions: Array,
    ranges: Array,
    seen: Numbers,
    rows: Numbers,
    things: Array,
) -> Bytes:
    """Return the picture (n, 3) blue, green, red.

    Args:
        table: obstacles
        balls: (k, 4) of other vehicles
        origin: (3,) m, ENU
        directions: (n, 3) ENU
        ranges: (n,) m
        seen: (n,) which thing
        rows: (n,) which obstacle
        things: (things, 3) red, green, blue of each
    """
    out, after = np.empty((len(ranges), 3), dtype=np.uint8), len(things) - len(balls)
    for r in range(len(ranges)):
        dx, dy, dz, what = directions[r, 0], directions[r, 1], directions[r, 2], seen[r]
        red, green, blue = sky(dz)
        if what != SKY:
            t = ranges[r] - BEFORE
            x, y, z = origin[0] + t * dx, origin[1] + t * dy, origin[2] + t * dz
            clear = math.exp(-t / HAZE)
            if what == GROUND:
                light = (AMBIENT + (1.0 - AMBIENT) * SUN[2]) * pattern(x, y, t)
            else:
                nx, ny, nz = normal(table, balls, after, what, rows[r], (x, y, z))
                light = AMBIENT + (1.0 - AMBIENT) * max(nx * SUN[0] + ny * SUN[1] + nz * SUN[2], 0.0)
            one, two, three = things[what, 0], things[what, 1], things[what, 2]
            red += clear * (light * one - red)
            green += clear * (light * two - green)
            blue += clear * (light * three - blue)
        out[r, 0], out[r, 1], out[r, 2] = (
            np.uint8(min(blue, 255.0)),
            np.uint8(min(green, 255.0)),
            np.uint8(min(red, 255.0)),
        )
    return out
