"""Analysis of one case: the content of result.json."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from millscale.analysis.charge.energy_budget import LEDGER, read_energy_budget
from millscale.analysis.charge.impacts import SPECTRA, read_impacts
from millscale.analysis.charge.result import charge_result
from millscale.analysis.result_file import ChargeResult, SingleBallResult
from millscale.analysis.shapes.segregation import segregation_of
from millscale.analysis.single_ball.result import single_ball_result
from millscale.analysis.wear.result import read_liner_loads_result
from millscale.runs.case_file import Case, load_case
from millscale.runs.case_folder import RESULT, SCHEMA, SERIES
from millscale.runs.series import read_series
from millscale.runs.untrusted import understood
from millscale.runs.writing import write_json


def analyse_case(folder: Path) -> dict[str, Any]:
    """Analyse a case folder from its case.json and series.csv; writes nothing.

    Returns:
        The content of result.json.

    Raises:
        RunFolderError: a file is missing, cut short or not understood.
    """
    folder = Path(folder)
    case = load_case(folder)
    identity = {key: getattr(case, key) for key in ("id", "kind", "scheme", "policy", "S")}
    return {"schema": SCHEMA, **identity, **_result(folder, case).document()}


def _result(folder: Path, case: Case) -> SingleBallResult | ChargeResult:
    series = read_series(folder / SERIES, case.kind)
    with understood(folder / SERIES, "make case.json and series.csv again: millscale run"):
        if case.kind == "single-ball":
            return single_ball_result(case, series)
        result = charge_result(case, series)
        window = result.mean_from_rad, result.mean_to_rad
        result = replace(result, segregation=segregation_of(folder, case, series, *window))
    if case.deck.liner_loads == "on":
        result = replace(result, liner_loads=read_liner_loads_result(folder, case))
    if case.deck.impacts == "on":
        with understood(folder / SPECTRA, f"make {SPECTRA} again: millscale run"):
            result = replace(result, impacts=read_impacts(folder, case))
    if case.deck.ledger != "on":
        return result
    with understood(folder / LEDGER, "make ledger.csv and impacts.csv again: millscale run"):
        return replace(result, ledger=read_energy_budget(folder))


def write_result(folder: Path) -> Path:
    """Write result.json of a case folder and return its path.

    Raises:
        RunFolderError: a file is missing, cut short or not understood.
    """
    write_json(folder / RESULT, analyse_case(folder))
    return folder / RESULT
