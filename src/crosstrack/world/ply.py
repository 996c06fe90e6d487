"""Vertices of PLY files: ASCII, binary little or big endian, any further properties and elements."""

from dataclasses import dataclass, field

import numpy as np

from crosstrack.types import Array
from crosstrack.world.columns import check_axes, count, from_records, from_text
from crosstrack.world.files import refuse

ORDERS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}
TYPES = {
    **{"char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4"},
    **{"int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4"},
    **{"float": "f4", "double": "f8", "float32": "f4", "float64": "f8"},
}
MOST_HEADER_LINES = 1000


@dataclass
class Element:
    """A table of the file."""

    name: str
    rows: int
    properties: list[tuple[str, str]] = field(default_factory=list)
    """name and numpy type; an empty type for a list"""


def points(name: str, data: bytes) -> Array:
    """Return the vertices of a PLY file, (n, 3).

    Raises:
        InputError: with the line or the byte count at fault.
    """
    order, elements, line, start = _header(name, data)
    for element in elements:
        listed = [title for title, kind in element.properties if not kind]
        if listed and (element.name == "vertex" or order != "="):
            raise refuse(name, f"element {element.name}", f"list property {listed[0]!r} up to the vertices is not read")
        if element.name == "vertex":
            return _vertices(name, data[start:], order, element, line)
        if order == "=":
            skipped = data[start:].split(b"\n", element.rows)
            start, line = len(data) - len(skipped[-1]), line + element.rows
        else:
            start += element.rows * _record(element, order).itemsize
    raise refuse(name, "header", "there is no element 'vertex'")


def _vertices(name: str, body: bytes, order: str, element: Element, line: int) -> Array:
    """Return x, y, z of the vertices, which start the body."""
    columns = [title for title, _ in element.properties]
    check_axes(name, "element vertex", columns)
    if order == "=":
        return from_text(name, body, element.rows, columns, line)
    return from_records(name, "element vertex", body, element.rows, _record(element, order))


def _record(element: Element, order: str) -> "np.dtype[np.void]":
    """Return the layout of a row; only the axes keep their names, since others may repeat."""
    titles = [title if title in "xyz" else f"_{i}" for i, (title, _) in enumerate(element.properties)]
    kinds = [order + kind for _, kind in element.properties]
    return np.dtype(list(zip(titles, kinds, strict=True)))


def _header(name: str, data: bytes) -> tuple[str, list[Element], int, int]:
    """Return byte order, elements, and line and byte at which the body starts."""
    if data[:3] != b"ply":
        raise refuse(name, "line 1", f"a PLY file starts with 'ply'; found {data[:3]!r}")
    order, elements, start = "", list[Element](), 0
    for line in range(1, MOST_HEADER_LINES + 1):
        end = data.find(b"\n", start)
        if end < 0:
            raise refuse(name, f"line {line}", "the file ends within its header")
        words = data[start:end].decode("latin-1").split()
        start = end + 1
        match words:
            case ["ply"] | ["comment", *_] | ["obj_info", *_] | []:
                pass
            case ["format", kind, _] if kind in ORDERS:
                order = ORDERS[kind]
            case ["element", title, rows]:
                elements.append(Element(title, count(name, f"line {line}", rows)))
            case ["property", "list", _, _, title] if elements:
                elements[-1].properties.append((title, ""))
            case ["property", kind, title] if elements and kind in TYPES:
                elements[-1].properties.append((title, TYPES[kind]))
            case ["end_header"] if order:
                return order, elements, line + 1, start
            case _:
                raise refuse(name, f"line {line}", f"not understood in a PLY header: {' '.join(words)[:80]!r}")
    raise refuse(name, "header", f"it has more than {MOST_HEADER_LINES} lines")
