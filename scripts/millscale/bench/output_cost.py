"""Cost of restart files and of rows of series.csv: `millscale bench output-cost`.

A finished multi-ball case continues from its last restart file in short runs that write one kind of
output often. The overhead is the cost of one file or row over the cost of the steps between two at
the intervals of the case. Times are processor times, and the least of several rounds, so that other
work on the machine changes them little.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from millscale.cases.decks import copy_decks
from millscale.engine.deck_run import engine_environment, find_engine
from millscale.engine.log import loop_timing, read_log
from millscale.engine.record import provenance
from millscale.engine.restart_file import read_restart
from millscale.engine.resume import RESUME_FILE
from millscale.runs.case_file import Case, load_case
from millscale.runs.untrusted import read_tail
from millscale.runs.writing import write_text

NEVER = 10**9
OCCUPANCY = "fix occupancy"
STEPS, RESTART_EVERY, ROW_EVERY = 600, 20, 4
ROUNDS = 3


@dataclass(frozen=True)
class Output:
    """Steps between restart files and between rows; whether the cross-section is averaged."""

    restart_every: int
    row_every: int
    cross_section: bool


def output_cost(case_folder: Path) -> dict:
    """Return the overheads of restart files and series at the intervals of a case.

    Args:
        case_folder: of a multi-ball case, with its restart files.
    """
    case = load_case(case_folder)
    runs = {
        "none": Output(NEVER, NEVER, True),
        "restarts": Output(RESTART_EVERY, NEVER, True),
        "rows": Output(NEVER, ROW_EVERY, False),
        "rows and cross-section": Output(NEVER, ROW_EVERY, True),
    }
    with tempfile.TemporaryDirectory(dir=case_folder.parent) as folder:
        step = _prepare(case_folder, Path(folder))
        rounds = [
            {name: _run(case, Path(folder), step, output) for name, output in runs.items()}
            for _ in range(ROUNDS)
        ]
    least = {name: min(times[name][0] for times in rounds) for name in runs}
    output = min(times["restarts"][1] for times in rounds)
    of_step = least["none"] / STEPS
    restart = (least["restarts"] - least["none"]) / (STEPS // RESTART_EVERY)
    row, with_section = (
        (least[name] - least["none"]) / (STEPS // ROW_EVERY)
        for name in ("rows", "rows and cross-section")
    )
    # The cross-section is sampled, with each row, in the second half of a rotation.
    mean_row = (row + with_section) / 2
    own = case.output
    return {
        "schema": 1,
        **provenance(),
        "command": "millscale bench output-cost CASE",
        "case": case.id,
        "balls": case.ball.count,
        "restart_steps": own.restart_steps,
        "sample_steps": own.sample_steps,
        "processor_s_per_step": of_step,
        "processor_s_per_restart_file": restart,
        "wall_s_per_restart_file": output / (STEPS // RESTART_EVERY),
        "processor_s_per_row": row,
        "processor_s_per_row_and_cross_section": with_section,
        "overhead_of_restarts": restart / (own.restart_steps * of_step),
        "overhead_of_series": mean_row / (own.sample_steps * of_step),
    }


def _prepare(case_folder: Path, folder: Path) -> int:
    """Copy the files of the case; return the step of the restart file."""
    newest = max(
        (read_restart(path) for path in case_folder.glob("mill.*.restart")), key=lambda x: x.step
    )
    shutil.copy(newest.path, folder / RESUME_FILE)
    for name in ("liner.stl", "parameters.in"):
        shutil.copy(case_folder / name, folder)
    return newest.step


def _run(case: Case, folder: Path, step: int, output: Output) -> tuple[float, float]:
    """Return processor time of the engine on one rank, and wall time of its output [s]."""
    copy_decks(("mill.in",), folder)
    if not output.cross_section:
        deck = folder / "charge_series.in"
        write_text(deck, deck.read_text(encoding="utf-8").split(OCCUPANCY)[0])
    done = step - case.time.settle_steps
    values = {
        "restart_steps": output.restart_every,
        "sample_steps": output.row_every,
        "rotation_steps": done + STEPS,
        "dumps": "off",
        "resume": 1,
    }
    words = [word for name, value in values.items() for word in ("-var", name, str(value))]
    parameters = folder / "parameters.in"
    kept = [
        x for x in parameters.read_text(encoding="utf-8").splitlines() if x.split()[1] not in values
    ]
    write_text(parameters, "\n".join(kept) + "\n")
    line = [str(find_engine()), "-in", "mill.in", "-log", "log.cost", *words]
    with (folder / "out").open("wb") as screen:
        process = subprocess.Popen(line, cwd=folder, env=engine_environment(), stdout=screen)
        _, status, usage = os.wait4(process.pid, 0)
    loop = loop_timing(read_log(folder / "log.cost"))
    if status or loop is None or loop.steps != STEPS:
        raise RuntimeError(read_tail(folder / "out", 2000))
    return usage.ru_utime + usage.ru_stime, loop.share["output"] * loop.loop_time
