"""Tables and drawings become the liner they were drawn from."""

import math

import ezdxf
import numpy as np
import pytest

from liner_files import apart, apart_turned, families, shape_of, trapezoids, write_csv, write_dxf
from millscale.errors import CampaignError
from millscale.liner.given import Source, liner_from_file
from millscale.liner.outline import mirrored_outline, reversed_outline
from millscale.liner.sector import CLOCKWISE, COUNTER

FAMILIES = families()


def read(path, R=1.0, **more):
    return liner_from_file(Source(path, **more), R, 0.0)


@pytest.mark.parametrize("unit", ["mm", "in"])
@pytest.mark.parametrize("name", FAMILIES)
def test_a_drawing_is_the_liner_it_was_drawn_from(tmp_path, name, unit):
    write_dxf(tmp_path / "a.dxf", FAMILIES[name], unit)
    given = read(tmp_path / "a.dxf", turns=COUNTER)
    expected = shape_of(FAMILIES[name])
    # Coordinates in a drawing have some 15 digits.
    assert apart(given.shape, expected) < 1e-12
    assert [node[3:] for node in given.shape.nodes] == [node[3:] for node in expected.nodes]
    assert (given.file, len(given.digest)) == ("a.dxf", 64)


@pytest.mark.parametrize("unit", ["mm", "in"])
@pytest.mark.parametrize("name", FAMILIES)
def test_a_table_is_the_liner_within_chords_and_tolerance(tmp_path, name, unit):
    write_csv(tmp_path / "a.csv", FAMILIES[name], unit, error=1e-4)
    given = read(tmp_path / "a.csv", turns=COUNTER, tolerance=3e-4)
    # The tolerance, chords, and a step of the turns that are tried.
    expected = shape_of(FAMILIES[name])
    error = (
        apart(given.shape, expected) if name == "smooth" else apart_turned(given.shape, expected)
    )
    assert error < 3e-4 + 1e-4 + 2e-4
    assert len(given.shape.nodes) <= 2 * len(FAMILIES[name].points)


def test_the_trapezoids_of_the_engine_come_back_from_a_table(tmp_path):
    liner = trapezoids()
    nodes = liner.polygon(1e-5)[0]
    rows = "".join(f"{x!r};{z!r}\n" for x, z in nodes.tolist())
    (tmp_path / "a.csv").write_text("# all around\nx_m;y_m\n" + rows)
    given = read(tmp_path / "a.csv", turns=CLOCKWISE)
    assert given.shape.sectors == 8
    assert apart(given.shape, liner) < 2e-5
    faces, expected = ({node[3] for node in shape.nodes} for shape in (given.shape, liner))
    assert faces == expected == {0, 1, 2, 3}


def test_polar_columns_are_read(tmp_path):
    liner = trapezoids()
    nodes = liner.polygon(1e-5)[0]
    r, angle = np.hypot(*nodes.T) / 0.0254, np.degrees(np.arctan2(nodes[:, 1], nodes[:, 0]))
    rows = "".join(f"{a!r},{b!r}\n" for a, b in zip(r.tolist(), angle.tolist(), strict=True))
    (tmp_path / "a.csv").write_text("r_in,angle_deg\n" + rows)
    assert apart(read(tmp_path / "a.csv").shape, liner) < 2e-5


def test_order_of_points_and_side_of_view_do_not_matter(tmp_path):
    expected = shape_of(FAMILIES["worn"])
    for k, outline in enumerate((FAMILIES["worn"], reversed_outline(FAMILIES["worn"]))):
        write_dxf(tmp_path / f"{k}.dxf", outline)
        assert apart(read(tmp_path / f"{k}.dxf", turns=COUNTER).shape, expected) < 1e-12
        write_dxf(tmp_path / f"m{k}.dxf", mirrored_outline(outline))
        assert apart(read(tmp_path / f"m{k}.dxf", turns=CLOCKWISE).shape, expected) < 1e-12
        assert apart(read(tmp_path / f"m{k}.dxf", turns=COUNTER).shape, expected) > 1e-3


