"""Error, version and timing in the engine's log."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from millscale.runs.untrusted import MOST_LOG, read_head, read_tail
from millscale.terminal import one_line

# The engine prints this when a signal ends it; its exit code is then 0, as after success.
_ENDED_BY_SIGNAL = "SIGINT/SIGTERM caught"
_LOOP = re.compile(r"^Loop time of (\S+) on (\d+) procs for (\d+) steps with (\d+) atoms", re.M)
_SECTION = re.compile(r"^(Pair|Neigh|Comm|Outpt|Other)\s+time \(%\) = (\S+)", re.M)
_CRASH = re.compile(
    r"process rank (\d+) with PID \d+ on node \S+\s+exited\s+on\s+(signal \d+ \([^)]*\))"
)
_LONGEST_LINE = 1000
_NAMES = {"Pair": "pair", "Neigh": "neigh", "Comm": "comm", "Outpt": "output", "Other": "other"}


@dataclass(frozen=True)
class LoopTiming:
    """Sums over the `run` commands of a log.

    Attributes:
        particle_steps: sum of steps x balls.
        loop_time: wall time inside the time loop [s].
        share: section -> fraction of the loop time; they add up to 1.
    """

    ranks: int
    balls: int
    steps: int
    particle_steps: int
    loop_time: float
    share: dict[str, float]


def read_log(*paths: Path) -> str:
    """Return the text of the logs that exist, one after the other; of a huge log only the end."""
    # After an error the engine may write bytes that are not text.
    return "\n".join(read_tail(path, MOST_LOG) for path in paths)


def engine_version(log: Path) -> str:
    """Return the first line of a log: the engine's version and its compilation."""
    return one_line(read_head(log, _LONGEST_LINE).partition("\n")[0])


def error_line(text: str) -> str | None:
    """Return the engine's last error message, or how it ended without one; None after success."""
    errors = [line.strip() for line in text.splitlines() if line.startswith("ERROR")]
    if errors:
        return errors[-1]
    crash = _CRASH.search(text)
    if crash:
        return f"the engine crashed: rank {crash[1]} exited on {crash[2]}"
    return "the engine was ended by a signal" if _ENDED_BY_SIGNAL in text else None


def loop_timing(text: str) -> LoopTiming | None:
    """Return the timing of the finished `run` commands in a log; None if there is none."""
    loops = [(float(t), int(p), int(n), int(a)) for t, p, n, a in _LOOP.findall(text)]
    if not loops:
        return None
    seconds = dict.fromkeys(_NAMES.values(), 0.0)
    for section, value in _SECTION.findall(text):
        seconds[_NAMES[section]] += float(value)
    total = sum(seconds.values())
    return LoopTiming(
        ranks=loops[-1][1],
        balls=loops[-1][3],
        steps=sum(steps for _, _, steps, _ in loops),
        particle_steps=sum(steps * balls for _, _, steps, balls in loops),
        loop_time=sum(time for time, *_ in loops),
        share={name: value / total if total > 0.0 else 0.0 for name, value in seconds.items()},
    )
