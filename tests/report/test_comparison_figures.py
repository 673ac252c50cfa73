"""Figures 9 to 14, run times and speed against error."""

import shutil
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.colors import to_hex
from numpy.testing import assert_allclose

from millscale.analysis.charge.comparison import compare_charges
from millscale.analysis.charge.speed_error import SHOWN, OverSeeds, mill_rows
from millscale.analysis.several_campaigns import load_charges
from millscale.analysis.shapes.occupancy import PolarCells
from millscale.analysis.shapes.velocity_field import VelocityField
from millscale.report import comparison_images as drawing
from millscale.report import images as report_figures
from millscale.report.comparison_images import by_scheme, comparison_images
from millscale.report.figures import shapes as shape_figures
from millscale.report.figures import speed as speed_figures
from millscale.report.figures.ball_picture import FALLING, ball_picture, colours_by_side
from millscale.report.figures.snapshot_sheet import VIEW, _on_pixels, snapshot_sheet
from millscale.report.figures.style import colour_of_S
from millscale.report.interactive import chart_of
from millscale.runs.dumps import Dump
from synthetic_result import with_case
from synthetic_throw import DROP


@pytest.fixture(scope="module")
def comparison(throws):
    return compare_charges(load_charges([throws])[0])


def dump_of(balls):
    names = ("x", "y", "z", "radius")
    columns = dict(zip(names, np.array(balls, float).T, strict=True))
    return Dump(0, columns | {"id": np.arange(1.0, len(balls) + 1)})


def drawn(balls, rising, pixels):
    white = np.full((pixels, pixels, 3), 255, np.uint8)
    return ball_picture(dump_of(balls), colours_by_side(rising), 1.0, white, VIEW)


def test_ball_is_drawn_where_it_is_in_its_size_and_colour():
    picture = drawn([(0.5, 0.0, 0.25, 0.1)], np.array([False]), pixels=208)
    pixel = 2.0 * VIEW / 208  # 0.01
    row, column = np.nonzero(np.any(picture < 250, axis=2))
    assert_allclose((column.mean() + 0.5) * pixel - VIEW, 0.5, atol=pixel)
    assert_allclose(VIEW - (row.mean() + 0.5) * pixel, 0.25, atol=pixel)
    # Of 314 pixels in the disc, a tenth may fall on either side of its rim.
    assert_allclose(row.size * pixel**2, np.pi * 0.1**2, rtol=0.1)
    brightest = picture.reshape(-1, 3)[np.argmin(np.abs(picture.reshape(-1, 3) - FALLING).sum(1))]
    assert_allclose(brightest.astype(int), FALLING, atol=3)


@pytest.mark.parametrize("order", [[0, 1], [1, 0]])
def test_nearer_ball_hides_the_farther_whatever_their_order(order):
    balls = np.array([(0.0, 0.9, 0.0, 0.2), (0.0, 0.1, 0.0, 0.2)])[order]
    picture = drawn(balls, balls[:, 1] < 0.5, pixels=101)
    red, _, blue = picture[50, 50].astype(int)
    assert red > blue


def test_balls_smaller_than_a_pixel_are_seen():
    picture = drawn([(0.3, 0.0, 0.3, 1e-4)], np.array([True]), pixels=100)
    assert 1 <= np.any(picture < 250, axis=2).sum() <= 4


def test_sheet_has_a_row_for_each_mill_and_a_column_for_each_angle(comparison):
    charges = comparison.charges.every[:2]
    figure = snapshot_sheet(charges, [0.5, 0.75, 1.0])
    assert len(figure.axes) == 6
    assert [axes.get_title() for axes in figure.axes[:3]] == ["0.5 rad", "0.75 rad", "1 rad"]
    assert "S = 2.6" in figure.axes[3].get_ylabel()
    assert [text.get_text() for text in figure.axes[1].texts] == ["no dump"]
    drawn = figure.axes[0].images[0].get_array()
    assert np.any(drawn[..., 0] > drawn[..., 2] + 50)
    assert np.any(drawn[..., 2] > drawn[..., 0] + 50)


