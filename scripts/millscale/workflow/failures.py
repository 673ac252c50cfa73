"""Known kinds of failure of a stage: how they are recognised, and advice for each.

A failure is classified by the stage's error, the output of engine and mpirun, the last row of the
series, processes killed for lack of memory since the stage began, and the free disk. The table
`CAUSES` holds all kinds and advice; `classify` reads no file.
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
DAMAGED, BY_HAND, MPI = "damaged file", "by hand", "mpi does not start"
# An engine that writes nothing for this time [s], and for the time of a few lines of its log, makes
# no progress.
SILENCE = 600.0
# A disk with less free space is full: every product of a stage is larger.
LEAST_FREE_BYTES = 64 * 1024
# No number of a series of a sound simulation is as large, in SI units.
WILD = 1e15
_TAIL_BYTES = 64 * 1024
# Heading of the engine's table: the engine has accepted the deck and begun to step.
_RUNNING = re.compile(r"^Step Atoms ", re.M)
_SIGNAL = re.compile(r"exited on signal (\d+)|ended by signal (\d+)")


class TimeLimitError(RuntimeError):
    """A stage took longer than its time limit."""


@dataclass(frozen=True)
class Cause:
    """A cause of failure.

    Attributes:
        kind: several causes may be of one kind.
        traces: regular expression found in the output or the error; empty if no text shows it.
        advice: what to do, one line.
    """

    kind: str
    traces: str
    advice: str


def _any(*expressions: str) -> str:
    """Return a regular expression that finds any of those that are not empty."""
    return "|".join(filter(None, expressions))


# Debian packages of the libraries that the gmsh wheel links to (scripts/setup installs them).
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
_WITHOUT_GMSH = 'or set wall.kind = "analytic", which needs no gmsh; run again'
# The message of the guard ends with possible causes, the likeliest first.
_LISTED = (
    "try the remedies of the message in their order; millscale plan FILE shows step_s over its "
    "limits"
)
# Recognised by text; the first that matches counts. A full disk or memory comes first because other
# errors follow from it, and NaN before lost balls for the same reason.
CAUSES = (
    Cause(
        BY_HAND,
        r"made by hand is not used: .*ends at step",
        "resume with sh mpirun.sh there, or move the named file to another folder; run again",
    ),
    Cause(
        BY_HAND,
        r"made by hand is not used",
        "move the named file to another folder, then run again",
    ),
    Cause(
        DISK_FULL,
        r"No space left on device|Disk quota exceeded|File too large",
        "free disk space, or increase dump_angle_rad or sample_angle_rad; run again",
    ),
    Cause(
        MEMORY,
        _any(
            r"std::bad_alloc|Failed to (re)?allocate|Cannot allocate memory|MemoryError"
            r"|[Oo]ut [Oo]f [Mm]emory|Unable to allocate",
            *(target.memory_message for target in TARGETS.values()),
        ),
        "run fewer cases at a time (--jobs), shorten slice_length_m, or request more memory",
    ),
    Cause(
        TIME_OUT,
        _any(
            r"longer than the time limit",
            *(target.time_limit_message for target in TARGETS.values()),
        ),
        "increase --time-limit or --ranks; millscale plan predicts the time",
    ),
    Cause(
        MPI,
        r"orte_init failed|MPI_INIT failed|PMIX ERROR",
        "repeat the command; if it fails again, check that the folder of TMPDIR exists and that "
        "mpirun -np 2 hostname works",
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
        "install the Debian package of the named library (scripts/setup does), " + _WITHOUT_GMSH,
    ),
    Cause(
        MISSING_LIBRARY,
        r"No module named",
        "install the named package into the same Python: scripts/setup does; run again",
    ),
    Cause(
        NOT_A_NUMBER,
        r"mill/guard: .*(\bnan\b|not a number|(not|no) finite|infinit)",
        _LISTED,
    ),
    Cause(
        NOT_A_NUMBER,
        r"is NaN!|[Nn]on-numeric|\bis (nan|-?inf) in line",
        "reduce step_s, or set it to `advised`; see the last rows of series.csv",
    ),
    Cause("overlap too large", r"mill/guard: [^;]*overlap", _LISTED),
    Cause(
        "overlap too large",
        r"balls of the settled bed overlap",
        "increase youngs_modulus_pa (millscale plan FILE warns of soft balls), or reduce step_s if "
        "it is given",
    ),
    Cause(
        NOT_SETTLED,
        r"(hangs in the air|still moves) after settling",
        "increase settle_s, or leave it out for 1.27 sqrt(R / g)",
    ),
    Cause("lost ball", r"mill/guard: [^;]*(left|outside|lost|faster)", _LISTED),
    Cause(
        "lost ball",
        r"[Ll]ost atoms|Out of range atoms",
        "see the last row or dump for its position: at a mesh wall, check liner.stl for a hole; "
        "elsewhere, reduce step_s",
    ),
    Cause(
        DAMAGED,
        r"cut short|not a complete dump|[Rr]estart file|not valid JSON|two runs in one file"
        r"|does not match its digest",
        "delete the named file and run again: its stage writes it again",
    ),
    Cause(
        "mesh error",
        r"liner mesh not fit.*smallest angle|the mesh needs",
        'leave out wall.axial_divisions for the automatic value, or set wall.kind = "analytic"',
    ),
    Cause(
        "mesh error",
        r"liner mesh not fit",
        'change wall.chord_error_m, or set wall.kind = "analytic"',
    ),
    Cause(
        "mesh error",
        r"mesh/surface|[Mm]esh .*(element|corrupt|quality|STL)|STL|duplicate elements|liner\.stl",
        "delete liner.stl in the case folder and run again: its stage writes it again",
    ),
    Cause(
        DOES_NOT_FIT,
        r"balls of radius .* do not fit|takes less than",
        "use smaller balls, a smaller S or wider grooves: millscale plan FILE shows the largest S",
    ),
    Cause(
        DOES_NOT_FIT,
        r"centre outside the liner",
        "delete charge.data, settled.restart and parameters.in in the case folder and run again: "
        "they belong to another mill",
    ),
    Cause(
        WRONG_DECK,
        r"Unknown command|Illegal |Invalid \S+ (style|command)|[Uu]nknown (fix|compute|pair|atom)"
        r"|Substitution for|Cannot open (include|input) |expected a (value|number|whole)",
        "delete the decks (*.in) in the case folder and run again: they are copied again",
    ),
)
# Not recognised by text.
_MORE_CAUSES = (
    Cause(KILLED, "", "repeat the command to resume: finished stages are kept"),
    Cause(
        "crash",
        "",
        "reduce step_s: a ball far outside crashes the engine; otherwise report it with the log",
    ),
    Cause(
        NO_PROGRESS, "", "check the processes with top; press Ctrl-C and repeat the command"
    ),
    Cause(UNKNOWN, "", "see the log"),
)  # fmt: skip
KINDS = tuple(dict.fromkeys(cause.kind for cause in (*CAUSES, *_MORE_CAUSES)))


def advice_of(kind: str, text: str = "") -> str:
    """Return the advice for a kind of failure and the text of its cause."""
    of_kind = [cause for cause in (*CAUSES, *_MORE_CAUSES) if cause.kind == kind]
    found = (cause for cause in of_kind if cause.traces and re.search(cause.traces, text))
    return next(found, of_kind[-1]).advice


@dataclass(frozen=True)
class Failure:
    """A failure: its kind, one line of cause, one line of advice."""

    kind: str
    cause: str
    advice: str


@dataclass(frozen=True)
class Traces:
    """What a failed stage has left.

    Attributes:
        error: the stage's error; the engine's own message if there is one.
        printed: end of the engine's log and of the stage's output.
        last_row: last line of the series.
        memory_kills: processes killed for lack of memory since the stage began.
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
    """Return the failure that the traces of a stage show."""
    kind, text = _kind(traces)
    cause = " ".join(text.split())
    return Failure(kind, cause if kind == UNKNOWN else f"{kind}: {cause}", advice_of(kind, cause))


