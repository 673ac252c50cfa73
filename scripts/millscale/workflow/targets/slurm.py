"""Slurm, through Snakemake's executor: what a machine needs for it, and the options of a run."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
from pathlib import Path

from millscale.errors import CampaignError

PLUGIN = "snakemake_executor_plugin_slurm"
# A job that was killed, or ended at its time, is queued again so often, each time with more time.
RETRIES = 2
# Looks at the queue come this long after a job was sent, then ten seconds later each time [s].
_FIRST_LOOK_S = 3
# Files a node has written may show up late on a shared file system [s].
_LATENCY_S = 60


def slurm_options(profile: Path | None, jobs: int) -> list[str]:
    """Snakemake's options for Slurm.

    Args:
        profile: folder with a `config.yaml` of the site, such as profiles/slurm.
        jobs: the most that wait or run at a time.
    """
    return [
        *("--executor", "slurm", "--jobs", str(jobs), "--retries", str(RETRIES)),
        *("--slurm-status-command", "sacct" if _keeps_accounts() else "squeue"),
        *("--slurm-requeue", "--slurm-init-seconds-before-status-checks", str(_FIRST_LOOK_S)),
        *("--latency-wait", str(_LATENCY_S)),
        *("--profile", str(profile.resolve()) if profile else "none"),
    ]


def node_cores() -> int:
    """Cores of the largest node of this Slurm.

    Raises:
        CampaignError: no Slurm here, it does not answer, or its executor is not installed.
    """
    if importlib.util.find_spec(PLUGIN) is None:
        raise CampaignError(
            "millscale run",
            "--slurm",
            f"{PLUGIN} is not installed",
            "pip install 'millscale[slurm]'",
        )
    for command in ("sbatch", "sinfo"):
        if not shutil.which(command):
            raise CampaignError(
                "millscale run",
                "--slurm",
                f"no {command} on the PATH",
                "a machine that submits jobs",
            )
    try:
        done = subprocess.run(
            ["sinfo", "--noheader", "--format", "%c"],
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            timeout=60,
        )
        # Nodes of several sizes in one line: "16+".
        return max(int(text.rstrip("+")) for text in done.stdout.split())
    except (ValueError, subprocess.TimeoutExpired):
        raise CampaignError(
            "millscale run", "--slurm", "sinfo names no nodes", "a Slurm that answers"
        ) from None


def _keeps_accounts() -> bool:
    """Whether `sacct` knows of jobs; if not, the controller does for MinJobAge after their end."""
    done = subprocess.run(
        ["scontrol", "show", "config"], capture_output=True, encoding="utf-8", errors="replace"
    )
    kept = [line for line in done.stdout.splitlines() if line.startswith("AccountingStorageType")]
    return bool(kept) and not kept[0].endswith("/none")


def check_profile(profile: Path | None) -> None:
    if profile is not None and not (profile / "config.yaml").is_file():
        raise CampaignError(
            "millscale run", "--profile", f"no config.yaml in {profile}", "a folder that has one"
        )
