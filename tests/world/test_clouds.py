"""Point clouds in every format, whole and broken."""

import io
import struct
import zipfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crosstrack.errors import InputError
from crosstrack.types import Array
from crosstrack.world import npz, pcd, ply
from crosstrack.world.cloud import Cloud
from crosstrack.world.lzf import decompress
from crosstrack.world.world import World

POINTS = np.round(np.random.default_rng(4).uniform(-5, 5, size=(200, 3)), 3)
RECORDS = np.zeros(200, dtype=[("r", "u1"), ("x", "f4"), ("normal", "f8"), ("y", "f8"), ("z", "f4"), ("ring", "u2")])
for axis, column in zip("xyz", POINTS.T, strict=True):
    RECORDS[axis] = column
RECORDS["ring"] = np.arange(200) % 16


def ply_header(kind: str, rows: int = 200) -> bytes:
    return (
        f"ply\nformat {kind} 1.0\ncomment made by hand\nelement station 2\nproperty int id\nelement vertex {rows}\n"
        "property uchar r\nproperty float x\nproperty double normal\nproperty float64 y\nproperty float32 z\n"
        "property uint16 ring\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    ).encode()


def rows_of_text() -> bytes:
    return "".join(f"7 {x} 0.5 {y} {z} 3\n" for x, y, z in POINTS.tolist()).encode()


def ply_text() -> bytes:
    return ply_header("ascii") + b"1\n2\n" + rows_of_text() + b"3 0 1 2\n"


def ply_binary(order: Literal["<", ">"], name: str) -> bytes:
    stations = np.array([1, 2], dtype=order + "i4").tobytes()
    return ply_header(name) + stations + RECORDS.astype(RECORDS.dtype.newbyteorder(order)).tobytes() + b"\3" + bytes(12)


def pcd_header(kind: str, width: int = 40, height: int = 5) -> bytes:
    return (
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS r x normal y z ring\nSIZE 1 4 8 8 4 2\n"
        f"TYPE U F F F F U\nCOUNT 1 1 1 1 1 1\nWIDTH {width}\nHEIGHT {height}\nVIEWPOINT 0 0 0 1 0 0 0\n"
        f"POINTS {width * height}\nDATA {kind}\n"
    ).encode()


def compress(data: bytes) -> bytes:
    """Write LZF greedily: repeats of three bytes or more seen within 8 KiB, literals else."""
    out, literals, seen, i = bytearray(), bytearray(), dict[bytes, int](), 0

    def flush() -> None:
        for k in range(0, len(literals), 32):
            part = literals[k : k + 32]
            out.extend([len(part) - 1, *part])
        literals.clear()

    while i < len(data):
        key, length = data[i : i + 3], 0
        if len(key) == 3 and key in seen and i - seen[key] <= 8192:
            while i + length < len(data) and length < 264 and data[seen[key] + length] == data[i + length]:
                length += 1
        back = i - seen.get(key, 0) - 1
        seen[key] = i
        if length < 3:
            literals.append(data[i])
            i += 1
            continue
        flush()
        high, rest = back >> 8, length - 2
        out.extend([rest << 5 | high, back & 255] if rest < 7 else [7 << 5 | high, rest - 7, back & 255])
        i += length
    flush()
    return bytes(out)


def pcd_compressed() -> bytes:
    plain = b"".join(RECORDS[name].tobytes() for name in ("r", "x", "normal", "y", "z", "ring"))
    packed = compress(plain)
    assert len(packed) < len(plain)
    return pcd_header("binary_compressed") + struct.pack("<II", len(packed), len(plain)) + packed


def npz_file(points: "np.ndarray[tuple[int, ...], np.dtype[np.generic]]", squeeze: bool = False) -> bytes:
    out = io.BytesIO()
    (np.savez_compressed if squeeze else np.savez)(out, points=points, other=np.zeros(3))
    return out.getvalue()


Reader = Callable[[str, bytes], Array]
WHOLE: dict[str, tuple[Reader, bytes]] = {
    "ply text": (ply.points, ply_text()),
    "ply windows": (ply.points, ply_text().replace(b"\n", b"\r\n")),
    "ply little": (ply.points, ply_binary("<", "binary_little_endian")),
    "ply big": (ply.points, ply_binary(">", "binary_big_endian")),
    "pcd text": (pcd.points, pcd_header("ascii") + rows_of_text()),
    "pcd binary": (pcd.points, pcd_header("binary") + RECORDS.tobytes()),
    "pcd compressed": (pcd.points, pcd_compressed()),
    "npz": (npz.points, npz_file(POINTS)),
    "npz compressed": (npz.points, npz_file(np.column_stack([POINTS, POINTS]).astype(np.float32), squeeze=True)),
}


@pytest.mark.parametrize("name", WHOLE)
def test_every_format_gives_back_the_points(name: str) -> None:
    read, data = WHOLE[name]
    np.testing.assert_allclose(read("cloud", data), POINTS, atol=1e-6)


@pytest.mark.parametrize("name", WHOLE)
@settings(max_examples=60, deadline=None)
@given(place=st.integers(0, 10**6), value=st.integers(0, 255), tail=st.booleans(), cut=st.booleans())
def test_a_damaged_file_reads_or_is_refused(name: str, place: int, value: int, tail: bool, cut: bool) -> None:
    read, whole = WHOLE[name]
    data = bytearray(whole)
    place %= len(data) if tail else min(len(data), 600)
    data[place] = value
    with suppress(InputError):
        assert read("cloud", bytes(data[:place] if cut else data)).shape[1:] == (3,)


@pytest.mark.parametrize("name", [name for name in WHOLE if name != "npz compressed"])
def test_a_file_cut_short_is_refused_with_what_is_missing(name: str) -> None:
    read, data = WHOLE[name]
    with pytest.raises(InputError):
        read("cloud", data[: len(data) // 2])


@settings(max_examples=100, deadline=None)
@given(st.lists(st.sampled_from([b"a", b"bc", b"abcabc", bytes(300), b"\xff\0"]), max_size=60).map(b"".join))
def test_lzf_undoes_its_compression(plain: bytes) -> None:
    assert decompress("cloud", compress(plain), len(plain)) == plain


def test_lzf_of_known_bytes() -> None:
    assert decompress("c", b"\x02abc" + b"\x20\x02", 6) == b"abcabc"
    assert decompress("c", b"\x00z" + b"\xe0\xff\x00", 1 + 264) == b"z" * 265


@settings(max_examples=150, deadline=None)
@given(st.binary(max_size=60), st.integers(0, 300))
def test_lzf_of_any_bytes_stays_in_its_room(data: bytes, size: int) -> None:
    with suppress(InputError):
        assert len(decompress("cloud", data, size)) == size


def header_of(shape: str, kind: str = "<f8") -> bytes:
    """Return an npz whose array claims a shape and holds nothing."""
    text = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}".ljust(117) + "\n"
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        archive.writestr("points.npy", b"\x93NUMPY\x01\x00" + struct.pack("<H", len(text)) + text.encode())
    return out.getvalue()


def objects() -> bytes:
    out = io.BytesIO()
    np.savez(out, allow_pickle=True, points=np.array([[{}, 1, 2]], dtype=object))
    return out.getvalue()


HUGE = 10**15
BROKEN: list[tuple[Reader, bytes, list[str]]] = [
    (ply.points, b"solid", ["line 1", "ply"]),
    (ply.points, b"ply\nformat ascii 2 3 4\n", ["line 2", "format ascii 2 3 4"]),
    (ply.points, b"ply\nformat ascii 1.0\nelement vertex -3\n", ["line 3", "'-3'"]),
    (ply.points, b"ply\nformat ascii 1.0\nelement vertex 3\nproperty quad x\n", ["line 4", "quad"]),
    (ply.points, b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n", ["line 5", "ends within its header"]),
    (ply.points, b"ply\nformat ascii 1.0\nelement face 0\nend_header\n", ["no element 'vertex'"]),
    (ply.points, ply_header("ascii").replace(b" y\n", b" w\n"), ["y is not there", "r, x, normal, w, z, ring"]),
    (ply.points, ply_header("binary_little_endian", HUGE) + bytes(500), [f"{HUGE} points", "492 are left"]),
    (ply.points, ply_header("ascii", HUGE) + b"1\n2\n" + rows_of_text(), [f"200 of {HUGE} points"]),
    (ply.points, ply_text().replace(b" 0.5 ", b" ", 1), ["line 18", "5 numbers where 6"]),
    (ply.points, ply_text().replace(b"7 ", b"7 nonsense", 1), ["line 18", "must be a number, found 'nonsense"]),
    (pcd.points, b"ply\n", ["line 1", "'ply'"]),
    (pcd.points, pcd_header("zipped"), ["DATA", "'zipped'"]),
    (pcd.points, pcd_header("binary", 10**8, 10**8) + bytes(99), ["DATA", "99 are left"]),
    (pcd.points, pcd_header("ascii").replace(b"POINTS 200", b"POINTS 7"), ["POINTS", "200"]),
    (pcd.points, pcd_header("ascii").replace(b"SIZE 1", b"SIZE 3"), ["FIELDS r", "size 3"]),
    (pcd.points, pcd_header("ascii").replace(b"SIZE 1 ", b"SIZE "), ["equally many", "6, 5, 6 and 6"]),
    (pcd.points, pcd_header("ascii").replace(b"FIELDS r x", b"FIELDS r w"), ["x is not there"]),
    (pcd.points, pcd_header("binary_compressed") + struct.pack("<II", 3, 27 * 200) + b"abc", ["cannot hold 5400"]),
    (pcd.points, pcd_header("binary_compressed") + struct.pack("<II", 90, 5) + b"abc", ["200 points of 27 bytes"]),
    (pcd.points, pcd_header("binary_compressed") + struct.pack("<II", 90, 5400) + b"abc", ["90", "3 are left"]),
    (npz.points, b"PK nothing", ["not an npz file"]),
    (npz.points, npz_file(np.zeros((4, 2))), ["(4, 2)"]),
    (npz.points, npz_file(np.zeros((4, 3), dtype="U4")), ["<U4"]),
    (npz.points, objects(), ["|O"]),
    (npz.points, header_of(f"({HUGE}, 3)"), [str(24 * HUGE), "holds 0"]),
]


@pytest.mark.parametrize(("read", "data", "words"), BROKEN)
def test_broken_files_are_refused_with_the_place(read: Reader, data: bytes, words: list[str]) -> None:
    with pytest.raises(InputError) as caught:
        read("cloud", data)
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_an_npz_without_points_says_what_there_is() -> None:
    out = io.BytesIO()
    np.savez(out, a=np.zeros(3), b=np.zeros(3))
    with pytest.raises(InputError, match=r"a\.npy, b\.npy"):
        npz.points("cloud", out.getvalue())


def test_voxels_hold_every_point_and_nothing_else(tmp_path: Path) -> None:
    (tmp_path / "scan.ply").write_bytes(ply_text())
    voxels = Cloud("scan.ply", voxel=0.5).build(tmp_path)
    assert voxels.occupied.sum() == len(np.unique(np.floor(POINTS / 0.5), axis=0))
    assert (World(grids=(voxels,)).distance(POINTS) <= 0).all()
    filled = np.argwhere(voxels.occupied) * 0.5 + voxels.origin
    gap = np.maximum(filled[:, None] - POINTS, POINTS - filled[:, None] - 0.5).max(axis=2).min(axis=1)
    assert (gap <= 1e-12).all()


def test_points_that_are_not_finite_are_left_out() -> None:
    points = np.array([[np.nan, 0, 0], [1, 2, 3], [0, np.inf, 0]])
    assert Cloud("a.npz").build({"a.npz": npz_file(points)}).occupied.sum() == 1


@pytest.mark.parametrize(
    ("name", "data", "word"),
    [
        ("a.las", b"", "ends in .ply, .pcd, .npz"),
        ("a.npz", npz_file(np.full((2, 3), np.nan)), "no finite point"),
        ("a.npz", npz_file(np.empty((0, 3))), "no finite point"),
        ("a.npz", npz_file(np.array([[0, 0, 0], [1e3, 1e3, 1e3]])), "1000 x 1000 x 1000 m"),
        ("a.npz", npz_file(np.array([[-1e308, 0, 0], [1e308, 1, 1]])), "at most 16000000"),
    ],
)
def test_clouds_that_make_no_voxels_are_refused(name: str, data: bytes, word: str) -> None:
    with pytest.raises(InputError) as caught:
        Cloud(name).build({name: data})
    assert word in str(caught.value)
