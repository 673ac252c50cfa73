"""Run a deck in the engine under mpirun; errors carry the engine's own message."""

from __future__ import annotations

import os
import resource
import shlex
import shutil
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from millscale.engine.environment import ENGINE_VARIABLE
from millscale.engine.log import error_line, read_log
from millscale.engine.machine import Spread, available_cores, physical_cores
from millscale.engine.parent_death import end_with_parent
from millscale.engine.temporary_folder import without_own_folder
from millscale.errors import CampaignError, EngineError

ENGINE = "liggghts_mill"
# Open MPI reads these to learn the nodes of a batch job. They differ by site, and Snakemake's
# executors remove some of them: one node needs none, and `Spread` has those of several nodes.
_BATCH_VARIABLES = ("SLURM_", "PBS_", "LSB_", "PE_HOSTFILE", "PMI_", "PMIX_")
_GRACE_S = 10.0


@dataclass(frozen=True)
class DeckRun:
    """A deck to run to its end.

    Attributes:
        folder: working folder.
        log: name of the engine's log.
        screen: file that receives the output of this process; searched for errors.
        resume: whether to continue from resume.restart.
    """

    deck: str
    folder: Path
    log: str
    screen: Path
    resume: bool


@dataclass(frozen=True)
class Spent:
    """Wall time and processor time, summed over all ranks, of a run [s].

    Beside other work the first is longer than the run needs; the second is not. Nobody measures
    the processor time of other nodes: on several nodes it is wall time times ranks, as ranks wait
    actively.
    """

    wall_time: float
    processor_time: float


def find_engine() -> Path:
    """Return the executable: $MILLSCALE_ENGINE, beside this Python, on the PATH or in build/."""
    named = os.environ.get(ENGINE_VARIABLE)
    if named:
        if not os.access(named, os.X_OK):
            raise CampaignError(
                ENGINE_VARIABLE, "", f"got {named}", "the path of an executable file"
            )
        return Path(named).absolute()
    on_path = shutil.which(ENGINE)
    source_build = Path(__file__).parents[3] / "build" / "liggghts_ext" / ENGINE
    candidates = [
        Path(sys.executable).parent / ENGINE,
        *([Path(on_path)] if on_path else []),
        source_build,
    ]
    for candidate in candidates:
        if os.access(candidate, os.X_OK):
            return candidate.absolute()
    raise CampaignError(
        ENGINE, "", f"not found beside {sys.executable}, on the PATH or in build/",
        f"run scripts/setup, or set {ENGINE_VARIABLE} to the executable",
    )  # fmt: skip


def mpirun_line(
    engine: Path | str, deck: str, log: str, ranks: int, per_node: int | None = None
) -> list[str]:
    """Return the command that runs a deck.

    The screen output stays on: with `-screen none` the engine loses every error of a rank above 0.
    Ranks are not bound: several mpirun at once would bind to the same core. Neighbours along the
    axis share a node.

    Args:
        per_node: ranks of a node of a batch job; None for ranks on this machine.
    """
    line = ["mpirun", "-np", str(ranks), "--bind-to", "none"]
    if per_node:
        line += ["--map-by", f"ppr:{per_node}:node"]
    elif ranks > available_cores():
        line.append("--oversubscribe")
    elif ranks > physical_cores():
        line.append("--use-hwthread-cpus")
    return [*line, str(engine), "-in", deck, "-log", log]


def mpirun_text(line: list[str]) -> str:
    """Return the command as typed in a shell."""
    return shlex.join(line)


def run_deck(run: DeckRun, ranks: int, lock: int, spread: Spread | None = None) -> Spent:
    """Run a deck to its end; it prints to the output of this process.

    Args:
        lock: descriptor that the engine inherits, so that the folder stays locked while it lives.
        spread: nodes of a batch job for the ranks; None for ranks on this machine.
    """
    per_node = spread.per_node if spread else None
    line = mpirun_line(find_engine(), run.deck, run.log, ranks, per_node)
    if run.resume:
        line += ["-var", "resume", "1"]
    print(mpirun_text(line), flush=True)
    begin, processor_begin = time.monotonic(), _processor_time()
    try:
        # In a session of its own, so that Ctrl-C reaches only the stage, which then ends mpirun.
        process = subprocess.Popen(
            line,
            cwd=run.folder,
            env=engine_environment(spread),
            stdin=subprocess.DEVNULL,
            pass_fds=(lock,),
            start_new_session=True,
            preexec_fn=end_with_parent(),
        )
    except FileNotFoundError:
        raise EngineError("mpirun not found on the PATH: run scripts/setup") from None
    try:
        code = process.wait()
    except BaseException:
        _end(process)
        raise
    cause = error_line(read_log(run.folder / run.log, run.screen))
    if code != 0 or cause:
        raise EngineError(cause or _exit_text(code))
    wall_time = time.monotonic() - begin
    return Spent(wall_time, ranks * wall_time if spread else _processor_time() - processor_begin)


def engine_text(line: list, folder: Path) -> tuple[str, str | None]:
    """Run an engine in a folder; return its output, and why it failed, or None."""
    done = subprocess.run(
        line,
        cwd=folder,
        env=engine_environment(),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        encoding="utf-8",
        errors="replace",
    )
    text = done.stdout + done.stderr
    ended = f"exit code {done.returncode}" if done.returncode else None
    return text, error_line(text) or ended


def engine_environment(spread: Spread | None = None) -> dict[str, str]:
    own = {k: v for k, v in os.environ.items() if not k.startswith(_BATCH_VARIABLES)}
    if spread:
        own = without_own_folder(own) | dict(spread.environment)
    environment = {**own, "OMP_NUM_THREADS": "1"}
    if os.geteuid() == 0:
        environment |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    return environment


def _processor_time() -> float:
    """Return user and system time of ended children and their children [s]."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def _end(process: subprocess.Popen) -> None:
    process.terminate()
    try:
        process.wait(_GRACE_S)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, 9)
        process.wait()


def _exit_text(code: int) -> str:
    return (
        f"mpirun ended by signal {-code}"
        if code < 0
        else f"mpirun ended with exit code {code}, no error in the log"
    )
