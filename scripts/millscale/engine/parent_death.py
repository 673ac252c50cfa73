"""End a process when its parent dies, however that happens. Linux only."""

from __future__ import annotations

import ctypes
import signal
import sys
from collections.abc import Callable

_PR_SET_PDEATHSIG = 1


def end_with_parent(number: int = signal.SIGTERM) -> Callable[[], None]:
    """Return a function that makes the kernel send a signal to this process when its parent dies.

    Call it at once, or pass it to Popen as `preexec_fn`. Without it, processes of a killed workflow
    would run on and keep their folders locked.
    """
    if sys.platform != "linux":
        return lambda: None
    prctl = ctypes.CDLL(None, use_errno=True).prctl

    def ask() -> None:
        prctl(_PR_SET_PDEATHSIG, number, 0, 0, 0)

    return ask
