"""Independent work on all processors, in forked processes."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from typing import Any, TypeVar

T = TypeVar("T")
R = TypeVar("R")

# What the forked processes do: they inherit it, so it need not be copied.
_work: tuple[Callable[[Any], Any], Sequence[Any]] | None = None


def forked(work: Callable[[T], R], items: Sequence[T]) -> list[R]:
    """Return work(item) of each item, in order, evaluated on all processors.

    Results are copied between processes: they must be pickled, and objects come back as others.
    """
    global _work
    count = min(len(os.sched_getaffinity(0)), len(items))
    if count < 2 or _work is not None:  # a forked process forks no further
        return [work(item) for item in items]
    _work = work, items
    try:
        fork = multiprocessing.get_context("fork")
        with ProcessPoolExecutor(count, mp_context=fork) as pool:
            return list(pool.map(_one, range(len(items))))
    finally:
        _work = None


def _one(index: int) -> Any:
    assert _work is not None
    work, items = _work
    return work(items[index])