def _kind(traces: Traces) -> tuple[str, str]:
    """Return kind and cause."""
    error, printed = traces.error, traces.printed
    found = _by_text(error)
    number = _signal(error) or _signal(printed)
    if found in (DISK_FULL, MEMORY, TIME_OUT):
        return found, error
    if traces.free_bytes < LEAST_FREE_BYTES:
        return DISK_FULL, f"{traces.free_bytes} bytes left on the disk; {error}"
    if traces.memory_kills > 0 and number == 9:
        return MEMORY, f"the system killed {traces.memory_kills} processes for memory; {error}"
    # Output shows more than the error only for these kinds: warnings may match the others.
    behind = _by_text(printed)
    if behind in (DISK_FULL, MEMORY, TIME_OUT, MPI):
        return behind, f"{_line_of(behind, printed)}; {error}"
    wild = _wild(traces.last_row) if found in (None, "lost ball") else ""
    if wild:
        return NOT_A_NUMBER, f"the last row of series.csv holds {wild}; {error}"
    if found:
        return found, error
    if number in (6, 7, 8, 11):
        return "crash", error
    if number in (1, 2, 9, 15) or "ended by a signal" in error:
        return KILLED, error
    if traces.runs_engine and "ERROR" in error and not _RUNNING.search(printed):
        return WRONG_DECK, error
    return UNKNOWN, error


