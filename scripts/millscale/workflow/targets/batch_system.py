"""What the batch systems of clusters have in common: jobs queue, each on one node or several."""

from __future__ import annotations

import importlib.util
import shlex
import shutil
import sys
from abc import ABC, abstractmethod
from collections.abc import Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from importlib.metadata import requires
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from millscale.errors import CampaignError
from millscale.formats import counted, duration
from millscale.workflow.targets.target import Target

if TYPE_CHECKING:
    from millscale.cases.cost import Rates
    from millscale.engine.machine import Allocation, CoreWish, Spread
    from millscale.runs.case_file import Case
    from millscale.workflow.jobs import Job

# A job waits in a queue: small cases share a job of about a quarter of an hour.
SHARED_JOB_S = 900.0
# A job that was killed, or ended at its time limit, is submitted again so often, each time with
# more time.
RETRIES = 2
# Files that a node has written may appear late on a shared file system [s].
LATENCY_S = 60
# More jobs than any site lets one user queue.
MOST_JOBS = 500
_MOST_JOBS_SHOWN = 20


@dataclass(frozen=True)
class Nodes:
    """The largest nodes of a cluster: cores of each, and how many one job can have."""

    cores: int
    count: int


class BatchSystem(Target, ABC):
    """A `Target` whose jobs wait in the queue of a cluster.

    Attributes:
        title: its name as people write it.
        plugin: Snakemake's executor plugin for it, a Python module.
        extra: the optional dependencies of pyproject.toml that have the plugin.
        commands: programs that must be on the PATH.
        job_variable: environment variable that only its jobs have.
    """

    name: ClassVar[str]
    about: ClassVar[str]
    title: ClassVar[str]
    plugin: ClassVar[str]
    extra: ClassVar[str]
    commands: ClassVar[tuple[str, ...]]
    job_variable: ClassVar[str]
    time_limit_message: ClassVar[str] = ""
    memory_message: ClassVar[str] = ""

    def __init__(self, profile: Path | None = None) -> None:
        if profile is not None and not (profile / "config.yaml").is_file():
            cause = f"no config.yaml in {profile}"
            raise CampaignError("millscale run", "--profile", cause, "a folder that has one")
        self.profile = profile

    @abstractmethod
    def nodes(self) -> Nodes:
        """Return the largest nodes; raise the error of `refused` if unknown."""

    @abstractmethod
    def spread(self, ranks: int, nodes: int) -> Spread:
        """Return ranks on the nodes of the job of this process, of which there are several."""

    @abstractmethod
    def executor_options(self) -> list[str]:
        """Return Snakemake's options that are particular to the executor plugin."""

    def refused(self, cause: str, accepted: str) -> CampaignError:
        """Return the error of a batch system that cannot be used."""
        return CampaignError("millscale run", f"--target {self.name}", cause, accepted)

    def install_line(self) -> str:
        """Return the command that installs the plugin in the version of pyproject.toml."""
        wanted = requires("millscale") or []
        named = [x.partition(";")[0].strip() for x in wanted if f'extra == "{self.extra}"' in x]
        return shlex.join([sys.executable, "-m", "pip", "install", *named])

    def check(self) -> None:
        """Refuse a machine from which jobs cannot be submitted.

        Raises:
            CampaignError: the executor plugin or a command is missing.
        """
        if importlib.util.find_spec(self.plugin) is None:
            raise self.refused(f"{self.plugin} is not installed", self.install_line())
        for command in self.commands:
            if not shutil.which(command):
                raise self.refused(f"no {command} on the PATH", "a machine that submits jobs")

    def allocate(
        self, cases: Sequence[Case], asked: CoreWish, usual: CoreWish, rates: Rates
    ) -> Allocation:
        """Give each case the ranks that are worth their cores, on as few nodes as possible."""
        from millscale.engine.machine import Allocation, check_numbers
        from millscale.workflow.placement import ranks_on_nodes

        check_numbers(asked)
        self.check()
        there, given = self.nodes(), asked.ranks or usual.ranks
        if any(case.kind == "multi-ball" for case in cases):
            _check_fit(given, asked.nodes, there)
        each = asked.nodes or 1
        return Allocation(
            ranks_on_nodes(cases, given, each * there.cores),
            jobs=asked.jobs or usual.jobs or MOST_JOBS,
            cores=there.cores * there.count,
            node_cores=there.cores,
            nodes=each,
        )

    def shared_job_s(self, allocation: Allocation, total_s: float) -> float:
        """Return the length of a shared job [s]."""
        return SHARED_JOB_S

    def snakemake_options(self, allocation: Allocation) -> list[str]:
        """Return Snakemake's options: executor, jobs at a time, retries, the site's profile."""
        return [
            *self.executor_options(),
            *("--jobs", str(allocation.jobs), "--retries", str(RETRIES)),
            *("--latency-wait", str(LATENCY_S)),
            *("--profile", str(self.profile.resolve()) if self.profile else "none"),
        ]

    def request_lines(self, jobs: Sequence[Job]) -> list[str]:
        """Return time, cores and memory requested, a line for each of the longest jobs."""
        lines = [
            f"{self.title}: {job.name}: {job.minutes} min requested, {duration(job.time_s)} "
            f"predicted, {_cores(job)}, {job.memory_mb} MB"
            for job in jobs[:_MOST_JOBS_SHOWN]
        ]
        more = len(jobs) - len(lines)
        return [*lines, f"{self.title}: and {more} shorter jobs"] if more else lines

    def waiting(self) -> AbstractContextManager[None]:
        """Return a context without a temporary folder: the jobs run on other machines."""
        return nullcontext()


def _check_fit(ranks: int | None, nodes: int | None, there: Nodes) -> None:
    """Refuse ranks and nodes that no job can have.

    Args:
        ranks, nodes: of a multi-ball case; None for no request.

    Raises:
        CampaignError: states what is accepted.
    """
    options = {"--ranks": ranks, "--nodes": nodes}
    where = " ".join(f"{option} {value}" for option, value in options.items() if value)
    needed = -(-(ranks or 1) // there.cores)
    cause = accepted = ""
    if nodes and ranks and ranks % nodes:
        cause, accepted = "nodes with unequal ranks", f"a multiple of {nodes} ranks"
    elif nodes and nodes < needed:
        cause = f"needs {needed} nodes of {counted(there.cores, 'core')}"
        accepted = f"--nodes {needed}, or at most {nodes * there.cores} ranks"
    elif (needed if nodes is None else nodes) > there.count:
        cause = f"needs {counted(nodes or needed, 'node')}, a job can have {there.count}"
        accepted = f"at most {counted(there.count * there.cores, 'rank')}"
    if cause:
        raise CampaignError("millscale run", where, cause, accepted)


def _cores(job: Job) -> str:
    cores = counted(job.ranks, "core")
    return cores if job.nodes == 1 else f"{cores} on {job.nodes} nodes"
