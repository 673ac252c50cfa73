"""The tutorial, executed: its commands in order in an empty folder, and the numbers it shows."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

PAGE = (Path(__file__).parents[1] / "docs/tutorial.md").read_text()
BLOCK = re.compile(r"^```(sh|python|text)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"\d[\d,]*(?:\.\d+)?")


@pytest.fixture(scope="module")
def steps(tmp_path_factory):
    """Each block that is run, with what it printed and what the page shows of that."""
    folder = tmp_path_factory.mktemp("tutorial")
    bin_folder = Path(sys.executable).parent
    environment = os.environ | {"PATH": f"{bin_folder}:{os.environ['PATH']}", "COLUMNS": "140"}
    found = []
    for kind, text in BLOCK.findall(PAGE):
        if kind == "text":
            found[-1][2] = text
            continue
        line = [sys.executable, "-c", text] if kind == "python" else ["bash", "-euc", text]
        done = subprocess.run(
            line, cwd=folder, env=environment, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, text + done.stdout + done.stderr
        found.append([text, done.stdout, ""])
    return found


def numbers(text):
    return [float(number.replace(",", "")) for number in NUMBER.findall(text)]


def step(steps, words):
    (found,) = (s for s in steps if words in s[0])
    return found


def test_the_plan_is_the_one_shown(steps):
    _, printed, shown = step(steps, "millscale plan my-mill.toml")
    for line in shown.splitlines()[:3]:
        assert line in [one.rstrip() for one in printed.splitlines()]


def test_the_prediction_is_the_one_shown(steps):
    _, printed, shown = step(steps, "millscale predict")
    for line in shown.splitlines()[1:]:
        name = line.split("│")[1].strip()
        rows = [row for row in printed.splitlines() if row.startswith("│")]
        found = next(row for row in rows if row.split("│")[1].strip() == name)
        value, low, high = numbers(line)[:3]
        # Another compiler may round differently, which chance magnifies up to the interval.
        assert low < numbers(found)[0] < high
        assert value == pytest.approx(0.5 * (low + high), rel=0.01)


def test_the_power_in_python_is_that_of_the_prediction(steps):
    _, printed, shown = step(steps, "ms.open")
    assert [line.split()[0] for line in printed.splitlines()] == [
        line.split()[0] for line in shown.splitlines()
    ]
    for line, other in zip(printed.splitlines(), shown.splitlines(), strict=True):
        assert float(line.split()[1]) == pytest.approx(float(other.split()[1]), rel=0.02)


def test_the_worn_liner_is_planned(steps):
    _, printed, _ = step(steps, "worn.csv")
    assert "12 pitches" in printed