def _by_text(text: str) -> str | None:
    return next((cause.kind for cause in CAUSES if re.search(cause.traces, text)), None)


def _line_of(kind: str, text: str) -> str:
    traces = "|".join(x.traces for x in CAUSES if x.kind == kind)
    return next(line.strip() for line in text.splitlines() if re.search(traces, line))


def _signal(text: str) -> int | None:
    found = _SIGNAL.search(text)
    return int(found[1] or found[2]) if found else None


def _wild(row: str) -> str:
    """Return the first number of a row that is NaN or beyond WILD; empty if there is none."""
    for word in row.split(","):
        try:
            if not abs(float(word)) < WILD:
                return word.strip()
        except ValueError:
            continue
    return ""


def diagnose(error: BaseException, folder: Path, stage: str, memory_kills: int) -> Failure:
    """Return the failure of a stage of a case folder.

    Args:
        error: what the stage raised.
        stage: its name; it wrote to STAGE.part.
        memory_kills: processes killed for lack of memory since it began.
    """
    log, screen = folder / f"log.{stage}", folder / f"out.{stage}"
    return classify(
        Traces(
            error=_text_of(error),
            printed=f"{tail(log)}\n{tail(screen)}",
            last_row=_last_line(folder / f"{stage}.part" / "series.csv"),
            memory_kills=memory_kills,
            free_bytes=shutil.disk_usage(folder).free,
            runs_engine=log.exists(),
        )
    )


def _text_of(error: BaseException) -> str:
    if isinstance(error, OSError) and error.errno == errno.EDQUOT:
        return f"Disk quota exceeded: {error.filename}"
    words = str(error)
    if not words or isinstance(error, MemoryError | KeyError | IndexError):
        return f"{type(error).__name__}: {words}".removesuffix(": ")
    return words


def tail(path: Path) -> str:
    """Return the end of a text file; empty if there is no file."""
    return read_tail(path, _TAIL_BYTES)


def _last_line(path: Path) -> str:
    lines = tail(path).splitlines()
    return lines[-1] if len(lines) > 1 else ""


def memory_kills() -> int:
    """Return how many processes of this control group or machine were killed for lack of memory."""
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
