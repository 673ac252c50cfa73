"""Files of a calibration: calibration.json, the calibrated campaign, report/index.html."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from millscale.calibration.figures import density_figure, profile_figure, rounds_figure
from millscale.calibration.inference import MISSED
from millscale.calibration.result import RESULT, Result
from millscale.calibration.table import campaign_name, target_cells
from millscale.report.build import INDEX, REPORT, environment
from millscale.report.images import Image, save_image
from millscale.runs.writing import write_json, write_text, writing_folder


def write_result(runs: Path, result: Result, provenance: dict[str, Any]) -> None:
    """Write the files of a calibration. An earlier page is replaced only when the new one is
    complete.

    Args:
        provenance: command, commit, machine and date.
    """
    write_json(runs / RESULT, provenance | result.document())
    for name, text in result.campaigns.items():
        write_text(runs / campaign_name(name), text)
    with writing_folder(runs / REPORT) as part:
        page = environment().get_template("calibration.html.j2")
        content = page.render(
            result=result,
            found=result.inference,
            rows=[(row, target_cells(row)) for row in result.rows()],
            warnings=list(result.warnings()),
            campaigns=list(result.campaigns.values()),
            missed=MISSED,
            figures=_figures(result, part),
            provenance=provenance,
        )
        write_text(part / INDEX, content)


def _figures(result: Result, folder: Path) -> list[Image]:
    images = [
        save_image(
            density_figure(result),
            folder / "parameters.png",
            "Density of the parameters over their ranges. Rings: samples. Orange: best values.",
        ),
        save_image(
            rounds_figure(result),
            folder / "rounds.png",
            "Best values and intervals after each round.",
        ),
    ]
    for number, target in enumerate(result.calibration.targets, 1):
        if target.abscissa is not None:
            caption = f"{target.name}: measured, calibrated, and all samples in grey."
            path = folder / f"profile-{number}.png"
            images.append(save_image(profile_figure(result, target), path, caption))
    return images
