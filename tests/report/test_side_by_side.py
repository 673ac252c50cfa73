"""Runs folders side by side: what is compared, what differs, and the page."""

import json
import math
import shutil

import numpy as np
import pytest
from numpy.testing import assert_allclose

from in_process import millscale
from millscale.analysis.charge.result import charge_scales
from millscale.analysis.differences import fact_rows
from millscale.report.figures import side_by_side as figures
from millscale.report.likeness import questions
from millscale.report.overview import QUANTITIES
from millscale.report.side_by_side import PHYSICAL, side_by_side
from millscale.runs.untrusted import RunFolderError
from synthetic_case import finish_case, typed, write_series
from synthetic_mills import SEEDS, charge_case, torque_number, write_mills

POWER = next(i for i, x in enumerate(QUANTITIES) if x.label == "power")
TOE = next(i for i, x in enumerate(QUANTITIES) if x.label == "toe")
MORE = 1.2  # power of the second runs folder over that of the first


@pytest.fixture(scope="module")
def worn(throws, tmp_path_factory):
    """The same charges with another friction, and a fifth more work of the drive."""
    copy = tmp_path_factory.mktemp("worn") / "worn"
    shutil.copytree(throws, copy)
    for folder in (copy / "cases").iterdir():
        case = json.loads((folder / "case.json").read_text())
        case["material"]["static_friction_pp"] = 0.3
        (folder / "case.json").write_text(json.dumps(case))
        rows = np.genfromtxt(folder / "series.csv", delimiter=",", names=True)
        columns = {name: rows[name] for name in rows.dtype.names}
        for name in ("drive_work_J", "drive_torque_Nm", "drive_power_W"):
            columns[name] = MORE * columns[name]
        write_series(folder / "series.csv", columns)
        finish_case(folder)
    return copy


@pytest.fixture(scope="module")
def found(throws, worn):
    return side_by_side([throws, worn])


def mills(folder, *cases, **options):
    folder.mkdir()
    return write_mills(folder, *cases, **options)


def answer(found, question):
    return next(x for x in questions(found) if x.question == question)


def test_like_mills_are_compared_by_name_of_their_folder(found, throws):
    assert [side.name for side in found.sides] == [throws.name, "worn"]
    kinds = [group.kind for group in found.groups]
    assert kinds[0].scheme == PHYSICAL and [kind.S for kind in kinds] == [1.0, 2.6, 2.6]
    for group in found.groups:
        first, second = group.rows
        assert [x.id for x in first.charges] == [x.id for x in second.charges]
    assert [len(group.rows[0].charges) for group in found.groups] == [1, 2, 1]


def test_power_differs_by_what_the_drive_does_and_the_shape_not_at_all(found):
    for group in found.groups:
        first, second = group.rows
        assert first.changes == (None,) * len(QUANTITIES) and first.errors is None
        assert second.changes[POWER].share == pytest.approx(MORE - 1.0, rel=1e-6)
        ours, theirs = second.row.estimates[POWER], first.row.estimates[POWER]
        assert second.changes[POWER].value == pytest.approx(ours.value - theirs.value)
        if ours.half_width is None:
            assert second.changes[POWER].half_width is None
        else:
            both = np.hypot(ours.half_width, theirs.half_width)
            assert second.changes[POWER].half_width == pytest.approx(both)
        assert second.numbers["power"] == pytest.approx(MORE * first.numbers["power"], rel=1e-6)
        if len(first.charges) == 1:
            assert second.errors.steady("contour_error_mean") == 0.0
    several = found.groups[1].rows[1]
    # Two of the four pairs are of one seed: the mean is half of that between two seeds.
    half = 0.5 * several.between_seeds.steady("contour_error_mean")
    assert several.errors.steady("contour_error_mean") == pytest.approx(half, rel=1e-9) != 0.0


def test_a_difference_within_its_interval_is_chance(found):
    group = found.groups[1]
    toe = group.rows[1].changes[TOE]
    assert toe is None or (toe.value == 0.0 and toe.is_chance and toe.share is None)
    power = group.rows[1].changes[POWER]
    assert power.is_chance == (abs(power.value) <= power.half_width)
    assert found.groups[0].rows[1].changes[POWER].is_chance is None  # one seed over a short time


def test_what_differs_is_named(found):
    assert [row.fact.label for row in found.differing] == ["sliding friction, ball and ball"]
    assert found.differing[0].values == (0.5, 0.3)
    assert answer(found, "One difference?").found == "they differ in the contacts alone"
    assert answer(found, "The same mill?").state == "good"
    assert "physical mill" in answer(found, "Scaled alike?").found
    assert answer(found, "Seeds?").state == "look"


