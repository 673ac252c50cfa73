"""Figures of a charge."""

from numpy.testing import assert_allclose

from millscale.analysis.finished_campaign import load_campaign
from millscale.report.figures.charge import charge_series
from synthetic_result import with_case


def test_similar_charges_coincide_in_the_dimensionless_figure(runs):
    figure = charge_series(load_campaign(runs).charges, dimensionless=True)
    for axes in figure.axes:
        first, second = axes.lines
        assert_allclose(first.get_ydata(), second.get_ydata(), rtol=1e-8)
    torque = figure.axes[2].lines[0].get_ydata()
    assert 0.349 < torque.min() < torque.max() < 0.391


def test_seeds_of_a_mill_share_a_name_and_schemes_a_colour(runs):
    case = load_campaign(runs).charges[0]
    again = with_case(case, id=f"{case.id}-seed2", seed=2)
    other = with_case(case, id="other", S=1.3, scheme="constant-speed")
    figure = charge_series([case, again, other], dimensionless=True)
    first, second, third = figure.axes[0].lines
    assert first.get_color() == second.get_color() != third.get_color()
    assert (first.get_linestyle(), third.get_linestyle()) == ("-", "--")
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names == [case.id, "other"]


def test_power_in_watts_is_that_of_the_series_and_the_start_does_not_set_the_scale(runs):
    case = load_campaign(runs).charges[0]
    series = case.series
    series["drive_power_W"][:4] *= 50.0
    axes = charge_series([case], dimensionless=False).axes[3]
    assert_allclose(axes.lines[0].get_ydata(), series["drive_power_W"])
    steady = series["drive_power_W"][30:]
    assert axes.get_ylim()[0] < steady.min()
    assert steady.max() < axes.get_ylim()[1] < 1.2 * steady.max()
