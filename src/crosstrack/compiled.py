"""Compilation of hot numeric functions to machine code."""

import hashlib
import os
import shutil
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

Function = TypeVar("Function", bound=Callable[..., Any])

REORDERING = {"contract", "nsz", "arcp", "reassoc"}
"""What the compiler may assume of floats; not that they are numbers, since NaN stands for what is left free."""


def compiled(function: Function) -> Function:
    """Compile a plain function of floats and arrays with numba, cached on disk, single-threaded.

    Inlined into whatever calls it: a call would be bound to the callee compiled alone while it is fresh and to the
    callee compiled with its caller once cached, and these round differently.
    """
    config: Any = numba.config
    given = config.CACHE_DIR
    config.CACHE_DIR = given or str(cache_folder())
    try:
        made = numba.njit(function, cache=True, forceinline=True, error_model="numpy", fastmath=REORDERING)
        return cast(Function, made)
    finally:
        config.CACHE_DIR = given


@cache
def cache_folder() -> Path:
    """Return the folder of the machine code of this state of the package, and drop those of other states.

    Numba looks for changes in the file of a function alone; what it calls from other files is compiled into it.
    """
    package = Path(__file__).parent
    sources = ((path, path.stat()) for path in sorted(package.rglob("*.py")))
    state = "".join(f"{path}{stat.st_mtime_ns}{stat.st_size}" for path, stat in sources)
    home = package / "__pycache__"
    if not os.access(package, os.W_OK):
        home = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "crosstrack"
    folder = home / f"compiled-{hashlib.sha256(state.encode()).hexdigest()[:16]}"
    for stale in set(home.glob("compiled-*")) - {folder}:
        shutil.rmtree(stale, ignore_errors=True)
    return folder