def with_occupancy(folder):
    """Write occupancy.csv of a charge: half full in the quarter x < 0, z < 0 within 0.9 (R - a)."""
    radii, angles = np.linspace(0.0, 1.0, 11), np.linspace(0.0, 2.0 * np.pi, 37)
    lines = ["radius_low,radius_high,angle_low_rad,angle_high_rad,solid_fraction"]
    for low, high in pairwise(radii):
        for begin, end in pairwise(angles):
            filled = high < 0.95 and 0.5 * np.pi - 1e-9 < begin and end < np.pi + 1e-9
            lines.append(f"{low:.9g},{high:.9g},{begin:.9g},{end:.9g},{0.5 * filled:g}")
    (folder / "occupancy.csv").write_text("\n".join(lines) + "\n")


def test_mean_fields_stand_right_of_the_snapshots(throws, tmp_path):
    charges = load_charges([shutil.copytree(throws, tmp_path / "runs")])[0][:2]
    with_occupancy(charges[0].folder)
    edges = np.linspace(-1.1, 1.1, 56)
    rising = np.where(np.arange(55) < 10, 1.0, 0.0) * np.ones((55, 1))
    balls = 5.0 * np.ones((55, 55))
    velocity = VelocityField(edges, balls, balls, np.stack([0.0 * balls, 5.0 * rising]))
    figure = snapshot_sheet(charges, [0.5, 1.0], {charges[0]: velocity})
    panels = figure.axes
    assert len(panels) == 8
    titles = [axes.get_title() for axes in panels[:4]]
    assert titles == ["0.5 rad", "1 rad", "mean", "mean velocity"]
    (fraction,) = (image.get_array() for image in panels[2].images)
    z, x = np.nonzero(fraction.filled(0.0) > 0.0)
    middle = 0.5 * (fraction.shape[0] - 1)
    # The rising side at the bottom, z up, and half of a ball around it.
    ball = charges[0].case.ball.radius_m / charges[0].case.mill.radius_m * middle
    assert x.max() <= middle + ball + 1 and z.max() <= middle + ball + 1
    assert fraction.max() == pytest.approx(0.5)
    inner = fraction[int(0.6 * middle) : int(0.8 * middle), int(0.6 * middle) : int(0.8 * middle)]
    assert_allclose(inner.compressed(), 0.5)
    assert inner.count() > 200
    (speed,) = (image.get_array() for image in panels[3].images)
    assert_allclose(speed, rising)
    for axes in panels[6:]:
        assert [text.get_text() for text in axes.texts] == ["not measured"]
    assert len(snapshot_sheet(charges[1:], [0.5]).axes) == 1  # no empty panels


def test_the_distance_from_the_reference_is_drawn_for_every_charge_that_has_one(comparison):
    charges = comparison.charges.every
    references = {row.charge: row.reference for row in comparison.rows}
    figure = shape_figures.contour_differences(comparison.measured, charges, references)
    assert len(figure.axes) == len(comparison.measured.shapes)
    axes = figure.axes[-1]
    lines = [line for line in axes.lines if line.get_label()[0] == "S"]
    assert len(lines) == sum(references[charge] is not charge for charge in charges) > 0
    # The surface of the scaled mill lies lower, away from the air.
    for line in lines:
        assert np.nanmedian(line.get_ydata()) == pytest.approx(-100.0 * DROP, abs=0.8)
    itself = {charge: charge for charge in charges}
    assert shape_figures.contour_differences(comparison.measured, charges, itself) is None


