"""Classes of balls: from `[[ball.class]]`, a table of sizes, or Bond's equilibrium charge."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

from millscale.campaign.campaign import Ball, BallClass, Material
from millscale.campaign.keys import TABLES
from millscale.campaign.reader import read_table, read_text
from millscale.errors import CampaignError

Section = Mapping[str, Any]
# Shares that do not add up to 1 within this are a slip, not rounding.
SUM_AGREEMENT = 0.01
# Exponent of the equilibrium charge of balls: the share by mass of balls smaller than x, at a
# top-up size B, is (x / B)^3.84. F. C. Bond, Grinding ball size selection, Mining Engineering 10
# (1958) 592-595, as textbooks quote it. Balls that all wear at the same rate have 4: their numbers
# are equal in equal ranges of diameter.
BOND_EXPONENT = 3.84


def with_classes(path: Path, ball: Section) -> dict[str, Any]:
    """Return the section [ball] with its classes, and their mean radius by mass as `radius_m`.

    Args:
        path: of the campaign file; a table of sizes is beside it.

    Raises:
        CampaignError: no size, two ways to state sizes, or shares that do not add up.
    """
    ways = {
        "radius_m": ball["radius_m"] is not None,
        "class": bool(ball["class"]),
        "sizes": ball["sizes"] is not None,
        "top_up_radius_m": ball["top_up_radius_m"] is not None,
    }
    given = [way for way, is_given in ways.items() if is_given]
    if len(given) != 1:
        what = "missing" if not given else "and " + ", ".join(given[1:]) + " both given"
        raise CampaignError(path, f"ball.{given[0] if given else 'radius_m'}", what,
                            "one of radius_m, [[ball.class]], sizes, top_up_radius_m")  # fmt: skip
    if ways["radius_m"]:
        return {**ball, "classes": ()}
    if ball["radius_std_m"] > 0.0:
        cause = f"got {ball['radius_std_m']:g} with {given[0]}, whose balls have sizes of their own"
        raise CampaignError(path, "ball.radius_std_m", cause, "no such key")
    if ways["top_up_radius_m"]:
        classes = equilibrium_charge(
            ball["top_up_radius_m"], ball["density_kg_m3"], ball["top_up_classes"]
        )
    else:
        entries, where = ball["class"], "ball.class"
        if ways["sizes"]:
            entries, where = _rows(path.parent / ball["sizes"]), "ball.sizes"
        classes = _classes(path, where, entries, ball["density_kg_m3"])
    mass = [one.share * one.density * one.volume for one in classes]
    radius = sum(m * one.radius for m, one in zip(mass, classes, strict=True)) / sum(mass)
    volume = sum(one.share * one.volume for one in classes)
    return {**ball, "radius_m": radius, "density_kg_m3": sum(mass) / volume, "classes": classes}


def equilibrium_charge(top_up: float, density: float, classes: int) -> tuple[BallClass, ...]:
    """Return Bond's equilibrium charge: equal ranges of radius from a quarter of the top-up size.

    Smaller balls, 0.5 % of the mass, leave the mill. Source and formula: `BOND_EXPONENT`.

    Args:
        top_up: radius of the balls that are added [m].
    """
    edges = [top_up * (0.25 + 0.75 * k / classes) for k in range(classes + 1)]
    below = [(edge / top_up) ** BOND_EXPONENT for edge in edges]
    radii = [0.5 * (a + b) for a, b in pairwise(edges)]
    shares = [b - a for a, b in pairwise(below)]
    return _by_number([BallClass(r, density, m) for r, m in zip(radii, shares, strict=True)])


def with_materials(ball: Ball, entries: Sequence[Section], material: Material, path: Path) -> Ball:
    """Return balls whose classes have their own materials where `[[ball.class]]` states them."""
    classes = []
    for number, (one, entry) in enumerate(zip(ball.classes, entries, strict=True), 1):
        own = {name: entry[name] for name in OWN if entry[name] is not None}
        if "youngs_modulus_pa" in own:
            own["youngs_modulus"] = own.pop("youngs_modulus_pa")
        if material.poisson_ratio != own.get("poisson_ratio", material.poisson_ratio) and (
            "youngs_modulus" not in own
        ):
            where = f"ball.class[{number}].youngs_modulus_pa"
            raise CampaignError(path, where, "missing beside an own poisson_ratio", "both or none")
        classes.append(replace(one, material=replace(material, **own) if own else None))
    return replace(ball, classes=tuple(classes))


COEFFICIENTS = tuple(
    f"{name}_{pair}"
    for name in ("restitution", "static_friction", "rolling_friction")
    for pair in ("pp", "pw")
)
OWN = ("youngs_modulus_pa", "poisson_ratio", *COEFFICIENTS)


def _classes(
    path: Path, where: str, entries: Sequence[Section], density: float
) -> tuple[BallClass, ...]:
    """Return the classes of entries with shares by mass or by number."""
    by_mass = [entry["mass_share"] is not None for entry in entries]
    by_count = [entry["count_share"] is not None for entry in entries]
    if not (all(by_mass) and not any(by_count)) and not (all(by_count) and not any(by_mass)):
        cause = "shares by mass and by number, or none"
        raise CampaignError(path, where, cause, "mass_share of all, or count_share of all")
    key = "mass_share" if all(by_mass) else "count_share"
    total = sum(entry[key] for entry in entries)
    if abs(total - 1.0) > SUM_AGREEMENT:
        raise CampaignError(path, where, f"{key} add up to {total:.4g}", "shares that make 1")
    classes = [
        BallClass(entry["radius_m"], entry["density_kg_m3"] or density, entry[key] / total)
        for entry in entries
    ]
    return _by_number(classes) if all(by_mass) else tuple(classes)


def _by_number(by_mass: Sequence[BallClass]) -> tuple[BallClass, ...]:
    """Return classes whose shares are by mass, with shares by number."""
    numbers = [one.share / (one.density * one.volume) for one in by_mass]
    return tuple(
        replace(one, share=n / sum(numbers)) for one, n in zip(by_mass, numbers, strict=True)
    )


def _rows(path: Path) -> tuple[dict[str, Any], ...]:
    """Return the rows of a table of sizes, checked as entries of `[[ball.class]]`."""
    rows = list(csv.DictReader(io.StringIO(read_text(path)), skipinitialspace=True))
    if not rows:
        raise CampaignError(path, "", "no rows", "a header such as diameter_mm,mass_share and rows")
    entries = []
    for number, row in enumerate(rows, 2):
        try:
            entries.append({name.strip(): float(text) for name, text in row.items()})
        except (TypeError, ValueError, AttributeError):
            cause = f"line {number} is no row of numbers: {', '.join(map(str, row.values()))[:60]}"
            raise CampaignError(path, "", cause, "a number in each column of the header") from None
    return read_table(path, "ball.class", TABLES["ball.class"], entries)
