"""Dimensionless means of the charge at S = 2.6 in variants of one campaign, three seeds each."""

from __future__ import annotations

import json
import statistics
from collections.abc import Mapping
from pathlib import Path

from rich.console import Console

from mill_bench.running import finish_campaign
from mill_bench.scenes import MILLS

SEEDS = (1, 2, 3)
QUANTITIES = ("kinetic", "torque", "power", "centre_x", "centre_z")
WALLS = {kind: f'[wall]\nkind = "{kind}"\n\n[multi_ball]' for kind in ("mesh", "analytic")}
SLICES = {
    "whole length": "[multi_ball]",
    **{f"{d} diameters": f"[multi_ball]\nslice_diameters = {d}" for d in (6, 4, 2)},
}


def compared(variants: Mapping[str, str], runs: Path, console: Console) -> dict:
    """Means over 4 to 8 rad of every variant against the last one named "whole length" or
    "analytic", with the spread of the seeds (largest less smallest).

    Args:
        variants: name to what stands for the line `[multi_ball]` of mills.toml.
    """
    results = {name: _results(name, text, runs, console) for name, text in variants.items()}
    reference = "analytic" if "analytic" in variants else "whole length"
    table = {}
    for quantity in QUANTITIES:
        values = {
            name: [result["dimensionless"][quantity] for result in of_seeds]
            for name, of_seeds in results.items()
        }
        base = statistics.fmean(values[reference])
        table[quantity] = {
            name: {
                "of_seeds": of,
                "difference_of_means": statistics.fmean(of) - base,
                "spread_of_seeds": max(of) - min(of),
            }
            for name, of in values.items()
        }
    return {"reference": reference, "means_over_rad": [4.0, 8.0], "quantities": table}


def _results(name: str, text: str, runs: Path, console: Console) -> list[dict]:
    folder = runs / f"charge-{name.replace(' ', '-')}"
    folder.mkdir(parents=True, exist_ok=True)
    campaign = folder / MILLS.name
    content = MILLS.read_text()
    for old, new in (
        ("S = [1.0, 2.6]", "S = [2.6]"),
        ("count = [231461, 13370]", f"count = [13370]\nseeds = {list(SEEDS)}"),
        ("rotation_angle_rad = 2.0", "rotation_angle_rad = 8.0"),
        ("[multi_ball]", text),
    ):
        if old not in content:
            raise RuntimeError(f"{MILLS.name} has no line {old!r}")
        content = content.replace(old, new)
    if not campaign.exists() or campaign.read_text() != content:
        campaign.write_text(content)
    finish_campaign(campaign, folder, [], console)
    cases = json.loads((folder / "campaign.json").read_text())["cases"]
    return [json.loads((folder / "cases" / case / "result.json").read_text()) for case in cases]
