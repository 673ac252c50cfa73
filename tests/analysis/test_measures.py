"""The table of measured quantities: names, comparisons, text."""

from types import SimpleNamespace

import pytest

from millscale.analysis.charge.pair_errors import errors_of_dumps
from millscale.analysis.finished_campaign import load_campaign
from millscale.analysis.measures import (
    ERRORS,
    NUMBERS,
    QUANTITIES,
    STUDIED,
    Column,
    ErrorColumn,
    Taken,
)
from millscale.analysis.shapes.shape import shape_of, snapshots_at
from millscale.analysis.shapes.surface_ends import SurfaceEnds
from millscale.runs.dumps import read_dump


@pytest.fixture(scope="module")
def charge(throws):
    return load_campaign(throws).charges[1]


def values(error):
    """The numbers of an error, those by curtain one by one."""
    if isinstance(error, dict):
        return [value for inner in error.values() for value in values(inner)]
    return [error]


def test_names_are_unique():
    for columns in (QUANTITIES, ERRORS):
        names = [column.name for column in columns]
        assert len(names) == len(set(names))


def test_a_charge_compared_with_itself_has_the_error_of_equal_charges(charge):
    (snapshot,) = snapshots_at(charge.folder, [1.0]).values()
    shape = shape_of(read_dump(snapshot.path), snapshot, charge.case)
    found = errors_of_dumps(shape, shape)
    for quantity in QUANTITIES:
        if quantity.taken is Taken.ONCE:
            found |= quantity.compared(quantity.read(charge), quantity.read(charge))
    averaged = {x.name for q in QUANTITIES if q.taken is Taken.AVERAGED for x in q.errors}
    measured = {error.name for error in ERRORS} - averaged
    assert set(found) == measured
    for error in ERRORS:
        if error.name in measured:
            assert values(found[error.name]) == [pytest.approx(error.same, abs=1e-12)] * len(
                values(found[error.name])
            )
            assert error.by_curtain or error.distance(found[error.name]) < 1e-12


def test_what_a_run_lacks_has_no_error(charge):
    for quantity in QUANTITIES:
        assert set(quantity.compared(None, None).values()) <= {None}


def test_the_sign_of_a_relative_error_is_that_of_the_excess():
    (power,) = (quantity for quantity in QUANTITIES if quantity.name == "power")
    assert power.compared(1.1, 1.0) == {"power_error": pytest.approx(0.1)}
    assert power.compared(1.0, 0.0) == {"power_error": None}


def test_numbers_of_a_charge_are_read_by_name(charge):
    read = {x.name: x.read(charge) for x in NUMBERS if x.taken is Taken.ONCE}
    assert read["torque"] == charge.result.dimensionless["torque"]
    assert read["flying_share"] == charge.result.mean["flying_share"]
    # Known after one revolution, which this charge does not complete.
    assert read.pop("mixing_index") is None
    assert read.pop("ends_power_share") is None  # periodic ends
    assert None not in read.values()


def test_ends_of_the_surface_are_read_from_a_shape():
    rows = {x.name: x for x in NUMBERS}
    shape = SimpleNamespace(ends=SurfaceEnds(toe=3.9, shoulder=1.2))
    assert rows["toe_angle_rad"].read(shape) == 3.9
    assert rows["shoulder_angle_rad"].read(shape) == 1.2
    assert rows["toe_angle_rad"].read(SimpleNamespace(ends=None)) is None


def test_text_has_unit_digits_and_sign():
    power = Column("power_error", "power", "%", 100.0, 2, signed=True)
    assert power.heading == "power [%]"
    assert [power.text(x) for x in (0.0123, -0.5, 0.0, None)] == ["+1.23", "-50.00", "0.00", "–"]
    assert power.text(0.0123, signed=False) == "1.23"
    assert Column("S", "S").heading == "S"


def test_a_distance_is_taken_from_the_value_of_equal_charges():
    overlap = ErrorColumn("iou", "overlap", same=1.0)
    assert overlap.distance(0.8) == pytest.approx(0.2)
    assert overlap.distance_name == "1 - iou"
    assert ErrorColumn("power_error", "power").distance(-0.04) == 0.04
    assert overlap.distance(None) is None


def test_parameter_studies_compare_five_errors():
    assert list(STUDIED) == ["contour", "curtain", "mass_flow", "power", "detach_angle"]
    assert all(error.about for error in STUDIED.values())
