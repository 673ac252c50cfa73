"""Results of docs/results whose power was sampled at single steps show none."""

import json
from pathlib import Path

import pytest

RESULTS = Path(__file__).parents[2] / "docs" / "results"
SAMPLED = {"power_W", "power_error", "power_dimensionless", "drive_torque_Nm", "power", "torque"}
WITHDRAWN = [
    file
    for file in sorted(RESULTS.glob("*.json"))
    if "withdrawn" in json.loads(file.read_text(encoding="utf-8"))
]


def words(value):
    """All keys of a document, and all texts that could name one."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield key
            yield from words(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from words(inner)
    elif isinstance(value, str):
        yield value


@pytest.mark.parametrize("file", WITHDRAWN, ids=lambda file: file.name)
def test_a_file_that_withdraws_its_power_holds_none(file):
    assert not SAMPLED & set(words(json.loads(file.read_text(encoding="utf-8"))))
