"""Option of the fuzz tests: the file for their counts."""

import json
from pathlib import Path

import pytest
from attempts import FAULTS, Tally


def pytest_addoption(parser):
    parser.addoption(
        "--fuzz-results", type=Path, default=None, metavar="FILE", help="write fuzz.json there"
    )


@pytest.fixture(scope="session")
def tallies(request):
    """Counts by kind of input, written to the file of --fuzz-results at the end."""
    found: dict[str, Tally] = {}
    yield found
    to = request.config.getoption("--fuzz-results")
    if to is None:
        return
    from millscale.engine.record import provenance

    sums = {
        "inputs_tried": sum(x.inputs_tried for x in found.values()),
        **{name: sum(len(getattr(x, name)) for x in found.values()) for name in FAULTS},
    }
    record = {
        "schema": 1,
        **provenance(),
        "command": f"python -m pytest tests/fuzz -m validate --fuzz-results {to}",
        **sums,
        "kinds": {name: tally.record() for name, tally in sorted(found.items())},
    }
    to.write_text(json.dumps(record, indent=1) + "\n")
