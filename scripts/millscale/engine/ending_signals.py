"""Signals that ask a process to end: Ctrl-C, `kill`, a closed terminal."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

ENDING_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
# Exit code of a process that such a signal ended, as shells have it for Ctrl-C.
INTERRUPTED = 130
Handler = Callable[[int, FrameType | None], None]


@contextmanager
def ending_signals_to(handler: Handler) -> Iterator[None]:
    """Call a handler on each ending signal; restore the handlers of before at the end.

    Ctrl-C is one of them, because a shell makes its background jobs ignore it.
    """
    before = {number: signal.signal(number, handler) for number in ENDING_SIGNALS}
    try:
        yield
    finally:
        for number, earlier in before.items():
            signal.signal(number, earlier)


def interrupt(number: int, frame: FrameType | None) -> None:
    """Raise KeyboardInterrupt, as Ctrl-C does."""
    raise KeyboardInterrupt


def interrupt_once(number: int, frame: FrameType | None) -> None:
    """Raise KeyboardInterrupt and ignore later signals, which would disturb an orderly end."""
    ignore_ending_signals()
    raise KeyboardInterrupt


def interrupt_once_on_ending_signals() -> None:
    """Let the first ending signal raise KeyboardInterrupt, for the rest of this process."""
    for number in ENDING_SIGNALS:
        signal.signal(number, interrupt_once)


def ignore_ending_signals() -> None:
    """Ignore ending signals for the rest of this process, or of `ending_signals_to`."""
    for number in ENDING_SIGNALS:
        signal.signal(number, signal.SIG_IGN)
