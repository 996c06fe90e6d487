"""Points of PCD files (Point Cloud Library, version 0.7): ascii, binary and binary_compressed."""

import struct

import numpy as np

from crosstrack.types import Array
from crosstrack.world.columns import AXES, check_axes, count, floats, from_records, from_text
from crosstrack.world.files import refuse
from crosstrack.world.lzf import decompress

TYPES = {
    **{("F", 4): "<f4", ("F", 8): "<f8", ("I", 1): "<i1", ("I", 2): "<i2", ("I", 4): "<i4", ("I", 8): "<i8"},
    **{("U", 1): "<u1", ("U", 2): "<u2", ("U", 4): "<u4", ("U", 8): "<u8"},
}
WORDS = ("VERSION", "FIELDS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "VIEWPOINT", "POINTS", "DATA")
MOST_HEADER_LINES = 100


def points(name: str, data: bytes) -> Array:
    """Return the points of a PCD file, (n, 3).

    Raises:
        InputError: with the header word or the byte count at fault.
    """
    header, line, start = _header(name, data)
    record, columns = _record(name, header)
    rows = _rows(name, header)
    body = data[start:]
    match header["DATA"]:
        case ["ascii"]:
            return from_text(name, body, rows, columns, line)
        case ["binary"]:
            return from_records(name, "DATA", body, rows, record)
        case ["binary_compressed"]:
            return _compressed(name, body, rows, record)
        case other:
            message = f"ascii, binary or binary_compressed is read; found {' '.join(other)!r}"
            raise refuse(name, "DATA", message)


def _header(name: str, data: bytes) -> tuple[dict[str, list[str]], int, int]:
    """Return the words of the header, and line and byte at which the body starts."""
    header: dict[str, list[str]] = {}
    start = 0
    for line in range(1, MOST_HEADER_LINES + 1):
        end = data.find(b"\n", start)
        if end < 0:
            raise refuse(name, f"line {line}", "the file ends within its header")
        words = data[start:end].decode("latin-1").split("#")[0].split()
        start = end + 1
        if not words:
            continue
        if words[0] not in WORDS:
            raise refuse(name, f"line {line}", f"a PCD header has no {words[0][:40]!r}; known: {', '.join(WORDS)}")
        header[words[0]] = words[1:]
        if words[0] == "DATA":
            return header, line + 1, start
    raise refuse(name, "header", f"it has more than {MOST_HEADER_LINES} lines")


def _record(name: str, header: dict[str, list[str]]) -> tuple["np.dtype[np.void]", list[str]]:
    """Return the layout of a point, and a name for each of its numbers."""
    fields, sizes, kinds = (header.get(word, []) for word in ("FIELDS", "SIZE", "TYPE"))
    counts = header.get("COUNT", ["1"] * len(fields))
    check_axes(name, "FIELDS", fields)
    if not len(fields) == len(sizes) == len(kinds) == len(counts):
        found = f"{len(fields)}, {len(sizes)}, {len(kinds)} and {len(counts)}"
        raise refuse(name, "header", f"FIELDS, SIZE, TYPE and COUNT must be equally many; found {found}")
    layout, columns = [], list[str]()
    for i, field in enumerate(fields):
        key, many = (kinds[i], count(name, "SIZE", sizes[i])), count(name, "COUNT", counts[i])
        if key not in TYPES or many > 100_000 or (field in AXES and many != 1):
            raise refuse(name, f"FIELDS {field}", f"type {key[0]}, size {key[1]}, count {many} is not read")
        layout.append((field if field in AXES else f"_{i}", TYPES[key], (many,) if many != 1 else ()))
        columns += [field] + [""] * (many - 1) if many else []
    return np.dtype(layout), columns


def _rows(name: str, header: dict[str, list[str]]) -> int:
    """Return the number of points, WIDTH x HEIGHT."""
    width, height, total = (header.get(word, []) for word in ("WIDTH", "HEIGHT", "POINTS"))
    if len(width) != 1 or len(height) != 1:
        raise refuse(name, "header", "WIDTH and HEIGHT, one number each, are needed")
    rows = count(name, "WIDTH", width[0]) * count(name, "HEIGHT", height[0])
    if total and count(name, "POINTS", total[0]) != rows:
        raise refuse(name, "POINTS", f"{total[0]} is not WIDTH x HEIGHT = {rows}")
    return rows


def _compressed(name: str, body: bytes, rows: int, record: "np.dtype[np.void]") -> Array:
    """Return x, y, z from compressed columns: all of the first field, then all of the second, and so on."""
    if len(body) < 8:
        raise refuse(name, "DATA", f"two sizes of 4 bytes are due; {len(body)} bytes are left")
    packed, unpacked = struct.unpack("<II", body[:8])
    if unpacked != rows * record.itemsize:
        message = f"{rows} points of {record.itemsize} bytes are not the {unpacked} bytes it says"
        raise refuse(name, "DATA", message)
    if packed > len(body) - 8:
        raise refuse(name, "DATA", f"{packed} compressed bytes are due; {len(body) - 8} are left")
    plain = decompress(name, body[8 : 8 + packed], unpacked)
    columns, at = [], 0
    for field in record.names or ():
        kind = record[field]
        if field in AXES:
            columns.append((field, floats(np.frombuffer(plain, kind, rows, at))))
        at += kind.itemsize * rows
    found = dict(columns)
    return np.stack([found[axis] for axis in AXES], axis=1)
