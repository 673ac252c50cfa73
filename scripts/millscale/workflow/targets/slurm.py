"""Slurm."""

from __future__ import annotations

import subprocess

from millscale.workflow.targets.batch_system import BatchSystem

# The first look at the state of a job, after its submission [s]; each next one is 10 s later.
_FIRST_LOOK_S = 3
_ANSWER_S = 60


class Slurm(BatchSystem):
    """Jobs are submitted with sbatch, by Snakemake's executor plugin."""

    name = "slurm"
    about = "jobs of Slurm"
    title = "Slurm"
    plugin = "snakemake_executor_plugin_slurm"
    install = "pip install 'millscale[slurm]'"
    commands = ("sbatch", "sinfo")
    time_limit_message = "DUE TO TIME LIMIT"
    memory_message = "oom.kill"

    def node_cores(self) -> int:
        """Return the cores of the largest node.

        Raises:
            CampaignError: Slurm does not answer.
        """
        try:
            done = _run("sinfo", "--noheader", "--format", "%c")
            # Nodes of several sizes in one line: "16+".
            return max(int(text.rstrip("+")) for text in done.split())
        except (ValueError, subprocess.TimeoutExpired):
            raise self.refused("sinfo names no nodes", "a Slurm that answers") from None

    def executor_options(self) -> list[str]:
        """Return the options of the plugin: how it asks for the state of jobs."""
        return [
            *("--executor", "slurm"),
            *("--slurm-status-command", "sacct" if _keeps_accounts() else "squeue"),
            *("--slurm-requeue", "--slurm-init-seconds-before-status-checks", str(_FIRST_LOOK_S)),
        ]


def _keeps_accounts() -> bool:
    """Return whether `sacct` knows ended jobs; squeue does so for MinJobAge after their end."""
    lines = _run("scontrol", "show", "config").splitlines()
    kept = [line for line in lines if line.startswith("AccountingStorageType")]
    return bool(kept) and not kept[0].endswith("/none")


def _run(*line: str) -> str:
    done = subprocess.run(
        line, capture_output=True, encoding="utf-8", errors="replace", timeout=_ANSWER_S
    )
    return done.stdout
