"""Charges against the physical mill, with known differences."""

import dataclasses
import json
import shutil

import numpy as np
import pytest
from numpy.testing import assert_allclose

from millscale.analysis.charge.comparison import compare_charges
from millscale.analysis.charge.pair import compare_two, load_charge
from millscale.analysis.charge.scaled_mills import Charges
from millscale.analysis.charge.speed_error import mill_rows
from millscale.analysis.measures import ERRORS
from millscale.analysis.several_campaigns import load_charges
from millscale.analysis.shapes.shape import end_circle
from millscale.runs.untrusted import RunFolderError
from synthetic_case import finish_case, record_stages, write_campaign
from synthetic_throw import (
    BED_HEIGHT,
    CURTAIN_BALLS,
    DROP,
    FLOW_MEAN,
    FLOW_SHIFT,
    SHIFT,
    throw_case,
    write_throw,
)


def documents(comparison):
    """The rows of results.json by id."""
    return {row.charge.id: row.document() for row in comparison.rows}


@pytest.fixture(scope="module")
def charges(throws):
    return load_charges([throws])[0]


@pytest.fixture(scope="module")
def comparison(charges):
    return compare_charges(charges)


@pytest.fixture
def rows(comparison):
    return documents(comparison)


REFERENCE = "mb-cg-paper-S1.000-fixed-seed1"
SCALED = "mb-cg-paper-S2.600-fixed-seed1"


def test_reference_is_the_physical_mill_of_either_scheme(charges):
    every = Charges(tuple(charges))
    assert {every.reference_of(charge).id for charge in charges} == {REFERENCE}


def test_without_the_physical_mill_the_largest_is_the_reference(charges):
    scaled = Charges(tuple(charge for charge in charges if charge.S > 1.0))
    found = {charge.id: scaled.reference_of(charge).id for charge in scaled}
    # A seed of the reference is a reference itself; the other scheme has its own.
    assert all(name == other for name, other in found.items())


def test_a_campaign_without_the_physical_mill_takes_that_of_another(charges):
    other = [dataclasses.replace(c, campaign="equal-filling") for c in charges if c.S > 1.0]
    every = Charges((*charges, *other))
    assert every.reference_of(other[0]).key == ("synthetic", REFERENCE)
    assert [c.id for c in every.mill_of(other[0]).seeds] == [
        SCALED,
        SCALED.replace("seed1", "seed2"),
    ]


def test_errors_of_a_reference_are_null(rows):
    row = rows[REFERENCE]
    assert row["is_reference"]
    nulls = ("contour_error_mean", "contour_error_max", "curtain_iou", "massflow_rms")
    assert all(row[name] is None for name in (*nulls, "massflow_correlation", "power_error"))
    assert row["mill_angle_rad"] == pytest.approx(1.0, abs=1e-3)


def test_contour_error_is_the_known_drop_of_the_bed(rows):
    row = rows[SCALED]
    # Balls of 0.027 in a kernel of 0.04: noise of a fifth of a ball (test_contour). At their ends
    # one line may stop on a lifter's top and the other in the groove, 0.076 deeper.
    assert_allclose(row["contour_error_mean"], DROP, atol=0.2 * 0.027)
    assert DROP < row["contour_error_max"] < 0.076 + 2.0 * DROP
    assert row["contour_second_method"] < 0.027
    assert_allclose(row["bulk_fraction"], 0.55, rtol=0.05)


def test_curtains_overlap_as_far_as_they_are_shifted(rows):
    row = rows[SCALED]
    assert sorted(row["curtain_iou"]) == ["4", "6"]
    # Bands of width w = 0.2 and a shift s: (w - s) / (w + s) is 0.67. The kernel of 0.03 and the
    # share of 90 % leave the width within a tenth; two samples of 120 balls cost about 0.1.
    expected = (0.2 - SHIFT) / (0.2 + SHIFT)
    for parts in row["curtain_iou"].values():
        for part in ("whole", "upper", "lower"):
            assert expected - 0.2 < parts[part] < expected + 0.15
    assert row["curtains"]["4"]["balls"] == CURTAIN_BALLS
    # Standard deviation of a band evenly filled.
    assert_allclose(row["curtains"]["4"]["width"], 0.2 / np.sqrt(12.0), rtol=0.12)


