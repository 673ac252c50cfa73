"""A real Slurm on this machine for tests: munged, slurmctld and slurmds with files of their own.

Each node is a slurmd with a port of its own, so that one machine stands for several.
"""

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
    """Return what this machine lacks to run a Slurm; empty if nothing."""
    path = f"{os.environ['PATH']}:/usr/sbin:/sbin"
    return [name for name in COMMANDS if not shutil.which(name, path=path)]


@dataclass(frozen=True)
class Cluster:
    """A Slurm that runs; `environment` is what a process needs beside its own to reach it."""

    folder: Path
    environment: dict[str, str]

    def __call__(self, *line: str) -> str:
        """Output of one of Slurm's commands."""
        done = subprocess.run(
            line,
            env={**os.environ, **self.environment},
            capture_output=True,
            text=True,
            timeout=300,
        )
        if done.returncode:
            raise RuntimeError(f"{' '.join(line)}: {done.stderr.strip()}")
        return done.stdout.strip()

    def jobs(self, state: str) -> list[str]:
        """Numbers of the jobs in a state, such as RUNNING."""
        return self("squeue", "--noheader", "--states", state, "--format", "%i").split()


@contextmanager
def cluster(folder: Path, cores: int, nodes: int = 1) -> Iterator[Cluster]:
    """Start a Slurm; stop it and all its jobs at the end.

    Args:
        folder: short, as sockets lie in it; made with the mode the daemons want.
        cores: of each node, whatever this machine has.
    """
    folder.mkdir(mode=0o755)
    path = f"{os.environ['PATH']}:/usr/sbin:/sbin"
    more = {"PATH": path, "SLURM_CONF": str(folder / "slurm.conf")}
    environment = {**os.environ, **more}
    _write_files(folder, cores, nodes)
    lines = {
        "munged": [
            *("--foreground", "--force", "--key-file", folder / "munge.key"),
            *("--socket", folder / "munge.socket", "--pid-file", folder / "munged.pid"),
            *("--log-file", folder / "munged.log", "--seed-file", folder / "munged.seed"),
        ],
        "slurmctld": ["-D", "-c", "-f", folder / "slurm.conf"],
    }
    for name in _names(nodes):
        lines[name] = ["-D", "-N", name, "-f", folder / "slurm.conf"]
    running: list[subprocess.Popen] = []
    try:
        for name, options in lines.items():
            with (folder / f"{name}.out").open("wb") as output:
                line = [name if name in DAEMONS else "slurmd", *map(str, options)]
                running.append(
                    subprocess.Popen(
                        line, env=environment, stdout=output, stderr=output, start_new_session=True
                    )
                )
            if name == "munged":
                _wait(lambda: (folder / "munge.socket").exists(), folder)
        started = Cluster(folder, more)
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


def _names(nodes: int) -> list[str]:
    return [f"node{number + 1}" for number in range(nodes)]


def _write_files(folder: Path, cores: int, nodes: int) -> None:
    (folder / "munge.key").write_bytes(os.urandom(128))
    (folder / "munge.key").chmod(0o400)
    for name in ("state", "spool"):
        (folder / name).mkdir()
    host = socket.gethostname()
    ports = [_free_port() for _ in range(1 + nodes)]
    user = "root" if os.geteuid() == 0 else os.environ["USER"]
    names = _names(nodes)
    node_lines = "\n".join(
        f"NodeName={name} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} CPUs={cores} "
        "RealMemory=4000"
        for name, port in zip(names, ports[1:], strict=True)
    )
    (folder / "slurm.conf").write_text(
        f"""ClusterName=millscale
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={ports[0]}
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
SlurmdSpoolDir={folder}/spool/%n
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/%n.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/%n.log
SlurmdParameters=config_overrides
{node_lines}
PartitionName={PARTITION} Nodes={",".join(names)} Default=YES MaxTime=INFINITE State=UP
"""
    )


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def _idle(started: Cluster) -> bool:
    try:
        return set(started("sinfo", "--noheader", "--format", "%T").split()) == {"idle"}
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
