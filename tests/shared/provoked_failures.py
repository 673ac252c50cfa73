"""Provokes every kind of failure with the real engine and notes what millscale says of it.

python tests/shared/provoked_failures.py --to docs/results/failures.json

Needs the engine (MILLSCALE_ENGINE or the PATH), and for the full disk `unshare` and the right to
mount in a name space of its own. Each failure has a copy of a small campaign for itself.
"""

import argparse
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import psutil

import small_campaign
from millscale.engine.deck_run import find_engine
from millscale.engine.environment import TIME_LIMIT_VARIABLE
from millscale.engine.record import provenance
from millscale.runs.digests import digest_of
from millscale.runs.layout import CAMPAIGN_FILE, CASE_FILE
from millscale.runs.provenance import read_provenance, write_provenance
from millscale.workflow.display import problems
from millscale.workflow.failures import KINDS, UNKNOWN
from millscale.workflow.status import campaign_status

BALL, CHARGE = small_campaign.SINGLE_BALLS[0], small_campaign.CHARGE
# A kill for want of memory needs a memory limit, which a test may not set: the system's count of
# such kills is raised by hand instead, and the rank is killed as the system would.
COUNTED_KILL = """
import sys
from itertools import count
from pathlib import Path
from millscale.workflow import failures
from millscale.workflow.run_stage import run_stage
failures.memory_kills = count().__next__
sys.exit(run_stage(Path(sys.argv[2]), sys.argv[1]))
"""


@dataclass(frozen=True)
class Scene:
    """Runs folder with one case that is about to fail."""

    runs: Path
    case: Path
    stage: str

    def edit(self, name: str, pattern: str, by: str) -> None:
        """Damage a file as if its stage had made it so: its digest would be refused first."""
        file = self.case / name
        text, edits = re.subn(pattern, by, file.read_text(), flags=re.M)
        assert edits, f"{name} has no {pattern}"
        file.write_text(text)
        stages = read_provenance(self.case)
        for stage in stages.values():
            for part in ("inputs", "products"):
                if name in stage[part]:
                    stage[part][name] = digest_of(file)
        write_provenance(self.case, stages)
        if name == CASE_FILE:
            # Otherwise the case would count as one that the campaign has changed since.
            file = self.runs / CAMPAIGN_FILE
            summary = json.loads(file.read_text()) | {"digests": {}}
            file.write_text(json.dumps(summary))

    def set(self, variable: str, value: str) -> None:
        self.edit(
            "parameters.in",
            rf"^variable {variable} string .*",
            f"variable {variable} string {value}",
        )

    def start(self, *python: str, **more: str) -> subprocess.Popen:
        module = python or ("-m", "millscale.workflow.run_stage")
        return subprocess.Popen(
            [sys.executable, *module, self.stage, str(self.case)],
            env={**os.environ, **more},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )

    def run(self, **more: str) -> None:
        self.start(**more).communicate(timeout=120)

    def long(self) -> None:
        """Make the rotation take an hour."""
        self.set("rotation_steps", "900000000")

    def engine(self, process: subprocess.Popen) -> psutil.Process:
        """The engine's first rank, once it has written something."""
        series = self.case / f"{self.stage}.part" / "series.csv"
        deadline = time.monotonic() + 60.0
        while not (series.exists() and series.stat().st_size > 1000):
            assert time.monotonic() < deadline and process.poll() is None, process.stderr
            time.sleep(0.05)
        children = psutil.Process(process.pid).children(recursive=True)
        return next(x for x in children if x.name() == find_engine().name)


def nan(scene: Scene) -> None:
    scene.set("youngs_moduli", '"1e300 1e300"')  # balls and liner
    scene.run()


def beyond_all_bounds(scene: Scene) -> None:
    scene.set("time_step", "1e-3")
    scene.run()


def overlap(scene: Scene) -> None:
    scene.set("youngs_moduli", '"2e4 2e4"')  # balls and liner
    scene.set("soft_particles", "yes")
    scene.run()


def lost_ball(scene: Scene) -> None:
    scene.set("youngs_moduli", '"1e11 1e11"')  # balls and liner
    scene.set("hard_particles", "yes")
    scene.run()


def mesh_error(scene: Scene) -> None:
    mesh = ("mesh", "variable liner_file string liner.stl", "variable curvature_deg string 2.0")
    scene.set("wall", r"\n".join(mesh))
    scene.edit("liner.stl", r"\A((?:.*\n){99})(?:.*\n){5}", r"\1")
    scene.run()


def missing_library(scene: Scene) -> None:
    """A gmsh that cannot load, as on a machine without the libraries it links to."""
    packages = scene.runs / "packages"
    packages.mkdir()
    said = "libGLU.so.1: cannot open shared object file: No such file or directory"
    (packages / "gmsh.py").write_text(f"raise OSError({said!r})\n")
    scene.edit("case.json", '"kind": "analytic"', '"kind": "mesh", "curvature_deg": 2.0')
    scene.run(PYTHONPATH=str(packages))


