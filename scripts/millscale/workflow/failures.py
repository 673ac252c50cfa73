"""Why a stage failed and what to do about it: known kinds of failure, told by their traces.

Traces are the stage's error, what engine and mpirun printed, the last row of the series, kills for
want of memory since the stage began, and the free disk. The table `CAUSES` is the one home of the
words; `classify` knows no file.
"""

from __future__ import annotations

import errno
import re
import shutil
from dataclasses import dataclass
from pathlib import Path

from millscale.runs.untrusted import read_tail
from millscale.workflow.targets import TARGETS

UNKNOWN, KILLED, NO_PROGRESS, TIME_OUT = "unknown", "killed", "no progress", "time out"
NOT_A_NUMBER, MEMORY, DISK_FULL, WRONG_DECK = "nan", "out of memory", "disk full", "wrong deck"
MISSING_LIBRARY, NOT_SETTLED, DOES_NOT_FIT = "missing library", "not settled", "does not fit"
DAMAGED, BY_HAND = "damaged file", "by hand"
# An engine that writes nothing for so long [s], and for the time of a few lines of its log, makes
# no progress.
SILENCE = 600.0
# Below this a disk is full: no product of a stage is smaller than a block of the file system.
LEAST_FREE_BYTES = 64 * 1024
# No number of a series is as large, in SI units, while the simulation goes well.
WILD = 1e15
_TAIL_BYTES = 64 * 1024
# Heading of the engine's table: from there on it was running, and its deck was understood.
_RUNNING = re.compile(r"^Step Atoms ", re.M)
_SIGNAL = re.compile(r"exited on signal (\d+)|ended by signal (\d+)")


class TimeLimitError(RuntimeError):
    """A stage took longer than it was allowed to."""


@dataclass(frozen=True)
class Cause:
    """A cause of failure: its kind, what its traces look like, and what to do.

    Attributes:
        kind: several causes may be of one kind.
        traces: regular expression of what was printed or said; empty if no text tells it.
        advice: one line.
    """

    kind: str
    traces: str
    advice: str


def _any(*expressions: str) -> str:
    """Return a regular expression that finds any of those that are not empty."""
    return "|".join(filter(None, expressions))


