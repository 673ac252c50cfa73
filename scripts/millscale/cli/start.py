"""The start of the command `millscale`, before its modules are loaded."""

from __future__ import annotations

import signal


def main() -> None:
    """Load the command line and run it; while it loads, Ctrl-C ends the process silently."""
    handler = signal.getsignal(signal.SIGINT)
    # A background job of a shell ignores it.
    if handler is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    from millscale.cli.main import main as run

    signal.signal(signal.SIGINT, handler)
    run()
