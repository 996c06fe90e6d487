"""Points of npz files: the array `points`.

The header of the array is read here rather than by numpy, which evaluates it as Python and makes room for whatever it
claims.
"""

import re
import struct
import zipfile
import zlib
from io import BytesIO
from typing import Literal

import numpy as np

from crosstrack.types import Array
from crosstrack.world.columns import floats
from crosstrack.world.files import MOST_BYTES, refuse

MEMBER = "points.npy"
HEADER = re.compile(
    rb"\{'descr': '([<>|](?:f[248]|[iu][1248]))', 'fortran_order': (True|False), "
    rb"'shape': \((\d{1,18}), (\d{1,9})\), ?\} *\n"
)


def points(name: str, data: bytes) -> Array:
    """Return the array `points` of an npz file, (n, 3); further columns are left out.

    Raises:
        InputError: it is not an npz file, has no such array, or the array is not (n, 3 or more) numbers.
    """
    try:
        array = _member(name, data)
        (length,) = struct.unpack_from("<H" if array[6] == 1 else "<I", array, 8)
    except (zipfile.BadZipFile, zlib.error, struct.error, OSError, EOFError, ValueError) as error:
        raise refuse(name, "points", f"not an npz file that can be read: {error}") from error
    except (NotImplementedError, RuntimeError, IndexError) as error:
        raise refuse(name, "points", f"not an npz file as numpy writes it: {error}") from error
    start = (10 if array[6] == 1 else 12) + length
    header = array[start - length : start]
    found = HEADER.fullmatch(header)
    if array[:6] != b"\x93NUMPY" or found is None or int(found[4]) < 3:
        said = header[:200].decode("latin-1").strip()
        raise refuse(name, "points", f"numbers of shape (n, 3) are needed; found {said!r}")
    kind, rows, columns = np.dtype(found[1].decode()), int(found[3]), int(found[4])
    held, needed = len(array) - start, rows * columns * kind.itemsize
    if needed > held:
        raise refuse(name, "points", f"its header asks for {needed} bytes; the file holds {held}")
    order: Literal["F", "C"] = "F" if found[2] == b"True" else "C"
    table = np.frombuffer(array, kind, rows * columns, start).reshape((rows, columns), order=order)
    return floats(table[:, :3])


def _member(name: str, data: bytes) -> bytes:
    """Return the array's bytes, unpacked."""
    with zipfile.ZipFile(BytesIO(data)) as archive:
        if MEMBER not in archive.namelist():
            found = ", ".join(archive.namelist()[:20]) or "nothing"
            raise refuse(name, "points", f"there is no array 'points'; found {found}")
        size = archive.getinfo(MEMBER).file_size
        if size > MOST_BYTES:
            raise refuse(name, "points", f"it unpacks to {size} bytes; at most {MOST_BYTES} are read")
        return archive.read(MEMBER)