# The Debian packages of what the gmsh wheel links to (scripts/setup installs them).
_LIBRARIES = {
    "libGLU": "libglu1-mesa",
    "libGL": "libgl1",
    "libfontconfig": "libfontconfig1",
    "libgomp": "libgomp1",
    "libXcursor": "libxcursor1",
    "libXfixes": "libxfixes3",
    "libXft": "libxft2",
    "libXinerama": "libxinerama1",
    "libXrender": "libxrender1",
}
_WITHOUT_GMSH = 'or take wall.kind = "analytic", which needs no gmsh; run again'
# What the guard's message ends with: what may be behind it, the likeliest first.
_LISTED = (
    "try what the message lists, in its order; millscale plan FILE shows step_s over its limits"
)
# Told by their words, in this order: the first that is found. A full disk or memory makes other
# errors follow it, and a number that is not one makes balls go astray.
CAUSES = (
    Cause(
        BY_HAND,
        r"made by hand is not used: .*ends at step",
        "sh mpirun.sh there goes on, or move what is named to another folder; run again",
    ),
    Cause(
        BY_HAND,
        r"made by hand is not used",
        "move what is named to another folder, then run again",
    ),
    Cause(
        DISK_FULL,
        r"No space left on device|Disk quota exceeded|File too large",
        "free some disk, or take a larger dump_angle_rad or sample_angle_rad; run again",
    ),
    Cause(
        MEMORY,
        _any(
            r"std::bad_alloc|Failed to (re)?allocate|Cannot allocate memory|MemoryError"
            r"|[Oo]ut [Oo]f [Mm]emory|Unable to allocate",
            *(target.memory_message for target in TARGETS.values()),
        ),
        "run fewer cases at a time (--jobs), a shorter slice_length_m, or ask for more memory",
    ),
    Cause(
        TIME_OUT,
        _any(
            r"longer than the time limit",
            *(target.time_limit_message for target in TARGETS.values()),
        ),
        "allow more time (--time-limit), or more ranks; millscale plan predicts the time",
    ),
    *(
        Cause(
            MISSING_LIBRARY,
            rf"{library}\.so[.\d]*: cannot open shared object",
            f"sudo apt-get install {package}, {_WITHOUT_GMSH}",
        )
        for library, package in _LIBRARIES.items()
    ),
    Cause(
        MISSING_LIBRARY,
        r"cannot open shared object file",
        "install the Debian package that holds the library named (scripts/setup does), "
        + _WITHOUT_GMSH,
    ),
    Cause(
        MISSING_LIBRARY,
        r"No module named",
        "install the package named into the same Python: scripts/setup does; run again",
    ),
    Cause(
        NOT_A_NUMBER,
        r"mill/guard: .*(\bnan\b|not a number|(not|no) finite|infinit)",
        _LISTED,
    ),
    Cause(
        NOT_A_NUMBER,
        r"is NaN!|[Nn]on-numeric|\bis (nan|-?inf) in line",
        "take a shorter step_s, or `advised`; look at the last rows of series.csv",
    ),
    Cause("overlap too large", r"mill/guard: [^;]*overlap", _LISTED),
    Cause(
        "overlap too large",
        r"balls of the settled bed overlap",
        "take a larger youngs_modulus_pa (millscale plan FILE warns of soft balls), or, if step_s "
        "is given, a shorter one",
    ),
    Cause(
        NOT_SETTLED,
        r"(hangs in the air|still moves) after settling",
        "take a longer settle_s, or leave it out for 1.27 sqrt(R / g)",
    ),
    Cause("lost ball", r"mill/guard: [^;]*(left|outside|lost|faster)", _LISTED),
    Cause(
        "lost ball",
        r"[Ll]ost atoms|Out of range atoms",
        "look where the last row or dump shows it: at a mesh, for a hole in liner.stl; elsewhere, "
        "take a shorter step_s",
    ),
    Cause(
        DAMAGED,
        r"cut short|not a complete dump|[Rr]estart file|not valid JSON|two runs in one file"
        r"|does not match its digest",
        "delete the file named and run again: its stage makes it anew",
    ),
    Cause(
        "mesh error",
        r"liner mesh not fit.*smallest angle|the mesh needs",
        'leave out wall.axial_divisions: the program chooses; or take wall.kind = "analytic"',
    ),
    Cause(
        "mesh error",
        r"liner mesh not fit",
        'change wall.chord_error_m, or take wall.kind = "analytic"',
    ),
    Cause(
        "mesh error",
        r"mesh/surface|[Mm]esh .*(element|corrupt|quality|STL)|STL|duplicate elements|liner\.stl",
        "delete liner.stl in the case folder and run again: it is made anew",
    ),
    Cause(
        DOES_NOT_FIT,
        r"balls of radius .* do not fit|takes less than",
        "take smaller balls, a smaller S or wider grooves: millscale plan FILE names the largest S",
    ),
    Cause(
        DOES_NOT_FIT,
        r"centre outside the liner",
        "delete charge.data, settled.restart and parameters.in in the case folder and run again: "
        "they are of another mill",
    ),
    Cause(
        WRONG_DECK,
        r"Unknown command|Illegal |Invalid \S+ (style|command)|[Uu]nknown (fix|compute|pair|atom)"
        r"|Substitution for|Cannot open (include|input) |expected a (value|number|whole)",
        "delete the decks (*.in) in the case folder and run again: they are copied anew",
    ),
)
# Told by something else than words.
_MORE_CAUSES = (
    Cause(KILLED, "", "run the same command again: finished stages are kept"),
    Cause(
        "crash",
        "",
        "take a shorter step_s: a ball far outside crashes the engine; else report it with the log",
    ),
    Cause(
        NO_PROGRESS, "", "see the processes with top; end the run with Ctrl-C and start it again"
    ),
    Cause(UNKNOWN, "", "see the log"),
)  # fmt: skip
KINDS = tuple(dict.fromkeys(cause.kind for cause in (*CAUSES, *_MORE_CAUSES)))


def advice_of(kind: str, said: str = "") -> str:
    """What to do about a failure of a kind, by what was printed or said of it."""
    of_kind = [cause for cause in (*CAUSES, *_MORE_CAUSES) if cause.kind == kind]
    found = (cause for cause in of_kind if cause.traces and re.search(cause.traces, said))
    return next(found, of_kind[-1]).advice


@dataclass(frozen=True)
class Failure:
    """What went wrong: its kind, one line of cause, one of what to do."""

    kind: str
    cause: str
    advice: str


@dataclass(frozen=True)
class Traces:
    """What is left of a stage that failed.

    Attributes:
        error: the stage's error, in the engine's words where it has some.
        printed: tail of the engine's log and of what the stage printed.
        last_row: last line of the series.
        memory_kills: processes killed for want of memory since the stage began.
        free_bytes: on the disk of the case folder.
        runs_engine: whether the stage runs the engine.
    """

    error: str
    printed: str = ""
    last_row: str = ""
    memory_kills: int = 0
    free_bytes: int = 1 << 40
    runs_engine: bool = False


