"""README.md, executed: its commands in their order, and the lines of output that it shows.

The campaign is quick.toml with the single balls as they are and a smaller charge, which takes
seconds. So numbers of single balls are compared, and of the charge the words.
"""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from in_process import millscale
from millscale.campaign.writer import toml_text
from page_blocks import PROMPT, Command, blocks, commands

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = blocks(PAGE)
NUMBER = re.compile(r"\d[\d,.]*")
pytestmark = pytest.mark.engine


@dataclass
class Session:
    """The folder in which the commands ran, and what each printed."""

    folder: Path
    printed: list[tuple[Command, str]] = field(default_factory=list)

    def of(self, words: str) -> tuple[Command, str]:
        (found,) = (pair for pair in self.printed if words in pair[0].line)
        return found


def smaller() -> str:
    campaign = tomllib.loads((ROOT / "campaigns/quick.toml").read_text(encoding="utf-8"))
    campaign["multi_ball"] |= {"slice_length_m": 0.1, "rotation_angle_rad": 3.0}
    return toml_text(campaign)


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    return run_page(tmp_path_factory.mktemp("readme"))


def run_page(folder: Path) -> Session:
    """Run all blocks that are to be run, in a folder; a line `. FILE` counts for the later ones."""
    made = Session(folder)
    (made.folder / "campaigns").mkdir()
    (made.folder / "campaigns/quick.toml").write_text(smaller(), encoding="utf-8")
    (made.folder / ".venv").symlink_to(sys.prefix)
    environment = os.environ | {"COLUMNS": "140"}
    run = [(block, command) for block in BLOCKS for command in to_run(block)]
    first = ""
    for block, command in run:
        line = ["bash", "-euc", first + command.line]
        if block.kind == "python":
            line = [sys.executable, "-c", command.line]
        done = subprocess.run(
            line, cwd=made.folder, env=environment, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, command.line + done.stdout + done.stderr
        made.printed.append((command, done.stdout))
        if command.line.startswith(". "):
            first += command.line + "\n"
    return made


def to_run(block):
    return [] if block.reason or block.kind == "text" else commands(block)


def words(line):
    """Return the words of a line of output, with a mark for each number and size."""
    return re.sub(r"# [kMG]B", "#", NUMBER.sub("#", line)).split()


def test_every_block_is_run_or_states_why_not():
    assert {block.kind for block in BLOCKS} <= {"bash", "console", "python"}
    assert all(len(block.reason.split()) > 3 for block in BLOCKS if block.reason)
    # No command hides in a block of another kind.
    for block in BLOCKS:
        assert block.kind == "console" or PROMPT not in block.text
    assert sum(bool(block.reason) for block in BLOCKS) <= 2


def test_the_lines_shown_are_lines_that_the_commands_print(session):
    compared = 0
    for command, printed in session.printed:
        lines = [words(line) for line in printed.splitlines()]
        for shown in command.shown:
            assert words(shown) in lines, f"{command.line}: {shown}\n{printed}"
            compared += 1
    assert compared >= 8


def test_the_plan_is_that_of_the_campaign(session):
    command, _ = session.of("millscale plan")
    printed = millscale("plan", ROOT / "campaigns/quick.toml").stdout
    lines = [" ".join(line.split()) for line in printed.splitlines()]
    for shown in command.shown[:3]:
        assert " ".join(shown.split()) in lines


def test_the_rows_of_single_balls_are_exact(session):
    command, printed = session.of("millscale status")
    lines = [" ".join(line.split()) for line in printed.splitlines()]
    for shown in (line for line in command.shown if line.startswith("sb-")):
        assert " ".join(shown.split()) in lines


def test_the_table_of_energies_is_that_of_the_report(session):
    results = json.loads((session.folder / "runs/quick/report/results.json").read_text())
    rows = {row["id"]: row for row in results["single_ball"]}
    table = re.findall(r"^\| (sb-\S+) \| ([\d.]+) \| ([\d.]+) \| ([+-][\d.]+) \|$", PAGE, re.M)
    assert len(table) == 4
    for name, energy, predicted, error in table:
        row = rows[name]
        assert float(energy) == pytest.approx(row["energy_ratio"], abs=2e-4)
        assert float(predicted) == pytest.approx(row["predicted_ratio"], abs=1e-4)
        assert float(error) == pytest.approx(100.0 * row["relative_error"], abs=0.02)


def test_the_lines_of_python_print_a_law_and_a_power(session):
    _, printed = session.of("import millscale as ms")
    assert printed.splitlines()[-1].endswith(" kW")
