"""Maps of the solid fraction in moved coordinates: beds whose surface follows a known law."""

from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from typer.testing import CliRunner

from millscale.analysis.shapes.occupancy import OCCUPANCY, PolarCells, read_occupancy
from millscale.cli.main import app
from millscale.prediction.extrapolation import ExtrapolationError, scale_function, weights
from millscale.prediction.field import moved, predict_field, share_elsewhere
from millscale.runs.untrusted import RunFolderError
from synthetic_mills import charge_case, write_mills

CELLS = PolarCells(np.linspace(0.0, 1.0, 51), np.linspace(0.0, 2.0 * np.pi, 61))
EXPONENT = 0.875


def surface(S):
    """Radius at which the bed begins."""
    return 0.60 + 0.05 * float(scale_function(S, EXPONENT))


def bed(S):
    """A ring of balls between the surface and the liner in half of the sectors. Cells that the
    surface cuts are filled in part."""
    squares = CELLS.radii**2
    filled = np.clip((squares[1:] - surface(S) ** 2) / np.diff(squares), 0.0, 1.0)
    return 0.55 * filled[:, None] * (np.arange(60) < 30)[None, :]


def write_map(folder, field):
    radii, angles = CELLS.radii, CELLS.angles
    rows = [
        f"6,12,600,{radii[i]:.10g},{radii[i + 1]:.10g},{angles[j]:.10g},{angles[j + 1]:.10g},{x}"
        for (i, j), x in np.ndenumerate(field)
    ]
    head = (
        "mill_angle_from_rad,mill_angle_to_rad,samples,"
        "radius_low,radius_high,angle_low_rad,angle_high_rad,solid_fraction"
    )
    folder.mkdir(exist_ok=True)
    (folder / OCCUPANCY).write_text("\n".join([head, *rows, ""]))


class Charge(SimpleNamespace):
    __hash__ = object.__hash__


@pytest.fixture
def charge(tmp_path):
    def some(S):
        folder = tmp_path / f"S{S}"
        write_map(folder, bed(S))
        return Charge(S=S, id=f"S{S}", folder=folder)

    return some


def test_a_file_is_read_as_it_was_written(charge):
    cells, field = read_occupancy(charge(1.7).folder)
    assert cells.is_like(CELLS)
    assert_allclose(field, bed(1.7))
    assert cells.areas.sum() == pytest.approx(np.pi)


def test_a_sum_of_equal_maps_is_the_map():
    same = [bed(1.7), bed(1.7)]
    assert share_elsewhere(moved(same, np.array([1.8, -0.8]), CELLS), bed(1.7), CELLS) < 5e-3


def test_balls_are_as_many_as_the_law_gives():
    by = np.array([1.8, -0.8])
    fields = [bed(1.7), bed(2.6)]
    balls = [(field * CELLS.areas).sum() for field in fields]
    found = (moved(fields, by, CELLS) * CELLS.areas).sum()
    assert found == pytest.approx(by @ balls, rel=1e-9)


def test_the_surface_is_where_the_law_puts_it(charge):
    """Cell by cell, the cells that the surface passes are wrong."""
    found = predict_field([charge(1.7), charge(2.6)], [charge(1.0)])
    truth = CELLS.smooth(bed(1.0), 0.03)
    by = weights(np.array([1.7, 2.6]), np.ones(2), EXPONENT)
    by_cell = CELLS.smooth(by[0] * bed(1.7) + by[1] * bed(2.6), 0.03)
    assert found.check < 0.01
    assert found.check < 0.2 * share_elsewhere(by_cell, truth, CELLS)
    assert found.check < 0.1 * found.nearest


def test_the_share_elsewhere_of_two_apart_is_one():
    left, right = np.zeros((2, 50, 60))
    left[:, :30], right[:, 30:] = 0.5, 0.5
    assert share_elsewhere(left, right, CELLS) == pytest.approx(1.0)
    assert share_elsewhere(left, left, CELLS) == 0.0


def test_smoothing_keeps_a_constant_and_closes_the_circle():
    assert_allclose(CELLS.smooth(np.full((50, 60), 0.3), 0.03), 0.3)
    first = np.zeros((50, 60))
    first[25, 0] = 1.0
    smooth = CELLS.smooth(first, 0.1)
    assert smooth[25, 1] == pytest.approx(smooth[25, -1])


def test_maps_of_other_cells_are_refused(charge):
    other = charge(2.6)
    text = (other.folder / OCCUPANCY).read_text().replace(",0.02,0,", ",0.021,0,")
    (other.folder / OCCUPANCY).write_text(text)
    with pytest.raises((ExtrapolationError, RunFolderError), match="cells"):
        predict_field([charge(1.7), other])


def test_one_value_of_S_is_refused(charge):
    with pytest.raises(ExtrapolationError, match="two values of S"):
        predict_field([charge(1.7)])


@pytest.mark.parametrize("text", ["", "a,b\n1,2\n", "radius_low\n1\n"])
def test_a_file_that_is_not_whole_is_refused(charge, text):
    case = charge(1.7)
    (case.folder / OCCUPANCY).write_text(text)
    with pytest.raises(RunFolderError, match="no column"):
        read_occupancy(case.folder)


def test_a_cut_file_is_refused(charge):
    case = charge(1.7)
    text = (case.folder / OCCUPANCY).read_text()
    (case.folder / OCCUPANCY).write_text("\n".join(text.splitlines()[:-7]) + "\n")
    with pytest.raises(RunFolderError, match="cells are not whole"):
        read_occupancy(case.folder)


def test_the_command_writes_the_map(tmp_path):
    runs = write_mills(tmp_path / "runs", charge_case(1.696, 1), charge_case(2.6, 1))
    for folder in (runs / "cases").iterdir():
        write_map(folder, bed(1.696 if "S1.696" in folder.name else 2.6))
    to = tmp_path / "map.csv"
    done = CliRunner().invoke(app, ["predict", str(runs), "--field", str(to)])
    assert done.exit_code == 0, done.output
    rows = to.read_text().splitlines()
    assert rows[0].startswith("radius_low,") and len(rows) == 1 + 50 * 60


def test_a_map_that_is_not_predicted_is_not_written(tmp_path):
    runs = write_mills(tmp_path / "runs", charge_case(1.696, 1), charge_case(2.6, 1))
    done = CliRunner().invoke(app, ["predict", str(runs), "--field", str(tmp_path / "map.csv")])
    assert "occupancy.csv" in str(done.exception)
    assert not (tmp_path / "map.csv").exists()
