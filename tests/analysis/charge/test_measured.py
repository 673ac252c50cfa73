"""Charges measured in pairs: which dumps count."""

from dataclasses import dataclass

import pytest

from millscale.analysis.charge import measured as module
from millscale.analysis.charge.measured import _pair_errors, measure
from millscale.analysis.charge.pair_errors import errors_of_dumps
from millscale.analysis.finished import Charge
from millscale.analysis.finished_campaign import load_campaign
from millscale.analysis.measures import NUMBERS, QUANTITIES, Taken
from millscale.runs.case_folder import load_finished
from millscale.runs.dumps import read_dump
from synthetic_case import finish_case
from synthetic_charge import write_charge
from synthetic_result import with_result


@dataclass(frozen=True)
class Steady:
    """A charge that is steady from a mill angle on [rad], and has no other numbers."""

    steady_from: float

    def has(self, column):
        return False

    @property
    def result(self):
        return self

    @property
    def dimensionless(self):
        return {}

    mean = dimensionless


def test_a_number_of_dumps_is_compared_over_the_steady_angles_that_both_have():
    ours, theirs = Steady(1.0), Steady(0.5)
    angles = {
        (ours, "throw_angle_rad"): {0.5: 9.0, 1.0: 1.16, 2.0: 1.36, 3.0: 9.0},
        (theirs, "throw_angle_rad"): {0.5: 9.0, 1.0: 1.1, 2.0: 1.3, 4.0: 9.0},
    }
    errors = _pair_errors((ours, theirs), {}, angles)
    # Means over 1 and 2 rad: 1.26 and 1.2 rad.
    assert errors.values["detach_angle_error"] == pytest.approx(0.05)
    angles[ours, "throw_angle_rad"] = {0.5: 9.0}
    assert _pair_errors((ours, theirs), {}, angles).values["detach_angle_error"] is None


def test_errors_of_dumps_are_those_of_the_last_and_means_over_the_steady_ones():
    none = errors_of_dumps(Nothing(), Nothing())
    dumps = {a: none | {"contour_error_mean": a, "contour_error_max": None} for a in (0.5, 1, 2)}
    errors = _pair_errors((Steady(0.7), Steady(0.9)), dumps, {})
    assert errors.values["contour_error_mean"] == 2
    assert errors.steady("contour_error_mean") == 1.5
    assert errors.steady("contour_error_max") is None
    content = errors.document()
    assert content["mill_angle_rad"] == 2
    steady = content["mean_over_angles"]
    assert (steady["from_rad"], steady["angles"]) == (1, 2)


class Nothing:
    """A shape without contour and curtains."""

    contour = type("contour", (), {"lines": []})
    curtains = None


def test_every_quantity_that_is_compared_has_a_mean_to_show_or_errors():
    numbers = {quantity.name for quantity in NUMBERS}
    for quantity in QUANTITIES:
        assert quantity.name in numbers or quantity.errors
        assert quantity.is_number or quantity.taken is not Taken.AVERAGED


def test_dumps_before_the_steady_part_are_read_only_if_they_are_drawn_or_compared(
    runs, monkeypatch
):
    charges = [with_result(x, mean_from_rad=0.7) for x in load_campaign(runs).charges]
    read = []

    def noted(path):
        read.append(path)
        return read_dump(path)

    monkeypatch.setattr(module, "read_dump", noted)
    monkeypatch.setattr(module, "forked", lambda work, items: [work(x) for x in items])
    monkeypatch.setattr(module, "SHAPES_KEPT", 1)  # the last angle, 1 rad
    whole = measure(charges, [tuple(charges)])
    assert len(read) == 2 and list(whole.shapes) == [pytest.approx(1.0)]
    monkeypatch.setattr(module, "SHAPES_KEPT", 4)  # both angles
    measured = measure(charges, [tuple(charges)])
    assert len(read) == 2 + 4
    assert measured.numbers == whole.numbers
    assert measured.errors[tuple(charges)] == whole.errors[tuple(charges)]


def test_missing_dumps_are_one_problem_and_leave_other_numbers(tmp_path):
    folder = write_charge(tmp_path, "constant-gravity")
    for path in (folder / "dump").iterdir():
        path.unlink()
    finish_case(folder)
    charge = Charge(load_finished(folder), "synthetic")
    measured = measure([charge], [])
    (problem,) = measured.problems[charge]
    assert "no dumps" in str(problem)
    assert measured.numbers[charge]["mixing_index"] is None
    assert measured.numbers[charge]["centre_x"] == pytest.approx(-0.37)
