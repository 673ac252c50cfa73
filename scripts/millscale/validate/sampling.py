"""What rows of series.csv miss between their steps: `millscale validate sampling`.

A finished multi-ball case continues from its last restart file with a row at every step. A quantity
that alternates from step to step has different means over the even and the odd steps. The largest
value of the rows is smaller than the largest value of all steps.
"""

from __future__ import annotations

import re
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from millscale.analysis.charge.result import charge_scales, torque_balance
from millscale.analysis.charge.steady import Window
from millscale.cases.decks import copy_decks
from millscale.engine.deck_run import engine_text, find_engine
from millscale.engine.record import provenance
from millscale.engine.restart_file import read_restart
from millscale.engine.resume import RESUME_FILE
from millscale.errors import EngineError
from millscale.runs.case_file import Case, load_case
from millscale.runs.series import Series, read_series
from millscale.runs.untrusted import RunFolderError
from millscale.runs.writing import write_json, write_text

COMMAND = "millscale validate sampling CASE..."
STEPS = 3000
LARGEST = ("largest_overlap_m", "largest_speed_m_s")
QUANTITIES = (
    *("drive_torque_Nm", "kinetic_translation_J", "kinetic_rotation_J", "centre_x_m"),
    *("balls_on_wall", "balls_in_bed", "balls_in_flight"),
    *("box_fixed_mass_fraction", "toe_angle_rad", "shoulder_angle_rad", "liner_slip", *LARGEST),
)
_RUN = re.compile(r"^run\s.*$", re.M)


def every_step(case_folder: Path, folder: Path, steps: int, step_s: float) -> Series:
    """Continue a case from its last restart file with a time step [s]; return its series, with a
    row for each step."""
    copy_decks(("mill.in",), folder)
    files = [read_restart(path) for path in case_folder.glob("mill.*.restart")]
    if not files:
        raise RunFolderError(case_folder, "no mill.*.restart", "give a case that has run")
    newest = max(files, key=lambda file: file.step)
    shutil.copyfile(newest.path, folder / RESUME_FILE)
    values = {
        "sample_steps": 1,
        "dumps": "off",
        "restart_steps": 10**9,
        "time_step": repr(step_s),
    }
    parameters = (case_folder / "parameters.in").read_text(encoding="utf-8").splitlines()
    lines = [x for x in parameters if x.startswith("#") or x.split()[1] not in values]
    lines += [f"variable {name} string {value}" for name, value in values.items()]
    write_text(folder / "parameters.in", "\n".join(lines) + "\n")
    deck = (folder / "mill.in").read_text(encoding="utf-8")
    # The deck resumes, but writes a new series.
    write_text(folder / "mill.in", _RUN.sub(f"run {steps}", deck))
    series = (folder / "charge_series.in").read_text(encoding="utf-8")
    begin = [line for line in series.splitlines() if not line.startswith("if ")]
    write_text(folder / "charge_series.in", "\n".join(begin) + "\n")
    _, cause = engine_text([str(find_engine()), "-in", "mill.in", "-var", "resume", "1"], folder)
    if cause:
        raise EngineError(f"mill.in did not finish: {cause}")
    return read_series(folder / "series.csv", "multi-ball")


def by_parity(series: Series, every: int) -> dict[str, dict[str, float]]:
    """Return means of each quantity over even and odd steps, half their difference, and scatter.

    Largest values also have the mean of the rows every `every` steps, and that of the largest
    values between rows.
    """
    even = series["step"] % 2 == 0
    found = {}
    for name in QUANTITIES:
        values = series[name]
        row = {
            "even": float(values[even].mean()),
            "odd": float(values[~even].mean()),
            "alternating": float(0.5 * (values[even].mean() - values[~even].mean())),
            "scatter": float(values.std()),
        }
        if name in LARGEST:
            whole = values[: len(values) // every * every].reshape(-1, every)
            row |= {
                "mean_of_rows": float(whole[:, -1].mean()),
                "mean_of_largest": float(whole.max(axis=1).mean()),
                "largest_of_rows": float(whole[:, -1].max()),
                "largest": float(whole.max()),
            }
        found[name] = row
    return found


def torque_of(series: Series, case: Case) -> dict[str, float]:
    """Return torque over M g R of a series: by the work of the drive and by the balance."""
    scales, ends = charge_scales(case, series), series["mill_angle_rad"][[0, -1]]
    window = Window(float(ends[0]), float(ends[1]), ends)
    balance = torque_balance(series, scales, window)
    by_charge = balance.weight_Nm + balance.angular_momentum_Nm
    return {
        "summed": balance.summed_Nm / scales.torque,
        "by_weight_and_momentum": by_charge / scales.torque,
        "difference": balance.difference,
    }


def sampled(case_folder: Path, steps: int, step_s: float | None = None) -> dict[str, Any]:
    """Return what the rows of a case miss, with its own time step or another [s]."""
    case = load_case(case_folder)
    own = case.time.step_s
    with tempfile.TemporaryDirectory(prefix="sampling-") as folder:
        series = every_step(case_folder, Path(folder), steps, step_s or own)
    every = round(case.output.sample_steps * own / (step_s or own))
    return {
        "S": case.S,
        "step_s": step_s or own,
        "balls": case.ball.count,
        "tangential_damping": case.deck.tangential_damping,
        "steps": steps,
        "sample_steps": every,
        "torque": torque_of(series, case),
        "quantities": by_parity(series, every),
    }


def write_sampling(cases: Sequence[Path], file: Path, steps: int, halved: bool) -> None:
    """Write sampling.json.

    Args:
        cases: folders of multi-ball cases.
        steps: number of steps that each case continues.
        halved: also run each case with half of its time step.
    """
    rows = []
    for folder in cases:
        rows.append(sampled(folder, steps))
        if halved:
            rows.append(sampled(folder, steps, 0.5 * rows[-1]["step_s"]))
        for row in rows[-1 - halved :]:
            difference = row["torque"]["difference"]
            print(f"S = {row['S']:g}, {row['step_s']:g} s: {difference:.1e} M g R", flush=True)
    write_json(file, {"schema": 1, **provenance(), "command": COMMAND, "cases": rows})
