"""Pictures as maps."""

import struct
import zlib
from contextlib import suppress
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray
from PIL import Image

from crosstrack.errors import InputError
from crosstrack.world.grids import Occupied
from crosstrack.world.image import ImageMap, greys, grow_and_shrink, otsu
from crosstrack.world.world import World

Pixels = NDArray[np.uint8]


def picture(pixels: Pixels, kind: str = "PNG") -> bytes:
    out = BytesIO()
    Image.fromarray(pixels).save(out, kind)
    return out.getvalue()


def corner_map() -> Pixels:
    """White, 40 wide and 30 high, with a black block of 10 x 6 pixels in the upper left corner."""
    pixels = np.full((30, 40), 255, dtype=np.uint8)
    pixels[:6, :10] = 0
    return pixels


def between(counts: NDArray[np.int64], level: int) -> float:
    """Variance between the pixels up to a level and those above, straight from its definition."""
    grey = np.arange(256)
    low, high = counts[: level + 1], counts[level + 1 :]
    if not low.sum() or not high.sum():
        return -1.0
    mean = (grey * counts).sum() / counts.sum()
    below, above = (grey[: level + 1] * low).sum() / low.sum(), (grey[level + 1 :] * high).sum() / high.sum()
    return float((low.sum() * (below - mean) ** 2 + high.sum() * (above - mean) ** 2) / counts.sum())


@settings(max_examples=100, deadline=None)
@given(arrays(np.int64, 256, elements=st.integers(0, 1000), fill=st.just(0)))
def test_otsu_maximises_the_variance_between(counts: NDArray[np.int64]) -> None:
    counts[3] += 1
    found = otsu(counts)
    if (counts > 0).sum() < 2:
        assert found is None
        return
    assert found is not None
    best = max(between(counts, level) for level in range(256))
    assert between(counts, found) == pytest.approx(best, rel=1e-9)
    assert found == 0 or between(counts, found - 1) < best or counts[found] > 0


def test_first_row_is_the_north_and_pixels_have_their_size() -> None:
    world = World(
        grids=(ImageMap("m.png", resolution=0.5, origin=(100, -20), height=4).build({"m.png": picture(corner_map())}),)
    )
    inside, beside = np.array([102.5, -6.5, 2.0]), np.array([110.0, -6.5, 2.0])
    assert world.distance(inside) == pytest.approx(-1.5)
    assert world.distance(beside) == pytest.approx(5.0)
    assert world.distance(np.array([102.5, -12.0, 2.0])) == pytest.approx(4.0)
    assert world.distance(np.array([102.5, -6.5, 7.0])) == pytest.approx(3.0)
    np.testing.assert_allclose(world.gradient(beside), [1, 0, 0], atol=1e-12)


def test_walls_stand_on_the_ground() -> None:
    world = World(grids=(ImageMap("m.png", height=2).build({"m.png": picture(corner_map())}, ground=10.0),))
    assert world.distance(np.array([0.5, 2.7, 13.0])) == pytest.approx(1.0)
    assert world.distance(np.array([0.5, 2.7, 9.0])) == pytest.approx(1.0)
    assert world.distance(np.array([0.5, 2.7, 11.0])) == pytest.approx(-0.3)


def test_fixed_threshold_is_the_last_grey_of_a_wall() -> None:
    pixels = np.array([[10, 100, 101, 200]], dtype=np.uint8)
    relief = ImageMap("m.png", threshold=100).build({"m.png": picture(pixels)})
    assert relief.occupied[:, 0].tolist() == [True, True, False, False]


def neighbours(free: Occupied, worst: bool) -> Occupied:
    """The least (worst) or greatest of each pixel and its neighbours, those beyond the edge left out."""
    rows, columns = free.shape
    pick = min if worst else max
    return np.array(
        [
            [
                pick(
                    free[i, j]
                    for i in range(max(row - 1, 0), min(row + 2, rows))
                    for j in range(max(column - 1, 0), min(column + 2, columns))
                )
                for column in range(columns)
            ]
            for row in range(rows)
        ]
    )


