"""The page of a study: report/index.html (self-contained), speed-against-error.json, images."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from millscale.formats import duration, hundredths, number
from millscale.report.build import INDEX, PAGE, REPORT
from millscale.report.images import Image, save_image
from millscale.runs.writing import new_folder, replace_folder, write_json, write_text
from millscale.study import pareto
from millscale.study.errors import ERRORS
from millscale.study.figures import time_against_error
from millscale.study.results import published, study_results

RESULTS = "speed-against-error.json"
TITLES = {pareto.WORST: "largest of all errors", **ERRORS}


def build_study(runs: Path, provenance: dict[str, Any]) -> dict[str, Any]:
    """Write the page of a study from its finished cases, RUNS/report; returns its results.

    An earlier page is replaced only when the new one is complete.

    Args:
        provenance: command, commit, machine and date, for the file.

    Raises:
        RunFolderError: the folder holds no study, or no finished case of its reference.
    """
    runs = Path(runs)
    results = study_results(runs)
    part = runs / f"{REPORT}.part"
    new_folder(part)
    write_json(part / RESULTS, published([results], provenance))
    write_text(part / INDEX, _page(results, provenance, part))
    folder = runs / REPORT
    replace_folder(part, folder)
    return results


def _page(results: dict[str, Any], provenance: dict[str, Any], folder: Path) -> str:
    environment = Environment(
        loader=FileSystemLoader(PAGE), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    environment.filters |= {"number": number, "duration": duration, "hundredths": hundredths}
    known = pareto.known_errors(results["rows"])
    return environment.get_template("study.html.j2").render(
        study=results,
        provenance=provenance,
        known=known,
        titles=TITLES,
        wanted=pareto.WANTED,
        figures=_figures(results["rows"], known, folder),
        worst=pareto.WORST,
    )


def _figures(rows: list[dict[str, Any]], known: list[str], folder: Path) -> list[Image]:
    return [
        save_image(
            time_against_error(rows, name, TITLES[name]),
            folder / f"time-against-{name.replace('_', '-')}.png",
            TITLES[name],
        )
        for name in (pareto.WORST, *known)
    ]
