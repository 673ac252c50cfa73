"""Analysis of one case: the content of result.json."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from millscale.analysis.charge.energy_budget import LEDGER, ledger_result
from millscale.analysis.charge.result import charge_result
from millscale.analysis.single_ball.result import single_ball_result
from millscale.runs.case_folder import (
    CASE,
    RESULT,
    SCHEMA,
    SERIES,
    RunFolderError,
    load_case,
)
from millscale.runs.series import read_series
from millscale.runs.untrusted import understood
from millscale.runs.writing import write_json

_RESULT_OF = {"single-ball": single_ball_result, "multi-ball": charge_result}


def analyse_case(folder: Path) -> dict[str, Any]:
    """Analyse a case folder from its case.json and series.csv; writes nothing.

    Returns:
        The content of result.json.

    Raises:
        RunFolderError: a file is missing, cut short or not understood.
    """
    folder = Path(folder)
    case = load_case(folder)
    kind = case.get("kind")
    if kind not in _RESULT_OF:
        raise RunFolderError(
            folder / CASE,
            f"kind is {kind!r}, accepted {', '.join(_RESULT_OF)}",
            "make it again with: millscale generate FILE --runs DIR",
        )
    series = read_series(folder / SERIES, kind)
    identity = {key: case[key] for key in ("id", "kind", "scheme", "policy", "S")}
    with understood(folder / SERIES, "make case.json and series.csv again: millscale run"):
        result = {"schema": SCHEMA, **identity, **_RESULT_OF[kind](case, series)}
    if case.get("deck", {}).get("ledger") == "on":
        with understood(folder / LEDGER, "make ledger.csv and impacts.csv again: millscale run"):
            result["ledger"] = ledger_result(folder)
    return result


def write_result(folder: Path) -> Path:
    """Write result.json of a case folder and return its path.

    Raises:
        RunFolderError: a file is missing, cut short or not understood.
    """
    write_json(folder / RESULT, analyse_case(folder))
    return folder / RESULT
