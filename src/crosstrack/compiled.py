"""Compilation of hot numeric functions to machine code."""

import hashlib
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core.compiler_lock import global_compiler_lock

from crosstrack.locks import lock

Function = TypeVar("Function", bound=Callable[..., Any])

REORDERING = {"contract", "nsz", "arcp", "reassoc"}
"""What the compiler may assume of floats; not that they are numbers, since NaN stands for what is left free."""
OPTIONS: dict[str, Any] = {
    "cache": True,
    "forceinline": True,
    "no_cfunc_wrapper": True,
    "error_model": "numpy",
    "fastmath": REORDERING,
}
"""Inlined into whatever calls it: a call would be bound to the callee compiled alone while it is fresh and to the
callee compiled with its caller once cached, and these round differently. Nothing written in C calls it, and what numba
would make for that is left out."""
HELD: set[Path] = set()
"""the locks that this process holds"""


def compiled(function: Function) -> Function:
    """Compile a plain function of floats and arrays with numba, cached on disk, single-threaded."""
    config: Any = numba.config
    given = config.CACHE_DIR
    config.CACHE_DIR = given or str(cache_folder())
    try:
        made: Any = numba.njit(function, **OPTIONS)
    finally:
        config.CACHE_DIR = given
    path = Path(made.stats.cache_path) / f"{function.__module__}.{function.__qualname__}.lock"
    made.compile = alone(made.compile, path)
    return cast(Function, made)


def alone(compile_for: Callable[[Any], Any], path: Path) -> Callable[[Any], Any]:
    """Let one process at a time compile a function: the others wait, and find it in the cache.

    That saves their work, and keeps the cache sound. Its index has no lock of its own: of two processes that add to it
    at once, one can leave its entry with the machine code of the other.
    """

    def compile_alone(signature: Any) -> Any:
        with global_compiler_lock, locked(path):
            return compile_for(signature)

    return compile_alone


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Hold the lock of a file, unless this process holds it; go without where there are no such locks.

    A function holds its lock while those that it calls are compiled, so processes do not wait for one another in a
    circle.
    """
    with ExitStack() as stack:
        if path not in HELD:
            with suppress(OSError):
                path.parent.mkdir(parents=True, exist_ok=True)
                lock(stack.enter_context(path.open("ab")), wait=True)
            HELD.add(path)
            stack.callback(HELD.discard, path)
        yield


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
