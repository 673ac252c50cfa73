"""A real Slurm of one node for tests: munged, slurmctld and slurmd with files of their own."""

from __future__ import annotations

import os
import shutil
import signal
import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

DAEMONS = ("munged", "slurmctld", "slurmd")
COMMANDS = (*DAEMONS, "sbatch", "squeue", "scontrol", "scancel", "sinfo")
PARTITION = "mill"


def missing() -> list[str]:
    """Return what this machine lacks to run a node; empty if nothing."""
    path = f"{os.environ['PATH']}:/usr/sbin:/sbin"
    return [name for name in COMMANDS if not shutil.which(name, path=path)]


@dataclass(frozen=True)
class Node:
    """A node that runs; `environment` is what a process needs beside its own to reach it."""

    folder: Path
    environment: dict[str, str]

    def __call__(self, *line: str) -> str:
        """Output of one of Slurm's commands."""
        done = subprocess.run(
            line, env={**os.environ, **self.environment}, capture_output=True, text=True, timeout=60
        )
        if done.returncode:
            raise RuntimeError(f"{' '.join(line)}: {done.stderr.strip()}")
        return done.stdout.strip()

    def jobs(self, state: str) -> list[str]:
        """Numbers of the jobs in a state, such as RUNNING."""
        return self("squeue", "--noheader", "--states", state, "--format", "%i").split()


@contextmanager
def node(folder: Path, cores: int) -> Iterator[Node]:
    """Start a node with so many cores, counted or not; stop it and all its jobs at the end.

    Args:
        folder: short, as sockets lie in it; made with the mode the daemons want.
    """
    folder.mkdir(mode=0o755)
    path = f"{os.environ['PATH']}:/usr/sbin:/sbin"
    more = {"PATH": path, "SLURM_CONF": str(folder / "slurm.conf")}
    environment = {**os.environ, **more}
    _write_files(folder, cores)
    lines = {
        "munged": [
            *("--foreground", "--force", "--key-file", folder / "munge.key"),
            *("--socket", folder / "munge.socket", "--pid-file", folder / "munged.pid"),
            *("--log-file", folder / "munged.log", "--seed-file", folder / "munged.seed"),
        ],
        "slurmctld": ["-D", "-c", "-f", folder / "slurm.conf"],
        "slurmd": ["-D", "-N", "node1", "-f", folder / "slurm.conf"],
    }
    running: list[subprocess.Popen] = []
    try:
        for name in DAEMONS:
            with (folder / f"{name}.out").open("wb") as output:
                line = [name, *map(str, lines[name])]
                running.append(
                    subprocess.Popen(
                        line, env=environment, stdout=output, stderr=output, start_new_session=True
                    )
                )
            if name == "munged":
                _wait(lambda: (folder / "munge.socket").exists(), folder)
        started = Node(folder, more)
        _wait(lambda: _idle(started), folder)
        yield started
        subprocess.run(["scancel", "--user", str(os.getuid())], env=environment, timeout=30)
        _wait(lambda: not started("squeue", "--noheader"), folder)
    finally:
        for process in reversed(running):
            process.send_signal(signal.SIGTERM)
        for process in reversed(running):
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()


def _write_files(folder: Path, cores: int) -> None:
    (folder / "munge.key").write_bytes(os.urandom(128))
    (folder / "munge.key").chmod(0o400)
    for name in ("state", "spool"):
        (folder / name).mkdir()
    ports = [_free_port() for _ in range(2)]
    user = "root" if os.geteuid() == 0 else os.environ["USER"]
    (folder / "slurm.conf").write_text(
        f"""ClusterName=millscale
SlurmctldHost={socket.gethostname()}(127.0.0.1)
SlurmctldPort={ports[0]}
SlurmdPort={ports[1]}
SlurmUser={user}
SlurmdUser={user}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
SchedulerParameters=batch_sched_delay=0,sched_interval=2
KillWait=10
JobRequeue=1
ReturnToService=2
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
SlurmdParameters=config_overrides
NodeName=node1 NodeHostname={socket.gethostname()} NodeAddr=127.0.0.1 CPUs={cores} RealMemory=4000
PartitionName={PARTITION} Nodes=node1 Default=YES MaxTime=INFINITE State=UP
"""
    )


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def _idle(started: Node) -> bool:
    try:
        return started("sinfo", "--noheader", "--format", "%T") == "idle"
    except RuntimeError:
        return False


def _wait(condition, folder: Path, seconds: float = 60.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > deadline:
            logs = "\n".join(
                f"{x.name}: {x.read_text(errors='replace')[-2000:]}"
                for x in [*folder.glob("*.out"), *folder.glob("*.log")]
            )
            raise RuntimeError(f"Slurm does not answer:\n{logs}")
        time.sleep(0.2)
