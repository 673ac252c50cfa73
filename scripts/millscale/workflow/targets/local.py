"""This machine: cases share its cores."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING

from millscale.errors import CampaignError
from millscale.workflow.targets.target import Target

if TYPE_CHECKING:
    from millscale.cases.cost import Rates
    from millscale.engine.machine import Allocation, CoreWish
    from millscale.runs.case_file import Case
    from millscale.workflow.jobs import Job

# A job starts a shell and a Python, which takes one to two seconds: small cases share a job of
# about a minute. Four jobs for each case at a time keep the cores busy to the end.
SHARED_JOB_S = 60.0
JOBS_PER_PLACE = 4


class Local(Target):
    """Jobs are processes of this machine."""

    name = "local"
    about = "this machine"
    time_limit_message = ""
    memory_message = ""

    def __init__(self, profile: Path | None = None) -> None:
        if profile is not None:
            cause = "got one without a batch system"
            raise CampaignError("millscale run", "--profile", cause, "with --target NAME")

    def allocate(
        self, cases: Sequence[Case], asked: CoreWish, usual: CoreWish, rates: Rates
    ) -> Allocation:
        """Share the cores of this machine among the cases."""
        if asked.nodes not in (None, 1):
            cause = "this machine is one node"
            raise CampaignError("millscale run", f"--nodes {asked.nodes}", cause, "--target slurm")
        from millscale.workflow.placement import place

        return place(cases, asked, usual, rates)

    def shared_job_s(self, allocation: Allocation, total_s: float) -> float:
        """Return the length of a shared job [s]: shorter if few cores would have work."""
        places = max(1, min(allocation.jobs, allocation.cores))
        return min(SHARED_JOB_S, total_s / (JOBS_PER_PLACE * places))

    def snakemake_options(self, allocation: Allocation) -> list[str]:
        """Return Snakemake's options: the cores, and the cases at a time."""
        return [
            *("--cores", str(allocation.cores), "--resources", f"case={allocation.jobs}"),
            *("--latency-wait", "0", "--profile", "none"),
        ]

    def request_lines(self, jobs: Sequence[Job]) -> list[str]:
        """Return nothing: nobody is asked for cores."""
        return []

    def waiting(self) -> AbstractContextManager[None]:
        """Return a temporary folder for the run and its jobs, removed at its end."""
        from millscale.engine.temporary_folder import own_folder

        return own_folder()