def test_lines_arcs_blocks_and_splines_of_a_drawing_are_joined(tmp_path):
    """A pitch of trapezoids as loose lines and an arc in a block, and the same with a spline."""
    outline = FAMILIES["rib"]
    p = 1e3 * outline.points
    for kind in ("arc", "spline", "ellipse"):
        drawing = ezdxf.new("R2010", units=4)
        block, space = drawing.blocks.new("PART"), drawing.modelspace()
        for i in (2, 0, 1):
            begin, end = (p[i], p[i + 1]) if i != 1 else (p[i + 1], p[i])
            space.add_line(begin, end)
        a, b = (math.atan2(*point[::-1]) for point in (p[3], p[4]))
        if kind == "arc":
            block.add_arc((0, 0), 1e3, math.degrees(a), math.degrees(b))
        elif kind == "ellipse":
            block.add_ellipse((0, 0), (1e3, 0), 1.0, a, b)
        else:
            angles = np.linspace(a, b, 40)
            points = 1e3 * np.column_stack([np.cos(angles), np.sin(angles)])
            block.add_spline(points)
        space.add_blockref("PART", (0, 0))
        space.add_text("LINER A-A")
        drawing.saveas(tmp_path / f"{kind}.dxf")
        given = read(tmp_path / f"{kind}.dxf")
        limit = 1e-9 if kind == "arc" else 2e-4
        assert apart(given.shape, shape_of(outline)) < limit
        assert any("splines and ellipses" in note for note in given.warnings) == (kind != "arc")


def test_one_layer_of_a_drawing_is_taken(tmp_path):
    write_dxf(tmp_path / "a.dxf", FAMILIES["rib"], layer="LINER")
    drawing = ezdxf.readfile(tmp_path / "a.dxf")
    drawing.modelspace().add_circle((0, 0), 1100, dxfattribs={"layer": "SHELL"})
    drawing.saveas(tmp_path / "a.dxf")
    with pytest.raises(CampaignError, match=r'2 separate outlines.*liner.layer.*"LINER", "SHELL"'):
        read(tmp_path / "a.dxf")
    assert apart(read(tmp_path / "a.dxf", layer="liner").shape, shape_of(FAMILIES["rib"])) < 1e-12
    with pytest.raises(CampaignError, match=r'no curve on the layer "linr", nearest is "LINER"'):
        read(tmp_path / "a.dxf", layer="linr")


def test_the_unit_of_a_drawing_is_never_guessed(tmp_path):
    write_dxf(tmp_path / "a.dxf", FAMILIES["rib"], "in", insunits=False)
    with pytest.raises(
        CampaignError, match=r"states no unit; accepted: liner\.unit, one of mm, cm"
    ):
        read(tmp_path / "a.dxf")
    assert apart(read(tmp_path / "a.dxf", unit="in").shape, shape_of(FAMILIES["rib"])) < 1e-12
    write_dxf(tmp_path / "a.dxf", FAMILIES["rib"], "mm")
    with pytest.raises(CampaignError, match="the numbers fit if their unit is mm"):
        read(tmp_path / "a.dxf", unit="in")


def test_a_mill_that_is_not_at_the_origin_is_moved(tmp_path):
    outline = FAMILIES["rib"]
    write_csv(tmp_path / "a.csv", outline, "m", 1e-6)
    text = (tmp_path / "a.csv").read_text().splitlines()
    moved = [f"{float(x) + 2.5},{float(y) - 1}" for x, y in (row.split(",") for row in text[1:])]
    (tmp_path / "a.csv").write_text("\n".join([text[0], *moved]))
    with pytest.raises(CampaignError, match=r"liner\.centre_x_m|spans"):
        read(tmp_path / "a.csv")
    given = read(tmp_path / "a.csv", centre=(2.5, -1.0))
    assert apart(given.shape, shape_of(outline)) < 3e-5
