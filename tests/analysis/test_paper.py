"""The paper's tables as shipped."""

import pytest
from numpy.testing import assert_allclose

from millscale.analysis.paper import numbers as paper

SCHEMES = ("constant-gravity", "constant-speed")


@pytest.mark.parametrize(("scheme", "power"), list(zip(SCHEMES, (1, 2), strict=True)))
def test_predicted_ratio_is_a_power_of_s_to_its_printed_digits(scheme, power):
    rows = paper.reported_energies(scheme)
    assert len(rows) == 6
    # Both 1/S and S are printed to three decimals.
    assert_allclose([r.predicted for r in rows], [r.S**-power for r in rows], atol=1.5e-3)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_actual_ratio_is_the_quotient_of_the_energies(scheme):
    rows = paper.reported_energies(scheme)
    # Half a unit of the last digit of 0.66 J is 0.8 %.
    assert_allclose([r.ratio for r in rows], [r.change / rows[0].change for r in rows], atol=3e-3)


def test_window_of_the_comparison_is_that_of_table_8():
    assert_allclose(paper.longest_window(), 3.568 - 2.591)


@pytest.mark.parametrize("S", [3.9 / 3.6, 1.083, 3.9 / 2.3])
def test_a_mill_of_the_paper_is_found_by_its_radii_or_its_rounded_s(S):
    assert paper.reported_energy("constant-gravity", S) is not None


def test_table_10_is_found_by_s():
    assert paper.reported_charge(1.0)["particles"] == 231461
    assert paper.reported_charge(3.9 / 1.5)["elapsed_h"] == 0.65
    assert paper.reported_charge(2.0) is None


def test_nothing_is_reported_for_what_the_paper_has_not():
    assert paper.reported_energy("constant-gravity", 2.0) is None
    assert paper.reported_energies("froude") == ()
    assert paper.reported_throw("froude") is None
