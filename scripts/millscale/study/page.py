"""The page of a parameter study: report/index.html (self-contained), speed-against-error.json."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from millscale.analysis.measures import STUDIED
from millscale.report.build import INDEX, REPORT, environment
from millscale.report.images import Image, save_image
from millscale.runs.writing import write_json, write_text, writing_folder
from millscale.study import pareto
from millscale.study.figures import time_against_error
from millscale.study.pareto import SettingRow
from millscale.study.results import StudyResults, published, study_results

RESULTS = "speed-against-error.json"
TITLES = {
    pareto.WORST: "largest of all errors",
    **{name: error.about for name, error in STUDIED.items()},
}


def build_study(runs: Path, provenance: dict[str, Any]) -> StudyResults:
    """Write the page of a study from its finished cases, RUNS/report; returns its results.

    An earlier page is replaced only when the new one is complete.

    Args:
        provenance: command, commit, machine and date, for the file.

    Raises:
        RunFolderError: the folder holds no study, or no finished case of its reference.
    """
    runs = Path(runs)
    results = study_results(runs)
    with writing_folder(runs / REPORT) as part:
        write_json(part / RESULTS, published([results], provenance))
        write_text(part / INDEX, _page(results, provenance, part))
    return results


def _page(results: StudyResults, provenance: dict[str, Any], folder: Path) -> str:
    known = pareto.known_errors(results.rows)
    return (
        environment()
        .get_template("study.html.j2")
        .render(
            study=results,
            provenance=provenance,
            known=known,
            titles=TITLES,
            wanted=pareto.WANTED,
            figures=_figures(results.rows, known, folder),
            worst=pareto.WORST,
        )
    )


def _figures(rows: Sequence[SettingRow], known: Sequence[str], folder: Path) -> list[Image]:
    return [
        save_image(
            time_against_error(rows, name, TITLES[name]),
            folder / f"time-against-{name.replace('_', '-')}.png",
            TITLES[name],
        )
        for name in (pareto.WORST, *known)
    ]
