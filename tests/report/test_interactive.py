"""What the script of the page draws: the lines of figures, the balls of charges."""

import base64
import gzip
import json
import shutil

import numpy as np
import pytest
from matplotlib.figure import Figure
from msgspec import structs

from millscale.analysis.finished_campaign import load_campaign
from millscale.analysis.shapes.snapshots import snapshots_near
from millscale.report import interactive
from millscale.report.ball_classes import colours_of_classes
from millscale.report.figures.style import colour_of_S
from millscale.report.interactive import chart_of, packed, view_of, views_of
from millscale.runs.case_file import BallClass, Balls
from millscale.runs.dumps import read_dump
from millscale.runs.untrusted import RunFolderError
from synthetic_result import with_case

CLASSES = tuple(BallClass(x, 2678.0, 50) for x in (0.1, 0.04, 0.06))
BALL = Balls(0.06, 7800.0, 1.0, 0.0, 3.0, 100)


def test_a_chart_holds_the_lines_and_axes_of_its_figure():
    figure = Figure()
    left, right = figure.subplots(1, 2)
    left.plot([0.0, 1.0, 2.0], [3.0, 4.0, np.nan], "--", color="#102030", label="S = 2")
    left.set(xlabel="angle [rad]", ylabel="power [kW]", xlim=(0.0, 2.0))
    right.plot([1.0, 10.0], [1.0, 2.0], "o", color="red")
    right.set_xscale("log")
    chart = chart_of(figure)
    one, other = chart["panels"]
    assert chart["columns"] == 2
    (line,) = one["lines"]
    assert (line["x"], line["y"], line["name"]) == ([0.0, 1.0, 2.0], [3.0, 4.0, None], "S = 2")
    assert (line["color"], line["dash"], line["mode"]) == ("#102030", "dash", "lines")
    assert one["x"] == {"title": "angle [rad]", "log": False, "range": [0.0, 2.0]}
    assert other["lines"][0]["mode"] == "markers" and other["x"]["log"]


def test_named_bands_are_part_of_a_chart():
    figure = Figure()
    axes = figure.subplots()
    axes.plot([0.0, 4.0], [1.0, 2.0])
    axes.axvspan(1.0, 2.5, color="#f3e3e0", lw=0).set_gid("II")
    axes.axvspan(3.0, 4.0, color="#000000")  # without a name
    (panel,) = chart_of(figure)["panels"]
    assert panel["bands"] == [{"name": "II", "x0": 1.0, "x1": 2.5, "color": "#f3e3e0"}]


def test_bars_and_pictures_stay_images():
    figure = Figure()
    figure.subplots().bar([1, 2], [3, 4])
    assert chart_of(figure) is None
    figure = Figure()
    figure.subplots().imshow(np.zeros((2, 2)))
    assert chart_of(figure) is None


def test_long_lines_are_thinned():
    figure = Figure()
    figure.subplots().plot(np.arange(10_000.0), np.zeros(10_000))
    x = chart_of(figure)["panels"][0]["lines"][0]["x"]
    assert interactive.MOST_POINTS / 2 < len(x) <= interactive.MOST_POINTS


def test_a_view_holds_the_balls_of_the_dumps(runs):
    charge = load_campaign(runs).charges[0]
    view = view_of(charge, 3)
    assert view["angles"] == pytest.approx([0.0, 0.5, 1.0], abs=0.02)
    R = charge.case.mill.radius_m
    (snapshot,) = snapshots_near(charge.folder, [1.0])
    dump = read_dump(snapshot.path)
    packed_places = base64.b64decode(view["frames"][-1]["places"])
    places = np.frombuffer(packed_places, "<i2").reshape(-1, 3) * 1.2 / 32767
    assert places[:, [0, 2]] == pytest.approx(dump.positions[:, [0, 2]] / R, abs=4e-5)
    assert view["ball"] == pytest.approx(charge.case.ball.radius_m / R, rel=1e-4)


def test_a_view_of_classes_names_them_and_the_class_of_each_ball(classes):
    several, equal = load_campaign(classes).charges
    view = view_of(several, 2)
    R = several.case.mill.radius_m
    assert [kind["name"] for kind in view["classes"]] == ["100 mm", "40 mm", "60 mm"]
    assert [kind["ball"] * R for kind in view["classes"]] == pytest.approx([0.1, 0.04, 0.06], 1e-3)
    assert [kind["color"] for kind in view["classes"]] == colours_of_classes(several.case.ball)
    kinds = np.frombuffer(base64.b64decode(view["frames"][-1]["kinds"]), "u1")
    (snapshot,) = snapshots_near(several.folder, [1.0])
    radii = np.array([0.1, 0.04, 0.06])[kinds]
    np.testing.assert_array_equal(radii, read_dump(snapshot.path)["radius"])
    alike = view_of(equal, 2)
    assert alike["classes"] == [] and "kinds" not in alike["frames"][0]


def test_a_charge_whose_dumps_hold_another_class_has_no_view(classes, tmp_path):
    copy = shutil.copytree(classes, tmp_path / "runs")
    several, equal = load_campaign(copy).charges
    several = with_case(several, ball=structs.replace(several.case.ball, classes=CLASSES[:2]))
    with pytest.raises(RunFolderError, match="of none of the 2 classes"):
        view_of(several, 2)
    assert list(views_of([several, equal])) == [equal.id]


def test_views_keep_within_the_size_of_a_page(runs, monkeypatch):
    charges = load_campaign(runs).charges
    monkeypatch.setattr(interactive, "MOST_BALLS", 2 * charges[0].balls + 1)
    views = views_of(charges)
    assert list(views) == [charges[0].id]
    assert len(views[charges[0].id]["frames"]) == 2


def test_packed_content_is_read_back():
    content = {"a": [1, None, "ω"]}
    assert json.loads(gzip.decompress(base64.b64decode(packed(content)))) == content


@pytest.mark.parametrize("S", [1.0, 1.1, 1.3, 1.7, 2.6, 4.0, 6.5, 20.0])
def test_the_colour_of_an_S_is_seen_on_white(S):
    assert contrast_on_white(colour_of_S(S)) >= 3.0


@pytest.mark.parametrize("count", [1, 2, 3, 6, 100])
def test_colours_of_classes_are_seen_on_white_and_go_by_size(count):
    radii = np.random.default_rng(1).permutation(np.linspace(0.02, 0.1, count))
    ball = structs.replace(BALL, classes=tuple(BallClass(x, 7800.0, 1) for x in radii.tolist()))
    colours = colours_of_classes(ball)
    contrasts = np.array([contrast_on_white(colour) for colour in colours])
    assert contrasts.min() >= 3.0
    assert len(set(colours)) == count
    # Lightness goes by size, so the order is seen in grey, too; 8 bits a channel round it.
    assert np.diff(contrasts[np.argsort(radii)]).max(initial=0.0) < 0.1


def contrast_on_white(colour):
    """Return the contrast of WCAG 2.2 of a colour on white."""
    channels = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    luminance = float(np.dot([0.2126, 0.7152, 0.0722], linear))
    return 1.05 / (luminance + 0.05)
