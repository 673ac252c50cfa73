"""provenance.json and `millscale verify`."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest
from small_campaign import CHARGE, SINGLE_BALLS, TEXT

from mill_campaign import provenance
from mill_runs.layout import STAGES

BALL = SINGLE_BALLS[0]


def stages_of(folder):
    return json.loads((folder / "provenance.json").read_text())["stages"]


def test_every_stage_says_with_what_it_was_made(finished):
    for case_id, kind in ((BALL, "single-ball"), (CHARGE, "multi-ball")):
        stages = stages_of(finished.case(case_id))
        assert set(stages) == {stage.name for stage in STAGES[kind]}
        for stage in STAGES[kind]:
            made = stages[stage.name]
            assert set(stage.products) <= set(made["products"])
            assert made["command"].startswith("millscale run ")
            assert made["libraries"]["numpy"] and made["hardware"]["cores"] >= 1
            assert ("engine" in made) == bool(stage.deck)
    made = stages_of(finished.case(CHARGE))["rotate"]
    assert "dump/charge.000000000.liggghts" in made["products"]
    assert len(made["engine"]["sha256"]) == 64


def test_digests_are_those_of_sha256sum(finished):
    case = finished.case(BALL)
    line = subprocess.run(
        ["sha256sum", case / "series.csv"], capture_output=True, text=True, check=True
    )
    digest = line.stdout.split()[0]
    stages = stages_of(case)
    assert stages["rotate"]["products"]["series.csv"] == digest
    assert stages["result"]["inputs"]["series.csv"] == digest


def test_the_commit_is_that_of_git():
    top = Path(provenance.__file__).parents[2]
    line = ["git", "-C", top, "rev-parse", "HEAD"]
    done = subprocess.run(line, capture_output=True, text=True)
    if done.returncode or not (top / ".git").exists():
        pytest.skip("not in a repository")
    assert provenance.source_commit() == done.stdout.strip()


def test_an_untouched_folder_has_no_differences(finished):
    done = finished("verify")
    assert done.returncode == 0 and "no differences" in done.stdout


def changed(finished, name, by):
    path = finished.case(BALL) / name
    text = path.read_text()
    date = path.stat().st_mtime_ns
    path.write_text(by(text))
    os.utime(path, ns=(date, date))


@pytest.mark.parametrize(
    ("name", "by", "said"),
    [
        ("series.csv", lambda text: text.replace("6", "7"), "series.csv: SHA-256 is"),
        ("liner.stl", lambda text: text[:-200], "liner.stl: SHA-256 is"),
        ("integrate.in", lambda text: text + "shell echo\n", "integrate.in: not the deck of this"),
        (
            "parameters.in",
            lambda text: text.replace("omega_physical string 2", "omega_physical string 3"),
            "parameters.in: not what case.json says",
        ),
        (
            "case.json",
            lambda text: text.replace('"gravity_m_s2": 9.81', '"gravity_m_s2": 9.82'),
            "case.json: differs from the campaign in physical.gravity_m_s2 (campaign 9.81, file",
        ),
        ("case.json", lambda text: text[:100], "case.json: cannot be read"),
        ("provenance.json", lambda text: "{}", "liner.stl: stage mesh has no provenance"),
    ],
)
def test_what_differs_is_said(finished, name, by, said):
    changed(finished, name, by)
    done = finished("verify")
    assert done.returncode == 1 and f"{BALL}/{said}" in done.stdout
    rows = json.loads(finished("verify", "--json").stdout)["differences"]
    assert {row["case"] for row in rows} == {BALL}


def test_a_missing_product_and_another_campaign_are_said(finished):
    (finished.case(BALL) / "result.json").unlink()
    copy = finished.runs / "campaign.toml"
    copy.write_text(TEXT.replace("speed_rad_s = 2.0", "speed_rad_s = 2.1"))
    done = finished("verify")
    assert f"{BALL}/result.json: missing" in done.stdout
    assert f"{CHARGE}/case.json: differs from the campaign in physical.omega_rad_s" in done.stdout


def test_a_product_made_from_another_input_is_said(finished):
    case, other = finished.case(BALL), finished.case(SINGLE_BALLS[1])
    stages = stages_of(case)
    stages["rotate"]["products"]["series.csv"] = provenance.digest_of(other / "series.csv")
    content = {"schema": 1, "stages": stages}
    (case / "provenance.json").write_text(json.dumps(content))
    shutil.copyfile(other / "series.csv", case / "series.csv")
    assert f"{BALL}/result.json: stage result has read another series.csv" in (
        finished("verify").stdout
    )


def test_a_stage_refuses_an_input_that_was_damaged(finished):
    changed(finished, "series.csv", lambda text: text[:-40])
    (finished.case(BALL) / "result.json").unlink()
    done = finished("run")
    assert done.returncode == 1
    assert "result failed: damaged file: series.csv does not match its digest" in done.stdout


def test_a_damaged_restart_does_not_reach_the_engine(finished):
    case = finished.case(CHARGE)
    restart = case / "settled.restart"
    date = restart.stat().st_mtime_ns
    restart.write_text(restart.read_text()[:-3])
    os.utime(restart, ns=(date, date))
    (case / "series.csv").unlink()
    done = finished("run")
    assert "rotate failed: damaged file: settled.restart does not match" in done.stdout
    assert not (case / "rotate.part" / "log.rotate").exists()


@pytest.mark.parametrize(
    "content",
    ["[]", "{", '{"schema": 1, "stages": {"mesh": {"inputs": {}, "products": {"../x": "a"}}}}',
     '{"schema": 1, "stages": {"mesh": {"inputs": {}, "products": {"/etc/passwd": "a"}}}}',
     '{"schema": 1, "stages": {"mesh": 3}}', "[" * 10**6],
)  # fmt: skip
def test_a_damaged_record_or_one_that_leads_outside_counts_as_none(tmp_path, content):
    (tmp_path / "provenance.json").write_text(content)
    assert provenance.read_provenance(tmp_path) == {}
