"""Where the jobs of a run are executed: this machine, or a batch system.

To add a batch system, write a `BatchSystem` in a file of this folder and add it to TARGETS.
"""

from __future__ import annotations

import os
from pathlib import Path

from millscale.engine.machine import Spread
from millscale.errors import CampaignError, nearest
from millscale.workflow.targets.batch_system import BatchSystem
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


def spread_of(ranks: int, nodes: int) -> Spread | None:
    """Return the ranks on the nodes of the batch job of this process; None for one node.

    Raises:
        CampaignError: several nodes, and this process is of no batch job.
    """
    if nodes == 1:
        return None
    for target in _TARGETS:
        if issubclass(target, BatchSystem) and target.job_variable in os.environ:
            return target().spread(ranks, nodes)
    raise CampaignError("millscale run", "", f"{nodes} nodes outside a batch job", "one node")


__all__ = ["TARGETS", "Local", "Slurm", "Target", "spread_of", "target_named"]
