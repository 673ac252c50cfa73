"""The charge at S = 2.6 on both walls: do torque and energy agree within the spread of seeds?"""

from __future__ import annotations

import json
import statistics
from pathlib import Path

from rich.console import Console

from mill_bench.scenes import MILLS
from mill_campaign.errors import CampaignError
from mill_campaign.machine import CoreWish
from mill_campaign.run_command import request, run_campaign

KINDS = ("mesh", "analytic")
SEEDS = (1, 2, 3)
QUANTITIES = ("kinetic", "torque", "power", "centre_x", "centre_z")


def charges_on_both_walls(runs: Path, console: Console) -> dict:
    """Dimensionless means over 4 to 8 rad, three seeds on each wall (minutes each).

    Returns:
        for each quantity the values of the seeds on both walls, the difference of their means,
        and the larger of the two spreads (largest less smallest).
    """
    results = {kind: _results(kind, runs / f"charge-{kind}", console) for kind in KINDS}
    return {
        name: _compared({k: [r["dimensionless"][name] for r in results[k]] for k in KINDS})
        for name in QUANTITIES
    }


def _compared(values: dict[str, list[float]]) -> dict:
    means = {kind: statistics.fmean(of) for kind, of in values.items()}
    return {
        **values,
        "difference_of_means": means["analytic"] - means["mesh"],
        "spread_of_seeds": max(max(of) - min(of) for of in values.values()),
    }


def _results(kind: str, folder: Path, console: Console) -> list[dict]:
    folder.mkdir(parents=True, exist_ok=True)
    campaign = folder / MILLS.name
    text = MILLS.read_text()
    for old, new in (
        ("S = [1.0, 2.6]", "S = [2.6]"),
        ("count = [231461, 13370]", f"count = [13370]\nseeds = {list(SEEDS)}"),
        ("rotation_angle_rad = 2.0", "rotation_angle_rad = 8.0"),
        ("[multi_ball]", f'[wall]\nkind = "{kind}"\n\n[multi_ball]'),
    ):
        if old not in text:
            raise RuntimeError(f"{MILLS.name} has no line {old!r}")
        text = text.replace(old, new)
    campaign.write_text(text)
    if not run_campaign(request(campaign, folder, [], CoreWish()), console):
        raise CampaignError(
            "millscale bench", "wall", "a charge failed", f"see millscale status {folder}"
        )
    cases = json.loads((folder / "campaign.json").read_text())["cases"]
    return [json.loads((folder / "cases" / case / "result.json").read_text()) for case in cases]
