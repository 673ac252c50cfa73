"""The index of the results: every page, with the dates of measurement that the page states."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[1] / "docs/results"


@pytest.fixture(scope="module")
def dates():
    spec = importlib.util.spec_from_file_location("dates", FOLDER / "dates.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_index_has_the_dates_of_its_pages(dates):
    index = dates.INDEX.read_text(encoding="utf-8")
    assert dates.dated(index) == index, "run docs/results/dates.py"
    pages = {path.name for path in FOLDER.glob("*.md")} - {"README.md"}
    assert {found["page"] for found in dates.ROW.finditer(index)} == pages


def test_every_page_states_when_it_was_measured(dates):
    pages = sorted(FOLDER.glob("*.md"))
    without = [path.name for path in pages if dates.measured(path.name) == "not stated"]
    assert without == []


def test_a_date_before_which_something_was_measured_does_not_count(dates, tmp_path, monkeypatch):
    monkeypatch.setattr(dates, "FOLDER", tmp_path)
    (tmp_path / "a.md").write_text("Run on 2026-01-02 and 2026-01-01, not before 2025-12-31.")
    assert dates.measured("a.md") == "2026-01-01 to 2026-01-02"
    (tmp_path / "b.md").write_text("Run before 2026-01-02.")
    assert dates.measured("b.md") == "not stated"
