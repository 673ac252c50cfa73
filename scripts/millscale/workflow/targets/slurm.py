"""Slurm."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

from millscale.engine.machine import Spread, ranks_per_node
from millscale.errors import EngineError
from millscale.workflow.targets.batch_system import BatchSystem, Nodes

# The first look at the state of a job, after its submission [s]; each next one is 10 s later.
_FIRST_LOOK_S = 3
_ANSWER_S = 60
# Names the configuration of Slurm where it has not its usual place. The executor plugin removes it
# from the environment of jobs, so that they get it by a second name.
_CONF, _KEPT_CONF = "SLURM_CONF", "MILLSCALE_SLURM_CONF"


class Slurm(BatchSystem):
    """Jobs are submitted with sbatch, by Snakemake's executor plugin."""

    name = "slurm"
    about = "jobs of Slurm"
    title = "Slurm"
    plugin = "snakemake_executor_plugin_slurm"
    extra = "slurm"
    commands = ("sbatch", "sinfo")
    job_variable = "SLURM_JOB_ID"
    time_limit_message = "DUE TO TIME LIMIT"
    memory_message = "oom.kill"

    def nodes(self) -> Nodes:
        """Return the largest nodes, and how many of them a partition has.

        Raises:
            CampaignError: Slurm does not answer.
        """
        try:
            # A line for each size of node in each partition.
            done = _run("sinfo", "--noheader", "--exact", "--format", "%c %D")
            sizes = [tuple(map(int, line.split())) for line in done.splitlines()]
            return Nodes(*max(sizes))
        except (TypeError, ValueError, subprocess.TimeoutExpired):
            raise self.refused("sinfo names no nodes", "a Slurm that answers") from None

    @contextmanager
    def waiting(self) -> Iterator[None]:
        """Give the jobs the configuration of Slurm."""
        file = os.environ.get(_CONF)
        if file:
            os.environ[_KEPT_CONF] = file
        try:
            yield
        finally:
            os.environ.pop(_KEPT_CONF, None)

    def spread(self, ranks: int, nodes: int) -> Spread:
        """Return ranks on the nodes of the job of this process.

        mpirun starts its daemons with srun. A job has one task on each node, with the cores for
        its ranks, and the daemons need as many.

        Raises:
            EngineError: Slurm does not name the nodes.
        """
        job, per_node = os.environ[self.job_variable], ranks_per_node(ranks, nodes)
        # The executor plugin removes SLURM_JOB_NODELIST.
        names = _run("squeue", "--noheader", "--jobs", job, "--format", "%N").strip()
        if not names:
            raise EngineError(f"squeue names no nodes of job {job}")
        return Spread(
            per_node,
            _configuration()
            | dict.fromkeys(("SLURM_JOB_ID", "SLURM_JOBID"), job)
            | dict.fromkeys(("SLURM_JOB_NODELIST", "SLURM_NODELIST"), names)
            | {
                "SLURM_TASKS_PER_NODE": f"{per_node}(x{nodes})",
                "SRUN_CPUS_PER_TASK": str(per_node),
            },
        )

    def executor_options(self) -> list[str]:
        """Return the options of the plugin: how it asks for the state of jobs."""
        return [
            *("--executor", "slurm"),
            *("--slurm-status-command", "sacct" if _keeps_accounts() else "squeue"),
            *("--slurm-requeue", "--slurm-init-seconds-before-status-checks", str(_FIRST_LOOK_S)),
        ]


def _configuration() -> dict[str, str]:
    """Return the variable that names the configuration of Slurm, if there is one."""
    file = os.environ.get(_CONF) or os.environ.get(_KEPT_CONF)
    return {_CONF: file} if file else {}


def _keeps_accounts() -> bool:
    """Return whether `sacct` knows ended jobs; squeue does so for MinJobAge after their end."""
    lines = _run("scontrol", "show", "config").splitlines()
    kept = [line for line in lines if line.startswith("AccountingStorageType")]
    return bool(kept) and not kept[0].endswith("/none")


def _run(*line: str) -> str:
    done = subprocess.run(
        line,
        env={**os.environ, **_configuration()},
        capture_output=True,
        encoding="utf-8",
        errors="replace",
        timeout=_ANSWER_S,
    )
    return done.stdout
