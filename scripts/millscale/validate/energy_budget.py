"""`python -m millscale.validate.energy_budget CASE_FOLDER [--to FILE]`: whether the energy adds up.

The folder is that of a multi-ball case that is settled. Its mill turns with an account of the
energy, once as campaigns run it and once with contacts as stock LIGGGHTS has them; written are the
terms of the last revolution and their closure.
"""

from __future__ import annotations

import argparse
import shutil
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from millscale.analysis.charge.energy_budget import account, impact_spectrum, read_ledger
from millscale.cases.decks import copy_decks
from millscale.cases.parameters import write_parameters
from millscale.engine.deck_run import engine_text, find_engine
from millscale.engine.record import provenance
from millscale.report.figures.energy_budget import energy_account
from millscale.runs.series import read_series
from millscale.runs.untrusted import read_object
from millscale.runs.writing import write_json, write_text

DECK, BED, PAIR = "mill.in", "settled.restart", "pair_gran.in"


@dataclass(frozen=True)
class Contacts:
    """Who evaluates contacts how: tangential damping, more words of the pair style, step [s]."""

    damping: str
    words: str
    step: float


# Steps: that of campaigns at S = 2.6, and the longest that plain damping takes there
# (docs/results/time-step.md).
PATHS = {
    "default": Contacts("bounded", "", 2e-4),
    "stock-compatible": Contacts("on", "memory stock", 1e-4),
}


def turned(case_folder: Path, folder: Path, path: Contacts, angle: float | None) -> dict[str, Any]:
    """Turn the settled mill of a case on one path; the account of its last revolution.

    Args:
        angle: of the rotation [rad]; None: that of the case.
    """
    case = read_object(case_folder / "case.json", "millscale generate")
    copy_decks((DECK,), folder)
    write_parameters(with_ledger(case, path, angle), folder)
    shutil.copyfile(case_folder / BED, folder / BED)
    pair = (folder / PAIR).read_text(encoding="utf-8")
    damping = "tangential_damping ${tangential_damping}"
    write_text(folder / PAIR, pair.replace(damping, f"{damping} {path.words}"))
    _, cause = engine_text([str(find_engine()), "-in", DECK], folder)
    if cause:
        raise RuntimeError(f"the engine did not come to the end of {DECK}: {cause}")
    return {
        "tangential_damping": path.damping,
        "step_s": path.step,
        "balls": case["ball"]["count"],
        **accounted(folder),
    }


def accounted(folder: Path) -> dict[str, Any]:
    """What the mill left in its folder: the account, its work by series.csv, its impacts."""
    found = account(read_ledger(folder))
    return {
        **found,
        "series_work_J": series_work(folder, found["from_rad"], found["to_rad"]),
        "impacts": impact_spectrum(folder / "impacts.csv"),
    }


def with_ledger(case: Mapping[str, Any], path: Contacts, angle: float | None) -> dict[str, Any]:
    """A case.json with the account in its decks, on a path, without dumps and restart files."""
    time, output = dict(case["time"]), dict(case["output"])
    longer = path.step / time["step_s"]
    angle = angle or time["rotation_angle_rad"]
    steps = time["rotation_steps"] / longer * angle / time["rotation_angle_rad"]
    time |= {"step_s": path.step, "rotation_steps": round(steps)}
    for name in ("sample_steps", "thermo_steps"):
        output[name] = max(1, round(output[name] / longer))
    output["restart_steps"] = time["rotation_steps"] + 1
    deck = case["deck"] | {
        "ledger": "on",
        "dumps": "off",
        "surface": "fast",
        "tangential_damping": path.damping,
    }
    return dict(case) | {"time": time, "output": output, "deck": deck}


def series_work(folder: Path, begin: float, end: float) -> float:
    """Work of the drive [J] between two mill angles [rad] by series.csv, summed apart from the
    energy budget."""
    series = read_series(folder / "series.csv", "multi-ball")
    angle = series["mill_angle_rad"]
    work = np.interp([begin, end], angle, series["drive_work_J"])
    return float(work[1] - work[0])


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("case", type=Path, help="folder of a settled multi-ball case")
    arguments.add_argument("--to", type=Path, default=Path("docs/results/ledger.json"))
    arguments.add_argument("--angle", type=float, help="rotation [rad]; default: the case's")
    arguments.add_argument("--only", choices=PATHS, help="one path; keeps the other's results")
    given = arguments.parse_args()
    paths = [given.only] if given.only else list(PATHS)
    kept = read_object(given.to, "remove it")["paths"] if given.only and given.to.exists() else {}
    case = read_object(given.case / "case.json", "millscale generate")
    for name in paths:
        with tempfile.TemporaryDirectory(prefix="ledger-") as folder:
            kept[name] = turned(given.case, Path(folder), PATHS[name], given.angle)
        print(f"{name}: closure {kept[name]['closure']:.3g}", flush=True)
        write(given.to, case, kept)


def write(file: Path, case: Mapping[str, Any], paths: Mapping[str, Any]) -> None:
    """The results so far: a path takes minutes, and the next may fail."""
    record = provenance() | {"command": "python -m millscale.validate.energy_budget CASE_FOLDER"}
    document = {"schema": 1, "case": case["id"], "S": case["S"], "paths": paths}
    file.parent.mkdir(parents=True, exist_ok=True)
    write_json(file, document | {"provenance": record})
    if "default" in paths:
        energy_account(paths["default"]).savefig(file.with_suffix(".png"), dpi=130)


if __name__ == "__main__":
    main()
