"""Closure of the energy budget of a mill: `millscale validate energy`.

A settled multi-ball case rotates with the energy budget on, once with the contact settings of
campaigns and once with those of stock LIGGGHTS. The results are the terms of the last revolution
and their residual.
"""

from __future__ import annotations

import re
import shutil
import tempfile
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from msgspec.structs import replace

from millscale.analysis.charge.energy_budget import read_energy_budget
from millscale.analysis.result_file import EnergyBudget
from millscale.campaign.contacts import ContactOptions
from millscale.cases.decks import copy_decks
from millscale.cases.parameters import write_parameters
from millscale.engine.deck_run import engine_text, find_engine
from millscale.engine.record import provenance
from millscale.errors import CampaignError, EngineError
from millscale.report.figures.energy_budget import energy_budget_figure
from millscale.runs.case_file import Case, load_case
from millscale.runs.series import read_series
from millscale.runs.typed import as_typed
from millscale.runs.untrusted import read_object
from millscale.runs.writing import write_json, write_text

COMMAND = "millscale validate energy CASE"
DECK, BED, PAIR = "mill.in", "settled.restart", "contacts_fast.in"


@dataclass(frozen=True)
class Contacts:
    """Options of the contacts between balls, and the time step [s]."""

    balls: ContactOptions
    step: float


# Steps: that of campaigns at S = 2.6, and the longest that plain damping takes there
# (docs/results/time-step.md).
CONTACTS = {
    "default": Contacts(ContactOptions(), 2e-4),
    "stock-compatible": Contacts(ContactOptions(damping="plain", stock_history=True), 1e-4),
}


def turned(
    case_folder: Path, folder: Path, contacts: Contacts, angle: float | None
) -> dict[str, Any]:
    """Rotate the settled mill of a case; return the energy budget of its last revolution.

    Args:
        angle: of the rotation [rad]; None: that of the case.
    """
    case = load_case(case_folder)
    copy_decks((DECK,), folder)
    write_parameters(with_energy_budget(case, contacts, angle), folder)
    shutil.copyfile(case_folder / BED, folder / BED)
    _set_pair_style(folder / PAIR, contacts.balls)
    _, cause = engine_text([str(find_engine()), "-in", DECK], folder)
    if cause:
        raise EngineError(f"{DECK} did not finish: {cause}")
    return {
        "tangential_damping": contacts.balls.tangential_damping,
        "step_s": contacts.step,
        "balls": case.ball.count,
        **accounted(folder),
    }


def _set_pair_style(deck: Path, contacts: ContactOptions) -> None:
    """Give the pair style of a deck the words of these options, instead of its variables."""
    text = deck.read_text(encoding="utf-8")
    words, count = re.subn(r"surface fast .*", contacts.pair_style_words(), text)
    if count != 1:
        raise ValueError(f"{deck}: {count} lines with `surface fast`, accepted: 1")
    write_text(deck, words)


def accounted(folder: Path) -> dict[str, Any]:
    """Return the energy budget of a folder, with the work of the mill by series.csv."""
    budget = read_energy_budget(folder)
    return {
        **asdict(budget),
        "series_work_J": series_work(folder, budget.from_rad, budget.to_rad),
    }


def with_energy_budget(case: Case, contacts: Contacts, angle: float | None) -> Case:
    """Return a case with the energy budget on, other contacts, and no dumps or restart files."""
    longer = contacts.step / case.time.step_s
    whole = case.time.rotation_angle_rad
    steps = round(case.time.rotation_steps / longer * (angle or whole) / whole)
    return replace(
        case,
        time=replace(case.time, step_s=contacts.step, rotation_steps=steps),
        output=replace(
            case.output,
            sample_steps=max(1, round(case.output.sample_steps / longer)),
            thermo_steps=max(1, round(case.output.thermo_steps / longer)),
            restart_steps=steps + 1,
        ),
        deck=replace(
            case.deck,
            ledger="on",
            dumps="off",
            surface="fast",
            tangential_damping=contacts.balls.tangential_damping,
        ),
    )


def series_work(folder: Path, begin: float, end: float) -> float:
    """Work of the drive [J] between two mill angles [rad] by series.csv, summed apart from the
    energy budget."""
    series = read_series(folder / "series.csv", "multi-ball")
    angle = series["mill_angle_rad"]
    work = np.interp([begin, end], angle, series["drive_work_J"])
    return float(work[1] - work[0])


def write_energy_budget(case_folder: Path, file: Path, angle: float | None, only: str) -> None:
    """Write ledger.json and its figure after each contact setting, which takes minutes.

    Args:
        case_folder: a settled multi-ball case.
        angle: rotation [rad]; None for that of the case.
        only: a key of CONTACTS, whose results replace those in the file; empty for all.

    Raises:
        CampaignError: `only` is not a key of CONTACTS.
    """
    if only and only not in CONTACTS:
        accepted = ", ".join(CONTACTS)
        raise CampaignError("millscale validate energy", "--only", f"got {only}", accepted)
    kept = read_object(file, "remove it")["paths"] if only and file.exists() else {}
    case = load_case(case_folder)
    for name in [only] if only else CONTACTS:
        with tempfile.TemporaryDirectory(prefix="energy-") as folder:
            kept[name] = turned(case_folder, Path(folder), CONTACTS[name], angle)
        print(f"{name}: closure {kept[name]['closure']:.3g}", flush=True)
        _write(file, case, kept)


def _write(file: Path, case: Case, paths: Mapping[str, Any]) -> None:
    record = provenance() | {"command": COMMAND}
    document = {"schema": 1, "case": case.id, "S": case.S, "paths": paths}
    file.parent.mkdir(parents=True, exist_ok=True)
    write_json(file, document | {"provenance": record})
    if "default" in paths:
        energy_budget_figure(as_typed(EnergyBudget, paths["default"])).savefig(
            file.with_suffix(".png"), dpi=130
        )
