"""The columns that the decks write are those that docs/reference/files.md describes."""

import re

import pytest

from paper_campaign import REPOSITORY

REFERENCE = (REPOSITORY / "docs/reference/files.md").read_text(encoding="utf-8")
TEMPLATES = REPOSITORY / "templates"


def header(template):
    """Return the columns of the table that a deck writes."""
    text = (TEMPLATES / template).read_text(encoding="utf-8").replace("&\n", "")
    return next(quoted for quoted in re.findall(r'"([^"]*)"', text) if "step,time_s" in quoted)


def documented(title, number=0):
    """Return the names in the first column of a table of a section, in order."""
    section = REFERENCE.partition(f"\n## {title}\n")[2].partition("\n## ")[0]
    table = section.split("\n|---")[1 + number].partition("\n\n")[0].splitlines()[1:]
    return [name for row in table for name in row.split("|")[1].strip().split(", ")]


@pytest.mark.parametrize(
    ("template", "number"), [("single_ball_series.in", 0), ("charge_series.in", 1)]
)
def test_columns_of_series_are_documented_in_their_order(template, number):
    assert header(template).split(",") == documented("series.csv", number)


def test_columns_of_the_energy_budget_are_documented():
    names = documented("ledger.csv")
    pairings = ("ball_ball", "ball_wall")
    expanded = {re.sub("^P_", f"{pairing}_", name) for name in names for pairing in pairings}
    assert set(header("ledger_on.in").split(",")) == expanded


def test_columns_of_dumps_are_documented():
    text = (TEMPLATES / "dumps_on.in").read_text(encoding="utf-8").replace("&\n", "")
    columns = re.search(r"charge\.\*\.liggghts +(.*)", text)[1].split()
    assert columns == documented("dump/charge.STEP.liggghts")