def does_not_fit(scene: Scene) -> None:
    widths = r"lifter_top_width \S+ groove_width [^\s\"]+"
    scene.edit("parameters.in", widths, "lifter_top_width 0.3 groove_width 0.035")
    scene.run()


def hangs(scene: Scene) -> None:
    scene.set("settle_steps", "20")
    scene.run()


def damaged_file(scene: Scene) -> None:
    replace(scene, stage="rotate").run()
    scene.edit("series.csv", r"\A((?:.*\n){99}.{99}).*\n(?:.*\n)*\Z", r"\1")
    scene.run()


def no_memory(scene: Scene) -> None:
    scene.edit("charge.data", r"^.* ([xz])lo ([xz])hi", r"-60 60 \1lo \2hi")
    wrapper = scene.runs / "engine"
    wrapper.write_text(f'#!/bin/sh\nulimit -v 1200000\nexec {find_engine()} "$@"\n')
    wrapper.chmod(0o755)
    scene.run(MILLSCALE_ENGINE=str(wrapper))


def no_session(scene: Scene) -> None:
    scene.run(OMPI_MCA_orte_tmpdir_base="/proc/none")


def killed_for_memory(scene: Scene) -> None:
    scene.long()
    process = scene.start("-c", COUNTED_KILL)
    scene.engine(process).send_signal(signal.SIGKILL)
    process.communicate(timeout=60)


def disk_full(scene: Scene) -> None:
    """The case on a file system of its own, of which 100 KiB are left."""
    script = (
        'set -e; mount -t tmpfs -o size=800k none "$2"; cp -a "$1"/. "$2"; '
        "free=$(df -k --output=avail $2 | tail -1); "
        'dd if=/dev/zero of="$2/filler" bs=1k count=$((free - 100)) status=none; '
        '"$3" -m millscale.workflow.run_stage rotate "$2" 2>&1 || true; '
        'rm "$2/filler"; cp -a "$2"/stage.json "$2"/out.rotate "$1"'
    )
    disk = scene.runs / "disk"
    disk.mkdir()
    done = subprocess.run(
        ["unshare", "-rm", "sh", "-c", script, "sh", scene.case, disk, sys.executable],
        capture_output=True,
        text=True,
        timeout=120,
    )
    if "unshare" in done.stderr or "mount:" in done.stderr:
        raise PermissionError(done.stderr.strip())


def time_out(scene: Scene) -> None:
    scene.long()
    scene.run(**{TIME_LIMIT_VARIABLE: "3"})


def series_from_elsewhere(scene: Scene) -> None:
    (scene.case / "series.csv").write_text("step,time_s\n1,0.1\n")
    scene.run()


def wrong_deck(scene: Scene) -> None:
    scene.edit("integrate.in", "nve/sphere", "nve/spear")
    scene.run()


def killed_rank(scene: Scene) -> None:
    scene.long()
    process = scene.start()
    scene.engine(process).send_signal(signal.SIGKILL)
    process.communicate(timeout=60)


def killed_stage(scene: Scene) -> None:
    scene.long()
    process = scene.start()
    rank = scene.engine(process)
    process.kill()
    process.communicate(timeout=60)
    _end(rank)


def crash(scene: Scene) -> None:
    scene.long()
    process = scene.start()
    scene.engine(process).send_signal(signal.SIGSEGV)
    process.communicate(timeout=60)


def no_progress(scene: Scene) -> None:
    """A rank that hangs; looked at while it does, so the caller's look comes too late."""
    scene.long()
    process = scene.start()
    rank = scene.engine(process)
    rank.suspend()
    time.sleep(2.0)
    (scene.runs / "seen.txt").write_text("\n".join(said(scene, silence=1.0)))
    rank.resume()
    process.terminate()
    process.communicate(timeout=60)


def _end(rank: psutil.Process) -> None:
    for x in (*rank.parents()[:1], rank):
        if x.name() in ("mpirun", find_engine().name):
            x.kill()
    psutil.wait_procs([rank], timeout=30)


@dataclass(frozen=True)
class Provocation:
    """How a failure is brought about, the kind it must be taken for, words of the advice given."""

    kind: str
    case: str
    stage: str
    how: str
    act: Callable[[Scene], None]
    advice: str = ""


