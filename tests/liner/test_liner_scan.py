"""A scan of hundreds of noisy points becomes a few lines and arcs within its stated error."""

import re

import numpy as np
import pytest

from liner_files import NOISE, NOWHERE, families, trapezoids, write_scan
from millscale import _core
from millscale.errors import CampaignError
from millscale.liner.csv_table import read_csv
from millscale.liner.given import Source, liner_from_file
from millscale.liner.outline import Outline, arc_points
from millscale.liner.simplify import reached_error, signed_distance, simplified

R = 4.0


@pytest.mark.parametrize("name", families(R))
def test_a_scan_becomes_few_pieces_within_the_stated_error(tmp_path, name):
    outline = families(R)[name]
    write_scan(tmp_path / "scan.csv", outline)
    source = Source(tmp_path / "scan.csv", tolerance=6e-3, turns="counter-clockwise")
    given = liner_from_file(source, R, 0.0)
    said = re.search(r"400 points are (\d+) lines and arcs, none farther than (\S+) m", str(given))
    assert int(said[1]) <= 20 and float(said[2]) <= 6e-3
    # Against what was scanned: the stated error, and that of the points in both directions.
    found = simplified(read_csv(tmp_path / "scan.csv"), 6e-3)
    assert reached_error(found, outline) <= float(said[2]) + np.sqrt(2.0) * NOISE + 1e-5
    assert found.pieces == int(said[1])


def test_the_stated_error_is_that_of_the_worst_point():
    points = np.column_stack([np.linspace(0.0, 1.0, 50), np.zeros(50)])
    points[20, 1] = 3e-3
    names = tuple(map(str, range(50)))
    line = Outline(NOWHERE, points, np.zeros(50), names, closed=False)
    found = simplified(line, 5e-3)
    assert 1e-3 < reached_error(line, found) <= 5e-3
    exact = simplified(line, 1e-4)
    assert reached_error(line, exact) <= 1e-4 and exact.pieces > found.pieces


def test_a_tolerance_below_the_noise_is_reported(tmp_path):
    write_scan(tmp_path / "scan.csv", families(R)["rib"])
    given = liner_from_file(
        Source(tmp_path / "scan.csv", tolerance=1.5e-3, turns="clockwise"), R, 0
    )
    assert "tolerance below the noise" in str(given.warnings)


def test_points_without_a_tolerance_are_taken_as_they_are(tmp_path):
    write_scan(tmp_path / "scan.csv", families(R)["rib"], noise=2e-4)
    given = liner_from_file(Source(tmp_path / "scan.csv", turns="clockwise"), R, 0.0)
    assert len(given.shape.nodes) == 399


def test_noise_that_crosses_itself_needs_a_tolerance(tmp_path):
    write_scan(tmp_path / "scan.csv", families(R)["rib"], noise=2e-2)
    with pytest.raises(CampaignError, match=r"crosses or touches itself"):
        liner_from_file(Source(tmp_path / "scan.csv", turns="clockwise"), R, 0.0)


def test_distances_from_arcs_are_those_from_their_circles():
    random = np.random.default_rng(1)
    for bulge in (0.9, -0.3, 1e-3, 0.0):
        begin, end = random.uniform(-1.0, 1.0, (2, 2))
        shares = np.linspace(0.1, 0.9, 5)
        line = begin + shares[:, None] * (end - begin)
        arc = arc_points(begin, end, bulge, shares) if bulge else line
        along = (end - begin) / np.linalg.norm(end - begin)
        left = np.array([-along[1], along[0]])
        rows = [np.repeat([p], 5, axis=0) for p in (begin, end)]
        on = signed_distance(arc, *rows, np.full(5, bulge))
        np.testing.assert_allclose(on, 0.0, atol=2e-12)
        beside = signed_distance(arc[2:3] + 1e-3 * left, begin[None], end[None], np.array([bulge]))
        np.testing.assert_allclose(beside, 1e-3, rtol=1e-9)


def test_closed_scans_are_fitted_from_a_corner():
    nodes = trapezoids(R).polygon(1e-3)[0]
    names = ("p",) * len(nodes)
    closed = Outline(NOWHERE, nodes, np.zeros(len(nodes)), names, closed=True)
    found = simplified(closed, 2e-3)
    assert found.closed and found.pieces <= 4 * 8 + 2
    assert reached_error(closed, found) <= 2e-3


def test_a_circle_within_the_tolerance_is_a_plain_drum(tmp_path):
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    rows = "".join(f"{R * np.cos(a)},{R * np.sin(a)}\n" for a in angle)
    (tmp_path / "drum.csv").write_text("x_m,y_m\n" + rows)
    drum = liner_from_file(Source(tmp_path / "drum.csv", tolerance=2e-3), R, 0.0).shape
    assert isinstance(drum, _core.Lifters) and drum.lifters == 0 and drum.radius == R
