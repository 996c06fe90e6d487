"""Policies as files: the arrays in an npz file, the card beside them as JSON text."""

import os
from importlib import resources
from io import BytesIO
from pathlib import Path, PurePath
from typing import Any

import numpy as np

from crosstrack import npz
from crosstrack.errors import InputError, Problem
from crosstrack.policy.card import from_json
from crosstrack.policy.fit import faults
from crosstrack.policy.policy import Policy

MOST_BYTES = 1 << 26
"""of a file, and of what it unpacks to"""
CARD = "card"
"""the array of the card's bytes, UTF-8"""
ENDING = ".npz"


def save(policy: Policy, path: str | Path) -> None:
    """Write a policy; a file that is there is replaced at once, or not at all.

    Raises:
        InputError: its card holds values that JSON has not.
        OSError: the file cannot be written.
    """
    path = Path(path)
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        part.write_bytes(to_bytes(policy))
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def to_bytes(policy: Policy) -> bytes:
    """Return the contents of a policy's file, the same for the same policy.

    Raises:
        InputError: its card holds values that JSON has not.
    """
    out, card = BytesIO(), policy.card.to_json().encode()
    held: dict[str, Any] = {CARD: np.frombuffer(card, np.uint8), **policy.arrays}
    np.savez(out, **held)
    return out.getvalue()


def load(path: str | Path) -> Policy:
    """Read a policy.

    Args:
        path: a file that ends in .npz; or a name alone, such as `ppo`, for one that ships with this package

    Raises:
        InputError: there is none, or everything that is wrong with it.
    """
    name = str(path)
    if PurePath(name).suffix.lower() != ENDING:
        if name not in shipped():
            there = ", ".join(shipped()) or "none"
            message = f"no such policy ships with this package; there are: {there}. A file's name ends in {ENDING}"
            raise InputError(name, [Problem("", message)])
        return from_bytes(name, (resources.files(__package__) / "trained" / f"{name}{ENDING}").read_bytes())
    path = Path(path)
    try:
        if not path.is_file():
            raise InputError(name, [Problem("", "no such file")])
        check(name, path.stat().st_size)
        return from_bytes(name, path.read_bytes())
    except OSError as error:
        raise InputError(name, [Problem("", f"cannot be read: {error.strerror}")]) from error


def shipped() -> list[str]:
    """Return the names of the policies that ship with this package."""
    folder = resources.files(__package__) / "trained"
    names = [entry.name for entry in folder.iterdir()] if folder.is_dir() else []
    return sorted(name.removesuffix(ENDING) for name in names if name.endswith(ENDING))


def from_bytes(name: str, data: bytes) -> Policy:
    """Read a policy from the contents of its file.

    Raises:
        InputError: everything that is wrong with it, each with its place.
    """
    check(name, len(data))
    arrays = npz.arrays(name, data, MOST_BYTES)
    text = arrays.pop(CARD, None)
    if text is None or text.dtype != np.uint8 or text.ndim != 1:
        raise InputError(name, [Problem(CARD, "this array is needed: the card as UTF-8 text, uint8 (bytes,)")])
    try:
        card = from_json(name, text.tobytes().decode())
    except UnicodeDecodeError as error:
        raise InputError(name, [Problem(CARD, f"is not UTF-8 text: byte {error.start}")]) from None
    if found := faults(card, arrays):
        raise InputError(name, found[:20])
    return Policy(card, {array: np.asarray(values, np.float32) for array, values in arrays.items()})


def check(name: str, size: int) -> None:
    """Refuse a file that is too large."""
    if size > MOST_BYTES:
        raise InputError(name, [Problem("", f"it is {size} bytes; at most {MOST_BYTES} are read")])