@pytest.mark.parametrize(("dilate", "erode"), [(0, 0), (1, 0), (0, 1), (1, 4), (3, 2)])
def test_free_space_is_dilated_then_eroded_as_the_article_does(dilate: int, erode: int) -> None:
    free = np.random.default_rng(1).uniform(size=(14, 17)) < 0.8
    expected = free
    for _ in range(dilate):
        expected = neighbours(expected, worst=False)
    for _ in range(erode):
        expected = neighbours(expected, worst=True)
    np.testing.assert_array_equal(grow_and_shrink(free, dilate, erode), expected)


def test_eroding_free_space_makes_walls_thicker() -> None:
    data = {"m.png": picture(corner_map())}
    occupied = ImageMap("m.png", dilate=1, erode=4).build(data).occupied
    assert occupied.sum() == (10 + 3) * (6 + 3)


@pytest.mark.parametrize("mode", ["1", "L", "LA", "P", "RGB", "RGBA", "CMYK"])
def test_every_mode_of_picture_reads_the_same(mode: str) -> None:
    out = BytesIO()
    Image.fromarray(corner_map()).convert("RGB").convert(mode).save(out, "JPEG" if mode == "CMYK" else "PNG")
    free = greys("m", out.getvalue()) > 127
    np.testing.assert_array_equal(free[:, 16:], corner_map()[:, 16:] > 127)
    np.testing.assert_array_equal(free[:4, :8], corner_map()[:4, :8] > 127)


def test_grey_weighs_colours_as_bt_601() -> None:
    pixels = np.array([[[255, 0, 0], [0, 255, 0], [0, 0, 255]]], dtype=np.uint8)
    assert greys("m", picture(pixels)).tolist() == [[76, 150, 29]]


def test_transparent_pixels_are_white() -> None:
    pixels = np.zeros((2, 2, 4), dtype=np.uint8)
    pixels[0, 0, 3] = 255
    assert greys("m", picture(pixels)).tolist() == [[0, 255], [255, 255]]


def test_jpeg_reads_as_the_picture() -> None:
    relief = ImageMap("m.jpg").build({"m.jpg": picture(corner_map(), "JPEG")})
    block = ~(corner_map()[::-1].T > 127)
    assert (relief.occupied == block).mean() > 0.97


def bomb(width: int, height: int) -> bytes:
    """Return a PNG that says it is huge."""
    header = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    chunk = struct.pack(">I", 13) + header + struct.pack(">I", zlib.crc32(header))
    return b"\x89PNG\r\n\x1a\n" + chunk + struct.pack(">I", 0) + b"IDAT" + struct.pack(">I", zlib.crc32(b"IDAT"))


def sixteen_bits() -> bytes:
    return picture(np.zeros((4, 4), dtype=np.uint16))


@pytest.mark.parametrize(
    ("data", "word"),
    [
        (b"", "not a PNG or JPG"),
        (b"GIF89a", "m.png: 1 problem\n  not a PNG or JPG"),
        (picture(corner_map())[:60], "not a PNG or JPG"),
        (bomb(5000, 5000), "5000 x 5000 pixels; at most 16000000"),
        (bomb(12000, 12000), "12000 x 12000 pixels"),
        (bomb(100_000, 100_000), "at most 16000000"),
        (sixteen_bits(), "8 bits"),
        (picture(np.full((3, 3), 77, dtype=np.uint8)), "all pixels have grey 77"),
    ],
)
def test_pictures_that_cannot_be_used_are_refused(data: bytes, word: str) -> None:
    with pytest.raises(InputError) as caught:
        ImageMap("m.png").build({"m.png": data})
    assert caught.value.source == "m.png"
    assert word in str(caught.value)


@settings(max_examples=80, deadline=None)
@given(st.integers(0, 10_000), st.integers(0, 255), st.booleans(), st.sampled_from(["PNG", "JPEG"]))
def test_a_damaged_picture_reads_or_is_refused(place: int, value: int, cut: bool, kind: str) -> None:
    data = bytearray(picture(corner_map(), kind))
    place %= len(data)
    data[place] = value
    with suppress(InputError):
        assert greys("m", bytes(data[:place] if cut else data)).ndim == 2


def test_a_missing_picture_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.png"):
        ImageMap("none.png").build(tmp_path)
    with pytest.raises(InputError, match=r"none\.png.*\n.*there are: a, b"):
        ImageMap("none.png").build({"b": b"", "a": b""})
