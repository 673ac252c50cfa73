"""The section "Breakage" of a report: an ore in the impacts of the charges.

`millscale breakage` keeps the ore file in the runs folder, where each later report finds it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from millscale.analysis.charge.impacts import NAMES
from millscale.analysis.finished import Charge
from millscale.analysis.ore.breakage import (
    MINUTE,
    POST_PROCESSING,
    Breakage,
    MillBreakage,
    breakage_of,
)
from millscale.analysis.ore.file import OreFile, load_ore
from millscale.engine.record import provenance
from millscale.formats import NONE, number
from millscale.report.figures.breakage import breakage_figure
from millscale.report.images import Image, save_image
from millscale.runs.writing import write_json, write_text, writing_folder

FOLDER, ORE, RESULT = "breakage", "ore.toml", "breakage.json"
_KILO = 1e-3
# Decades of less than this share of the power of the largest are left out.
LEAST_SHOWN = 1e-4
_CAPTION = "Power of the impacts of the physical mill by their energy, and breakage by size."

Cells = tuple[str, ...]


@dataclass(frozen=True)
class BreakageTable:
    """A table: title, heads of its columns, rows of text. The first column holds names."""

    title: str
    heads: Cells
    rows: list[Cells]


@dataclass(frozen=True)
class BreakageSection:
    """What the section shows."""

    found: Breakage
    tables: list[BreakageTable]
    image: Image

    about = POST_PROCESSING

    @property
    def fit_line(self) -> str:
        return fit_line(self.found)


def write_breakage(runs: Path, charges: Sequence[Charge], ore: OreFile) -> Breakage:
    """Write the folder `breakage` of a runs folder: ore, numbers, figure.

    Raises:
        RunFolderError: no charge recorded its impacts.
    """
    found = breakage_of(charges, ore, runs)
    with writing_folder(runs / FOLDER) as part:
        write_text(part / ORE, ore.text)
        write_json(part / RESULT, {"schema": 1, **provenance(), **found.document()})
        save_image(breakage_figure(found), part / "breakage.png", _CAPTION)
    return found


def breakage_section(runs: Path, charges: Sequence[Charge], to: Path) -> BreakageSection | None:
    """Return the section of a runs folder that keeps an ore file and has spectra; else None.

    Raises:
        CampaignError: the ore file is not accepted.
    """
    path = runs / FOLDER / ORE
    if not path.is_file() or all(charge.result.impacts is None for charge in charges):
        return None
    found = breakage_of(charges, load_ore(path), runs)
    image = save_image(breakage_figure(found), to / "breakage.png", _CAPTION)
    return BreakageSection(found, breakage_tables(found), image)


def breakage_tables(found: Breakage) -> list[BreakageTable]:
    """Return the tables of the command and of the report."""
    several = len(found.mills) > 1
    tables = [_mills(found), _sizes(found, found.mills[0])]
    if several and found.ore.tavares is not None:
        tables.append(_rates(found))
    tables.append(_decades(found, found.mills[0]))
    return tables


def fit_line(found: Breakage) -> str:
    """Return Austin's function nearest to the rates of the first mill; empty without."""
    fit = found.mills[0].fit
    if fit is None:
        return ""
    of = fit.selection
    return (
        f"Austin's function nearest to the rates of {_name(found.mills[0])}: a = {of.rate:.3g} "
        f"1/min, alpha = {of.exponent:.3g}, mu = {1e3 * of.size:.3g} mm, Lambda = {of.fall:.3g}; "
        f"rms of the logarithm {fit.error:.2g}"
    )


def _name(mill: MillBreakage) -> str:
    return f"S = {mill.S:.4g}, {mill.scheme.replace('-', ' ')}, {mill.policy}"


