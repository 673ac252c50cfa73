"""Presets and rows of lifters: closed forms of their shapes, and campaigns that state them."""

import math
from itertools import pairwise

import numpy as np
import pytest

from liner_files import NOWHERE, apart
from millscale import _core
from millscale.campaign.build import load_campaign
from millscale.cases.case import cases_of
from millscale.cases.law import physical_liner
from millscale.errors import CampaignError
from millscale.liner.given import Preset, liner_of_preset, liner_of_rows
from millscale.liner.lifter_rows import LifterRow, wave_outline
from small_campaign import TEXT

R = 4.0


def test_rows_of_equal_lifters_are_the_trapezoids_of_the_engine():
    row = LifterRow(0.3, 0.25, 0.3, 0.3)
    for rows, lifters in (((row,), 25), ((row, row), 24)):
        own = liner_of_rows(NOWHERE, R, rows, lifters, 0.1).shape
        engine = _core.Lifters.from_face_angle(R, R - 0.3, 0.25, 0.3, lifters, 0.1)
        assert own.sectors == lifters // len(rows)
        # The number of lifters in a sector moves its middle.
        turned = _core.Profile(
            list(own.nodes), own.sectors, math.pi / lifters * (len(rows) - 1) + 0.1
        )
        assert apart(turned if len(rows) > 1 else own, engine, most=4.5) < 1e-12


def test_faces_lean_as_stated_and_edges_are_round():
    row = LifterRow(0.3, 0.25, math.radians(14), math.radians(47), 0.04)
    nodes = liner_of_rows(NOWHERE, R, (row,), 20, 0.0).shape.nodes
    assert sorted(node[2] for node in nodes if node[2] < 0.0) == pytest.approx([-0.04, -0.04])
    along = {
        face: math.atan2(t2 - t, r2 - r)
        for (r, t, arc, face, _), (r2, t2, *_) in pairwise([*nodes, nodes[0]])
        if arc == 0.0
    }
    # A lifter's centre line is a quarter turn before its top; the trailing face is the next one's.
    centre = along[2] - 0.5 * math.pi
    lean = {
        1: math.degrees(math.remainder(along[1] - centre, math.pi)),
        3: -math.degrees(math.remainder(along[3] - centre - math.tau / 20, math.pi)),
    }
    assert lean == pytest.approx({1: 14.0, 3: 47.0}, abs=1e-9)


def test_a_wave_is_smooth_and_as_high_as_stated():
    liner = liner_of_preset(NOWHERE, R, Preset("wave", 20, 0.2), 0.0).shape
    assert (liner.radius, liner.clear_radius) == pytest.approx((R, R - 0.2), rel=1e-12)
    outline = wave_outline(NOWHERE, R, 0.2, 20)
    for i in range(3):
        arriving, leaving = (
            math.atan2(*(outline.ends[k] - outline.points[k])[::-1])
            + side * 2.0 * math.atan(outline.bulges[k])
            for k, side in ((i, 1.0), (i + 1, -1.0))
        )
        assert math.remainder(arriving - leaving, math.tau) == pytest.approx(0.0, abs=1e-12)


def test_a_step_has_the_area_of_its_triangles():
    liner = liner_of_preset(NOWHERE, R, Preset("step", 10, 0.2), 0.0).shape
    # Per pitch: axis to edge, along the face to the circle, and on to the next edge; the face is
    # radial.
    expected = 10 * 0.5 * R * (R - 0.2) * math.sin(math.tau / 10)
    assert liner.area == pytest.approx(expected, rel=1e-12)


def test_a_plain_preset_is_a_drum():
    liner = liner_of_preset(NOWHERE, R, Preset("plain", 0), 0.0).shape
    assert isinstance(liner, _core.Lifters) and liner.lifters == 0


