"""The command line on a small campaign, with stand-ins for the engine and the analysis."""

import io
import os
import signal
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from unittest.mock import patch

import pytest

import small_campaign
from millscale.cli.main import main

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
        line = [*self.line(command), *arguments]
        output, errors = io.StringIO(), io.StringIO()
        with (
            patch.dict(os.environ, self.environment(**more)),
            patch.object(sys, "argv", ["millscale", *line]),
            redirect_stdout(output),
            redirect_stderr(errors),
            pytest.raises(SystemExit) as ended,
        ):
            main()
        code = ended.value.code or 0
        return subprocess.CompletedProcess(line, code, output.getvalue(), errors.getvalue())

    def start(self, command: str, *arguments: str, **more: str) -> subprocess.Popen:
        """Start a command as a shell's background job, which ignores Ctrl-C, and return."""
        return subprocess.Popen(
            [sys.executable, "-m", "millscale.cli.main", *self.line(command), *arguments],
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
