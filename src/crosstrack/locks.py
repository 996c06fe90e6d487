"""Locks of files between processes, where the system has them: Windows has none."""

import sys
from typing import BinaryIO

if sys.platform != "win32":
    import fcntl


def lock(file: BinaryIO, *, wait: bool) -> None:
    """Lock an open file until it is closed, or its process ends.

    Raises:
        BlockingIOError: another holds the lock, and waiting was not asked for.
        OSError: the file system has no locks.
    """
    if sys.platform != "win32":
        fcntl.flock(file, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
