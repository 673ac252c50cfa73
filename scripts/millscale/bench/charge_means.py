"""Dimensionless means of the charge at S = 2.6 in variants of one campaign, three seeds each."""

from __future__ import annotations

import statistics
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from millscale.bench.running import finish_campaign
from millscale.bench.scenes import MILLS
from millscale.runs.untrusted import read_object
from millscale.runs.writing import write_text

SEEDS = (1, 2, 3)
QUANTITIES = ("kinetic", "kinetic_rotation", "torque", "power", "centre_x", "centre_z")
_MULTI_BALL = "[multi_ball]"
_REMEDY = "millscale bench makes it"


@dataclass(frozen=True)
class Variants:
    """Variants of mills.toml.

    Attributes:
        reference: name of the variant the others are compared with.
        edits: name of a variant to its edits, line to what stands for it.
    """

    reference: str
    edits: Mapping[str, Mapping[str, str]]


WALLS = Variants(
    "analytic",
    {
        kind: {_MULTI_BALL: f'[wall]\nkind = "{kind}"\n\n{_MULTI_BALL}'}
        for kind in ("mesh", "analytic")
    },
)
SLICES = Variants(
    "whole length",
    {
        "whole length": {},
        **{
            f"{d} diameters": {_MULTI_BALL: f"{_MULTI_BALL}\nslice_diameters = {d}"}
            for d in (6, 4, 2)
        },
    },
)


def compared(variants: Variants, runs: Path, console: Console) -> dict:
    """Return means over 4 to 8 rad of every variant against the reference, with the spread of seeds
    (largest less smallest), and the largest overlap over the ball radius.
    """
    results = {name: _results(name, edits, runs, console) for name, edits in variants.edits.items()}
    table = {}
    for quantity in QUANTITIES:
        values = {
            name: [result["dimensionless"][quantity] for result in of_seeds]
            for name, of_seeds in results.items()
        }
        base = statistics.fmean(values[variants.reference])
        table[quantity] = {
            name: {
                "of_seeds": of,
                "difference_of_means": statistics.fmean(of) - base,
                "spread_of_seeds": max(of) - min(of),
            }
            for name, of in values.items()
        }
    return {
        "reference": variants.reference,
        "means_over_rad": [4.0, 8.0],
        "quantities": table,
        "largest_overlap_over_radius": {
            name: [result["largest_overlap_over_radius"] for result in of_seeds]
            for name, of_seeds in results.items()
        },
    }


def _results(name: str, edits: Mapping[str, str], runs: Path, console: Console) -> list[dict]:
    folder = runs / f"charge-{name.replace(' ', '-')}"
    folder.mkdir(parents=True, exist_ok=True)
    campaign, content = folder / MILLS.name, edited(edits)
    if not campaign.exists() or campaign.read_text(encoding="utf-8") != content:
        write_text(campaign, content)
    finish_campaign(campaign, folder, [], console)
    cases = read_object(folder / "campaign.json", _REMEDY)["cases"]
    return [read_object(folder / "cases" / case / "result.json", _REMEDY) for case in cases]


def edited(edits: Mapping[str, str]) -> str:
    """Return mills.toml with edits, for three seeds of the S = 2.6 mill only, to 8 rad."""
    content = MILLS.read_text(encoding="utf-8")
    whole = {
        "S = [1.0, 1.696, 2.6, 4.2, 6.1]": "S = [2.6]",
        "count = [231461, 47446, 13370, 3124, 1020]": f"count = [13370]\nseeds = {list(SEEDS)}",
        "rotation_angle_rad = 2.0": "rotation_angle_rad = 8.0",
    }
    for old, new in (whole | dict(edits)).items():
        if old not in content:
            raise RuntimeError(f"{MILLS.name} has no line {old!r}")
        content = content.replace(old, new)
    return content
