"""The report of a campaign: report/index.html (self-contained), results.json and the images."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from millscale.analysis.charge.errors import CURTAINS_OF_THE_PAPER
from millscale.analysis.charge.speed_error import model_rows
from millscale.analysis.finished_campaign import Campaign, load_campaign
from millscale.analysis.paper import numbers as paper
from millscale.analysis.single_ball import comparison
from millscale.analysis.single_ball.windows import common_windows
from millscale.formats import degrees, duration, hundredths, number, percent
from millscale.report import images as report_figures
from millscale.report.figures.comparison import comparison_images
from millscale.runs.case_folder import RunFolderError, verify_line
from millscale.runs.untrusted import understood
from millscale.runs.writing import new_folder, replace_folder, write_json, write_text

PAGE = Path(__file__).parent / "page"
REPORT, INDEX, RESULTS = "report", "index.html", "results.json"


def build_report(runs: Path) -> Path:
    """Write the report of a runs folder from its finished cases; returns its index.html.

    Cases that are not finished are named in it. An earlier report is replaced only when the new
    one is complete.

    Raises:
        RunFolderError: the folder holds no campaign, or no case is finished.
    """
    campaign = load_campaign(Path(runs))
    if not campaign.single and not campaign.charges:
        raise RunFolderError(
            Path(runs),
            f"none of its {len(campaign.missing)} cases is finished",
            f"run them with: millscale run FILE --runs {shlex.quote(str(runs))}",
        )
    part = campaign.runs / f"{REPORT}.part"
    new_folder(part)
    write_json(part / RESULTS, campaign.results())
    with understood(campaign.runs, f"find the file with: {verify_line(campaign.runs)}"):
        write_text(part / INDEX, _page(campaign, part))
    folder = campaign.runs / REPORT
    replace_folder(part, folder)
    return folder / INDEX


def _page(campaign: Campaign, folder: Path) -> str:
    environment = Environment(
        loader=FileSystemLoader(PAGE), autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    environment.filters |= {
        "number": number,
        "percent": percent,
        "duration": duration,
        "hundredths": hundredths,
        "degrees": degrees,
    }
    return environment.get_template("report.html.j2").render(
        campaign=campaign,
        cases=campaign.single + campaign.charges,
        hardware=_hardware(campaign),
        geometry=_geometry(campaign),
        angles=_angles(campaign),
        energies=_energies(campaign),
        windows=common_windows(campaign.single),
        words=report_figures.words,
        policies=report_figures.policy_figures(campaign, folder),
        ratios=report_figures.ratio_figures(campaign, folder),
        charge_overview=report_figures.charge_overview(campaign, folder),
        charges=[report_figures.charge_images(case, folder) for case in campaign.charges],
        shapes=comparison_images(campaign.comparison, folder),
        models=model_rows(campaign.comparison.rows),
        reported_charge=paper.reported_charge,
        paper_curtains=[str(number) for number in CURTAINS_OF_THE_PAPER],
        model=_model(campaign),
        of_paper=campaign.of_paper,
    )


def _hardware(campaign: Campaign) -> list[str]:
    """The machines the cases ran on, each once."""
    found = [case.timing["hardware"] for case in campaign.single + campaign.charges]
    return list(dict.fromkeys(f"{h['cpu']}, {h['available_cores']} cores" for h in found))


def _geometry(campaign: Campaign) -> list[dict[str, Any]]:
    """The mills of each scheme and policy, beside Tables 4, 6 and 7."""
    operation = {
        "constant-gravity": paper.table("table6_constant_gravity"),
        "constant-speed": paper.table("table7_constant_speed"),
    }
    liners = paper.table("table4_geometry")
    if not campaign.of_paper:
        operation, liners = {}, ()
    seen = {}
    for case in campaign.single + campaign.charges:
        document = case.case
        scheme, S = document["scheme"], document["S"]
        seen.setdefault(
            (scheme, comparison.POLICIES.index(document["policy"]), S),
            {
                "scheme": scheme,
                "policy": document["policy"],
                "S": S,
                "mill": document["mill"],
                "liner": paper.scheme_row(liners, S),
                "operation": paper.scheme_row(operation.get(scheme, ()), S),
            },
        )
    return [seen[key] for key in sorted(seen)]


def _angles(campaign: Campaign) -> list[dict[str, Any]]:
    """Rows of the detach angles by scheme and policy, with what the paper read off."""
    models = comparison.policy_models(campaign.rows, comparison.row_key)
    return [
        {
            "scheme": fit["scheme"],
            "policy": fit["policy"],
            "fit": fit,
            "reported": paper.reported_throw(fit["scheme"]) if campaign.of_paper else None,
            "rows": models[fit["scheme"], fit["policy"]],
        }
        for fit in campaign.fits
    ]


def _energies(campaign: Campaign) -> list[dict[str, Any]]:
    """Tables 8 and 9: for each scheme a line for each S, a cell for each policy."""
    models = comparison.policy_models(campaign.rows, comparison.row_key)
    tables, of_paper = [], campaign.of_paper
    for scheme in dict.fromkeys(row["scheme"] for row in campaign.rows):
        policies = [policy for of, policy in models if of == scheme]
        columns = [{row["S"]: row for row in models[scheme, policy]} for policy in policies]
        tables.append(
            {
                "scheme": scheme,
                "policies": policies,
                "reported": paper.reported_throw(scheme) if of_paper else None,
                "paper_worst": max(
                    (row.ratio / row.predicted - 1.0 for row in paper.reported_energies(scheme)),
                    key=abs,
                    default=None,
                ),
                "lines": [
                    _line(scheme, S, columns, of_paper) for S in sorted(set().union(*columns))
                ],
                "fits": [fit for fit in campaign.fits if fit["scheme"] == scheme],
            }
        )
    return tables


def _line(scheme: str, S: float, columns: list[dict[float, Any]], of_paper: bool) -> dict[str, Any]:
    """One S of a scheme: a cell for each policy's column of rows by S."""
    cells = [column.get(S) for column in columns]
    return {
        "S": S,
        "predicted": next(cell["predicted_ratio"] for cell in cells if cell),
        "paper": paper.reported_energy(scheme, S) if of_paper else None,
        "cells": cells,
    }


def _model(campaign: Campaign) -> dict[str, list[dict[str, str]]]:
    """What the cases model and leave out, each statement once."""
    statements: dict[str, dict[str, dict[str, str]]] = {"in": {}, "out": {}}
    for case in campaign.single + campaign.charges:
        for side, known in statements.items():
            for entry in case.case.get("model", {}).get(side, []):
                known.setdefault(f"{entry['what']}: {entry['reason']}", entry)
    return {side: list(known.values()) for side, known in statements.items()}
