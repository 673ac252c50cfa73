"""The front, the recommendations and ours against stock, on made-up rows."""

import json
import math
from dataclasses import asdict, replace

import pytest

from millscale.analysis.measures import STUDIED
from millscale.study import pareto
from synthetic_rows import error, row


def labels(rows):
    return [found.label for found in rows]


KNOWN = [row("a", 1.0, 0.10), row("b", 2.0, 0.03), row("c", 3.0, 0.05), row("d", 9.0, 0.01)]


@pytest.mark.parametrize("name", ["contour", pareto.WORST])
def test_the_front_is_what_nothing_beats_in_time_and_error(name):
    assert labels(pareto.front(KNOWN[::-1], name)) == ["a", "b", "d"]
    naive = [
        one.label
        for one in KNOWN
        if not any(
            other.time_s < one.time_s
            and other.errors["contour"].error < one.errors["contour"].error
            for other in KNOWN
        )
    ]
    assert labels(pareto.front(KNOWN, name)) == naive


def test_equal_settings_are_on_the_front_together_and_dearer_ones_of_equal_error_are_not():
    rows = [row("a", 1.0, 0.05), row("twin", 1.0, 0.05), row("dear", 2.0, 0.05)]
    assert labels(pareto.front(rows, "power")) == ["a", "twin"]


def test_one_setting_is_the_front_and_none_is_no_front():
    assert labels(pareto.front([row("a", 1.0, 0.5)], "power")) == ["a"]
    assert pareto.front([], "power") == []
    assert pareto.recommendations([]) != []
    assert pareto.time_to_solution([]) == []


def test_luck_within_the_spread_puts_nothing_on_the_front():
    rows = [row("cheap", 1.0, 0.008, 0.01), row("lucky", 5.0, 0.0, 0.01)]
    assert labels(pareto.front(rows, "contour")) == ["cheap"]
    assert rows[1].resolved("contour") == 0.01


@pytest.mark.parametrize("missing", [None, math.nan])
def test_a_missing_error_leaves_a_setting_out_of_that_front_and_of_the_worst(missing):
    rows = [row("a", 2.0, 0.05)]
    errors = {name: error(0.01) for name in STUDIED} | {"curtain": error(missing)}
    holed = row("holed", 1.0, 0.01, errors=errors)
    rows.append(holed)
    assert holed.worst is None
    assert labels(pareto.front(rows, "curtain")) == ["a"]
    assert labels(pareto.front(rows, "power")) == ["holed"]
    assert labels(pareto.front(rows, pareto.WORST)) == ["a"]
    found = {(r.error, r.wanted): r for r in pareto.recommendations(rows)}
    assert found["power", 0.01].setting == "holed"
    assert found[pareto.WORST, 0.10].setting == "a"
    json.dumps([asdict(r) for r in found.values()], allow_nan=False)


def test_an_error_of_no_row_does_not_count():
    rows = [
        row("a", 1.0, 0.02, errors={n: error(None if n == "curtain" else 0.02) for n in STUDIED})
    ]
    known = pareto.known_errors(rows)
    assert "curtain" not in known
    rows = [replace(rows[0], worst=pareto.worst_of(rows[0].errors, known))]
    assert pareto.recommendations(rows)[-1].setting == "a"


def test_the_cheapest_setting_whose_error_plus_spread_is_no_more_is_recommended():
    rows = [*KNOWN, row("nearly", 1.5, 0.025, 0.006)]
    found = {(r.error, r.wanted): r for r in pareto.recommendations(rows)}
    assert [found["contour", share].setting for share in pareto.WANTED] == ["d", "b", "a"]
    assert found[pareto.WORST, 0.03].setting == "b"
    assert found["contour", 0.03].bound == 0.03
    # Every kind of error counts for the worst, not the largest alone.
    errors = {name: error(0.025) for name in STUDIED} | {"power": error(0.02, 0.02)}
    spoiled = row("spoiled", 1.0, 0.0, errors=errors)
    found = {(r.error, r.wanted): r for r in pareto.recommendations([spoiled])}
    assert found[pareto.WORST, 0.03].setting is None
    assert found[pareto.WORST, 0.10].bound == 0.04


def test_if_none_is_good_enough_the_nearest_is_named():
    found = pareto.recommendations([row("a", 1.0, 0.2), row("b", 9.0, 0.15, 0.01)])
    assert {r.setting for r in found} == {None}
    assert {r.nearest for r in found} == {"b"}
    assert found[0].nearest_bound == pytest.approx(0.16)


def test_a_reference_is_neither_on_the_front_nor_recommended():
    truth = row("truth", 0.5, 0.0, is_reference=True)
    assert labels(pareto.front([truth, *KNOWN], "contour")) == ["a", "b", "d"]
    assert "truth" not in {r.setting for r in pareto.recommendations([truth, *KNOWN])}


def test_the_default_is_compared_with_the_cheapest_stock_setting_as_good():
    rows = [
        row("ours", 2.0, 0.03, is_default=True),
        row("coarse", 6.0, 0.08, engine="stock"),
        row("good", 20.0, 0.03, engine="stock"),
        row("dear", 60.0, 0.01, engine="stock"),
    ]
    found = pareto.time_to_solution(rows)
    assert [r.error for r in found] == [*STUDIED, pareto.WORST]
    assert {r.stock for r in found} == {"good"}
    assert {r.ratio for r in found} == {10.0}
    # Both times scatter by a tenth.
    assert found[0].ratio_spread == pytest.approx(10.0 * math.sqrt(0.02))
    assert found[0].at_least is None


def test_what_chance_adds_to_stock_is_not_held_against_it():
    rows = [
        row("ours", 2.0, 0.0, 0.01, is_default=True),
        row("one-seed", 8.0, 0.009, 0.02, engine="stock"),
    ]
    assert pareto.time_to_solution(rows)[0].ratio == 4.0


def test_stock_must_be_as_good_in_every_error_to_be_as_good_in_all():
    errors = {name: error(0.03) for name in STUDIED}
    ours = row("ours", 1.0, 0.0, is_default=True, errors=errors | {"power": error(0.05)})
    # Its worst is smaller than ours, but not all of its errors are.
    stock = row("stock", 5.0, 0.0, engine="stock", errors=errors | {"curtain": error(0.04)})
    found = {r.error: r for r in pareto.time_to_solution([ours, stock])}
    assert found["contour"].ratio == found["power"].ratio == 5.0
    assert found["curtain"].ratio is None
    assert found[pareto.WORST].ratio is None
    assert found[pareto.WORST].at_least == 5.0
    assert found[pareto.WORST].best_stock == "stock"
    assert found[pareto.WORST].best_stock_error == 0.04