def test_a_layer_of_balls_fills_no_more_than_its_space():
    """Centres in one thin ring, their volume spread over a ball: a wide ring of the same volume."""
    cells = PolarCells(np.linspace(0.0, 1.0, 51), np.linspace(0.0, 2.0 * np.pi, 181))
    values = np.zeros((50, 180))
    values[40] = 4.0
    ball = 0.08
    found, half = _on_pixels(cells, values, 1.0 / (1.0 + ball), ball)
    assert half == pytest.approx(1.0)
    width = 2.0 * (1.0 + ball) / len(found)
    ring = np.pi * (cells.radii[41] ** 2 - cells.radii[40] ** 2)
    assert np.nansum(found) * width**2 == pytest.approx(4.0 * ring, rel=0.03)
    # Across the ring the volume is spread by 3 / (4 ball) (1 - (r / ball)^2).
    assert np.nanmax(found) == pytest.approx(4.0 * 0.02 * 0.75 / ball, rel=0.06)
    assert np.isnan(found[len(found) // 2, len(found) // 2])


def test_the_reference_lies_on_top_whatever_its_S(comparison):
    charges = comparison.charges.every[1:]
    assert not any(charge.is_physical for charge in charges)
    looks = shape_figures.looks_of(charges, [charges[0]])
    assert all(looks[charges[0]]["zorder"] > looks[x]["zorder"] for x in charges[1:])
    figure = shape_figures.curtain_profiles(comparison.measured, charges, [charges[0]])
    names = {line["name"] for panel in chart_of(figure)["panels"] for line in panel["lines"]}
    assert {charge.label for charge in charges} <= names
    drawn = [c for axes in figure.axes for c in axes.collections]
    assert {c.get_zorder() for c in drawn} == {3, 4}


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_contours_have_a_panel_for_each_angle_and_none_empty(comparison, count):
    shapes = dict(list(comparison.measured.shapes.items()) * 2)
    every = {angle + i: found for i in range(4) for angle, found in shapes.items()}
    measured = replace(comparison.measured, shapes=dict(list(every.items())[:count]))
    figure = shape_figures.contours(measured, comparison.charges.every)
    assert len(figure.axes) == count
    assert all(axes.lines for axes in figure.axes)


def test_contours_of_all_mills_are_drawn_and_of_the_physical_mill_in_black(comparison):
    figure = shape_figures.contours(comparison.measured, comparison.charges.every)
    axes = figure.axes[0]
    colours = [to_hex(line.get_color()) for line in axes.lines if line.get_label()[0] == "S"]
    assert colours.count("#000000") == 1
    assert len(colours) == 4


def test_only_curtains_of_enough_balls_are_drawn(comparison):
    figure = shape_figures.curtain_profiles(comparison.measured, comparison.charges.every)
    assert [axes.get_title() for axes in figure.axes] == ["curtain 4", "curtain 6"]
    assert all(axes.collections for axes in figure.axes)


def test_a_mill_without_the_curtains_of_the_paper_has_its_own(comparison):
    def only(numbers, shape):
        kept = dict(zip(numbers, (shape.curtains or {}).values(), strict=False))
        return replace(shape, curtains=kept)

    def titles(numbers):
        shapes = {
            angle: {charge: only(numbers, shape) for charge, shape in found.items()}
            for angle, found in comparison.measured.shapes.items()
        }
        measured = replace(comparison.measured, shapes=shapes)
        figure = shape_figures.curtain_profiles(measured, comparison.charges.every)
        return figure and [axes.get_title() for axes in figure.axes]

    assert titles([3]) == ["curtain 3"]
    assert titles([]) is None


def test_mass_flow_is_drawn_in_both_frames_in_percent(comparison):
    figure = shape_figures.mass_flow(comparison.charges.every)
    fixed, rotating = figure.axes
    share = comparison.charges.every[0].series["box_fixed_mass_fraction"]
    assert_allclose(fixed.lines[0].get_ydata(), 100.0 * share)
    assert_allclose(rotating.lines[0].get_ydata(), 100.0 * (share + 0.01))


def test_speed_against_error_has_every_mill_but_the_reference(comparison):
    mills = mill_rows(comparison.rows)
    figure = speed_figures.speed_against_error(mills)
    for axes, error in zip(figure.axes, SHOWN, strict=True):
        assert len(axes.containers) == 2  # the two schemes
        drawn = np.concatenate([c.lines[0].get_ydata() for c in axes.containers])
        values = [mill.errors[error.name].mean for mill in mills if not mill.is_reference]
        assert_allclose(sorted(drawn), sorted(error.factor * value for value in values))


def test_speed_against_error_has_no_panel_for_what_no_mill_measured(comparison):
    nothing = {"power_error": OverSeeds(None, None, None)}
    mills = [replace(mill, errors=mill.errors | nothing) for mill in mill_rows(comparison.rows)]
    figure = speed_figures.speed_against_error(mills)
    titles = [error.heading for error in SHOWN if error.name != "power_error"]
    assert [axes.get_ylabel() for axes in figure.axes] == titles


def test_run_times_stand_beside_the_paper_s(comparison):
    axes = speed_figures.run_times(mill_rows(comparison.rows)).axes[0]
    lines = {line.get_label(): line for line in axes.lines}
    assert_allclose(lines["the paper, 20 s"].get_ydata()[[0, -1]], [35.2, 0.65])
    assert_allclose(lines["constant gravity"].get_ydata(), 12.5 / 3600.0)


def test_marks_have_the_colour_of_their_S(comparison):
    mills = mill_rows(comparison.rows)
    colours = {colour_of_S(mill.name.S) for mill in mills}
    axes = speed_figures.run_times(mills).axes[0]
    marks = [to_hex(x.get_color()) for x in axes.lines if x.get_linestyle() == "None"]
    assert len(marks) == len(mills) and set(marks) == colours
    for axes in speed_figures.speed_against_error(mills).axes:
        marks = {to_hex(x.get_color()) for x in axes.lines if x.get_marker() in "osD^"}
        assert colour_of_S(2.6) in marks


def test_policies_are_drawn_apart(comparison):
    mills = mill_rows(comparison.rows)
    matched = [
        replace(mill, name=mill.name._replace(policy="friction-matched"))
        for mill in mills
        if mill.name.S > 1.0
    ]
    axes = speed_figures.run_times([*mills, *matched], of_paper=False).axes[0]
    lines = {x.get_label(): x for x in axes.lines if not x.get_label().startswith("_")}
    assert set(lines) == {
        "constant gravity",
        "constant speed",
        "constant gravity, friction-matched",
        "constant speed, friction-matched",
    }
    assert lines["constant speed, friction-matched"].get_markerfacecolor() == "white"
    first = comparison.charges.every[1]
    other = with_case(first, policy="friction-matched")
    looks = shape_figures.looks_of([first, other])
    assert looks[first]["color"] == looks[other]["color"]
    assert looks[first]["ls"] != looks[other]["ls"]


def test_images_have_the_paper_s_numbers_in_their_captions(comparison, tmp_path, monkeypatch):
    monkeypatch.setattr(report_figures, "DPI", 30)
    images = comparison_images(comparison, tmp_path)
    captions = [
        image.caption
        for group in (images.sheets, images.contours, images.curtains, images.flow, images.speed)
        for image in group
    ]
    for number in ("Fig. 9", "Fig. 10", "Fig. 11", "Fig. 12", "Fig. 13", "Fig. 14", "Table 10"):
        assert any(caption.startswith(number) for caption in captions), number
    assert images.problems == []
    assert len(list(tmp_path.glob("*.png"))) == len(captions)


def test_a_sheet_that_cannot_be_drawn_is_explained(comparison, tmp_path, monkeypatch):
    from millscale.runs.untrusted import RunFolderError

    def cannot(charges, *_):
        raise RunFolderError(charges[0].folder, "damaged", "run again")

    monkeypatch.setattr(report_figures, "DPI", 30)
    monkeypatch.setattr(drawing, "snapshot_sheet", cannot)
    images = comparison_images(comparison, tmp_path)
    assert images.sheets == []
    assert len([problem for problem in images.problems if "damaged" in problem]) == 2
    assert images.contours


def test_a_scheme_without_the_physical_mill_of_its_own_is_drawn_with_the_other_s():
    def charge(scheme, S):
        return SimpleNamespace(scheme=scheme, state="", S=S, is_physical=S == 1.0)

    physical, half = charge("constant-gravity", 1.0), charge("constant-gravity", 2.0)
    third, own = charge("constant-speed", 3.0), charge("constant-speed", 1.0)
    assert by_scheme([half, physical, third]) == {
        "constant-gravity": [physical, half],
        "constant-speed": [physical, third],
    }
    assert by_scheme([physical, third, own])["constant-speed"] == [own, third]
    assert by_scheme([half, third])["constant-speed"] == [third]


def test_mass_flow_over_a_pitch_is_the_mean_of_the_pitches_less_the_reference(
    comparison, monkeypatch
):
    charges = comparison.charges.every[:3]
    rows = {charge: i for i, charge in enumerate(charges)}

    def masses(charge):
        """Two pitches of shares that a linear phase and the charge make known."""
        wave = np.linspace(0.01, 0.02, shape_figures.PHASES) + 0.001 * rows[charge]
        return np.array([wave - 0.002, wave + 0.002])

    monkeypatch.setattr(shape_figures, "pitch_masses", masses)
    upper, lower = shape_figures.mass_flow_over_pitch(charges).axes
    assert [line.get_ydata()[0] for line in upper.lines] == pytest.approx([1.0, 1.1, 1.2])
    for i, line in enumerate(lower.lines):
        assert line.get_ydata() == pytest.approx(np.full(shape_figures.PHASES, 0.1 * i), abs=1e-9)
    monkeypatch.setattr(shape_figures, "pitch_masses", lambda charge: None)
    assert shape_figures.mass_flow_over_pitch(charges) is None
