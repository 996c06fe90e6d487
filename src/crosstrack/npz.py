"""Arrays of numbers in npz files that anyone may have written.

The headers of the arrays are read here rather than by numpy, which evaluates them as Python and makes room for whatever
they claim; objects, which numpy would unpickle, are refused.
"""

import math
import re
import struct
import zipfile
import zlib
from collections.abc import Sequence
from io import BytesIO
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from crosstrack.errors import InputError, Problem

Numbers = NDArray[np.number[Any]]
MOST_MEMBERS = 4096
ENDING = ".npy"
HEADER = re.compile(
    rb"\{'descr': '([<>|](?:f[248]|[iu][1248]))', 'fortran_order': (True|False), "
    rb"'shape': \((|\d{1,18},|\d{1,18}(?:, \d{1,18}){1,31})\), ?\} *\n"
)


def arrays(name: str, data: bytes, most: int, wanted: Sequence[str] = ()) -> dict[str, Numbers]:
    """Return the arrays of an npz file by name, read-only.

    Args:
        name: of the file, for messages
        data: its contents
        most: bytes that may be unpacked
        wanted: the arrays that must be there, and alone are read; by default all are

    Raises:
        InputError: it is not an npz file, lacks an array, holds something other than numbers, or unpacks to more.
    """
    try:
        with zipfile.ZipFile(BytesIO(data)) as archive:
            members = [_member(name, archive, array) for array in wanted] or archive.infolist()
            _check(name, members, most)
            packed = {member.filename.removesuffix(ENDING): archive.read(member) for member in members}
    except (zipfile.BadZipFile, zlib.error, struct.error, OSError, EOFError, ValueError) as error:
        raise _refuse(name, "", f"not an npz file that can be read: {error}") from error
    except (NotImplementedError, RuntimeError, IndexError) as error:
        raise _refuse(name, "", f"not an npz file as numpy writes it: {error}") from error
    return {array: _numbers(name, array, unpacked) for array, unpacked in packed.items()}


def _member(name: str, archive: zipfile.ZipFile, array: str) -> zipfile.ZipInfo:
    """Return where an array is."""
    if array + ENDING not in archive.namelist():
        found = ", ".join(archive.namelist()[:20]) or "nothing"
        raise _refuse(name, array, f"there is no array {array!r}; found {found}")
    return archive.getinfo(array + ENDING)


def _check(name: str, members: list[zipfile.ZipInfo], most: int) -> None:
    """Refuse members that are too many, too large, packed in another way, or no arrays, before they are unpacked."""
    if len(members) > MOST_MEMBERS:
        raise _refuse(name, "", f"it holds {len(members)} arrays; at most {MOST_MEMBERS} are read")
    if len({member.filename for member in members}) < len(members):
        raise _refuse(name, "", "it holds two arrays of one name")
    for member in members:
        if not (member.filename.endswith(ENDING) and member.filename.isprintable()):
            raise _refuse(name, "", f"it holds {member.filename!r:.80}, which is no array")
        if member.compress_type not in {zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED}:
            raise _refuse(name, "", f"{member.filename!r:.80} is not packed as numpy does it")
    size = sum(member.file_size for member in members)
    if size > most:
        raise _refuse(name, "", f"it unpacks to {size} bytes; at most {most} are read")


def _numbers(name: str, place: str, data: bytes) -> Numbers:
    """Return the array whose npy file holds these bytes."""
    if data[:6] != b"\x93NUMPY" or len(data) < 12:
        raise _refuse(name, place, "is not an array as numpy writes it")
    begin = 10 if data[6] == 1 else 12
    (length,) = struct.unpack_from("<H" if begin == 10 else "<I", data, 8)
    start = begin + length
    header = data[begin:start]
    found = HEADER.fullmatch(header)
    if found is None:
        raise _refuse(name, place, f"must hold numbers, found {header[:200].decode('latin-1').strip()!r}")
    shape = tuple(int(size) for size in found[3].split(b",") if size)
    kind, count = np.dtype(found[1].decode()), math.prod(shape)
    held, needed = len(data) - start, count * kind.itemsize
    if needed > held:
        raise _refuse(name, place, f"its header asks for {needed} bytes; the file holds {held}")
    order: Literal["F", "C"] = "F" if found[2] == b"True" else "C"
    flat: Numbers = np.frombuffer(data, kind, count, start)
    try:
        return flat.reshape(shape, order=order)
    except ValueError as error:  # empty, with other sizes that are beyond what numpy counts
        raise _refuse(name, place, f"its shape cannot be: {error}") from error


def _refuse(name: str, place: str, message: str) -> InputError:
    """Return the error about one array of a file."""
    return InputError(name, [Problem(place[:80], message)])
