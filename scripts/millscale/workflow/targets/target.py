"""What a run needs to know of the place where its jobs are executed."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Protocol

if TYPE_CHECKING:
    # Loaded only where they are used: every stage loads this module for the table of failures.
    from millscale.cases.cost import Rates
    from millscale.engine.machine import Allocation, CoreWish
    from millscale.runs.case_file import Case
    from millscale.workflow.jobs import Job


class Target(Protocol):
    """A place where Snakemake executes the jobs of a run.

    Attributes:
        name: as `millscale run --target` takes it.
        about: a few words for the help text.
        time_limit_message: regular expression of what appears in the output of a job that was
            ended at its time limit; empty if there is no such output.
        memory_message: the same for a job that was ended for want of memory.
    """

    name: ClassVar[str]
    about: ClassVar[str]
    time_limit_message: ClassVar[str]
    memory_message: ClassVar[str]

    def __init__(self, profile: Path | None = None) -> None: ...

    def allocate(
        self, cases: Sequence[Case], asked: CoreWish, usual: CoreWish, rates: Rates
    ) -> Allocation:
        """Give each case its MPI ranks; arguments as of `placement.place`.

        Raises:
            CampaignError: the target is not available, or has not what is asked for.
        """
        ...

    def shared_job_s(self, allocation: Allocation, total_s: float) -> float:
        """Return how long [s] a job of several small cases may take; `total_s` is that of all."""
        ...

    def snakemake_options(self, allocation: Allocation) -> list[str]:
        """Return the options that make Snakemake execute jobs here."""
        ...

    def request_lines(self, jobs: Sequence[Job]) -> list[str]:
        """Return what is requested for the jobs, for people; empty if nothing is."""
        ...

    def waiting(self) -> AbstractContextManager[None]:
        """Return the context in which the command waits for its jobs."""
        ...
