"""Where clients may have files written: a client may be anyone, and is given no more than a folder."""

from pathlib import Path


def inside(name: str, folders: tuple[Path, ...], suffix: str) -> Path | None:
    """Return the file of a name that a client gives, relative to the first folder; None where it may not be written.

    It must lie in one of the folders, links followed, and end as files of its kind do.
    """
    if "\0" in name:
        return None
    path = (folders[0] / name).resolve()
    if path.suffix.lower() != suffix or path.is_dir():
        return None
    return path if any(path.is_relative_to(folder.resolve()) for folder in folders) else None