def _mills(found: Breakage) -> BreakageTable:
    energy = found.ore.energy
    other = "dissipated" if energy == "available" else "available"
    heads = (
        "by the scaled mill",
        "seeds",
        "energy of an impact, physical / scaled",
        "impacts [1/s]",
        *(f"{energy}, {name} [kW]" for name in NAMES.values()),
        f"{other}, all [kW]",
        "drive [kW]",
        "the ore takes [kW/t]",
    )
    rows = [
        (
            _name(mill),
            str(mill.seeds),
            number(mill.energy_factor),
            f"{mill.impacts:,.0f}",
            *(number(_KILO * mill.power[pairing], 2) for pairing in NAMES),
            number(_KILO * mill.other_power, 2),
            number(_KILO * mill.drive_power, 2),
            # W/kg is kW/t.
            number(mill.specific_power, 2),
        )
        for mill in found.mills
    ]
    return BreakageTable("Impacts of the physical mill", heads, rows)


def _sizes(found: Breakage, mill: MillBreakage) -> BreakageTable:
    ore = found.ore
    heads = ["size [mm]", "energy of an impact over the mass of a particle [kWh/t]"]
    if ore.drop_weight is not None:
        heads += ["t10, JK [%]", "energy in the range of the test [%]"]
    if ore.tavares is not None:
        heads += [
            "energy in impacts that break [%]",
            "t10 of the broken, Tavares [%]",
            "selection function [1/min]",
            "broken in 1 min, with damage [%]",
        ]
        heads += ["Austin's of the batch test [1/min]"] if ore.austin is not None else []
    rows = []
    for row in mill.sizes:
        cells = [f"{1e3 * row.size:.4g}", number(row.specific_energy)]
        if ore.drop_weight is not None:
            cells += [number(row.t10, 1), _percent(row.tested_share)]
        if ore.tavares is not None:
            spread = f" ± {number(MINUTE * row.rate_deviation)}" if row.rate_deviation else ""
            cells += [
                _percent(row.breaking_share),
                number(row.fragments_t10, 1),
                number(_per_minute(row.rate)) + spread,
                _percent(row.broken_share),
            ]
            cells += [number(_per_minute(row.austin))] if ore.austin is not None else []
        rows.append(tuple(cells))
    return BreakageTable(f"Particles of one size, by {_name(mill)}", tuple(heads), rows)


def _percent(share: float | None) -> str:
    return NONE if share is None else f"{100.0 * share:.1f}"


def _per_minute(rate: float | None) -> float | None:
    return None if rate is None else MINUTE * rate


def _rates(found: Breakage) -> BreakageTable:
    first, *others = found.mills
    heads = ("size [mm]", *(f"over that of {_name(first)}: {_name(x)}" for x in others))
    rows = []
    for k, row in enumerate(first.sizes):
        rates = [mill.sizes[k].rate for mill in others]
        ratios = [x / row.rate if x is not None and row.rate else None for x in rates]
        rows.append((f"{1e3 * row.size:.4g}", *(number(x) for x in ratios)))
    return BreakageTable("Selection function by the other scaled mills", heads, rows)


def _decades(found: Breakage, mill: MillBreakage) -> BreakageTable:
    sizes = found.ore.sizes if found.ore.tavares is not None else ()
    heads = (
        "energy of an impact from [J]",
        "impacts [1/s]",
        *(f"{found.ore.energy}, {_name(x)} [kW]" for x in found.mills),
        *(f"of the rate of {1e3 * size:.4g} mm [%]" for size in sizes),
    )
    power = [{row.low: row.power for row in x.decades} for x in found.mills]
    whole = max((row.power for row in mill.decades), default=0.0)
    rows = [
        (
            f"{row.low:.0e}",
            f"{row.impacts:,.4g}",
            *(number(_KILO * x.get(row.low, 0.0)) for x in power),
            *(_percent(share) for share in row.rate_shares),
        )
        for row in mill.decades
        if row.power >= LEAST_SHOWN * whole
    ]
    return BreakageTable("Impacts by decade of energy", heads, rows)
