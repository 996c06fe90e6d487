"""Messages in CDR, the encoding of ROS 2: little-endian, every number aligned to its own size.

A message whose texts and counts are fixed has all its numbers at fixed places. Such a message is laid out
once, and then many of them are filled in at a time, column by column.
Source: OMG Common Data Representation, DDS-XTypes 1.3, section 7.4, plain CDR version 1.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

PREAMBLE = b"\x00\x01\x00\x00"
"""says: plain CDR, little-endian"""


@dataclass
class Builder:
    """Lay out one message, field after field."""

    data: bytearray = field(default_factory=lambda: bytearray(PREAMBLE))
    """the message so far, with zeros in the slots"""
    slots: dict[str, tuple[str, tuple[int, ...], int]] = field(default_factory=dict)
    """name to numpy type, shape and offset of what is filled in later"""

    def align(self, size: int) -> None:
        """Pad to a multiple of `size` bytes, counted from behind the preamble."""
        self.data += bytes(-(len(self.data) - len(PREAMBLE)) % size)

    def put(self, kind: str, *values: float) -> None:
        """Append numbers of one numpy type."""
        self.array(np.array(values, dtype=kind))

    def text(self, value: str) -> None:
        """Append a text: its length with the closing zero, then its bytes."""
        encoded = value.encode() + b"\x00"
        self.put("<u4", len(encoded))
        self.data += encoded

    def array(self, values: NDArray[Any]) -> None:
        """Append the numbers of an array, without a count. An empty one does not align."""
        if values.size:
            self.align(values.dtype.itemsize)
            self.data += values.tobytes()

    def slot(self, name: str, kind: str, *shape: int) -> None:
        """Leave room for numbers that change from message to message."""
        dtype = np.dtype(kind)
        size = int(np.prod(shape, dtype=int)) * dtype.itemsize
        if size:
            self.align(dtype.itemsize)
        self.slots[name] = (kind, shape, len(self.data))
        self.data += bytes(size)

    def dtype(self) -> np.dtype[np.void]:
        """Return the structured type of the slots, as large as the message."""
        return np.dtype(
            {
                "names": list(self.slots),
                "formats": [(kind, shape) for kind, shape, _ in self.slots.values()],
                "offsets": [offset for _, _, offset in self.slots.values()],
                "itemsize": len(self.data),
            }
        )


def constant(dtype: np.dtype[np.void]) -> NDArray[np.bool_]:
    """Return for every byte of a structured type whether it lies outside its fields."""
    outside = np.ones(dtype.itemsize, dtype=np.bool_)
    for kind, offset, *_ in (dtype.fields or {}).values():
        outside[offset : offset + kind.itemsize] = False
    return outside