def classify(traces: Traces) -> Failure:
    """The failure that the traces of a stage tell of."""
    kind, said = _kind(traces)
    cause = " ".join(said.split())
    return Failure(kind, cause if kind == UNKNOWN else f"{kind}: {cause}", advice_of(kind, cause))


def _kind(traces: Traces) -> tuple[str, str]:
    """Kind and cause."""
    error, printed = traces.error, traces.printed
    found = _by_words(error)
    number = _signal(error) or _signal(printed)
    if found in (DISK_FULL, MEMORY, TIME_OUT):
        return found, error
    if traces.free_bytes < LEAST_FREE_BYTES:
        return DISK_FULL, f"{traces.free_bytes} bytes left on the disk; {error}"
    if traces.memory_kills > 0 and number == 9:
        return MEMORY, f"the system killed {traces.memory_kills} processes for memory; {error}"
    # What was printed tells more than the error only about the machine: warnings name the rest.
    behind = _by_words(printed)
    if behind in (DISK_FULL, MEMORY, TIME_OUT):
        return behind, f"{_line_of(behind, printed)}; {error}"
    wild = _wild(traces.last_row) if found in (None, "lost ball") else ""
    if wild:
        return NOT_A_NUMBER, f"the last row of series.csv holds {wild}; {error}"
    if found:
        return found, error
    if number in (6, 7, 8, 11):
        return "crash", error
    if number in (1, 2, 9, 15) or "told to end by a signal" in error:
        return KILLED, error
    if traces.runs_engine and "ERROR" in error and not _RUNNING.search(printed):
        return WRONG_DECK, error
    return UNKNOWN, error


def _by_words(text: str) -> str | None:
    return next((cause.kind for cause in CAUSES if re.search(cause.traces, text)), None)


def _line_of(kind: str, text: str) -> str:
    traces = "|".join(x.traces for x in CAUSES if x.kind == kind)
    return next(line.strip() for line in text.splitlines() if re.search(traces, line))


def _signal(text: str) -> int | None:
    found = _SIGNAL.search(text)
    return int(found[1] or found[2]) if found else None


def _wild(row: str) -> str:
    """The first number of a row of a series that is none or beyond all bounds; empty if none is."""
    for word in row.split(","):
        try:
            if not abs(float(word)) < WILD:
                return word.strip()
        except ValueError:
            continue
    return ""


def diagnose(error: BaseException, folder: Path, stage: str, memory_kills: int) -> Failure:
    """The failure of a stage of a case folder.

    Args:
        error: what the stage raised.
        stage: its name; it worked in STAGE.part.
        memory_kills: kills for want of memory since it began.
    """
    log, screen = folder / f"log.{stage}", folder / f"out.{stage}"
    return classify(
        Traces(
            error=_words_of(error),
            printed=f"{tail(log)}\n{tail(screen)}",
            last_row=_last_line(folder / f"{stage}.part" / "series.csv"),
            memory_kills=memory_kills,
            free_bytes=shutil.disk_usage(folder).free,
            runs_engine=log.exists(),
        )
    )


def _words_of(error: BaseException) -> str:
    if isinstance(error, OSError) and error.errno == errno.EDQUOT:
        return f"Disk quota exceeded: {error.filename}"
    words = str(error)
    if not words or isinstance(error, MemoryError | KeyError | IndexError):
        return f"{type(error).__name__}: {words}".removesuffix(": ")
    return words


def tail(path: Path) -> str:
    """End of a text file; empty if there is none."""
    return read_tail(path, _TAIL_BYTES)


def _last_line(path: Path) -> str:
    lines = tail(path).splitlines()
    return lines[-1] if len(lines) > 1 else ""


def memory_kills() -> int:
    """Processes killed for want of memory so far: in this control group, or on this machine."""
    for path in (_group_events(), Path("/proc/vmstat")):
        try:
            words = path.read_text(encoding="utf-8").split()
            return int(words[words.index("oom_kill") + 1])
        except (OSError, ValueError, IndexError):
            continue
    return 0


def _group_events() -> Path:
    try:
        lines = Path("/proc/self/cgroup").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    group = next((line[3:] for line in lines if line.startswith("0::")), "")
    return Path(f"/sys/fs/cgroup/{group}/memory.events")
