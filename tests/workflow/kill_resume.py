"""Kill a running campaign at random moments in several ways, resume it each time, and compare.

    python tests/workflow/kill_resume.py --kills 20 --to docs/results/kill-resume.json

Needs the engine. The full disk is a small tmpfs, which only root may mount; without it that way of
killing is a limit on the size of files.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import datetime
import fcntl
import json
import os
import random
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from pathlib import Path

import psutil

import small_campaign
from millscale.engine.code_version import described_commit
from millscale.engine.deck_run import find_engine
from millscale.engine.machine import hardware
from millscale.engine.parent_death import end_with_parent
from millscale.engine.restart_file import NotWholeError, read_restart
from millscale.engine.resume import RESTART_FILES
from millscale.runs.layout import STAGES
from millscale.runs.lock import LOCK_FILE

CASE = small_campaign.CHARGE
TMPFS_BYTES = 64 << 20
LONGEST_S = 900.0
# Kinds of kill that need a running engine; the others may come at any moment.
OF_ENGINE = (
    "SIGKILL mpirun",
    "SIGKILL a rank",
    "SIGKILL a rank, newest restart file cut",
    "full disk",
)
OF_WORKFLOW = (
    "SIGKILL millscale",
    "SIGKILL snakemake",
    "SIGKILL the stage",
    "SIGINT millscale",
    "SIGTERM millscale",
)


@dataclass
class Kill:
    """One kill and what followed.

    Attributes:
        moment_s: after the start of the command.
        stage, step: at work then, and the engine's last step in series.csv, 0 outside the rotation.
        ended_s: until the command had ended.
        lock_free_s: until the locks of runs folder and case were free, from the kill on.
        next_said: about the stage that was killed, by the next run that lived long enough.
        rows_compared, rows_that_differ: of series.csv at that moment, with the uninterrupted run.
        made_again: products that were complete and yet changed since.
        other_ranks_refused: whether a run on another number of ranks is refused then; where there
            is nothing to go on from, it is not.
    """

    number: int
    kind: str
    moment_s: float
    stage: str
    step: int
    detail: str = ""
    exit_code: int = 0
    ended_s: float = 0.0
    lock_free_s: float = 0.0
    said: str = ""
    next_said: str = ""
    rows_compared: int = 0
    rows_that_differ: int = 0
    made_again: list[str] = field(default_factory=list)
    other_ranks_refused: bool = False


def campaign_text(rotation_angle: float, restart_angle: float, balls: int) -> str:
    """One charge, with many restart files."""
    head = small_campaign.TEXT.split("[single_ball]")[0]
    return (
        f"{head}[multi_ball]\nS = [2.0]\ncount = [{balls}]\nslice_length_m = 0.15\nsettle_s = 0.3\n"
        f"rotation_angle_rad = {rotation_angle}\nstep_s = 1e-4\n"
        f"restart_angle_rad = {restart_angle}\ndump_angle_rad = 0.5\n"
    )


@dataclass(frozen=True)
class Campaign:
    """A campaign file, where it runs, and the files of the uninterrupted run."""

    file: Path
    runs: Path
    ranks: int

    @property
    def case(self) -> Path:
        return self.runs / "cases" / CASE

    @property
    def temporary(self) -> Path:
        """Its temporary folder, beside the campaign file."""
        return self.file.with_name("tmp")

    def line(self, ranks: int) -> list[str]:
        # The disk that is made full is a small one.
        options = ["--runs", str(self.runs), "--ranks", str(ranks), "--ignore-disk"]
        return [sys.executable, "-m", "millscale", "run", str(self.file), *options]

    def environment(self) -> dict[str, str]:
        self.temporary.mkdir(exist_ok=True)
        return {**os.environ, "PYTHONUNBUFFERED": "1", "TMPDIR": str(self.temporary)}

    def start(self, screen: Path) -> psutil.Popen:
        with screen.open("wb") as output:
            return psutil.Popen(
                self.line(self.ranks),
                env=self.environment(),
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                preexec_fn=end_with_parent(signal.SIGKILL),
            )

    def refuses_other_ranks(self) -> bool:
        """Return whether a run on one rank more or less is refused; write nothing."""
        line = [*self.line(1 if self.ranks > 1 else 2), "--dry-run"]
        asked = subprocess.run(line, env=self.environment(), capture_output=True, text=True)
        refused = asked.returncode == 2 and "--start-over" in asked.stderr
        if asked.returncode and not refused:
            raise RuntimeError(asked.stderr)
        return refused

    def complete(self) -> dict[str, tuple[int, int]]:
        """Identity of the products of the stages that are complete."""
        found = {}
        for stage in STAGES["multi-ball"]:
            paths = [self.case / name for name in stage.products]
            if all(path.exists() for path in paths):
                found |= {p.name: (p.stat().st_ino, p.stat().st_mtime_ns) for p in paths}
        return found

    def series(self) -> Path:
        """Return the path of the series, finished or in the part folder."""
        part = self.case / "rotate.part" / "series.csv"
        return part if part.exists() else self.case / "series.csv"


def _named(process: psutil.Process, word: str) -> list[psutil.Process]:
    """Return the descendants of a process whose command line contains the word."""
    found = []
    for child in process.children(recursive=True):
        with contextlib.suppress(psutil.Error):
            if any(word in part for part in child.cmdline()[:4]):
                found.append(child)
    return found


def _ranks(process: psutil.Process) -> list[psutil.Process]:
    name = find_engine().name
    found = []
    for child in _named(process, name):
        with contextlib.suppress(psutil.Error, IndexError):  # it may have ended meanwhile
            if Path(child.cmdline()[0]).name == name:
                found.append(child)
    return found


def _at_work(campaign: Campaign, process: psutil.Process) -> tuple[str, psutil.Process] | None:
    """Return the running stage and its process, a child of this command."""
    with contextlib.suppress(psutil.Error, OSError, ValueError, KeyError):
        record = json.loads((campaign.case / "stage.json").read_text())
        for child in process.children(recursive=True):
            if child.pid == record["process"] and record["state"] == "running":
                return record["stage"], child
    return None


def _stage(campaign: Campaign, process: psutil.Process) -> str:
    return (_at_work(campaign, process) or ("",))[0]


def _last_step(series: Path) -> int:
    rows = _rows(series)
    return int(rows[-1].split(",")[0]) if len(rows) > 1 else 0


def _rows(series: Path) -> list[str]:
    """Header and complete rows."""
    try:
        return series.read_text(errors="replace").split("\n")[:-1]
    except FileNotFoundError:
        return []


def wait_until_free(campaign: Campaign) -> float:
    """Return the seconds until neither runs folder nor case is locked."""
    begin = time.monotonic()
    for folder in (campaign.runs, campaign.case):
        if not (folder / LOCK_FILE).exists():
            continue
        with (folder / LOCK_FILE).open("rb+") as file:
            while True:
                with contextlib.suppress(BlockingIOError):
                    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    break
                if time.monotonic() - begin > LONGEST_S:
                    raise TimeoutError(f"{folder} stays locked")
                time.sleep(0.02)
    return time.monotonic() - begin


def strike(kind: str, campaign: Campaign, process: psutil.Popen, chance: random.Random) -> str:
    """Kill in one of the ways; return a note."""
    if kind.endswith("millscale"):
        process.send_signal(getattr(signal, kind.split()[0]))
    elif kind == "full disk":
        return _fill_disk(campaign, process)
    elif kind == "SIGKILL mpirun":
        _named(process, "mpirun")[0].kill()
    elif kind == "SIGKILL snakemake":
        _named(process, "snakemake")[0].kill()
    elif kind == "SIGKILL the stage":
        at_work = _at_work(campaign, process)
        if at_work is None:
            raise psutil.NoSuchProcess(process.pid)
        at_work[1].kill()
    else:
        rank = chance.choice(_ranks(process))
        rank.kill()
        if "cut" in kind:
            process.wait(LONGEST_S)
            return _cut_newest(campaign, chance)
    return ""


def _fill_disk(campaign: Campaign, process: psutil.Popen) -> str:
    if not os.path.ismount(campaign.runs):
        for rank in _ranks(process):
            resource.prlimit(rank.pid, resource.RLIMIT_FSIZE, (1 << 15, 1 << 15))
        return "stood for by a limit on the size of files"
    filler = campaign.runs / "filler"
    with filler.open("wb", buffering=0) as file, contextlib.suppress(OSError):
        while True:
            file.write(b"x" * (1 << 16))
    try:
        process.wait(LONGEST_S)
    finally:
        filler.unlink()
    return "until the run had ended"


def _cut_newest(campaign: Campaign, chance: random.Random) -> str:
    """Cut the newest restart file of the stage at a random byte."""
    found = []
    for name in RESTART_FILES:
        for path in campaign.case.glob(f"*.part/{name}"):
            with contextlib.suppress(NotWholeError, OSError):
                found.append(read_restart(path))
    if not found:
        return "there was no restart file yet"
    newest = max(found, key=lambda file: file.step).path
    size = newest.stat().st_size
    length = chance.randrange(size)
    os.truncate(newest, length)
    return f"{newest.name} cut to {length} of {size} bytes"


def _begin(campaign: Campaign, kind: str, chance: random.Random, screen: Path) -> psutil.Popen:
    """Start the command and wait for the moment of the kill."""
    process = campaign.start(screen)
    # Two thirds of the other kills also come while an engine runs.
    if kind in OF_ENGINE or chance.random() < 2 / 3:
        # Mostly while the mill turns: on a slow machine all would come while the charge settles.
        settling = chance.random() < 0.2
        _wait(
            process,
            lambda: _ranks(process) and (settling or _stage(campaign, process) == "rotate"),
        )
        time.sleep(chance.uniform(0.0, 6.0))
    else:
        time.sleep(chance.uniform(0.3, 8.0))
    if kind in OF_ENGINE:
        _wait(process, lambda: _ranks(process))
    elif kind == "SIGKILL snakemake":
        _wait(process, lambda: _named(process, "snakemake"))
    elif kind == "SIGKILL the stage":
        _wait(process, lambda: _at_work(campaign, process))
    return process


def _wait(process: psutil.Popen, ready) -> None:
    while process.poll() is None and not ready():
        time.sleep(0.01)


def kill_once(
    number: int, kind: str, campaign: Campaign, chance: random.Random, reference: Path
) -> Kill | None:
    """Start the campaign, kill it, wait for its end; None if it was done before."""
    screen = campaign.file.with_name(f"screen.{number}")
    begin, before = time.monotonic(), campaign.complete()
    process = _begin(campaign, kind, chance, screen)
    if process.poll() is not None:
        return None
    kill = Kill(
        number,
        kind,
        round(time.monotonic() - begin, 2),
        _stage(campaign, process),
        _last_step(campaign.series()),
    )
    struck = time.monotonic()
    try:
        kill.detail = strike(kind, campaign, process, chance)
    except (psutil.NoSuchProcess, IndexError):
        process.wait(LONGEST_S)
        return None
    kill.exit_code = process.wait(LONGEST_S)
    kill.ended_s = round(time.monotonic() - struck, 2)
    wait_until_free(campaign)
    kill.lock_free_s = round(time.monotonic() - struck, 2)
    kill.said = _what_failed(screen)
    kill.rows_compared, kill.rows_that_differ = _compare_rows(campaign.series(), reference)
    after = campaign.complete()
    kill.made_again = [name for name in before if after.get(name) != before[name]]
    kill.other_ranks_refused = campaign.refuses_other_ranks()
    return kill


def _what_failed(screen: Path) -> str:
    lines = [line for line in screen.read_text().splitlines() if "failed:" in line]
    return lines[-1].split("; see")[0].split("failed: ", 1)[-1] if lines else ""


def next_note(screen: Path) -> str:
    """Return the note of a run about a stage that had ended early."""
    words = ("goes on", "begins anew", "starts over", "complete before")
    for line in screen.read_text().splitlines():
        if line.startswith(f"{CASE}: ") and any(word in line for word in words):
            return line.removeprefix(f"{CASE}: ")
    return ""


def _compare_rows(series: Path, reference: Path) -> tuple[int, int]:
    rows, expected = _rows(series), _rows(reference)
    return len(rows), sum(a != b for a, b in zip(rows, expected, strict=False))


def differences(case: Path, reference: Path) -> dict:
    """Return how the finished case differs from the uninterrupted one: 0 and empty if equal."""
    with (case / "series.csv").open() as a, (reference / "series.csv").open() as b:
        mine, theirs = list(csv.DictReader(a)), list(csv.DictReader(b))
    largest = {
        name: max(
            (abs(float(x[name]) - float(y[name])) for x, y in zip(mine, theirs, strict=False)
             if x[name] != y[name]),
            default=0.0,
        )
        for name in theirs[0]
    }  # fmt: skip
    files = ["occupancy.csv", *(f"dump/{path.name}" for path in (reference / "dump").iterdir())]
    results = [json.loads((x / "result.json").read_text()) for x in (case, reference)]
    return {
        "series_rows": len(mine) - len(theirs),
        "series_largest": {name: value for name, value in largest.items() if value},
        "files_that_differ": [
            name for name in files if (case / name).read_bytes() != (reference / name).read_bytes()
        ],
        "dumps": len(list((case / "dump").iterdir())) - len(files) + 1,
        "results_that_differ": [
            name for name in results[1] if results[0][name] != results[1][name]
        ],
        "steps": [json.loads((x / "timing.json").read_text())["steps"] for x in (case, reference)],
    }


def run_to_the_end(campaign: Campaign, screen: Path) -> None:
    process = campaign.start(screen)
    if process.wait(LONGEST_S) != 0:
        raise RuntimeError(screen.read_text())


@contextlib.contextmanager
def small_disk(folder: Path) -> Iterator[None]:
    """Mount a small disk at a folder, if that is allowed."""
    folder.mkdir()
    line = ["mount", "-t", "tmpfs", "-o", f"size={TMPFS_BYTES}", "tmpfs", str(folder)]
    mounted = shutil.which("mount") and subprocess.run(line, capture_output=True).returncode == 0
    try:
        yield
    finally:
        # Lazily: what a failed test leaves running may still use it.
        if mounted:
            subprocess.run(["umount", "--lazy", str(folder)], check=True)


def kill_and_resume(folder: Path, kinds: list[str], seed: int, text: str, ranks: int = 2) -> dict:
    """Kill a campaign once in each of these ways and resume it; returns kills and differences.

    A campaign that comes to its end before the last kill is followed by another one.
    """
    file = folder / "small.toml"
    file.write_text(text)
    whole = Campaign(file, folder / "whole", ranks)
    begin = time.monotonic()
    run_to_the_end(whole, folder / "screen.whole")
    record = {"uninterrupted_s": round(time.monotonic() - begin, 1), "kills": [], "finished": []}
    chance, waiting = random.Random(seed), list(kinds)
    while waiting or not record["finished"]:
        place = folder / f"runs.{len(record['finished'])}"
        with small_disk(place):
            campaign = Campaign(file, place, ranks)
            kills = _kill_until_done(campaign, waiting, chance, whole.case / "series.csv")
            record["kills"] += [asdict(kill) for kill in kills]
            shown = differences(campaign.case, whole.case)
            attempts = json.loads((campaign.case / "timing.json").read_text())["attempts"]
            left = sorted(path.name for path in campaign.temporary.iterdir())
            shown |= {"left_in_temporary_folder": left}
            record["finished"].append({"kills": len(kills), "attempts": attempts, **shown})
    return record


def _kill_until_done(
    campaign: Campaign, waiting: list[str], chance: random.Random, reference: Path
) -> list[Kill]:
    """Kill in the ways that wait, taken off the list, until the campaign is done."""
    kills: list[Kill] = []
    while waiting:
        number = len(list(campaign.file.parent.glob("screen.[0-9]*")))
        kill = kill_once(number, waiting[0], campaign, chance, reference)
        _note_what_was_said(kills, campaign.file.with_name(f"screen.{number}"))
        if kill is None:
            break
        waiting.pop(0)
        kills.append(kill)
    screen = campaign.file.with_name(f"screen.{len(list(campaign.file.parent.glob('screen.*')))}")
    run_to_the_end(campaign, screen)
    _note_what_was_said(kills, screen)
    return kills


def _note_what_was_said(kills: list[Kill], screen: Path) -> None:
    """By the run after the last kill, and for kills after which a run ended before it spoke."""
    for kill in reversed(kills):
        if kill.next_said:
            return
        kill.next_said = next_note(screen)
        print(kill, flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--to", type=Path, help="file to write")
    options = parser.parse_args()
    ways = [*OF_ENGINE, *OF_WORKFLOW]
    kinds = [ways[i % len(ways)] for i in range(options.kills)]
    random.Random(options.seed).shuffle(kinds)
    with tempfile.TemporaryDirectory() as folder:
        text = campaign_text(rotation_angle=5.0, restart_angle=0.1, balls=500)
        record = kill_and_resume(Path(folder), kinds, options.seed, text)
    command = f"python tests/workflow/kill_resume.py --kills {options.kills}"
    origin = {
        "schema": 1,
        "command": f"{command} --seed {options.seed} --to {options.to}",
        "commit": described_commit(),
        "machine": hardware(),
        "date": datetime.date.today().isoformat(),
    }
    content = json.dumps(origin | record, indent=1) + "\n"
    if options.to:
        options.to.write_text(content)
    else:
        print(content)


if __name__ == "__main__":
    main()