_STIFF = "Young's modulus of 1e11 Pa, step as before"
_COUNTED = "rank killed by signal 9, count of kills for memory raised by hand"
_PLAN = "millscale plan FILE"
PROVOCATIONS = (
    Provocation("nan", BALL, "rotate", "Young's modulus of 1e300 Pa", nan, "in their order"),
    Provocation(
        "lost ball", BALL, "rotate", "time step ten times too long", beyond_all_bounds, _PLAN
    ),
    Provocation("overlap too large", CHARGE, "settle", "Young's modulus of 2e4 Pa", overlap, _PLAN),
    Provocation("lost ball", CHARGE, "settle", _STIFF, lost_ball, "in their order"),
    Provocation(
        "not settled", CHARGE, "settle", "settling for 20 steps", hangs, "increase settle_s"
    ),
    Provocation(
        "does not fit", BALL, "rotate", "grooves of 35 mm", does_not_fit, "a smaller S or wider"
    ),
    Provocation(
        "missing library", BALL, "mesh", "gmsh without libGLU", missing_library, "libglu1-mesa"
    ),
    Provocation(
        "mesh error", BALL, "rotate", "five lines cut out of liner.stl", mesh_error, "liner.stl"
    ),
    Provocation("damaged file", BALL, "result", "series.csv cut in a row", damaged_file, "delete"),
    Provocation(
        "out of memory", CHARGE, "settle", "box of 120 m, ulimit -v 1.2 GB", no_memory, "--jobs"
    ),
    Provocation(
        "mpi does not start", BALL, "rotate", "no folder for its session", no_session, "TMPDIR"
    ),
    Provocation("out of memory", BALL, "rotate", _COUNTED, killed_for_memory, "--jobs"),
    Provocation(
        "disk full", BALL, "rotate", "100 KiB left on a file system of its own", disk_full, "free"
    ),
    Provocation(
        "time out", BALL, "rotate", "a rotation of hours, time limit 3 s", time_out, "--time-limit"
    ),
    Provocation("wrong deck", BALL, "rotate", "a fix that does not exist", wrong_deck, "*.in"),
    Provocation(
        "killed", BALL, "rotate", "rank killed by signal 9", killed_rank, "repeat the command"
    ),
    Provocation(
        "killed", BALL, "rotate", "stage killed by signal 9", killed_stage, "repeat the command"
    ),
    Provocation("crash", BALL, "rotate", "rank ended by signal 11", crash, "report it"),
    Provocation(
        "by hand", BALL, "rotate", "a series from elsewhere", series_from_elsewhere, "move"
    ),
    Provocation(
        "no progress", BALL, "rotate", "rank stopped, silence of 1 s allowed", no_progress, "top"
    ),
)


def said(scene: Scene, silence: float = 600.0) -> list[str]:
    """The lines of `millscale status` about the case."""
    statuses = [x for x in campaign_status(scene.runs, silence) if x.id == scene.case.name]
    return [line.replace(f"{scene.runs}/", "") for line in problems(scene.runs, statuses)]


def prepared(folder: Path) -> Path:
    """A runs folder whose cases are ready for the engine."""
    file, runs = folder / "small.toml", folder / "ready"
    file.write_text(small_campaign.TEXT)
    subprocess.run(
        [sys.executable, "-m", "millscale", "generate", file, "--runs", runs],
        check=True, stdout=subprocess.DEVNULL,
    )  # fmt: skip
    for case, stages in ((BALL, ("mesh", "deck")), (CHARGE, ("mesh", "charge", "deck"))):
        for stage in stages:
            line = [
                sys.executable,
                "-m",
                "millscale.workflow.run_stage",
                stage,
                runs / "cases" / case,
            ]
            subprocess.run(line, check=True)
    return runs


def provoke(it: Provocation, ready: Path, folder: Path) -> list[str]:
    """What millscale says of a failure.

    Args:
        ready: as of `prepared`.
        folder: to work in; made.

    Raises:
        PermissionError: this machine does not let it happen.
    """
    shutil.copytree(ready, folder)
    scene = Scene(folder, folder / "cases" / it.case, it.stage)
    it.act(scene)
    seen = folder / "seen.txt"
    return seen.read_text().splitlines() if seen.exists() else said(scene)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--to", type=Path, required=True, metavar="FILE")
    options = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as name:
        ready = prepared(Path(name))
        for number, it in enumerate(PROVOCATIONS):
            lines = provoke(it, ready, Path(name) / f"runs-{number}")
            recognised = bool(lines) and f": {it.kind}: " in lines[0]
            rows.append(
                {"kind": it.kind, "how": it.how, "recognised": recognised, "printed": lines}
            )
            print(
                f"{it.kind} ({it.how}): {'recognised' if recognised else 'NOT RECOGNISED'}",
                flush=True,
            )
    kinds = sorted({row["kind"] for row in rows})
    record = {
        "schema": 1,
        **provenance(),
        "command": f"python tests/shared/provoked_failures.py --to {options.to}",
        "kinds_provoked": kinds,
        "kinds_not_provoked": sorted(set(KINDS) - set(kinds) - {UNKNOWN}),
        "recognised": sum(row["recognised"] for row in rows),
        "provoked": len(rows),
        "failures": rows,
    }
    options.to.write_text(json.dumps(record, indent=1) + "\n")
    return 0 if all(row["recognised"] for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
