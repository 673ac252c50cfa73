"""Give an input to a reader and record tracebacks, hangs and writes outside a folder."""

import os
import signal
import sys
import traceback
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

# Longer than any reader needs for a damaged file of a few kilobytes [s]: of the processor, and by
# the clock, for one that waits, on a busy machine.
COMPUTING_S, WAITING_S = 20.0, 120.0
FAULTS = ("tracebacks", "hangs", "writes_outside", "wrong_numbers")
_WRITING = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND
# Python's events of changes to files, and which of their arguments are paths.
_CHANGES = {
    "os.mkdir": (0,), "os.rename": (0, 1), "os.remove": (0,), "os.rmdir": (0,),
    "os.symlink": (1,), "os.link": (1,), "os.truncate": (0,), "os.chmod": (0,),
    "os.utime": (0,), "shutil.rmtree": (0,),
}  # fmt: skip
_PROGRAMS = (
    "os.system",
    "os.exec",
    "os.posix_spawn",
    "os.spawn",
    "subprocess.Popen",
    "pickle.find_class",
)


class Hang(BaseException):
    """A reader did not return in time."""


class WrongNumberError(Exception):
    """A reader accepted a changed file as the original."""


@dataclass
class Tally:
    """Outcomes of the inputs of a kind; each list holds examples."""

    inputs_tried: int = 0
    accepted: int = 0
    refused: int = 0
    tracebacks: list[str] = field(default_factory=list)
    hangs: list[str] = field(default_factory=list)
    writes_outside: list[str] = field(default_factory=list)
    wrong_numbers: list[str] = field(default_factory=list)

    def record(self) -> dict[str, int]:
        numbers = {key: getattr(self, key) for key in ("inputs_tried", "accepted", "refused")}
        return numbers | {key: len(getattr(self, key)) for key in FAULTS}

    @property
    def faults(self) -> list[str]:
        return [example for name in FAULTS for example in getattr(self, name)]


_watched: list[tuple[Path, list[str]]] = []


def _audit(event: str, arguments: tuple) -> None:
    if not _watched:
        return
    folder, outside = _watched[-1]
    if event == "open":
        path, _, flags = arguments
        if (
            isinstance(flags, int)
            and flags & _WRITING
            and isinstance(path, str | bytes | os.PathLike)
        ):
            _note(folder, outside, event, path)
    elif event in _CHANGES:
        for place in _CHANGES[event]:
            _note(folder, outside, event, arguments[place])
    elif event in _PROGRAMS:
        outside.append(f"{event} {arguments!r:.200}")


def _note(folder: Path, outside: list[str], event: str, path: object) -> None:
    real = os.path.realpath(os.fsdecode(path)) if not isinstance(path, int) else ""
    # Python stores compiled modules when they are first loaded.
    if real and not Path(real).is_relative_to(folder) and "__pycache__" not in real:
        outside.append(f"{event} {real}")


sys.addaudithook(_audit)


@contextmanager
def _limited():
    def too_long(number, frame):
        raise Hang

    timers = {
        signal.SIGPROF: (signal.ITIMER_PROF, COMPUTING_S),
        signal.SIGALRM: (signal.ITIMER_REAL, WAITING_S),
    }
    before = {number: signal.signal(number, too_long) for number in timers}
    # On one processor `forked` works in this process, whose changes to files are seen.
    processors = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(processors)})
    for timer, seconds in timers.values():
        signal.setitimer(timer, seconds)
    try:
        yield
    finally:
        os.sched_setaffinity(0, processors)
        for number, (timer, _) in timers.items():
            signal.setitimer(timer, 0.0)
            signal.signal(number, before[number])


def attempt(
    tally: Tally, folder: Path, shown: object, act: Callable[[], None], refusals: tuple[type, ...]
) -> None:
    """Call a reader and record the outcome.

    Args:
        folder: the only one in which it may write.
        shown: the input, for the note of a fault.
        refusals: errors whose text is a line for the user, for each mistake.
    """
    outside: list[str] = []
    tally.inputs_tried += 1
    _watched.append((Path(os.path.realpath(folder)), outside))
    try:
        with _limited():
            act()
        tally.accepted += 1
    except refusals as error:
        tally.refused += 1
        # An OSError is shown to the user as file and system message; a campaign has a line for each
        # of its mistakes.
        lines = len(getattr(error, "mistakes", (error,)))
        if str(error).strip().count("\n") != lines - 1 or not str(error).strip():
            tally.tracebacks.append(
                f"not a line for each mistake: {str(error)!r:.300} of {shown!r:.500}"
            )
    except WrongNumberError as error:
        tally.wrong_numbers.append(f"{error} of {shown!r:.2000}")
    except Hang:
        tally.hangs.append(f"{shown!r:.2000}")
    except Exception:
        tally.tracebacks.append(f"{traceback.format_exc()} of {shown!r:.2000}")
    finally:
        _watched.pop()
    if outside:
        tally.writes_outside.append(f"{outside[:3]} of {shown!r:.2000}")
