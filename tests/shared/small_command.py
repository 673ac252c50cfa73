"""The command line on a small campaign, with stand-ins for the engine and the analysis."""

import os
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import small_campaign
from in_process import millscale

STAND_IN = Path(__file__).with_name("stand_in")


@dataclass(frozen=True)
class Millscale:
    """`millscale` with one campaign file and runs folder."""

    file: Path
    runs: Path

    def environment(self, **more: str) -> dict[str, str]:
        path = [str(STAND_IN / "packages"), *filter(None, [os.environ.get("PYTHONPATH")])]
        engine = {"MILLSCALE_ENGINE": str(STAND_IN / "liggghts_mill")}
        return {**os.environ, **engine, "PYTHONPATH": os.pathsep.join(path), **more}

    def __call__(self, command: str, *arguments: str, **more: str) -> subprocess.CompletedProcess:
        """Run a command to its end, in this process: faster. `more` goes to its environment."""
        return millscale(*self.line(command), *arguments, **self.environment(**more))

    def start(self, command: str, *arguments: str, **more: str) -> subprocess.Popen:
        """Start a command as a shell's background job, which ignores Ctrl-C, and return."""
        return subprocess.Popen(
            [sys.executable, "-m", "millscale", *self.line(command), *arguments],
            env=self.environment(**more),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN),
        )

    def line(self, command: str) -> list[str]:
        if command in ("status", "report", "verify"):
            return [command, str(self.runs)]
        runs = [] if command == "plan" else ["--runs", str(self.runs)]
        return [command, str(self.file), *runs]

    def case(self, case_id: str) -> Path:
        return self.runs / "cases" / case_id

    def dates(self) -> dict[str, int]:
        """Time of the last change of every product and case.json, by path in the runs folder."""
        return {
            str(path.relative_to(self.runs)): path.stat().st_mtime_ns
            for path in self.runs.glob("cases/*/*")
            if path.suffix in (".json", ".csv", ".stl", ".vtp", ".in", ".data", ".restart")
            and path.name not in ("stage.json", "provenance.json")
        }


def small(folder: Path) -> Millscale:
    file = folder / "small.toml"
    file.write_text(small_campaign.TEXT)
    return Millscale(file, folder / "runs")