def test_mass_flow_is_that_of_the_shifted_wave(rows):
    row = rows[SCALED]
    shift = 2.0 * np.pi * FLOW_SHIFT
    assert_allclose(row["massflow_rms"], 0.01 * np.sqrt(2.0) * np.sin(0.5 * shift), rtol=0.01)
    assert_allclose(row["massflow_correlation"], np.cos(shift), atol=0.01)
    assert_allclose(row["massflow_rms_over_mean"], row["massflow_rms"] / FLOW_MEAN, rtol=0.01)
    assert_allclose(row["massflow_rotating_rms"], row["massflow_rms"], rtol=1e-9)


def test_rows_have_the_documented_errors_and_are_json(rows):
    for row in rows.values():
        assert {error.name for error in ERRORS} <= row.keys()
        assert row["not_measured"] == []
        json.dumps(row, allow_nan=False)
    row = rows[SCALED]
    assert_allclose(
        row["total_mass_kg"], row["balls"] * throw_case("constant-gravity", 1, 1)["ball"]["mass_kg"]
    )
    assert row["toe_angle_rad"] == row["numbers"]["toe_angle_rad"]


def test_seeds_are_measured_against_each_other(rows):
    first, second = rows[SCALED], rows[SCALED.replace("seed1", "seed2")]
    pair = [row["contour_error_mean"] for row in (first, second)]
    assert_allclose(first["seed_spread"]["contour_error_mean"], np.std(pair, ddof=1))
    assert first["seeds"] == 2
    assert first["between_seeds"] == second["between_seeds"]
    # Two packings below the same height: chance alone, a fraction of the drop.
    assert 0.0 < first["between_seeds"]["contour_error_mean"] < 0.3 * DROP
    assert first["between_seeds"]["curtain_iou_whole"] > first["curtain_iou_whole"]
    # One seed: its own spread is unknown, that of the nearest model is lent.
    assert rows[REFERENCE]["seed_spread"] is None
    assert rows[REFERENCE]["between_seeds_of"] == SCALED


def test_twin_at_constant_speed_differs_by_nothing(charges, comparison):
    (row,) = (row.document() for row in comparison.schemes)
    assert row["constant_gravity"] == SCALED
    # Same seed, same packing over R - a: the made-up charges are equal.
    assert row["contour_error_mean"] < 1e-9
    assert row["curtain_iou_whole"] == 1.0
    assert_allclose(row["power_error"], 0.0, atol=1e-9)
    assert comparison.charges.twin_of(comparison.charges.every[0]) is None


def test_rows_of_mills_are_means_over_their_seeds(comparison, rows):
    mills = {(mill.name.scheme, mill.name.S): mill for mill in mill_rows(comparison.rows)}
    assert len(mills) == 3
    contour = mills["constant-gravity", 2.6].errors["contour_error_mean"]
    steady = [
        rows[name]["mean_over_angles"]["contour_error_mean"]
        for name in (SCALED, SCALED.replace("seed1", "seed2"))
    ]
    assert_allclose(contour.mean, np.mean(steady))
    assert_allclose(contour.deviation, np.std(steady, ddof=1))
    assert mills["constant-gravity", 1.0].errors["contour_error_mean"].mean is None


def test_numbers_of_the_bed_are_those_put_in(charges, rows):
    numbers = rows[SCALED]["numbers"]
    (case,) = (charge.case for charge in charges if charge.id == SCALED)
    # The surface is level, and ends where its chord meets the circle.
    shoulder = np.arccos((BED_HEIGHT - DROP) / end_circle(case))
    assert numbers["shoulder_angle_rad"] == pytest.approx(shoulder, abs=0.02)
    assert numbers["toe_angle_rad"] == pytest.approx(2.0 * np.pi - shoulder, abs=0.02)
    assert_allclose(numbers["solid_fraction"], 0.55, rtol=0.05)
    assert numbers["torque"] == pytest.approx(0.37, rel=1e-6)
    assert numbers["curtain_share"] == pytest.approx(2 * CURTAIN_BALLS / rows[SCALED]["balls"])
    # Evenly spread over 0.2 in x; the standard deviation of 240 balls is known to 5 %.
    assert_allclose(numbers["curtain_width"], 0.2 / np.sqrt(12.0), rtol=0.15)
    # The dumps hold no velocities, which lead back to the throw.
    assert numbers["throw_angle_rad"] is None