def test_different_mills_are_stated_and_compared_in_both_units(tmp_path):
    """Twice the length is twice the power and the same dimensionless number."""
    short = mills(tmp_path / "short", *(charge_case(2.6, seed) for seed in SEEDS))
    long = [charge_case(2.6, seed, physical__length_m=2.0) for seed in SEEDS]
    found = side_by_side([short, mills(tmp_path / "long", *long)])
    (group,) = found.groups
    assert group.rows[1].changes[POWER].share == pytest.approx(1.0, rel=1e-9)
    assert group.rows[1].numbers["power"] == pytest.approx(group.rows[0].numbers["power"])
    same = answer(found, "The same mill?")
    assert same.state == "look" and "length [m] 1 | 2" in same.found
    assert "dimensionless" in same.remedy
    assert answer(found, "Seeds?").state == "good"
    # Cases without dumps have no shape; the page is made all the same.
    assert "no dumps" in answer(found, "Whole?").found
    assert figures.contours(group, found.measured, figures.colours_of(found.sides), False) is None


def test_without_a_common_mill_the_most_trusted_are_shown_and_it_is_stated(tmp_path):
    folders = [
        mills(tmp_path / f"S{S}", *(charge_case(x, seed) for x in (S, 6.0) for seed in (1,)))
        for S in (1.696, 2.6)
    ]
    for folder in folders:
        shutil.rmtree(folder / "cases/mb-cg-paper-S6.000-seed1")
    found = side_by_side(folders)
    (group,) = found.groups
    assert group.kind is None and [row.case.S for row in group.rows] == [1.696, 2.6]
    assert answer(found, "Scaled alike?").state == "look"
    assert "not finished" in answer(found, "Whole?").found


def test_a_series_of_speeds_is_drawn_against_the_speed(tmp_path):
    folders = []
    for percent in (80.0, 70.0, 75.0):
        omega = percent / 100.0 * math.sqrt(9.81 / (3.9 - 0.02))
        cases = [charge_case(2.6, seed, physical__omega_rad_s=omega) for seed in SEEDS]

        def torque(S, seed, percent=percent):
            return percent / 75.0 * torque_number(S, seed)

        folders.append(mills(tmp_path / f"{percent:g}", *cases, torque=torque))
    found = side_by_side(folders)
    assert found.varied.fact.heading == "speed [% of critical]"
    assert_allclose(found.varied.values, (80.0, 70.0, 75.0))
    colours = figures.colours_of(found.sides)
    figure = figures.answers(found, found.groups[0], colours)
    axes = figure.axes[0]
    assert axes.get_ylabel() == QUANTITIES[POWER].heading
    assert figure.axes[2].get_xlabel() == "speed [% of critical]"
    x, y = axes.lines[0].get_data()
    assert_allclose(x, [70.0, 75.0, 80.0])
    powers = [row.row.estimates[POWER].value for row in found.groups[0].rows]
    assert_allclose(y, [powers[1], powers[2], powers[0]])
    # Torque and speed. The wave of the torque is not scaled, and does not end with a window.
    assert_allclose(np.array(y) / y[1], (np.array(x) / 75.0) ** 2, rtol=1e-5)


def test_the_speed_is_that_of_the_physical_mill_and_a_profile_has_no_trapezoid():
    """A scaled mill has another share of the critical speed: its ball is larger."""
    rows = {row.fact.heading: row for row in fact_rows([typed(charge_case(2.6, 1))])}
    share = 100.0 / math.sqrt(9.81 / (3.9 - 0.02))
    assert rows["speed [% of critical]"].values[0] == pytest.approx(share, rel=1e-12)
    assert rows["face angle [deg]"].values[0] > 0.0
    case = charge_case(2.6, 1)
    case["mill"]["profile"] = [[1.0, 0.0, 0.0, 0, 0]]
    assert "face angle [deg]" not in {x.fact.heading for x in fact_rows([typed(case)])}


@pytest.mark.parametrize("physical", [False, True])
def test_series_are_in_the_colour_of_their_folder_and_in_the_unit_named(found, physical):
    colours = figures.colours_of(found.sides)
    group = found.groups[0]
    power = figures.series(group, colours, physical).axes[2]
    assert power.get_ylabel() == f"drive power {'[kW]' if physical else '/ M g R ω'}"
    assert [line.get_color() for line in power.lines] == list(colours.values())
    for line, row in zip(power.lines, group.rows, strict=True):
        (charge,) = row.charges
        over = charge.series["drive_power_W"] / charge_scales(charge.case, charge.series).power
        scale = 1e-3 * row.row.physical.power_scale if physical else 1.0
        assert_allclose(line.get_ydata(), scale * over)


