"""series.csv: columns by name, damage reported."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from millscale.runs.series import read_series
from millscale.runs.untrusted import RunFolderError
from synthetic_ball import usual_motion
from synthetic_case import write_series


def test_columns_are_taken_by_name_not_by_position(case, tmp_path):
    columns = usual_motion(case).series()
    write_series(tmp_path / "a.csv", columns)
    write_series(tmp_path / "b.csv", dict(reversed(columns.items())))
    first, second = (read_series(tmp_path / f"{n}.csv", "single-ball") for n in "ab")
    for name, values in columns.items():
        assert_allclose(first[name], values, rtol=1e-9, atol=1e-12)
        assert np.array_equal(first[name], second[name])


def test_cut_line_is_named(folder):
    path = folder / "series.csv"
    text = path.read_text()
    path.write_text(text[: len(text) // 2].rsplit(",", 3)[0])
    lines = len(path.read_text().splitlines())
    with pytest.raises(RunFolderError, match=rf"series.csv: line {lines} has .*cut short.*run"):
        read_series(path, "single-ball")


def test_a_missing_file_is_reported_with_the_command_that_makes_it(tmp_path):
    with pytest.raises(RunFolderError, match=r"no such file; run the case again: millscale run"):
        read_series(tmp_path / "series.csv", "single-ball")


@pytest.mark.parametrize(("rows", "cause"), [(0, "no column step"), (1, "0 rows"), (2, "1 rows")])
def test_file_without_rows_is_refused(folder, rows, cause):
    path = folder / "series.csv"
    path.write_text("\n".join(path.read_text().splitlines()[:rows]))
    with pytest.raises(RunFolderError, match=cause):
        read_series(path, "single-ball")


def test_missing_column_is_named(case, tmp_path):
    columns = usual_motion(case).series()
    del columns["time_in_flight_s"]
    write_series(tmp_path / "series.csv", columns)
    with pytest.raises(RunFolderError, match=r"no column time_in_flight_s; columns are step"):
        read_series(tmp_path / "series.csv", "single-ball")


@pytest.mark.parametrize("value", ["nan", "inf", "4o"])
def test_value_that_is_no_number_is_refused(folder, value):
    path = folder / "series.csv"
    lines = path.read_text().splitlines()
    cells = lines[7].split(",")
    cells[5] = value
    lines[7] = ",".join(cells)
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(RunFolderError, match=f"z_m is {value} in line 8|not a number"):
        read_series(path, "single-ball")


def test_two_runs_in_one_file_are_reported(folder):
    path = folder / "series.csv"
    lines = path.read_text().splitlines()
    path.write_text("\n".join([*lines, lines[3]]) + "\n")
    with pytest.raises(RunFolderError, match=r"step goes from .* two runs in one file"):
        read_series(path, "single-ball")


@pytest.mark.parametrize("column", [1, 2])
@pytest.mark.parametrize("change", [0.0, -0.1])
def test_time_and_mill_angle_must_increase(folder, column, change):
    path = folder / "series.csv"
    lines = path.read_text().splitlines()
    before, cells = (line.split(",") for line in lines[-2:])
    cells[column] = repr(float(before[column]) + change)
    lines[-1] = ",".join(cells)
    path.write_text("\n".join(lines) + "\n")
    cause = rf"(time_s|mill_angle_rad) goes from .* in line {len(lines)}"
    with pytest.raises(RunFolderError, match=cause):
        read_series(path, "single-ball")


def test_a_mill_at_rest_stays_at_angle_0(case, tmp_path):
    columns = usual_motion(case).series()
    columns["mill_angle_rad"][:3] = 0.0
    write_series(tmp_path / "series.csv", columns)
    assert read_series(tmp_path / "series.csv", "single-ball")["mill_angle_rad"][2] == 0.0


def test_two_columns_of_a_name_and_a_row_that_looks_like_a_comment_are_refused(folder):
    path = folder / "series.csv"
    text = path.read_text()
    path.write_text(text.replace(",x_m,", ",x_m,x_m,").replace("\n", ",0\n"))
    with pytest.raises(RunFolderError, match="two columns have the same name"):
        read_series(path, "single-ball")
    lines = text.splitlines()
    path.write_text("\n".join([*lines[:9], f"#{lines[9]}", *lines[10:]]) + "\n")
    with pytest.raises(RunFolderError, match="a value is not a number"):
        read_series(path, "single-ball")


@pytest.mark.parametrize(
    ("column", "value", "accepted"),
    [
        ("largest_overlap_m", "nan", False),
        ("toe_angle_rad", "nan", True),
        ("toe_angle_rad", "inf", False),
    ],
)
def test_only_optional_columns_may_be_nan(case, tmp_path, column, value, accepted):
    columns = usual_motion(case).series()
    columns[column] = np.full_like(columns["step"], float(value))
    write_series(tmp_path / "series.csv", columns)
    if accepted:
        assert np.isnan(read_series(tmp_path / "series.csv", "single-ball")[column]).all()
    else:
        with pytest.raises(RunFolderError, match=f"{column} is {value} in line 2"):
            read_series(tmp_path / "series.csv", "single-ball")
