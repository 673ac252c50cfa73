"""Outlines that are no liner are refused in one line that states what and where."""

import math

import ezdxf
import numpy as np
import pytest

from liner_files import families, write_csv, write_dxf
from millscale.errors import CampaignError
from millscale.liner.given import Source, liner_from_file

R = 1.0
PITCH = families(R)["rib"]


def csv_lines(tmp_path, unit="mm"):
    write_csv(tmp_path / "good.csv", PITCH, unit)
    return (tmp_path / "good.csv").read_text().splitlines()


def refusal(path, content, **more):
    if isinstance(content, list):
        content = "\n".join(content)
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(CampaignError) as error:
        liner_from_file(Source(path, **more), R, 0.0)
    text = str(error.value)
    assert "\n" not in text and path.name in text and "accepted: " in text
    return text


def test_a_table_that_is_no_table(tmp_path):
    path, good = tmp_path / "a.csv", csv_lines(tmp_path)
    assert "empty" in refusal(path, "")
    assert "no header: the first row is" in refusal(path, good[1:])
    assert 'row 1: got the header "x,y"' in refusal(path, ["x,y", *good[1:]])
    assert 'row 1: got the header "x_mm,y_in"' in refusal(path, ["x_mm,y_in", *good[1:]])
    assert "2 points" in refusal(path, good[:3])
    assert "row 9: got 1 columns: 12" in refusal(path, [*good[:8], "12"])
    assert "decimal commas" in refusal(path, [*good[:5], "1,5,2,5"])
    assert "row 6: got 1 | nan" in refusal(path, [*good[:5], "1,nan"])
    assert "bytes of 0" in refusal(path, "\n".join(good).encode("utf-16-le"))
    with pytest.raises(CampaignError, match="no such file"):
        liner_from_file(Source(tmp_path / "no.csv"), R, 0.0)
    assert 'a file that ends in ".pdf"' in refusal(tmp_path / "a.pdf", "x")


def test_a_table_cut_short_does_not_span_a_pitch(tmp_path):
    good = csv_lines(tmp_path)
    text = refusal(tmp_path / "a.csv", good[: len(good) // 2])
    assert "do not meet" in text or "open by" in text


@pytest.mark.parametrize("wrong", ["m", "cm", "in", "ft"])
def test_the_unit_that_would_fit_is_named(tmp_path, wrong):
    good = csv_lines(tmp_path)
    text = refusal(tmp_path / "a.csv", [f"x_{wrong},y_{wrong}", *good[1:]])
    assert "mill.radius_m is 1" in text and "the numbers fit if their unit is mm" in text


def test_an_outline_that_crosses_itself_names_both_pieces(tmp_path):
    good = csv_lines(tmp_path)
    swapped = [*good[:2], good[4], good[3], good[2], *good[5:]]
    text = refusal(tmp_path / "a.csv", swapped)
    assert "crosses or touches itself" in text and "row 3 " in text and "row 5 " in text


def test_neighbouring_pitches_that_cross_are_refused(tmp_path):
    half = math.pi / 8
    points = np.array([[math.cos(half), -math.sin(half)], [0.8, -0.5], [0.8, 0.5],
                       [math.cos(half), math.sin(half)]])  # fmt: skip
    rows = [f"{x},{y}" for x, y in points]
    assert "crosses" in refusal(tmp_path / "a.csv", ["x_m,y_m", *rows])


def test_lifters_that_point_away_from_the_axis_are_inside_out(tmp_path):
    good = csv_lines(tmp_path, "m")
    points = np.array([[float(v) for v in row.split(",")] for row in good[1:]])
    r, angle = np.hypot(*points.T), np.arctan2(points[:, 1], points[:, 0])
    out = np.column_stack([(2.0 - r) * np.cos(angle), (2.0 - r) * np.sin(angle)])
    rows = [f"{x},{y}" for x, y in out]
    assert "inside out" in refusal(tmp_path / "a.csv", ["x_m,y_m", *rows])


def test_a_body_beside_the_axis_is_no_liner(tmp_path):
    rows = ["x_m,y_m", "0.9,-0.1", "1,-0.1", "1,0.1", "0.9,0.1", "0.9,-0.1"]
    text = refusal(tmp_path / "a.csv", rows)
    assert "does not go around the axis" in text and "its middle is at x = 0.95, y = 0" in text


def test_asymmetric_lifters_need_a_direction(tmp_path):
    write_csv(tmp_path / "a.csv", families(R)["worn"])
    with pytest.raises(CampaignError, match=r'liner\.turns = "clockwise" or "counter-clockwise"'):
        liner_from_file(Source(tmp_path / "a.csv"), R, 0.0)


def test_a_number_of_lifters_that_contradicts_the_pitch(tmp_path):
    text = refusal(tmp_path / "a.csv", csv_lines(tmp_path), lifters=9)
    assert "spans 45 degrees, 8 of them around the mill, and liner.lifters is 9" in text


def test_drawings_with_faults(tmp_path):
    path = tmp_path / "a.dxf"
    write_dxf(path, PITCH)
    good = path.read_bytes()
    assert "empty" in refusal(path, b"")
    assert "not a DXF drawing" in refusal(path, b"hello")
    assert "cut short: no EOF after line" in refusal(path, good[: len(good) // 2])
    assert "no line, arc or curve" in refusal(path, good.replace(b"LWPOLYLINE", b"XWPOLYLINE"))


def loose(tmp_path, change):
    """A drawing of all trapezoids as loose lines."""
    nodes = 1e3 * PITCH.points
    drawing = ezdxf.new("R2010", units=4)
    pieces = [[nodes[i], nodes[i + 1]] for i in range(len(nodes) - 1)]
    change(pieces)
    for begin, end in pieces:
        drawing.modelspace().add_line(begin, end)
    drawing.saveas(tmp_path / "a.dxf")
    return (tmp_path / "a.dxf").read_bytes()


def test_a_gap_between_lines_is_located(tmp_path):
    def gap(pieces):
        pieces[1][0] = pieces[1][0] + [0.5, 0.0]

    text = refusal(tmp_path / "a.dxf", loose(tmp_path, gap))
    assert "the outline is open: 0.5 in the drawing's unit to the nearest end" in text


def test_a_branch_is_located(tmp_path):
    def branch(pieces):
        pieces.append([pieces[1][0], [0.0, 0.0]])

    assert "more than two lines meet" in refusal(tmp_path / "a.dxf", loose(tmp_path, branch))


def test_a_line_drawn_twice_is_one_line(tmp_path):
    (tmp_path / "a.dxf").write_bytes(loose(tmp_path, lambda pieces: pieces.append(pieces[1][::-1])))
    assert liner_from_file(Source(tmp_path / "a.dxf"), R, 0.0).shape.sectors == 8
