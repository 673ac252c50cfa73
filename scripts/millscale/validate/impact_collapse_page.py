"""Page and picture of impact spectra of several S, made from impact-collapse.json."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from millscale.analysis.charge.impacts import ALIKE, DEVIATIONS, FEWEST
from millscale.formats import NONE, number
from millscale.report.figures.style import STYLE, colour_of_S

Row = dict[str, Any]
COMMAND = "millscale validate impact-collapse runs/impact-collapse"
NAMES = {
    ("ball_ball", "ball"): "ball on ball",
    ("ball_wall", "ball"): "ball on liner",
    ("ball_wall", "area"): "ball on liner, per area",
}
# Down to this share of the largest value of a spectrum.
SHOWN = 1e-5
_HEAD = """# Impact spectra of scaled mills

Which part of the impact spectrum of a scaled mill is that of the physical mill?
The mills are slices of the paper's mill (`campaigns/impact-collapse.toml`), filled alike, with
Young's modulus scaled so that overlaps are alike.

```sh
millscale run campaigns/impact-collapse.toml --runs runs/impact-collapse --ranks 1 --jobs 1
{command}
```

Generated from [impact-collapse.json](impact-collapse.json).
Commit {commit}, {machine}, {date}.

Energies of contacts are over m (omega R)^2 of their own mill, m the mass of a ball.
Over m g R they are Fr times that, and Fr is the same in all mills, so both collapse alike.
Sums are per ball and revolution ([impacts.md](../theory/impacts.md#scaled-mills)).
A scaled mill back-scaled to the physical mill has these numbers unchanged.
Balls are not scaled, so a scaled mill has S times as much liner for each ball.
Contacts with the liner are therefore also compared per area of the liner, the sums over S.

![impact-collapse](impact-collapse.png)

Lines are means over the seeds, bands their least and most.
Points of the lower row are ratios by decade, with two standard errors; dashed: per area.

## Mills

{scheme}, policy {policy}, Young's modulus {stiffness}.

| S | seeds | balls | slice / ball | Fr | m (omega R)^2 [J] | step / limit | mill angle [rad] \
| steady | largest overlap / a | error of the sum |
|---|---|---|---|---|---|---|---|---|---|---|
"""
_RULES = """
The error of the sum is that of the spectrum against the dissipation summed without regard to
contacts, relative.
A decade agrees if its ratio is within {alike:g} % and {deviations:g} standard errors of 1.
The error is that of the mean over the seeds; of one seed it is that of the count.
Dashes mark fewer than {fewest:g} contacts.
Decades below 0.1 % of the energy of every mill are left out.

## How much agrees

Share of the energy of S = {reference:.4g} in decades that agree [%], and the ratio of the sums.

| energy | contacts | {heads} |
|---|---|{rules}|
"""


def page(document: Row) -> str:
    """Return the page of impact-collapse.json."""
    kept = ("command", "commit", "machine", "date", "policy", "stiffness")
    head = {key: document[key] for key in kept}
    machine = document["machine"]
    head["machine"] = f"{machine['cpu']}, {machine['available_cores']} cores"
    scheme = document["scheme"].replace("-", " ")
    lines = [_HEAD.format(**head, scheme=scheme[:1].upper() + scheme[1:])]
    lines += [_mill_line(mill) for mill in document["mills"]]
    scaled = [mill["S"] for mill in document["mills"][1:]]
    lines.append(
        _RULES.format(
            alike=100.0 * ALIKE,
            deviations=DEVIATIONS,
            fewest=FEWEST,
            reference=document["reference_S"],
            heads=" | ".join(f"S = {S:.4g} | sum" for S in scaled),
            rules="|".join(["---"] * 2 * len(scaled)),
        )
    )
    for spectrum in document["spectra"]:
        cells = [
            f"{100.0 * share:.0f} | {_ratio(whole)}"
            for share, whole in zip(spectrum["alike_shares"], spectrum["all"], strict=True)
        ]
        lines.append(f"| {spectrum['quantity']} | {_name(spectrum)} | {' | '.join(cells)} |\n")
    for spectrum in document["spectra"]:
        lines += _decades(document, spectrum)
    return "".join(lines)


def _name(spectrum: Row) -> str:
    return NAMES[spectrum["pairing"], spectrum["per"]]


def _mill_line(mill: Row) -> str:
    first, last = mill["window_rad"]
    seeds = ", ".join(map(str, mill["seeds"]))
    return (
        f"| {mill['S']:.4g} | {seeds} | {mill['balls']:,} | {mill['slice_ball_diameters']:.3g} "
        f"| {mill['froude']:.4g} | {mill['energy_unit_J']:.4g} | {mill['step_over_limit']:.2f} "
        f"| {first:.2f} to {last:.2f} | {'yes' if mill['steady'] else 'no'} "
        f"| {number(mill['largest_overlap_over_radius'], 2)} | {mill['sum_error']:.1e} |\n"
    )


def _ratio(found: Row) -> str:
    if found["ratio"] is None:
        return NONE
    text = f"{found['ratio']:.2f} ± {found['error']:.2f}"
    return f"**{text}**" if found["alike"] else text


def _decades(document: Row, spectrum: Row) -> Iterator[str]:
    """Yield the table of one spectrum."""
    reference = document["mills"][0]
    scaled = document["mills"][1:]
    heads = " | ".join(f"S = {mill['S']:.4g}" for mill in scaled)
    yield f"\n## {spectrum['quantity'].capitalize()}, {_name(spectrum)}\n\n"
    yield (
        f"Ratio to S = {reference['S']:.4g}; bold agrees.\n"
        f"The third column is in joules of S = {reference['S']:.4g}.\n\n"
        f"| from, over m (omega R)^2 | over m g R | [J] | of its energy [%] | {heads} |\n"
    )
    yield f"|---|---|---|---|{'|'.join(['---'] * len(scaled))}|\n"
    for decade in spectrum["decades"]:
        low = decade["low"]
        cells = " | ".join(_ratio(found) for found in decade["mills"])
        yield (
            f"| {low:.0e} | {low * reference['froude']:.1e} "
            f"| {low * reference['energy_unit_J']:.1e} | {100.0 * decade['share']:.1f} "
            f"| {cells} |\n"
        )


def draw(document: Row, file: Path) -> Figure:
    """Draw spectra and their ratios by decade.

    Args:
        file: picture to write.
    """
    spectra = [x for x in document["spectra"] if x["per"] == "ball"]
    per_area = {x["quantity"]: x for x in document["spectra"] if x["per"] == "area"}
    with rc_context(STYLE):
        figure = Figure(figsize=(13.0, 6.2), layout="constrained")
        rows = figure.subplots(
            2, len(spectra), sharex=True, squeeze=False, height_ratios=(1.5, 1.0)
        )
        for upper, lower, spectrum in zip(*rows, spectra, strict=True):
            _curves(upper, spectrum)
            _ratios(lower, spectrum, "o-")
            if spectrum["pairing"] == "ball_wall":
                _ratios(lower, per_area[spectrum["quantity"]], "s--")
            lower.axhspan(1.0 - ALIKE, 1.0 + ALIKE, color="#ddd", linewidth=0.0, zorder=0)
            lower.set_ylim(0.0, 2.0)
            upper.set_title(f"{spectrum['quantity']}, {_name(spectrum)}")
            lower.set_xlabel(r"energy of a contact over $m\,(\omega R)^2$")
            froude = document["mills"][0]["froude"]
            over_weight = upper.secondary_xaxis(
                1.0,
                functions=(
                    lambda x, froude=froude: np.multiply(x, froude),
                    lambda x, froude=froude: np.divide(x, froude),
                ),
            )
            over_weight.tick_params(labelsize="x-small")
            over_weight.set_xlabel(r"over $m\,g\,R$", fontsize="x-small")
        rows[0][0].set_ylabel(r"over $m\,(\omega R)^2$, per decade, ball, revolution")
        rows[1][0].set_ylabel(f"ratio to S = {document['reference_S']:.4g}")
        rows[0][0].legend()
        figure.savefig(file, dpi=110)
    return figure


def _curves(axes: Axes, spectrum: Row) -> None:
    largest = max((max(curve["mean"], default=0.0) for curve in spectrum["curves"]), default=0.0)
    shown: list[float] = []
    for curve in spectrum["curves"]:
        colour = colour_of_S(curve["S"])
        axes.plot(curve["energy"], curve["mean"], color=colour, label=f"S = {curve['S']:.4g}")
        axes.fill_between(
            curve["energy"], curve["least"], curve["most"], color=colour, alpha=0.25, linewidth=0.0
        )
        pairs = zip(curve["energy"], curve["mean"], strict=True)
        shown += [energy for energy, value in pairs if value > SHOWN * largest]
    axes.set(xscale="log", yscale="log")
    if shown:
        axes.set_ylim(SHOWN * largest, 3.0 * largest)
        axes.set_xlim(0.5 * min(shown), 2.0 * max(shown))


def _ratios(axes: Axes, spectrum: Row, style: str) -> None:
    for k, whole in enumerate(spectrum["all"]):
        points = [
            (decade["low"] * 10.0**0.5, found["ratio"], DEVIATIONS * found["error"])
            for decade in spectrum["decades"]
            if (found := decade["mills"][k])["ratio"] is not None
        ]
        if points:
            energy, ratio, error = zip(*points, strict=True)
            axes.errorbar(
                energy, ratio, error, fmt=style, markersize=3.5, capsize=2,
                color=colour_of_S(whole["S"]),
            )  # fmt: skip
