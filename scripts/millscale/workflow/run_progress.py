"""Progress of a run over all of its cases: share done, counts of states, time left."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

from millscale.engine.machine import Allocation
from millscale.formats import counted, duration
from millscale.runs.case_file import Case
from millscale.workflow.predictions import time_left
from millscale.workflow.status import CaseStatus, share_done

# Time in which the end that is shown follows a new estimate [s], and its largest share of the time
# left: near the end of a run it follows at once.
SMOOTHING_S, LARGEST_DELAY = 15.0, 0.25
# Less time than this is not predicted: the last case is being analysed [s].
_LEAST_S = 1.0


class SmoothedTimeLeft:
    """Time left whose end follows the estimates with a delay, so that it does not jump."""

    def __init__(self) -> None:
        self._end: float | None = None
        self._at = 0.0

    def __call__(self, estimate: float, now: float) -> float:
        """Return the time left [s] after one more estimate.

        Args:
            estimate: time left [s].
            now: of a steady clock [s].
        """
        end = now + estimate
        delay = min(SMOOTHING_S, LARGEST_DELAY * estimate)
        if self._end is not None and delay > 0.0:
            share = 1.0 - math.exp(-(now - self._at) / delay)
            end = self._end + share * (end - self._end)
        self._end, self._at = end, now
        return max(0.0, end - now)


class RunProgress:
    """Progress of the cases of a run, after each reading of their status.

    Attributes:
        share: of the predicted time that is done.
        counts: how many cases are done, running and failed; "starting" before the first begins.
        left: time left, for people.
    """

    def __init__(
        self,
        cases: Sequence[Case],
        allocation: Allocation,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._cases, self._allocation = {case.id: case for case in cases}, allocation
        self._clock, self._smoothed = clock, SmoothedTimeLeft()
        self._first: int | None = None
        self._begun = False
        self.share, self.counts, self.left = 0.0, "", ""

    def update(self, statuses: Sequence[CaseStatus]) -> None:
        """Take in the status of all cases, in any order."""
        states = [status.state for status in statuses]
        finished = states.count("done") + states.count("failed")
        self._first = finished if self._first is None else self._first
        self._begun = self._begun or "running" in states or finished != self._first
        self.share, self.counts = share_done(statuses), self._counts(states)
        left = self._smoothed(time_left(statuses, self._cases, self._allocation), self._clock())
        self.left = f"about {duration(left)} left" if left >= _LEAST_S else "ending"
        if finished == len(states):
            self.left = ""

    def line(self) -> str:
        """Return all of it in one line."""
        return ", ".join(filter(None, [self.counts, f"{percent(self.share)} %", self.left]))

    def _counts(self, states: Sequence[str]) -> str:
        all_cases = counted(len(states), "case")
        if not self._begun and set(states) != {"done"}:
            return f"starting, {states.count('done')} of {all_cases} done"
        others = [f"{states.count(x)} {x}" for x in ("running", "failed") if x in states]
        return ", ".join([f"{states.count('done')} of {all_cases} done", *others])


def percent(share: float) -> int:
    """Return a share in whole percent, 100 only for all."""
    return math.floor(100.0 * share)


class Bar:
    """A progress bar of a run."""

    def __init__(self, progress: RunProgress, console: Console | None = None) -> None:
        self._progress = progress
        self.shown = Progress(
            TextColumn("{task.description}"),
            BarColumn(bar_width=None),
            TaskProgressColumn(),
            TextColumn("{task.fields[left]}"),
            console=console,
            expand=True,
        )
        self._task = self.shown.add_task("", total=1.0, left="")

    def update(self) -> Progress:
        """Return the bar as the progress is now."""
        now = self._progress
        self.shown.update(self._task, completed=now.share, description=now.counts, left=now.left)
        return self.shown
