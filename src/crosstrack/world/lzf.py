"""LZF, the compression of Marc Lehmann's LibLZF, which PCD files use."""

import numpy as np
from numpy.typing import NDArray

from crosstrack.compiled import compiled
from crosstrack.world.files import refuse

Bytes = NDArray[np.uint8]
MOST_GROWTH = 88
"""three bytes give at most 264"""


def decompress(name: str, data: bytes, size: int) -> bytes:
    """Return the `size` bytes that `data` stands for.

    Raises:
        InputError: the data cannot hold that many, or are not LZF.
    """
    if size > MOST_GROWTH * len(data):
        raise refuse(name, "DATA", f"{len(data)} compressed bytes cannot hold {size}")
    plain = np.empty(size, dtype=np.uint8)
    stop = unpack(np.frombuffer(data, dtype=np.uint8).copy(), plain)
    if stop >= 0:
        raise refuse(name, f"compressed byte {stop}", f"the data are not {size} bytes in LZF")
    return plain.tobytes()


@compiled
def unpack(data: Bytes, plain: Bytes) -> int:
    """Fill `plain` from compressed `data`; return -1, or the byte at which they do not fit.

    A control byte below 32 copies that many bytes and one more. Any other holds a length (upper 3 bits; 7
    takes a further byte) and a distance back (lower 5 bits and one byte) from which length + 2 bytes are
    repeated.
    """
    i, out = 0, 0
    while i < len(data):
        begin = i
        control = int(data[i])
        i += 1
        if control < 32:
            length = control + 1
            if i + length > len(data) or out + length > len(plain):
                return begin
            for k in range(length):
                plain[out + k] = data[i + k]
            i += length
        else:
            length = control >> 5
            if i + (2 if length == 7 else 1) > len(data):
                return begin
            if length == 7:
                length += int(data[i])
                i += 1
            back = out - ((control & 31) << 8) - int(data[i]) - 1
            i += 1
            length += 2
            if back < 0 or out + length > len(plain):
                return begin
            for k in range(length):
                plain[out + k] = plain[back + k]
        out += length
    return -1 if out == len(plain) else len(data)
