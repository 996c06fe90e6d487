"""The files that a world is made from."""

from collections.abc import Mapping
from pathlib import Path

from crosstrack.errors import InputError, Problem

MOST_BYTES = 1 << 30
Files = Path | Mapping[str, bytes]
"""a folder, or contents by name"""


def refuse(name: str, place: str, message: str) -> InputError:
    """Return the error about one place in a file."""
    return InputError(name, [Problem(place, message)])


def read(files: Files, name: str) -> bytes:
    """Return the contents of a file.

    Raises:
        InputError: it is missing, cannot be read, or is larger than 1 GiB.
    """
    if not isinstance(files, Path):
        if name not in files:
            raise refuse(name, "", f"no such file; there are: {', '.join(sorted(files)) or 'none'}")
        return files[name]
    path = files / name
    try:
        if not path.is_file():
            raise refuse(name, "", f"no such file: {path}")
        size = path.stat().st_size
        if size > MOST_BYTES:
            raise refuse(name, "", f"it is {size} bytes; at most {MOST_BYTES} are read")
        return path.read_bytes()
    except OSError as error:
        raise refuse(name, "", f"cannot be read: {error.strerror}") from error