def test_contours_of_the_physical_mill_are_those_over_R_less_a_times_it(found):
    colours, group = figures.colours_of(found.sides), found.groups[1]
    over, metres = (figures.contours(group, found.measured, colours, x) for x in (False, True))
    unit = group.rows[0].case.physical
    for a, b in zip(over.axes, metres.axes, strict=True):
        for ours, theirs in zip(a.lines, b.lines, strict=True):
            scale = unit.radius_m - unit.ball_radius_m
            assert_allclose(theirs.get_ydata(), scale * ours.get_ydata())
    assert len(over.legends) == 1
    assert [x.get_text() for x in over.legends[0].get_texts()] == list(colours)


@pytest.mark.parametrize("count", [2, 6, 11])
def test_colours_of_folders_are_distinct_and_seen_on_white(found, count):
    class Named:
        def __init__(self, name):
            self.name = name

    colours = figures.colours_of([Named(str(i)) for i in range(count)])
    assert len(set(colours.values())) == count
    for colour in colours.values():
        channels = np.array([int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5)])
        linear = np.where(
            channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4
        )
        assert 1.05 / (linear @ [0.2126, 0.7152, 0.0722] + 0.05) >= 3.0, colour


def test_keys_of_the_campaign_files_that_differ_are_listed(throws, worn, tmp_path):
    folders = [shutil.copytree(x, tmp_path / x.name) for x in (throws, worn)]
    for folder, height in zip(folders, (120, 60), strict=True):
        text = f'[campaign]\nname = "a"\n[liner]\nlifter_height_mm = {height}\n'
        (folder / "campaign.toml").write_text(text + "[[liner.row]]\ncount = 3\n" * (height == 60))
    keys = {row.key: row.values for row in side_by_side(folders).keys}
    assert keys == {"liner.lifter_height_mm": ("120", "60"), "liner.row[0].count": ("", "3")}
    (folders[0] / "campaign.toml").write_text("[liner")
    assert side_by_side(folders).keys == ()


def test_the_page_and_its_numbers(throws, worn, tmp_path):
    done = millscale("compare", throws, worn, "--to", tmp_path / "new/page")
    assert done.returncode == 0, done.stderr
    assert done.stdout == f"comparison: {tmp_path / 'new/page/index.html'}\n"
    page = (tmp_path / "new/page/index.html").read_text()
    assert "They differ in <b>contacts</b>" in page and "(+20.0 %)" in page
    assert page.count("<figure") == page.count("data:image/webp") > 6
    assert "http" not in page.partition('id="plotly"')[0]
    content = json.loads((tmp_path / "new/page/comparison.json").read_text())
    assert [x["name"] for x in content["runs"]] == [throws.name, "worn"]
    rows = [x for x in content["multi_ball"] if x["group"] == PHYSICAL]
    power = [row["physical_mill"]["power [kW]"] for row in rows]
    assert power[1]["difference"] == pytest.approx((MORE - 1.0) * power[0]["value"], rel=1e-6)
    # An earlier comparison is replaced, anything else is kept.
    again = millscale("compare", worn, throws, "--to", tmp_path / "new/page", "--json")
    assert json.loads(again.stdout)["runs"][0]["name"] == "worn"
    refused = millscale("compare", worn, throws, "--to", tmp_path)
    assert refused.returncode == 2 and "is no earlier comparison" in refused.stderr


def test_single_balls_are_compared(runs, tmp_path):
    copy = shutil.copytree(runs, tmp_path / "copy")
    found = side_by_side([runs, copy])
    group = next(x for x in found.balls if x.kind.S == 2.6)
    first, second = group.rows
    assert first.ball.result == second.ball.result and first.ball is not second.ball
    figure = figures.trajectories(group, figures.colours_of(found.sides))
    radius = first.ball.case.mill.radius_m
    assert figure.axes[0].lines[0].get_xdata()[0] == first.ball.series["x_m"][0] / radius


@pytest.mark.parametrize(
    ("folders", "message"),
    [
        (("throws",), "one runs folder; name two or more"),
        (("throws", "throws"), "is named twice"),
        (("throws", "empty"), "no case is finished; run them with: millscale run FILE --runs"),
        (("throws", "absent"), "absent/campaign.json: no such file"),
    ],
)
def test_wrong_folders_are_refused(throws, tmp_path, folders, message):
    places = {"throws": throws, "empty": tmp_path / "empty", "absent": tmp_path / "absent"}
    (tmp_path / "empty/cases/mb-x").mkdir(parents=True)
    content = {"schema": 1, "name": "empty", "cases": ["mb-x"]}
    (tmp_path / "empty/campaign.json").write_text(json.dumps(content))
    with pytest.raises(RunFolderError, match=message):
        side_by_side([places[name] for name in folders])
