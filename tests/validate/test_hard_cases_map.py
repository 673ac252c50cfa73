"""The committed map of hard cases: every case and path, and no end without a name."""

import json
from pathlib import Path

import pytest

from millscale.validate.cases import CASES
from millscale.validate.deck import BACKENDS
from millscale.validate.hard_cases_page import named
from millscale.validate.verdict import UNSTABLE

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(scope="module")
def document():
    return json.loads((DOCS / "results" / "hard-cases.json").read_text())


def test_the_map_holds_every_case_on_every_path(document):
    held = {(row["case"], row["path"]) for row in document["rows"]}
    assert held == {(case.name, path) for case in CASES for path in BACKENDS}
    assert held == {(turn["case"], turn["path"]) for turn in document["turns"]}


def test_no_run_crashed_or_lost_a_ball_without_a_name(document):
    for row in document["rows"]:
        assert row["lost"] == 0, row
        assert (row["verdict"] == UNSTABLE) == (row["stopped_by"] is not None), row
        assert row["stopped_by"] is None or named(row["stopped_by"]), row
