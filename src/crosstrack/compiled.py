"""Compilation of hot numeric functions to machine code."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

Function = TypeVar("Function", bound=Callable[..., Any])


def compiled(function: Function) -> Function:
    """Compile a plain function of floats and arrays with numba, cached on disk, single-threaded."""
    return cast(Function, numba.njit(function, cache=True, error_model="numpy", fastmath={"contract", "nsz", "arcp", "reassoc"}))
