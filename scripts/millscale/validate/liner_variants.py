"""The single ball with other lifters and start phases: `millscale validate liner-variants`.

The paper gives neither the face angle of the lifters nor the phase of the mill at the start. The
lifter is a trapezoid whose foot leaves the groove width between two lifters, or has parallel faces.
"""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from millscale.analysis.variants import markdown, variant_rows
from millscale.campaign.reader import campaign_tree
from millscale.campaign.writer import Tree, toml_text
from millscale.engine.machine import CoreWish
from millscale.errors import CampaignError
from millscale.runs.writing import write_text
from millscale.workflow.run_command import request, run_campaign

RATIOS = (1.0, 2.6)
# Reading of the lifter, and phase at the start in quarters of a pitch.
VARIANTS = (*(("trapezoid", quarter) for quarter in range(4)), ("parallel", 0))


def variant_campaign(base: Tree, reading: str, quarter: int) -> Tree:
    """Return a single-ball campaign with another liner, for RATIOS and the policy paper.

    Args:
        base: sections of the campaign; stays as it is.
        quarter: phase at the start, in quarters of the angle between two lifters.
    """
    liner, pitch_deg = base["liner"], 360.0 / base["liner"]["lifters"]
    return base | {
        "campaign": base.get("campaign", {}) | {"name": f"{reading}-phase-{quarter}-quarters"},
        "liner": liner | {"reading": reading, "phase_deg": quarter * pitch_deg / 4.0},
        "scaling": base["scaling"] | {"S": list(RATIOS), "policies": ["paper"]},
    }


def compare_variants(file: Path, runs: Path, console: Console) -> str:
    """Run every variant of a campaign and return their table in Markdown.

    Args:
        file: campaign of a single ball.
        runs: folder for the campaigns and, beside each, its runs folder.

    Raises:
        CampaignError: the campaign has no liner or no single ball, or a case failed.
    """
    base = campaign_tree(file)
    for section in ("liner", "scaling", "single_ball"):
        if section not in base:
            raise CampaignError(file, section, "missing", "the campaign of a single ball")
    runs.mkdir(parents=True, exist_ok=True)
    folders = []
    for reading, quarter in VARIANTS:
        campaign = runs / f"{reading}-{quarter}.toml"
        write_text(campaign, toml_text(variant_campaign(base, reading, quarter)))
        folders.append(campaign.with_suffix(""))
        if not run_campaign(request(campaign, folders[-1], [], CoreWish()), console):
            cause = "a case failed"
            raise CampaignError(campaign, "", cause, f"see millscale status {folders[-1]}")
    return markdown([row for s in RATIOS for row in variant_rows(folders, s, "paper")])
