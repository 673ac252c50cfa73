"""Processes that end with the one that started them, however that one ends. Linux only."""

from __future__ import annotations

import ctypes
import signal
import sys
from collections.abc import Callable

_PR_SET_PDEATHSIG = 1


def end_with_parent(number: int = signal.SIGTERM) -> Callable[[], None]:
    """A function that makes the kernel send `number` to this process when its parent has died.

    Call it at once, or hand it to Popen as `preexec_fn`. What a killed workflow leaves running
    would keep its folders locked, and work on for nobody.
    """
    if sys.platform != "linux":
        return lambda: None
    prctl = ctypes.CDLL(None, use_errno=True).prctl

    def ask() -> None:
        prctl(_PR_SET_PDEATHSIG, number, 0, 0, 0)

    return ask
