"""The machine: its cores, how cases share them, and its description in timing.json."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import psutil

from millscale.errors import CampaignError

_QUOTA = Path("/sys/fs/cgroup/cpu.max")


@dataclass(frozen=True)
class CoreWish:
    """Requested ranks and nodes of a multi-ball case, and cases at a time; None for no request."""

    ranks: int | None = None
    jobs: int | None = None
    oversubscribe: bool = False
    nodes: int | None = None


@dataclass(frozen=True)
class Allocation:
    """How the cores are shared.

    Attributes:
        ranks: MPI ranks by case id; a single ball runs on one.
        jobs: the most cases that run at a time.
        cores: the most cores in use at a time.
        notes: requests of the campaign that this machine cannot meet, and why.
        node_cores: cores of a node of a batch system; None for this machine.
        nodes: nodes requested for each case.
    """

    ranks: Mapping[str, int]
    jobs: int
    cores: int
    notes: tuple[str, ...] = ()
    node_cores: int | None = None
    nodes: int = 1

    def nodes_of(self, case_id: str) -> int:
        """Return the nodes of a case: those requested, more if its ranks do not fit, fewer if
        some would have no rank."""
        ranks = self.ranks[case_id]
        if self.node_cores is None:
            return 1
        needed = math.ceil(ranks / self.node_cores)
        return math.ceil(ranks / ranks_per_node(ranks, max(needed, min(self.nodes, ranks))))


def ranks_per_node(ranks: int, nodes: int) -> int:
    """Return the most ranks of a node; the last node may have fewer."""
    return math.ceil(ranks / nodes)


@dataclass(frozen=True)
class Spread:
    """MPI ranks on several nodes of a batch job.

    Attributes:
        per_node: as of `ranks_per_node`.
        environment: variables that state the nodes of the job to mpirun.
    """

    per_node: int
    environment: Mapping[str, str]


def available_cores() -> int:
    """Return the cores that this process may use, by CPU affinity and the container's quota."""
    cores = len(os.sched_getaffinity(0))
    try:
        quota, period = _QUOTA.read_text(encoding="utf-8").split()
        return max(1, min(cores, math.ceil(int(quota) / int(period))))
    except (OSError, ValueError):
        return cores


def physical_cores() -> int:
    """Return the cores of the machine; a second hardware thread does not count."""
    return psutil.cpu_count(logical=False) or available_cores()


def hardware() -> dict[str, str | int]:
    """Return processor model, its cores, and the cores this process may use, for timing.json."""
    return {"cpu": _cpu_model(), "cores": physical_cores(), "available_cores": available_cores()}


def _cpu_model() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return "unknown"
    entries = {key.strip(): value.strip() for key, _, value in (x.partition(":") for x in lines)}
    return entries.get("model name") or entries.get("Model") or "unknown"


def check_numbers(asked: CoreWish) -> dict[str, int | None]:
    """Return the numbers that options request, by option.

    Raises:
        CampaignError: a number is smaller than 1.
    """
    given = {"--ranks": asked.ranks, "--jobs": asked.jobs, "--nodes": asked.nodes}
    for option, value in given.items():
        if value is not None and value < 1:
            raise CampaignError("millscale run", option, f"got {value}", "a whole number >= 1")
    return given


def allowed(asked: CoreWish, cores: int, charges: bool) -> int:
    """Return the cores that options request; 1 if there is no request.

    Args:
        charges: whether there are multi-ball cases; single balls run on one rank.

    Raises:
        CampaignError: not a number of cores, or more than there are without `oversubscribe`.
    """
    given = check_numbers(asked)
    wanted = (asked.jobs or 1) * ((asked.ranks or 1) if charges else 1)
    if wanted > cores and not asked.oversubscribe:
        raise CampaignError(
            "millscale run",
            " ".join(f"{option} {value}" for option, value in given.items() if value),
            f"needs {wanted} cores, this machine offers {cores}",
            f"at most {cores} in all, or --oversubscribe, which is slower",
        )
    return wanted
