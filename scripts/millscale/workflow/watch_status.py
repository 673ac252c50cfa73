"""`millscale status`: one look at a runs folder, or one after the other while something runs."""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from rich.console import Console
from rich.live import Live

from millscale.workflow.display import problems, status_table, status_view
from millscale.workflow.predicted_times import error_line
from millscale.workflow.status import CaseStatus, campaign_status


def show(runs: Path, silence: float, as_json: bool, console: Console) -> None:
    """Print the status of every case, as a table or as JSON.

    Args:
        silence: an engine that writes nothing for so long makes no progress [s].
    """
    statuses = campaign_status(runs, silence)
    if as_json:
        print(json.dumps([asdict(x) for x in statuses], indent=1))
        return
    console.print(status_table(statuses))
    for line in [*problems(runs, statuses), error_line(runs)]:
        if line:
            console.print(line, markup=False, highlight=False, soft_wrap=True)


def watch_status(runs: Path, silence: float, as_json: bool, every: float, console: Console) -> None:
    """Show the status again and again, until no case runs.

    Args:
        every: time between two looks [s].
    """
    with Live(console=console, auto_refresh=False) as live:
        while True:
            statuses = campaign_status(runs, silence)
            if as_json:
                print(json.dumps([asdict(x) for x in statuses]), flush=True)
            elif console.is_terminal:
                live.update(status_view(runs, statuses, _counts(statuses)), refresh=True)
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
    steps = sum(x.steps * x.balls for x in statuses)
    done = sum(x.step * x.balls for x in statuses)
    percent = 100.0 * done / steps if steps else 100.0
    return (
        f"{time.strftime('%H:%M:%S')} {len(statuses)} cases: {', '.join(counts)}; {percent:.0f} %"
    )
