"""The images of a report that show all scaled mills with a charge: Figs. 9 to 14, Table 10."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from millscale.analysis.charge.comparison import ChargeComparison
from millscale.analysis.charge.measured import Measured
from millscale.analysis.charge.speed_error import mill_rows
from millscale.analysis.finished import Charge
from millscale.analysis.forked import forked
from millscale.analysis.paper.numbers import is_papers_mill
from millscale.report.captions import charges_of, words
from millscale.report.figures import shapes as shape_figures
from millscale.report.figures import speed as speed_figures
from millscale.report.figures.snapshot_sheet import snapshot_sheet
from millscale.report.images import Image, save_image
from millscale.runs.untrusted import RunFolderError

SHEET_OF = {"constant-gravity": "Fig. 9", "constant-speed": "Fig. 10"}


@dataclass(frozen=True)
class ComparisonImages:
    """Images by what they show.

    Attributes:
        of_paper: the mill is the paper's, so captions name its figures.
        problems: what could not be drawn, and why.
    """

    of_paper: bool = True
    sheets: list[Image] = field(default_factory=list)
    contours: list[Image] = field(default_factory=list)
    curtains: list[Image] = field(default_factory=list)
    flow: list[Image] = field(default_factory=list)
    speed: list[Image] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)

    def caption(self, figure: str, text: str) -> str:
        """Return a caption that names the paper's figure where the mill is the paper's."""
        return f"{figure}: {text}" if self.of_paper else text


def comparison_images(comparison: ChargeComparison, to: Path) -> ComparisonImages:
    """Draw all scaled mills of a campaign into the folder of the report; one seed of each."""
    charges = comparison.charges
    images = ComparisonImages(all(is_papers_mill(charge.case) for charge in charges))
    first = [mill.first for mill in charges.mills]
    if not first:
        return images
    references = {row.charge: row.reference for row in comparison.rows}
    used = {x for charge, x in references.items() if x is not charge and not x.is_physical}
    for S in sorted({reference.S for reference in used}):
        images.problems.append(
            f"No physical mill among the finished cases: errors are against S = {S:.4g}."
        )
    schemes = list(by_scheme(first).items())

    def drawn(of: tuple[str, list[Charge]]) -> ComparisonImages:
        found = ComparisonImages(images.of_paper)
        _of_scheme(found, comparison.measured, *of, references, to)
        return found

    for found in forked(drawn, schemes):
        for name in ("sheets", "contours", "curtains", "problems"):
            getattr(images, name).extend(getattr(found, name))
    _flow(images, first, to)
    mills = mill_rows(comparison.rows)
    figure = speed_figures.run_times(mills, images.of_paper)
    text = "processor time of a rotation against the number of balls"
    caption = images.caption("Table 10", text)
    images.speed.append(save_image(figure, to / "table10-wall-time.png", caption))
    if any(not mill.is_reference for mill in mills):
        figure = speed_figures.speed_against_error(mills)
        caption = "errors against processor time; numbers: S; bars: standard deviation over seeds"
        images.speed.append(save_image(figure, to / "speed-against-error.png", caption))
    return images


def by_scheme(charges: Sequence[Charge]) -> dict[str, list[Charge]]:
    """Return the charges of each scheme by S. The physical mill is the same mill in all schemes: a
    scheme without it takes that of another, of each state of the liner."""
    physical = [charge for charge in charges if charge.is_physical]
    found: dict[str, list[Charge]] = {}
    for scheme in dict.fromkeys(charge.scheme for charge in charges):
        own = [charge for charge in charges if charge.scheme == scheme]
        for state in dict.fromkeys(charge.state for charge in own):
            if not any(charge.is_physical and charge.state == state for charge in own):
                own += [charge for charge in physical if charge.state == state][:1]
        found[scheme] = sorted(own, key=lambda charge: charge.S)
    return found


def _of_scheme(
    images: ComparisonImages,
    measured: Measured,
    scheme: str,
    charges: list[Charge],
    references: Mapping[Charge, Charge],
    to: Path,
) -> None:
    """Draw Figs. 9 to 12 of one scheme."""
    angles, of = sorted(measured.shapes), f"{words(scheme)}, {charges_of(charges)}"
    if not any(measured.shapes.values()):
        images.problems.append(
            f"{words(scheme)}, snapshots, contours and curtains: no case has a dump at the mill "
            "angles of the others"
        )
        return
    try:
        sheet = snapshot_sheet(charges, angles, measured.velocities)
    except RunFolderError as error:
        images.problems.append(str(error))
    else:
        text = f"{of}: snapshots, and right of them means over the steady part"
        caption = images.caption(SHEET_OF.get(scheme, "Figs. 9, 10"), text)
        images.sheets.append(save_image(sheet, to / f"fig9-{scheme}.png", caption))
    figure = shape_figures.contours(measured, charges, references.values())
    text = f"{of}: surface of the bed; similar charges coincide"
    caption = images.caption("Fig. 11", text)
    images.contours.append(save_image(figure, to / f"fig11-{scheme}.png", caption))
    if difference := shape_figures.contour_differences(measured, charges, references):
        caption = (
            f"{of}: distance of each surface from that of the reference along its normal, positive "
            "towards the air; 0 for similar charges"
        )
        path = to / f"contour-differences-{scheme}.png"
        images.contours.append(save_image(difference, path, caption))
    last = measured.shapes[measured.last_angle]
    known = [c for c in charges if c in last]
    if figure := shape_figures.curtain_profiles(measured, known, references.values()):
        text = f"{of}, at {measured.last_angle:.4g} rad: the smallest regions that hold 90 % of "
        text += "the balls that a lifter threw; similar charges coincide"
        caption = images.caption("Fig. 12", text)
        images.curtains.append(save_image(figure, to / f"fig12-{scheme}.png", caption))
    else:
        images.problems.extend(sorted({f"curtains, {c.id}: {last[c].problem}" for c in known}))


def _flow(images: ComparisonImages, charges: list[Charge], to: Path) -> None:
    """Draw Figs. 13 and 14."""
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
    text = f"liner and monitoring box at rest, {known[0].label}"
    caption = images.caption("Fig. 13", text)
    images.flow.append(save_image(box, to / "fig13-box.png", caption))
    for scheme, own in by_scheme(known).items():
        figure = shape_figures.mass_flow(own)
        of = f"{words(scheme)}, {charges_of(own)}"
        text = f"{of}: mass in the box over the mass of the charge; similar charges coincide"
        caption = images.caption("Fig. 14", text)
        images.flow.append(save_image(figure, to / f"fig14-{scheme}.png", caption))
        folded = shape_figures.mass_flow_over_pitch(own)
        if folded:
            caption = f"{of}: mean over the steady lifter pitches, the box at rest"
            if len(own) > 1:
                caption += "; below, the difference from the first"
            images.flow.append(save_image(folded, to / f"mass-over-pitch-{scheme}.png", caption))
