"""What the script of the page draws: the lines of figures, the balls of charges."""

import base64
import gzip
import json

import numpy as np
import pytest
from matplotlib.figure import Figure

from millscale.analysis.finished_campaign import load_campaign
from millscale.analysis.shapes.snapshots import snapshots_near
from millscale.report import interactive
from millscale.report.figures.style import colour_of_S
from millscale.report.interactive import chart_of, packed, view_of, views_of
from millscale.runs.dumps import read_dump


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
    channels = [int(colour_of_S(S)[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in channels]
    luminance = float(np.dot([0.2126, 0.7152, 0.0722], linear))
    assert 1.05 / (luminance + 0.05) >= 3.0
