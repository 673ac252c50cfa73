"""The images of a report that hold all multi-ball models: Figs. 9 to 14, Table 10."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from millscale.analysis.charge.comparison import ChargeComparison
from millscale.analysis.charge.scaled_mills import Charge, seeds_of
from millscale.analysis.charge.speed_error import model_rows
from millscale.analysis.paper.numbers import is_papers_mill
from millscale.report.figures import shapes as shape_figures
from millscale.report.figures import speed as speed_figures
from millscale.report.figures.snapshot_sheet import snapshot_sheet
from millscale.report.images import Image, save_image, words
from millscale.runs.case_folder import RunFolderError, is_physical

SHEET_OF = {"constant-gravity": "Fig. 9", "constant-speed": "Fig. 10"}


@dataclass(frozen=True)
class ComparisonImages:
    """Images by what they show; `problems` says what could not be drawn, and why.

    Attributes:
        of_paper: the mill is the paper's, so its figures are named.
    """

    of_paper: bool = True
    sheets: list[Image] = field(default_factory=list)
    contours: list[Image] = field(default_factory=list)
    curtains: list[Image] = field(default_factory=list)
    flow: list[Image] = field(default_factory=list)
    speed: list[Image] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)

    def caption(self, figure: str, text: str) -> str:
        """A caption that names the paper's figure where the mill is the paper's."""
        return f"{figure}: {text}" if self.of_paper else text


def comparison_images(comparison: ChargeComparison, to: Path) -> ComparisonImages:
    """Draw all models of a campaign into the report's folder; one seed of each."""
    images = ComparisonImages(all(is_papers_mill(c.case) for c in comparison.charges))
    first = [c for c in comparison.charges if seeds_of(c, comparison.charges)[0] is c]
    if not first:
        return images
    largest = {row["reference_S"] for row in comparison.rows if not is_physical(row["reference_S"])}
    for S in sorted(largest):
        images.problems.append(
            f"No physical mill among the finished cases: errors are against S = {S:.4g}."
        )
    for scheme, charges in by_scheme(first).items():
        _of_scheme(images, comparison, scheme, charges, to)
    _flow(images, first, to)
    rows = model_rows(comparison.rows)
    figure = speed_figures.run_times(rows, images.of_paper)
    caption = images.caption("Table 10", "time of a rotation")
    images.speed.append(save_image(figure, to / "table10-wall-time.png", caption))
    if any(not row["is_reference"] for row in rows):
        figure = speed_figures.speed_against_error(rows)
        caption = "speed against error; numbers: S; bars: standard deviation over seeds"
        images.speed.append(save_image(figure, to / "speed-against-error.png", caption))
    return images


def by_scheme(charges: Sequence[Charge]) -> dict[str, list[Charge]]:
    """The charges of each scheme by S. The physical mill is the same mill in all schemes: where one
    has none of its own, another's stands for it."""
    physical = [charge for charge in charges if is_physical(charge.S)]
    found: dict[str, list[Charge]] = {}
    for scheme in dict.fromkeys(charge.case["scheme"] for charge in charges):
        own = [charge for charge in charges if charge.case["scheme"] == scheme]
        if not any(is_physical(charge.S) for charge in own):
            own += physical[:1]
        found[scheme] = sorted(own, key=lambda charge: charge.S)
    return found


def _of_scheme(
    images: ComparisonImages,
    comparison: ChargeComparison,
    scheme: str,
    charges: list[Charge],
    to: Path,
) -> None:
    """Figs. 9 to 12 of one scheme."""
    angles = sorted(comparison.shapes)
    if not any(comparison.shapes.values()):
        images.problems.append(
            f"{words(scheme)}, snapshots, contours and curtains: no case has a dump at the mill "
            "angles of the others"
        )
        return
    try:
        sheet = snapshot_sheet(charges, angles)
    except RunFolderError as error:
        images.problems.append(str(error))
    else:
        caption = images.caption(SHEET_OF.get(scheme, "Figs. 9, 10"), words(scheme))
        images.sheets.append(save_image(sheet, to / f"fig9-{scheme}.png", caption))
    figure = shape_figures.contours(comparison, charges)
    caption = images.caption("Fig. 11", words(scheme))
    images.contours.append(save_image(figure, to / f"fig11-{scheme}.png", caption))
    last = comparison.shapes[comparison.last_angle]
    known = [c for c in charges if c.key in last]
    if any(last[c.key].curtains for c in known):
        figure = shape_figures.curtain_profiles(comparison, known)
        text = f"{words(scheme)}, {comparison.last_angle:.4g} rad"
        caption = images.caption("Fig. 12", text)
        images.curtains.append(save_image(figure, to / f"fig12-{scheme}.png", caption))
    else:
        images.problems.extend(sorted({f"curtains, {c.id}: {last[c.key].problem}" for c in known}))


def _flow(images: ComparisonImages, charges: list[Charge], to: Path) -> None:
    """Figs. 13 and 14."""
    known = [charge for charge in charges if shape_figures.has_flow(charge)]
    for charge in charges:
        if charge not in known:
            images.problems.append(
                f"mass flow, {charge.id}: series.csv has no mass in the monitoring box; run the "
                "case again to measure it"
            )
    if not known:
        return
    box = shape_figures.monitoring_box(known[0])
    caption = images.caption("Fig. 13", "the box at rest")
    images.flow.append(save_image(box, to / "fig13-box.png", caption))
    for scheme, own in by_scheme(known).items():
        figure = shape_figures.mass_flow(own)
        caption = images.caption("Fig. 14", words(scheme))
        images.flow.append(save_image(figure, to / f"fig14-{scheme}.png", caption))
