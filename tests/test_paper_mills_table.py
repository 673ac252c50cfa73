"""The tables of the paper's mills in reproduction.md are those of the stored results."""

import importlib.util
import json

import pytest

from paper_campaign import REPOSITORY

RESULTS = REPOSITORY / "docs/results"


@pytest.fixture(scope="module")
def printer():
    spec = importlib.util.spec_from_file_location("paper_mills", RESULTS / "paper_mills.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def stored():
    return json.loads((RESULTS / "paper-multi-ball.json").read_text(encoding="utf-8"))


def test_the_page_has_the_tables_of_the_stored_results(printer, stored):
    page = (RESULTS / "reproduction.md").read_text(encoding="utf-8").splitlines()
    for table in printer.tables(stored):
        assert len(table) > 4
        for line in table:
            assert line in page


def test_a_line_is_the_mean_over_the_seeds_of_a_mill(printer, stored):
    mill = [
        row
        for row in stored["rows"]
        if (row["campaign"], row["scheme"], row["S"])
        == ("paper-multi-ball", "constant-gravity", 2.6)
    ]
    assert len(mill) == 3
    errors = [100.0 * row["mean_over_angles"]["contour_error_mean"] for row in mill]
    line = next(
        line
        for line in printer.ladder(stored, "paper-multi-ball")
        if line.startswith("| constant gravity | 2.6 |")
    )
    shown = line.split("|")[7].strip()
    assert shown.startswith(f"{sum(errors) / 3:.2f}")


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [(0.314, 2, ".31"), (-0.001, 2, ".00"), (4.0, 1, "4.0"), (10.05, 1, "10.1"), (-0.52, 1, "-.5")],
)
def test_a_short_number(printer, value, digits, text):
    assert printer.short(value, digits) == text


def test_one_seed_and_equal_seeds_have_no_spread(printer):
    assert printer.with_spread([0.5], 2) == printer.with_spread([0.5, 0.5, 0.5], 2) == ".50"
    assert printer.with_spread([1.0, 2.0, 3.0], 1) == "2.0 ± 1.0"
    assert printer.with_spread([None], 1) == ""
