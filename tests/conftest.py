"""The fixture `contact_row`: a check of the contact law that is also a row of the published table.

    python -m pytest tests -m contact --contact-docs docs

runs every test that makes rows, slow ones too, and writes docs/results/contact-tests.json and
docs/results/contact-tests.md from them. Without the option the rows are only asserted. With
`--contact-keep` and -k a part of the tests is run anew.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from contact_table import excess, with_kept, write_contact_docs
from millscale.engine.environment import COMMAND_VARIABLE

pytest_plugins = ["analysis_fixtures", "campaign_fixtures"]

_COMMAND = "python -m pytest tests -m contact --contact-docs docs"
_ROWS = pytest.StashKey[list]()


def pytest_addoption(parser):
    parser.addoption("--contact-docs", type=Path, help="docs folder for the table of contact tests")
    parser.addoption(
        "--contact-keep", action="store_true", help="keep the table's rows of tests that do not run"
    )


@pytest.fixture(autouse=True)
def _no_command_of_another_test(monkeypatch):
    """A command that runs in this process is what provenance.json records of those it starts."""
    monkeypatch.setenv(COMMAND_VARIABLE, "")
    monkeypatch.delenv(COMMAND_VARIABLE)


def pytest_configure(config):
    config.stash[_ROWS] = []


def pytest_collection_modifyitems(items):
    for item in items:
        if "contact_row" in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.contact)


@pytest.fixture
def contact_row(request):
    """Function (test, path, wall, quantity, *, expected, got, tolerance, reason, ...) that asserts
    |got - expected| <= tolerance and keeps the row of the worst case.

    Args:
        path, wall: who evaluates the contacts; "-" where it does not matter.
        expected, got, tolerance: numbers or arrays that broadcast.
        reason: of the tolerance, from the time step or the precision.
        dt: time step [s]. at: names of the cases, one for each entry.
        fault: what is known to be wrong there; the row must then be off, and is if it still is.
    """
    rows = request.config.stash[_ROWS]

    def row(
        test,
        path,
        wall,
        quantity,
        *,
        expected,
        got,
        tolerance,
        reason,
        dt=None,
        at=None,
        fault=None,
    ):
        assert isinstance(path, str), f"a path is a word of the table, got {path!r}"
        arrays = np.broadcast_arrays(
            *(np.atleast_1d(x).astype(float) for x in (expected, got, tolerance))
        )
        error = np.abs(arrays[1] - arrays[0])
        worst = int(np.argmax([excess(*pair) for pair in zip(error, arrays[2], strict=True)]))
        fine = bool((error <= arrays[2]).all())
        rows.append(
            {
                "test": test,
                "path": path,
                "wall": wall,
                "dt_s": dt,
                "quantity": quantity,
                "at": None if at is None else str(at[worst]),
                "cases": len(error),
                **{
                    name: float(a[worst])
                    for name, a in zip(("expected", "got", "tolerance"), arrays, strict=True)
                },
                "error": float(error[worst]),
                "reason": fault if fault and not fine else reason,
                "verdict": "pass" if fine else "fault" if fault else "fail",
            }
        )
        if fault:
            assert not fine, f"{test}, {quantity}: the known fault is gone: {fault}"
            return
        shown = ", ".join(f"{k} {v}" for k, v in rows[-1].items() if k != "reason")
        assert fine, f"{shown}; the tolerance is of: {reason}"

    return row


def pytest_sessionfinish(session):
    docs = session.config.getoption("--contact-docs")
    if docs is not None:
        rows, command = session.config.stash[_ROWS], _COMMAND
        if session.config.getoption("--contact-keep"):
            rows, command = with_kept(docs, rows), f"{_COMMAND} --contact-keep"
        write_contact_docs(docs, rows, command)
