"""Where the jobs of a run are executed: this machine, or a batch system.

To add a batch system, write a `BatchSystem` in a file of this folder and add it to TARGETS.
"""

from __future__ import annotations

from pathlib import Path

from millscale.errors import CampaignError, nearest
from millscale.workflow.targets.local import Local
from millscale.workflow.targets.slurm import Slurm
from millscale.workflow.targets.target import Target

# By the name that `millscale run --target` takes.
_TARGETS: tuple[type[Target], ...] = (Local, Slurm)
TARGETS = {target.name: target for target in _TARGETS}


def target_named(name: str, profile: Path | None = None) -> Target:
    """Return the target of a name.

    Args:
        profile: folder of a site's settings, as in profiles/slurm; None for none.

    Raises:
        CampaignError: no such target, or the profile does not fit it.
    """
    if name not in TARGETS:
        near = nearest(name, TARGETS)
        cause = f"got {name}" + (f", nearest is {near}" if near else "")
        raise CampaignError("millscale run", "--target", cause, ", ".join(TARGETS))
    return TARGETS[name](profile)


__all__ = ["TARGETS", "Local", "Slurm", "Target", "target_named"]
