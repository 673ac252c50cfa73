"""Damaged outlines of liners are refused in one line, or are liners."""

import pytest
from mutations import as_saved_elsewhere, damaged
from trials import NUMBERS, run

from liner_files import families, trapezoids, write_csv, write_dxf
from millscale.campaign.build import load_campaign
from millscale.cases.case import cases_of
from millscale.liner.given import Source, liner_from_file
from small_campaign import TEXT


def read_as(ending, **more):
    def read(folder, data):
        path = folder / f"a.{ending}"
        path.write_bytes(data)
        given = liner_from_file(Source(path, **more), 1.0, 0.0)
        # What is accepted can be simulated.
        given.shape.scaled(2.0).polygon(1e-3)
        assert abs(given.shape.radius - 1.0) < 1e-9

    return read


def tables(folder):
    found = []
    for name in ("rib", "worn", "wave"):
        write_csv(folder / "good.csv", families()[name], error=2e-3)
        found.append((folder / "good.csv").read_bytes())
    return found


@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.parametrize("tolerance", [None, 1e-3])
def test_tables(tallies, number, tolerance, tmp_path):
    inputs = damaged(tables(tmp_path)) | as_saved_elsewhere(tables(tmp_path))
    read = read_as("csv", tolerance=tolerance, turns="clockwise")
    run(tallies, f"liner table, tolerance {tolerance}", number, inputs, read, tmp_path)


def drawings(folder):
    """Return drawings of the oldest version, which is short, and of a recent one."""
    import ezdxf

    found = []
    for version in ("R12", "R2010"):
        drawing = ezdxf.new(version)
        drawing.header["$INSUNITS"] = 4
        outline = families()["worn"]
        points = 1e3 * outline.points
        for i in range(outline.pieces):
            drawing.modelspace().add_line(points[i], points[i + 1])
        drawing.saveas(folder / "good.dxf")
        found.append((folder / "good.dxf").read_bytes())
    write_dxf(folder / "good.dxf", families()["rib"])
    return [*found, (folder / "good.dxf").read_bytes()]


@pytest.mark.parametrize("number", NUMBERS)
def test_drawings(tallies, number, tmp_path):
    read = read_as("dxf", unit="mm", turns="clockwise")
    run(tallies, "liner drawing", number, damaged(drawings(tmp_path)), read, tmp_path)


@pytest.mark.parametrize("number", NUMBERS)
def test_shells(tallies, number, tmp_path):
    from millscale.cases.wall_panels import panels_of
    from millscale.mesh import write_stl

    write_stl(tmp_path / "good.stl", panels_of(trapezoids(), 0.3, 0.02, 1))
    text = (tmp_path / "good.stl").read_bytes()
    read = read_as("stl", unit="m")
    run(tallies, "liner shell", number, damaged([text]), read, tmp_path)


ROWS = """[liner]
lifters = 12
[[liner.row]]
height_mm = 60
top_width_mm = 50
leading_angle_deg = 14
[[liner.row]]
height_m = 0.03
top_width_mm = 50
trailing_angle_deg = 30
edge_radius_mm = 5
"""
PRESETS = (
    'preset = "wave"\nlifters = 12\nlifter_height_m = 0.06\n',
    'preset = "step"\nlifters = 10\nlifter_height_m = 0.05\nedge_radius_mm = 4\n',
    'preset = "ship-lap"\nlifters = 8\nlifter_height_m = 0.05\nlifter_top_width_m = 0.06\n',
)


@pytest.mark.parametrize("number", NUMBERS)
def test_campaigns_with_rows_and_presets(tallies, number, tmp_path):
    head, _, tail = TEXT.partition("[liner]")
    rest = "\n[ball]" + tail.partition("[ball]")[2]
    texts = [f"{head}{ROWS}{rest}", *(f"{head}[liner]\n{keys}{rest}" for keys in PRESETS)]

    def read(folder, data):
        (folder / "c.toml").write_bytes(data)
        cases_of(load_campaign(folder / "c.toml"))

    inputs = damaged([text.encode() for text in texts])
    run(tallies, "campaign with a liner", number, inputs, read, tmp_path)
