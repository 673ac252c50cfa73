"""Status of a runs folder in the terminal: once, repeatedly, or while a run goes on."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Protocol

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.progress import Progress
from rich.table import Table
from rich.text import Text

from millscale.engine.machine import Allocation
from millscale.formats import counted, duration
from millscale.runs.case_file import Case
from millscale.runs.layout import CASES_FOLDER
from millscale.workflow.predictions import error_line
from millscale.workflow.run_progress import Bar, RunProgress, percent
from millscale.workflow.status import CaseStatus, campaign_status, case_status, share_done

STATE_COLOURS = {
    "done": "green",
    "running": "cyan",
    "failed": "red",
    "damaged": "red",
    "interrupted": "yellow",
    "waiting": "bright_black",
}
# In this order the cases are shown.
_ORDER = ("running", "failed", "damaged", "interrupted", "waiting", "done")
# Lines of a screen that the bar, the heading and the lines of the shell take.
_OTHER_LINES = 6
_COLUMNS = ("case", "state", "stage", "steps", "%", "simulated", "particle-steps/s", "left")
# Between two columns.
_GAP = 2
# Columns that a narrow terminal does not show, the least needed first.
_OPTIONAL = ("particle-steps/s", "simulated", "steps")
_REFRESH_S = 1.0
_LINE_S = 10.0
_LINE_EVERY_S = 30.0


class Watch(Protocol):
    def __call__(self) -> None: ...


class Watching(Protocol):
    """Yields a function that shows the progress of cases."""

    def __call__(
        self, console: Console, runs: Path, cases: Sequence[Case], allocation: Allocation
    ) -> AbstractContextManager[Watch]: ...


@contextmanager
def watching(
    console: Console, runs: Path, cases: Sequence[Case], allocation: Allocation
) -> Iterator[Watch]:
    """Yield a function that shows the status of the cases; call it often."""
    statuses, progress = Statuses(runs, cases), RunProgress(cases, allocation)
    if not console.is_terminal:
        lines = _Lines(console, statuses, progress)
        try:
            yield Paced(_REFRESH_S, lines)
        finally:
            lines()
        return
    bar = Bar(progress, console)
    with Live(console=console, auto_refresh=False, transient=True) as live:

        def show() -> None:
            now = statuses()
            progress.update(now)
            live.update(Group(bar.update(), status_view(runs, now, console)), refresh=True)

        yield Paced(_REFRESH_S, show)


@contextmanager
def counting(console: Console, what: str) -> Iterator[Callable[[int, int], None]]:
    """Yield a function that shows how many are done: a bar, or lines outside a terminal."""
    if console.is_terminal:
        with Progress(*Progress.get_default_columns(), console=console, transient=True) as bar:
            task = bar.add_task(what, total=None)
            yield lambda done, total: bar.update(task, completed=done, total=total)
        return
    shown = time.monotonic()

    def line(done: int, total: int) -> None:
        nonlocal shown
        if time.monotonic() - shown > _LINE_S:
            shown = time.monotonic()
            console.print(f"{done} of {total} {what}", markup=False, highlight=False)

    yield line


def show(runs: Path, silence: float, as_json: bool, console: Console) -> None:
    """Print the status of every case, as a table or as JSON.

    Args:
        silence: an engine that writes nothing for this time makes no progress [s].
    """
    statuses = campaign_status(runs, silence)
    if as_json:
        print(json.dumps([asdict(x) for x in statuses], indent=1))
        return
    console.print(status_table(statuses, console))
    for line in [*problems(runs, statuses), error_line(runs)]:
        if line:
            console.print(line, markup=False, highlight=False, soft_wrap=True)


def watch_status(runs: Path, silence: float, as_json: bool, every: float, console: Console) -> None:
    """Show the status repeatedly until no case runs.

    Args:
        every: interval [s].
    """
    with Live(console=console, auto_refresh=False) as live:
        while True:
            statuses = campaign_status(runs, silence)
            if as_json:
                print(json.dumps([asdict(x) for x in statuses]), flush=True)
            elif console.is_terminal:
                view = Group(Text(_counts(statuses)), status_view(runs, statuses, console))
                live.update(view, refresh=True)
            else:
                console.print(_counts(statuses), highlight=False)
            if all(x.state != "running" for x in statuses):
                break
            time.sleep(every)
    if not as_json and not console.is_terminal:
        for line in problems(runs, statuses):
            console.print(line, markup=False, highlight=False, soft_wrap=True)


def _counts(statuses: Sequence[CaseStatus]) -> str:
    states = [x.state for x in statuses]
    counts = [f"{states.count(name)} {name}" for name in dict.fromkeys(states)]
    return (
        f"{time.strftime('%H:%M:%S')} {counted(len(statuses), 'case')}: "
        f"{', '.join(counts)}; {percent(share_done(statuses))} %"
    )


def status_table(statuses: Sequence[CaseStatus], console: Console) -> Table:
    """Return a row for each case, running cases first, with the columns that fit on the terminal:
    state, stage, steps, simulated time, rate, time left."""
    rows, names = [_row(status) for status in _ordered(statuses)], list(_COLUMNS)
    for name in _OPTIONAL:
        if console.is_terminal and _width(rows, names) > console.width:
            names.remove(name)
    table = Table(box=None, pad_edge=False)
    for name in names:
        words = name in ("case", "state", "stage")
        table.add_column(name, justify="left" if words else "right", no_wrap=True)
    for row in rows:
        table.add_row(*(row[name] for name in names))
    return table


def _ordered(statuses: Sequence[CaseStatus]) -> list[CaseStatus]:
    return sorted(statuses, key=lambda status: _ORDER.index(status.state))


def _width(rows: Sequence[dict[str, str | Text]], names: Sequence[str]) -> int:
    """Return the width of a table of these columns [characters]."""
    columns = ((name, *(row[name] for row in rows)) for name in names)
    return sum(max(map(len, column)) for column in columns) + _GAP * (len(names) - 1)


def _row(status: CaseStatus) -> dict[str, str | Text]:
    """Return the cells of a case by column."""
    rate = status.particle_steps_per_s
    state = "starting" if status.is_starting else status.state
    mark = ", by hand" if status.by_hand else ""
    return {
        "case": status.id,
        "state": Text(state + mark, style=STATE_COLOURS[status.state]),
        "stage": status.stage,
        "steps": f"{status.step:,}/{status.steps:,}",
        "%": f"{status.percent:.0f}",
        "simulated": f"{status.simulated_s:.2f} s",
        "particle-steps/s": f"{rate:,.0f}" if rate else "",
        "left": duration(status.time_left_s),
    }


class Statuses:
    """Status of the cases of a run. The files of a case are not read again once it is done."""

    def __init__(self, runs: Path, cases: Sequence[Case]) -> None:
        self._runs, self.cases = runs, cases
        self._done: dict[str, CaseStatus] = {}

    def __call__(self) -> list[CaseStatus]:
        return [self._done.get(case.id) or self._read(case) for case in self.cases]

    def _read(self, case: Case) -> CaseStatus:
        status = case_status(self._runs / CASES_FOLDER / case.id, case)
        if status.state == "done":
            self._done[case.id] = status
        return status


def status_view(runs: Path, statuses: Sequence[CaseStatus], console: Console) -> RenderableType:
    """Return the table, running cases first, and the problems below it, cut to the size of the
    terminal."""
    ordered = _ordered(statuses)
    room = max(console.height - _OTHER_LINES, 4)
    lines = problems(runs, ordered)[: room // 4 * 2]
    table = status_table(ordered[: room - len(lines)], console)
    return Group(table, *(Text(line, no_wrap=True, overflow="ellipsis") for line in lines))


def problems(runs: Path, statuses: Sequence[CaseStatus]) -> list[str]:
    """Return two lines for each case with a problem: stage, cause and log; what to do."""
    lines = []
    for x in (x for x in statuses if x.problem):
        log = runs / CASES_FOLDER / x.id / x.log
        state = f"{x.stage} {x.state}".strip()
        lines += [f"{x.id}: {state}: {x.problem}; see {log}", f"  to do: {x.advice}"]
    return lines


class Paced:
    """Call a function every `interval` seconds, and at most a fiftieth of the time.

    Reading the files of ten thousand cases must not take a core from them.
    """

    def __init__(self, interval: float, call: Watch) -> None:
        self._interval, self._call, self._next = interval, call, 0.0

    def __call__(self) -> None:
        begin = time.monotonic()
        if begin >= self._next:
            self._call()
            end = time.monotonic()
            self._next = end + max(self._interval, 50.0 * (end - begin))


class _Lines:
    """Print a line when a case changes state or stage, and the overall progress regularly."""

    def __init__(self, console: Console, statuses: Statuses, progress: RunProgress) -> None:
        self._console, self._statuses, self._progress = console, statuses, progress
        self._seen: dict[str, tuple[str, ...]] = {}
        self._next_line = time.monotonic() + _LINE_EVERY_S

    def __call__(self) -> None:
        statuses = self._statuses()
        self._progress.update(statuses)
        for status in statuses:
            self._print_change(status)
        if time.monotonic() >= self._next_line:
            self._print(self._progress.line())
            self._next_line = time.monotonic() + _LINE_EVERY_S

    def _print_change(self, status: CaseStatus) -> None:
        now = (status.state, status.stage, status.failure)
        before = self._seen.get(status.id)
        self._seen[status.id] = now
        # A case that failed or was interrupted before this run is about to run again.
        old = before is None and status.state in ("failed", "interrupted")
        if now == before or old or status.state == "waiting":
            return
        what = f"{status.stage} {status.state}" if status.stage else status.state
        self._print(f"{status.id}: {what}" + (f": {status.problem}" if status.problem else ""))
        if status.advice:
            self._print(f"  to do: {status.advice}")

    def _print(self, text: str) -> None:
        stamp = time.strftime("%H:%M:%S")
        self._console.print(f"{stamp} {text}", markup=False, highlight=False, soft_wrap=True)
