"""Progress from files that the engine is still writing."""

import os
import time
from types import SimpleNamespace

import pytest

from millscale.runs.layout import stage_of
from millscale.workflow import progress
from millscale.workflow.progress import Progress, last_value, stage_progress


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", 0.0),
        ("step,time_s\n", 0.0),
        ("step,time_s\n10,0.1\n20,0.2\n", 20.0),
        ("step,time_s\n10,0.1\n20,0", 10.0),
        ("step,time_s\n10,0.1\n2\n", 10.0),
        ("step,time_s\nsoon,0.1\n", 0.0),
        ("step,time_s\nnan,0.1\n", 0.0),
        ("step,time_s\n" + "".join(f"{i},0.{i:06d}\n" for i in range(5000)), 4999.0),
    ],
)
def test_the_last_full_line_counts(tmp_path, text, expected):
    path = tmp_path / "series.csv"
    path.write_text(text)
    assert last_value(path, "step") == expected


def test_a_series_that_is_not_there_yet_is_zero(tmp_path):
    assert last_value(tmp_path / "series.csv", "step") == 0.0


def charge_case(folder):
    """A multi-ball case of 100 settling and 1,000 rotation steps, half way in the stages."""
    (folder / "settle.part").mkdir()
    (folder / "rotate.part").mkdir()
    return SimpleNamespace(time=SimpleNamespace(settle_steps=100, steps=1000))


def test_settling_is_read_from_the_log(tmp_path):
    case = charge_case(tmp_path)
    log = tmp_path / "settle.part" / "log.settle"
    log.write_text(
        "    Step    Atoms    KinEng\n       0   50   0\n      25   50   0.9144\n      5"
    )
    assert stage_progress(tmp_path, case, stage_of("multi-ball", "settle")).step == 25


@pytest.mark.parametrize("first", [10, 110])
def test_a_rotation_counts_from_its_own_start(tmp_path, first):
    case = charge_case(tmp_path)
    series = tmp_path / "rotate.part" / "series.csv"
    series.write_text(f"step,time_s\n{first},0\n{first + 290},1\n")
    os.utime(series, (5.0, 5.0))
    found = stage_progress(tmp_path, case, stage_of("multi-ball", "rotate"))
    assert found == Progress(step=300, at=5.0)


def test_a_stage_that_has_written_nothing_is_at_its_start(tmp_path):
    case = charge_case(tmp_path)
    for name in ("settle", "rotate"):
        assert stage_progress(tmp_path, case, stage_of("multi-ball", name)) == Progress(0, 0.0)


def test_a_stage_that_begins_anew_while_it_is_read_is_at_its_start(tmp_path, monkeypatch):
    case = charge_case(tmp_path)
    series = tmp_path / "rotate.part" / "series.csv"
    series.write_text("step,time_s\n10,0\n300,1\n")

    def last_value_then_gone(path, column):
        value = last_value(path, column)
        series.unlink()
        return value

    monkeypatch.setattr(progress, "last_value", last_value_then_gone)
    stage = stage_of("multi-ball", "rotate")
    assert stage_progress(tmp_path, case, stage) == Progress(0, 0.0)


@pytest.mark.parametrize(
    ("line", "since"),
    [
        ("Setting up run at Sun Nov 22 20:11:32 2026\n", (2026, 11, 22, 20, 11, 32, 0, 0, -1)),
        ("Setting up run at some time\n", None),
        ("reading restart file\n", None),
    ],
)
def test_a_rate_counts_from_the_first_step_and_not_from_the_reading_of_files(tmp_path, line, since):
    case = charge_case(tmp_path)
    part = tmp_path / "rotate.part"
    (part / "series.csv").write_text("step,time_s\n10,0\n300,1\n")
    (part / "log.rotate").write_text(f"LIGGGHTS\n{line}Memory usage per processor\n")
    found = stage_progress(tmp_path, case, stage_of("multi-ball", "rotate"))
    assert found.since == (time.mktime(since) if since else 0.0)
