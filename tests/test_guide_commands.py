"""The commands of the guide on campaigns that come with millscale, as far as they are cheap.

Plans are made, runs are tried with --dry-run, and plans of studies are shown. Commands with FILE
stand for any campaign. `tests/test_docs.py` checks the options of all.
"""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest

from in_process import millscale
from page_blocks import blocks

ROOT = Path(__file__).parents[1]
GUIDE = sorted((ROOT / "docs/guide").glob("*.md"))
# Options that make a command cheap.
CHEAP = {"plan": [], "run": ["--dry-run"]}
# Where a command needs a cluster, or runs that are not there.
ELSEWHERE = ("--slurm", "--target", "--from")


def lines_of(page: str) -> list[str]:
    """Return the lines with `millscale` of the blocks of a page, without prompts."""
    text = "".join(block.text for block in blocks(page)).replace("\\\n", " ")
    lines = (line.strip().removeprefix("$ ") for line in text.splitlines())
    return [line for line in lines if line.startswith("millscale ")]


def found() -> list:
    commands = []
    for path in GUIDE:
        for line in lines_of(path.read_text(encoding="utf-8")):
            words = shlex.split(line, comments=True)[1:]
            campaigns = [word for word in words if word.startswith("campaigns/")]
            cheap = words[0] in CHEAP or (words[0] == "study" and "--plan" in words)
            if cheap and campaigns and not set(words).intersection(ELSEWHERE):
                commands.append(pytest.param(words, id=f"{path.stem}: {' '.join(words)}"))
    return commands


COMMANDS = found()


def test_the_guide_has_commands_to_try():
    assert len(COMMANDS) >= 5


@pytest.mark.parametrize("words", COMMANDS)
def test_a_command_of_the_guide_is_accepted(words, tmp_path, monkeypatch):
    (tmp_path / "campaigns").symlink_to(ROOT / "campaigns")
    monkeypatch.chdir(tmp_path)
    done = millscale(*words, *CHEAP.get(words[0], []))
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout
    assert [path.name for path in tmp_path.iterdir()] == ["campaigns"]


def test_the_plans_shown_in_the_guide_are_those_of_the_campaigns(monkeypatch):
    """Cores and times are those of a machine; mill, speed and charge are not."""
    monkeypatch.chdir(ROOT)
    compared = 0
    for path in GUIDE:
        for block in blocks(path.read_text(encoding="utf-8")):
            first, _, shown = block.text.partition("\n")
            if not first.startswith("$ millscale plan campaigns/"):
                continue
            printed = millscale(*shlex.split(first)[2:]).stdout
            lines = {" ".join(line.split()) for line in printed.splitlines()}
            for line in shown.splitlines():
                if line.split()[:1] in (["mill"], ["speed"], ["charge"]):
                    assert " ".join(line.split()) in lines
                    compared += 1
    assert compared >= 3


def test_the_line_that_installs_the_executor_of_slurm_is_the_pinned_one():
    import tomllib

    content = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    (pinned,) = content["project"]["optional-dependencies"]["slurm"]
    assert f"pip install {pinned} " in (ROOT / "docs/guide/slurm.md").read_text(encoding="utf-8")
