"""The cache of machine code, when several processes compile at once."""

import json
import os
import subprocess
import sys
from pathlib import Path

MODULE = """
from crosstrack.compiled import compiled

@compiled
def half(x):
    return x / 2

@compiled
def summed(values):
    total = half(values[0])
    for k in range(1, values.size):
        total += half(values[k])
    return total
"""
CALLS = """
import json, sys, numpy, summing
sys.stdin.readline()
found = summing.summed(numpy.arange(5, dtype=sys.argv[1]))
misses = [sum(function.stats.cache_misses.values()) for function in (summing.half, summing.summed)]
print(json.dumps([found, *misses]))
"""
KINDS = ("float64", "int64")


def summed(folder: Path, kinds: tuple[str, ...]) -> list[list[float]]:
    """Sum halves in one process for each kind, all at once: the sum, and how often each function was compiled."""
    environment = os.environ | {"PYTHONPATH": str(folder), "NUMBA_CACHE_DIR": str(folder / "cache")}
    command = [sys.executable, "-c", CALLS]
    running = [
        subprocess.Popen([*command, kind], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment)
        for kind in kinds
    ]
    for each in running:
        assert each.stdin
        each.stdin.write("\n")
        each.stdin.flush()
    return [json.loads(each.communicate()[0]) for each in running]


def test_one_process_compiles_and_the_others_find_it(tmp_path: Path) -> None:
    (tmp_path / "summing.py").write_text(MODULE)
    found = summed(tmp_path, ("float64", "float64"))
    assert [row[0] for row in found] == [5.0, 5.0]
    assert [sum(column) for column in zip(*found, strict=True)][1:] == [1, 1]


def test_what_processes_compile_at_once_is_all_kept_and_right(tmp_path: Path) -> None:
    (tmp_path / "summing.py").write_text(MODULE)
    assert summed(tmp_path, KINDS) == [[5.0, 1, 1]] * 2
    assert summed(tmp_path, KINDS) == [[5.0, 0, 0]] * 2
