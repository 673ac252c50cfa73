"""Rows of torque by case and seed, and the error of samples at single steps."""

import numpy as np
import pytest

from millscale.analysis.finished_campaign import load_campaign
from millscale.validate.sampling import QUANTITIES, by_parity, torque_of
from millscale.validate.torque import of_seeds, page, rows_of
from synthetic_case import case_document, finish_case, typed, write_campaign
from synthetic_charge import charge_columns, write_charge


def series(steps=60):
    step = np.arange(1, steps + 1)
    columns = {name: np.full(steps, 2.0) for name in QUANTITIES}
    columns["drive_torque_Nm"] = np.where(step % 2 == 0, 3.0, 2.0)
    columns["largest_overlap_m"] = np.where(step % 10 == 3, 5.0, 1.0)
    return {"step": step, **columns}


def test_a_quantity_that_alternates_differs_between_even_and_odd_steps():
    found = by_parity(series(), 10)
    assert found["drive_torque_Nm"]["alternating"] == 0.5
    assert (found["drive_torque_Nm"]["even"], found["drive_torque_Nm"]["odd"]) == (3.0, 2.0)
    assert found["centre_x_m"]["alternating"] == 0.0


def test_rows_show_less_of_a_largest_value_than_there_was():
    found = by_parity(series(), 10)["largest_overlap_m"]
    assert (found["mean_of_rows"], found["largest_of_rows"]) == (1.0, 1.0)
    assert (found["mean_of_largest"], found["largest"]) == (5.0, 5.0)


@pytest.fixture
def row():
    return {"S": 2.6, "step_s": 2e-4, "wall_damping": "bounded", "seed": 1, "torque": 0.37}


def test_seeds_are_taken_together_and_other_settings_are_not(row):
    rows = [row, row | {"seed": 2, "torque": 0.39}, row | {"step_s": 1e-4, "torque": 0.5}]
    (found,) = of_seeds(rows)
    assert (found["seeds"], found["step_s"]) == (2, 2e-4)
    assert found["torque"] == pytest.approx(0.38)
    assert found["deviation"] == pytest.approx(0.01 * np.sqrt(2.0))


def test_the_page_has_a_line_for_each_charge(tmp_path):
    folders = [write_charge(tmp_path, scheme) for scheme in ("constant-gravity", "constant-speed")]
    for folder in folders:
        finish_case(folder)
    write_campaign(tmp_path, [folder.name for folder in folders])
    rows = list(rows_of(load_campaign(tmp_path).charges))
    assert [abs(row["difference"]) < 1e-6 for row in rows] == [True, True]
    about = {"command": "c", "commit": "abc", "machine": {"cpu": "x"}, "date": "2026-11-30"}
    torque = {"summed": 0.37, "by_weight_and_momentum": 0.369, "difference": 0.001}
    found = {"S": 2.6, "step_s": 2e-4, "steps": 60, "sample_steps": 10, "torque": torque}
    found["quantities"] = by_parity(series(), 10)
    text = page({"rows": rows, "seeds": of_seeds(rows), **about}, {"cases": [found]})
    assert text.count("| 2.6 |") == len(rows) + len(of_seeds(rows)) + len(QUANTITIES) + 3
    assert "| 2.6 | 0.0002 | drive_torque_Nm | 3 | 2 | 2.0e-01 |" in text


def test_the_torque_of_a_stretch_is_found_by_both_ways():
    case = case_document("multi-ball", "constant-gravity", "paper", 2.6, balls=150)
    found = torque_of(charge_columns(case, end=8.0), typed(case))
    assert found["summed"] == pytest.approx(0.37, rel=1e-9)
    assert abs(found["difference"]) < 1e-9