def test_runs_without_states_and_box_are_compared_as_far_as_they_go(tmp_path):
    folders = [
        write_throw(tmp_path, throw_case("constant-gravity", S, 1), states=False)
        for S in (1.0, 2.6)
    ]
    for folder in folders:
        finish_case(folder)
    write_campaign(tmp_path, [folder.name for folder in folders])
    charges = load_charges([tmp_path])[0]
    row = next(row for row in compare_charges(charges).rows if row.charge.S > 1.0).document()
    assert_allclose(row["contour_error_mean"], DROP, atol=0.2 * 0.027)
    assert row["curtain_iou"] is None
    assert row["massflow_rms"] is None
    assert any("c_detach[24]" in lack for lack in row["not_measured"])
    assert any("box_fixed_mass_fraction" in lack for lack in row["not_measured"])


def test_dumps_at_other_mill_angles_are_not_compared(tmp_path):
    folders = [write_throw(tmp_path, throw_case("constant-gravity", S, 1)) for S in (1.0, 2.6)]
    for dump in reversed(sorted((folders[1] / "dump").iterdir())):
        step = int(dump.name.split(".")[1])
        dump.rename(dump.with_name(f"charge.{step + 1000:09d}.liggghts"))  # 0.16 rad later
    for folder in folders:
        finish_case(folder)
    write_campaign(tmp_path, [folder.name for folder in folders])
    row = compare_charges(load_charges([tmp_path])[0]).rows[1].document()
    assert row["contour_error_mean"] is None
    assert any("no dump at the mill angle" in lack for lack in row["not_measured"])
    assert row["massflow_rms"] is not None


def test_a_damaged_dump_is_noted_and_the_others_are_compared(throws, tmp_path):
    shutil.copytree(throws, tmp_path / "runs")
    dump = max((tmp_path / "runs/cases" / SCALED / "dump").iterdir())
    dump.write_text(dump.read_text()[:-200])
    rows = documents(compare_charges(load_charges([tmp_path / "runs"])[0]))
    assert rows[SCALED]["mill_angle_rad"] == 0.5
    assert any("cut short" in lack for lack in rows[SCALED]["not_measured"])
    assert rows[SCALED.replace("seed1", "seed2")]["mill_angle_rad"] == 1.0


def test_numbers_of_the_bed_at_rest_come_from_the_settling(throws, tmp_path):
    shutil.copytree(throws, tmp_path / "runs")
    settled = {"schema": 1, "largest_overlap_over_radius": 0.012, "bulk_fraction": 0.6}
    (tmp_path / "runs/cases" / SCALED / "settled.json").write_text(json.dumps(settled))
    record_stages(tmp_path / "runs/cases" / SCALED)
    rows = documents(compare_charges(load_charges([tmp_path / "runs"])[0]))
    assert rows[SCALED]["settled"] == {"largest_overlap_over_radius": 0.012, "bulk_fraction": 0.6}
    assert rows[REFERENCE]["settled"] == dict.fromkeys(rows[SCALED]["settled"])


def test_two_cases_differ_as_in_the_whole_comparison(throws, rows):
    pair = compare_two(*(load_charge(throws / "cases" / x) for x in (SCALED, REFERENCE)))
    for name in ("mill_angle_rad", "contour_error_mean", "curtain_iou", "massflow_rms"):
        assert pair[name] == rows[SCALED][name]
    assert pair["mean_over_angles"] == rows[SCALED]["mean_over_angles"]
    assert [case["id"] for case in pair["cases"]] == [SCALED, REFERENCE]
    with pytest.raises(RunFolderError, match="no such file"):
        load_charge(throws)
