"""The committed map of hard cases: every case and contact backend, and no unexplained end."""

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


def test_the_map_has_every_case_with_every_contact_backend(document):
    held = {(row["case"], row["path"]) for row in document["rows"]}
    assert held == {(case.name, backend) for case in CASES for backend in BACKENDS}
    assert held == {(turn["case"], turn["path"]) for turn in document["turns"]}


def test_no_run_crashed_or_lost_a_ball_without_a_name(document):
    for row in document["rows"]:
        assert row["lost"] == 0, row
        assert (row["verdict"] == UNSTABLE) == (row["stopped_by"] is not None), row
        assert row["stopped_by"] is None or named(row["stopped_by"]), row
