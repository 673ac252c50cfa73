"""Impacts of a charge: the file, sums, decades, and scaled mills beside the largest."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from millscale.analysis.charge.impacts import (
    LOWEST,
    collapses,
    energy_unit,
    read_impacts,
    rebinned,
    summed_bins,
)
from millscale.analysis.finished_campaign import load_campaign
from millscale.report.figures.impacts import collapse_figure
from millscale.report.figures.style import colour_of_S
from millscale.report.impacts_section import impacts_section
from millscale.runs.untrusted import RunFolderError
from synthetic_case import finish_case, typed, write_campaign, write_case
from synthetic_impacts import DURATION, write_spectra
from synthetic_mills import charge_case, columns_of


def edges_of(bins):
    return bins.energy_low_J, bins.energy_high_J


def test_there_are_as_many_contacts_in_decades_as_in_bins():
    edges = 3.0 * np.logspace(-11, 1, 8 * 12 + 1)
    contacts = np.arange(96.0)
    decades = rebinned(edges[:-1], edges[1:], contacts, 3.0)
    assert decades.sum() == pytest.approx(contacts.sum())
    assert_allclose(decades[1:13], contacts.reshape(12, 8).sum(axis=1))


def test_a_bin_on_the_edge_of_a_decade_is_divided_over_the_logarithm():
    decades = rebinned([10**-3.25], [10**-2.75], [8.0], 1.0)
    assert decades[-4 - LOWEST] == pytest.approx(4.0) and decades[-3 - LOWEST] == pytest.approx(4.0)


@pytest.fixture
def case():
    return charge_case(2.6, 1)


def test_powers_are_energies_over_the_duration(tmp_path, case):
    write_spectra(tmp_path, case, contacts=1000.0)
    found = read_impacts(tmp_path, typed(case))
    unit = energy_unit(typed(case))
    assert found.energy_unit_J == unit
    assert found.ball_ball.contacts_per_s == pytest.approx(2000.0 / DURATION)
    # Half of the contacts near 2e-4, half near 2e-3.
    ended = 1000.0 * (2e-4 + 2e-3) * unit / DURATION
    assert found.ball_ball.ended_W == pytest.approx(ended)
    assert found.ball_ball.lasting_W == pytest.approx(0.5 * unit / DURATION)
    assert found.ball_ball.dissipated_W == pytest.approx(ended + 0.5 * unit / DURATION)
    assert found.ball_ball.sum_error < 1e-12
    one = found.classes[0]
    assert (one.pairing, one.ball_class, one.other_class) == ("ball_ball", 1, 1)
    assert found.classes[1].other_class is None
    assert math.fsum(one.dissipated.power_W) == pytest.approx(ended)


def test_a_sum_that_is_off_is_stated(tmp_path, case):
    write_spectra(tmp_path, case, contacts=1000.0, all_contacts=1.01)
    found = read_impacts(tmp_path, typed(case))
    assert found.ball_ball.sum_error == pytest.approx(0.01 / 1.01, rel=1e-6)


def test_bins_of_classes_are_summed(tmp_path, case):
    write_spectra(tmp_path, case, contacts=1000.0, classes=2)
    found = read_impacts(tmp_path, typed(case))
    assert len([one for one in found.classes if one.pairing == "ball_ball"]) == 3
    bins = summed_bins(found, "ball_ball")
    assert len(bins.contacts_per_s) == 2
    assert math.fsum(bins.contacts_per_s) == pytest.approx(6000.0 / DURATION)


@pytest.mark.parametrize(
    ("damage", "cause"),
    [
        (lambda text: text.replace("pairing", "kind"), "columns must be"),
        (lambda text: text.rsplit(",", 1)[0], "a row is not whole"),
        (lambda text: text.replace("ball_ball,1,1", "ball_ball,x,1"), "a row is not whole"),
        (lambda text: "".join(text.splitlines(keepends=True)[:1]), "a row is not whole"),
    ],
)
def test_a_damaged_file_is_refused_in_one_line(tmp_path, case, damage, cause):
    path = write_spectra(tmp_path, case, contacts=1000.0)
    path.write_text(damage(path.read_text()))
    with pytest.raises(RunFolderError, match=cause):
        read_impacts(tmp_path, typed(case))


@pytest.fixture(scope="module")
def mills(tmp_path_factory):
    """S = 1, 1.696 and 2.6; that of 2.6 has half of the strong contacts on balls. Read only."""
    runs, names = tmp_path_factory.mktemp("mills"), []
    for S in (1.0, 1.696, 2.6):
        case = charge_case(S, 1)
        case["deck"]["impacts"] = "on"
        folder = write_case(runs, case, columns_of(case))
        balls = case["ball"]["count"]
        write_spectra(folder, case, contacts=5.0 * balls, strong=0.5 if S == 2.6 else 1.0)
        finish_case(folder)
        names.append(folder.name)
    write_campaign(runs, names)
    return runs


def test_mills_are_compared_with_the_largest_decade_by_decade(mills):
    found = {(one.S, one.pairing): one for one in collapses(load_campaign(mills).charges)}
    assert set(found) == {(S, p) for S in (1.696, 2.6) for p in ("ball_ball", "ball_wall")}
    alike = found[1.696, "ball_ball"]
    assert alike.reference_S == 1.0
    assert [x.low for x in alike.decades] == pytest.approx([1e-4, 1e-3])
    assert [x.ratio for x in alike.decades] == pytest.approx([1.0, 1.0])
    assert alike.alike_share == pytest.approx(1.0)
    weak = found[2.6, "ball_ball"]
    assert [x.ratio for x in weak.decades] == pytest.approx([1.0, 0.5])
    assert [x.is_alike for x in weak.decades] == [True, False]
    # The strong contacts are ten times as energetic.
    assert weak.alike_share == pytest.approx(1.0 / 11.0)


def test_spectra_have_the_colour_of_their_S_and_the_width_of_what_is_shown(mills):
    charges = load_campaign(mills).charges
    for axes in collapse_figure(charges).axes:
        colours = {line.get_label(): line.get_color() for line in axes.lines}
        named = {f"S = {x.S:.4g}": colour_of_S(x.S) for x in charges}
        assert {k: v for k, v in colours.items() if k[0] == "S"} == named
        energies = np.concatenate([line.get_xdata()[line.get_ydata() > 0] for line in axes.lines])
        low, high = axes.get_xlim()
        assert low < energies.max() < high < 10.0 * energies.max()


def test_the_report_has_a_section_of_impacts(mills, tmp_path):
    section = impacts_section(load_campaign(mills).charges, tmp_path)
    assert len(section.charges) == 3 and len(section.compared) == 4
    names = {path.name for path in tmp_path.glob("*.png")}
    assert names == {"impacts.png", *(f"{one.id}-impacts.png" for one in section.charges)}


def test_a_report_without_impacts_has_no_section(throws, tmp_path):
    assert impacts_section(load_campaign(throws).charges, tmp_path) is None
