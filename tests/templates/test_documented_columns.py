"""The columns that the decks write are those that docs/reference/files.md describes."""

import re

import pytest

from paper_campaign import REPOSITORY
from reference_tables import documented

TEMPLATES = REPOSITORY / "templates"


def header(template):
    """Return the columns of the table that a deck writes."""
    text = (TEMPLATES / template).read_text(encoding="utf-8").replace("&\n", "")
    return next(quoted for quoted in re.findall(r'"([^"]*)"', text) if "step,time_s" in quoted)


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
