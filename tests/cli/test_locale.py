"""Every command under a locale without UTF-8, with names and texts that are not ASCII."""

import json
import subprocess
import sys

import pytest

from small_campaign import SINGLE_BALLS, TEXT
from small_command import Millscale

ASCII_ONLY = {"LC_ALL": "C", "LANG": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
ABOUT = "Kugelmühle – 粉砕"


@pytest.fixture
def command(tmp_path):
    file = tmp_path / "mühle.toml"
    text = TEXT.partition("[multi_ball]")[0].replace("\n\n[mill]", f'\nabout = "{ABOUT}"\n\n[mill]')
    file.write_text(text, encoding="utf-8")
    return Millscale(file, tmp_path / "läufe")


def run(command, *arguments):
    line = [sys.executable, "-m", "millscale", *command.line(arguments[0]), *arguments[1:]]
    environment = command.environment(**ASCII_ONLY)
    return subprocess.run(line, env=environment, capture_output=True)


def test_every_command_reads_writes_and_prints_without_utf8_in_the_locale(command):
    for arguments in (("plan",), ("plan", "--json"), ("generate",), ("run", "--dry-run"), ("run",)):
        done = run(command, *arguments)
        assert done.returncode == 0, done.stderr.decode()
    for arguments in (("status",), ("status", "--json"), ("verify",)):
        done = run(command, *arguments)
        assert done.returncode == 0, done.stderr.decode()
        done.stdout.decode("ascii")
    copy = (command.runs / "campaign.toml").read_bytes()
    assert copy == command.file.read_bytes()
    summary = json.loads((command.runs / "campaign.json").read_bytes())
    assert (summary["about"], summary["file"]) == (ABOUT, "mühle.toml")
    assert (command.case(SINGLE_BALLS[0]) / "result.json").exists()


def test_an_error_names_a_file_by_its_name(command):
    command.file.write_text(
        command.file.read_text(encoding="utf-8").replace("radius_m =", '"größe" =', 1), "utf-8"
    )
    done = run(command, "plan")
    # The radius is missing, and its key in German is not known.
    missing, unknown = done.stderr.splitlines()
    assert done.returncode == 2
    assert all(b"m\\xfchle.toml" in line for line in (missing, unknown))
    assert b"mill.radius_m: missing" in missing and b"gr\\xf6\\xdfe" in unknown
