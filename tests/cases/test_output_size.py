"""Disk space of cases: predicted, compared with files, and required before a run."""

import json
import shutil
from collections import namedtuple

import pytest
from msgspec import structs

from millscale.campaign.build import load_campaign
from millscale.cases import output_size
from millscale.cases.case import cases_of
from millscale.cases.output_size import output_bytes, size_text
from millscale.errors import CampaignError
from small_campaign import CHARGE, SINGLE_BALLS, TEXT

Usage = namedtuple("Usage", "total used free")


def case_of(tmp_path, text, number=-1):
    (tmp_path / "c.toml").write_text(text)
    return cases_of(load_campaign(tmp_path / "c.toml"))[number]


def test_output_grows_by_the_dumps_asked_for(tmp_path):
    base = case_of(tmp_path, TEXT)
    more = structs.replace(base, output=structs.replace(base.output, dump_steps=35))
    dumps = [x.time.steps // x.output.dump_steps for x in (base, more)]
    grown = (dumps[1] - dumps[0]) * (output_size.DUMP_HEAD + 50 * output_size.DUMPED_BALL)
    assert output_bytes(more) - output_bytes(base) == grown > 0


def test_a_case_beyond_its_budget_is_refused(tmp_path):
    text = (
        TEXT.replace("count = [50]", "count = [50]\ndump_angle_rad = 1e-4") + "[run]\noutput_gb = "
    )
    with pytest.raises(CampaignError, match=f"run.output_gb: {CHARGE} would write .* GB"):
        case_of(tmp_path, text + "0.01")
    assert case_of(tmp_path, text + "1.0").predicted.output_bytes > 1e7


def test_the_plan_shows_the_disk_space(millscale):
    rows = json.loads(millscale("plan", "--json").stdout)
    assert all(1e5 < row["output_bytes"] < 1e7 for row in rows)
    assert "disk" in millscale("plan").stdout


def test_a_small_disk_is_refused_before_anything_is_written(millscale, monkeypatch):
    monkeypatch.setattr(shutil, "disk_usage", lambda _: Usage(10**9, 10**9, 10**6))
    done = millscale("run")
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1
    assert "the cases to do write" in done.stderr and "1.0 MB free" in done.stderr
    assert "--ignore-disk" in done.stderr and not millscale.runs.exists()


def test_a_small_disk_is_enough_for_finished_cases(finished, monkeypatch):
    monkeypatch.setattr(shutil, "disk_usage", lambda _: Usage(10**9, 10**9, 10**6))
    assert finished("run").returncode == 0
    (finished.case(SINGLE_BALLS[0]) / "series.csv").unlink()
    assert finished("run").returncode == 2
    assert finished("run", "--ignore-disk", "--dry-run").returncode == 0


@pytest.mark.parametrize(
    ("size", "text"),
    [(0, "0 B"), (12_345, "12 kB"), (3_400_000, "3.4 MB"), (1.24e9, "1.2 GB"), (4e12, "4000 GB")],
)
def test_sizes_are_shown_with_a_unit(size, text):
    assert size_text(size) == text


@pytest.mark.engine
def test_a_run_takes_the_predicted_disk_space(tmp_path, monkeypatch):
    """At most the prediction and over a fifth of it; fixed parts dominate so small a case."""
    from millscale.workflow.run_stage import run_stage
    from provoked_failures import prepared

    runs = prepared(tmp_path)
    folder = runs / "cases" / CHARGE
    for stage in ("settle", "rotate"):
        assert run_stage(folder, stage) == 0
    places = (folder, runs / "settled")
    taken = sum(x.stat().st_size for place in places for x in place.rglob("*") if x.is_file())
    predicted = json.loads((folder / "case.json").read_text())["predicted"]["output_bytes"]
    assert 0.2 * predicted < taken <= predicted