@pytest.mark.parametrize(
    ("rows", "lifters", "text"),
    [
        ((LifterRow(0.3, 0.25, 0.3, 0.3),) * 2, 25, "got 25 with 2 rows"),
        ((LifterRow(0.3, 0.9, 0.3, 0.3),), 25, "overlaps the next lifter at the foot by"),
        ((LifterRow(4.1, 0.1, 0.3, 0.3),), 25, "reaches the axis"),
        ((LifterRow(0.01, 1.0, 0.3, 0.3),), 5, "leaves the liner's circle"),
        ((LifterRow(0.3, 0.25, 0.3, 0.3, 0.4),), 25, "edge radius of 0.4 m does not fit"),
    ],
)
def test_rows_that_do_not_fit_are_refused(rows, lifters, text):
    with pytest.raises(CampaignError, match=text):
        liner_of_rows(NOWHERE, R, rows, lifters, 0.0)


def campaign(folder, liner):
    head, _, tail = TEXT.partition("[liner]")
    text = head + "[liner]\n" + liner + "\n[ball]" + tail.partition("[ball]")[2]
    (folder / "c.toml").write_text(text)
    return load_campaign(folder / "c.toml")


WAVE = 'preset = "wave"\nlifters = 12\nlifter_height_mm = 60\n'
HI_LO = """lifters = 12
[[liner.row]]
height_mm = 60
top_width_in = 2
leading_angle_deg = 14
[[liner.row]]
height_mm = 30
top_width_mm = 50
trailing_angle_deg = 30
edge_radius_mm = 5
"""


@pytest.mark.parametrize(
    ("liner", "sectors"),
    [
        (WAVE, 12),
        (HI_LO, 6),
        ('preset = "plain"\n', 1),
        ('preset = "step"\nlifters = 10\nlifter_height_m = 0.05\nface_angle_deg = 5\n', 10),
        ('preset = "rail"\nlifters = 9\nlifter_height_m = 0.05\nlifter_top_width_mm = 60\n', 9),
        ('preset = "ship-lap"\nlifters = 8\nlifter_height_m = 0.05\nlifter_top_width_mm = 60\n', 8),
    ],
)
def test_campaigns_with_presets_and_rows_plan(tmp_path, liner, sectors):
    found = campaign(tmp_path, liner)
    assert physical_liner(found).sectors == sectors
    for case in cases_of(found):
        assert case.liner_file is None
        assert case.mill.lifters == (sectors if sectors > 1 else 0)


@pytest.mark.parametrize(
    ("liner", "text"),
    [
        (WAVE + 'profile = "a.csv"\n', "stated by profile and by preset"),
        (WAVE + "groove_width_m = 0.1\n", r'given with preset = "wave".*which takes lifter_height'),
        (WAVE.replace("lifters = 12\n", ""), r"liner\.lifters: missing"),
        (WAVE.replace("lifter_height_mm = 60", ""), r"liner\.lifter_height_m: missing"),
        (WAVE.replace("60", "1600"), "got 1.6 in a mill of 1 m"),
        ('preset = "plain"\nlifters = 3\n', r"liner\.lifters: got 3"),
        ("tolerance_mm = 3\n", "given with trapezoidal lifters"),
        ('profile = "no.csv"\n', "no such file"),
        (HI_LO.replace("lifters = 12", "lifters = 13"), "a multiple of 2"),
        (HI_LO.replace("height_mm = 30\n", ""), r"liner\.row\[2\]\.height_m: missing"),
    ],
)
def test_contradictions_are_refused_with_key_and_remedy(tmp_path, liner, text):
    with pytest.raises(CampaignError, match=text) as error:
        campaign(tmp_path, liner)
    assert "accepted: " in str(error.value)


def test_an_offset_liner_whose_radius_is_at_a_corner_is_refused(tmp_path):
    found = campaign(
        tmp_path, 'preset = "step"\nlifters = 10\nlifter_height_m = 0.05\nface_angle_deg = 5\n'
    )
    path = tmp_path / "c.toml"
    path.write_text(path.read_text().replace('["paper"]', '["offset-liner"]'))
    assert np.isfinite(physical_liner(found).area)
    with pytest.raises(CampaignError, match=r"farthest from the axis at a corner|offset"):
        cases_of(load_campaign(path))
