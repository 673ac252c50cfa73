"""provenance.json and `millscale verify`."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

from millscale.cases.decks import template_folder
from millscale.engine import code_version
from millscale.runs.digests import digest_of
from millscale.runs.layout import STAGES
from millscale.runs.provenance import read_provenance, write_provenance
from millscale.workflow import stage_record, verify
from millscale.workflow.run_stage import run_stage
from small_campaign import CHARGE, SINGLE_BALLS, TEXT

BALL = SINGLE_BALLS[0]


def records(folder):
    return json.loads((folder / "provenance.json").read_text())["stages"]


def test_every_stage_records_code_machine_and_command(finished):
    for case_id, kind in ((BALL, "single-ball"), (CHARGE, "multi-ball")):
        stages = records(finished.case(case_id))
        assert set(stages) == {stage.name for stage in STAGES[kind]}
        for stage in STAGES[kind]:
            made = stages[stage.name]
            assert set(stage.products) <= set(made["products"])
            assert made["command"].startswith("millscale run ")
            assert made["libraries"]["numpy"] and made["hardware"]["cores"] >= 1
            assert ("engine" in made) == bool(stage.deck)
    made = records(finished.case(CHARGE))["rotate"]
    assert "dump/charge.000000000.liggghts" in made["products"]
    assert len(made["engine"]["sha256"]) == 64


def test_digests_are_those_of_sha256sum(finished):
    case = finished.case(BALL)
    line = subprocess.run(
        ["sha256sum", case / "series.csv"], capture_output=True, text=True, check=True
    )
    digest = line.stdout.split()[0]
    stages = records(case)
    assert stages["rotate"]["products"]["series.csv"] == digest
    assert stages["result"]["inputs"]["series.csv"] == digest


def test_the_commit_is_that_of_git():
    top = Path(code_version.__file__).parents[3]
    line = ["git", "-C", top, "rev-parse", "HEAD"]
    done = subprocess.run(line, capture_output=True, text=True)
    if done.returncode or not (top / ".git").exists():
        pytest.skip("not in a repository")
    commit = done.stdout.strip()
    assert code_version.source_commit() == commit
    assert code_version.described_commit().removesuffix("-dirty") == commit[:12]


@pytest.mark.parametrize(("modified", "suffix"), [(False, ""), (True, "-dirty")])
def test_an_installed_package_knows_its_commit(tmp_path, monkeypatch, modified, suffix):
    monkeypatch.setattr(code_version, "_TOP", tmp_path)
    build = {"commit": 40 * "a", "modified": modified}
    monkeypatch.setattr(code_version, "build_record", lambda: build)
    assert code_version.source_commit() is None
    assert code_version.described_commit() == 12 * "a" + suffix
    monkeypatch.setattr(code_version, "build_record", lambda: None)
    assert code_version.described_commit() is None


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
    ("name", "by", "message"),
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
        ("case.json", lambda text: text[:100], "case.json: not valid JSON"),
        ("provenance.json", lambda text: "{}", "liner.stl: stage mesh has no provenance"),
    ],
)
def test_differences_are_reported(finished, name, by, message):
    changed(finished, name, by)
    done = finished("verify")
    assert done.returncode == 1 and f"{BALL}/{message}" in done.stdout
    rows = json.loads(finished("verify", "--json").stdout)["differences"]
    assert {row["case"] for row in rows} == {BALL}


def test_a_deck_of_another_version_may_differ_in_comments_alone(finished, tmp_path, monkeypatch):
    templates = tmp_path / "templates"
    shutil.copytree(template_folder(), templates)
    deck = templates / "integrate.in"
    deck.write_text("# Another comment.\n" + deck.read_text())
    monkeypatch.setattr(verify, "template_folder", lambda: templates)
    assert not verify.verify(finished.runs).differences
    deck.write_text(deck.read_text() + "shell echo\n")
    differences = verify.verify(finished.runs).differences
    assert {difference.file for difference in differences} == {"integrate.in"}


OLDER = {"millscale": "0.0.9", "commit": 40 * "b"}


@pytest.fixture
def older(finished, tmp_path, monkeypatch):
    """A finished runs folder whose provenance names an older version with other templates and
    parameters."""
    for case_id in (*SINGLE_BALLS, CHARGE):
        folder = finished.case(case_id)
        stages = {name: {**made, **OLDER} for name, made in records(folder).items()}
        write_provenance(folder, stages)
    templates = tmp_path / "templates"
    shutil.copytree(template_folder(), templates)
    (templates / "integrate.in").write_text("fix integrate all nve/sphere\n")
    monkeypatch.setattr(verify, "template_folder", lambda: templates)
    monkeypatch.setattr(verify, "parameters_text", lambda case: "variable other equal 1\n")
    return finished


def test_a_folder_of_an_older_version_is_compared_with_its_digests(older):
    done = older("verify")
    assert done.stdout.splitlines()[0] == (
        "3 cases made by millscale 0.0.9 (commit bbbbbbbbbbbb): "
        "case.json and decks are compared with their digests only"
    )
    assert done.returncode == 0 and "no differences" in done.stdout
    assert json.loads(older("verify", "--json").stdout)["note"] in done.stdout


def test_an_older_version_is_noted_where_it_made_part_of_the_cases(older):
    folder = older.case(CHARGE)
    write_provenance(folder, {x: {**y, "commit": None} for x, y in records(folder).items()})
    (folder.parent / BALL / "provenance.json").unlink()
    note = older("verify").stdout.splitlines()[-2]
    assert note.startswith("2 cases made by millscale 0.0.9 (commit bbbbbbbbbbbb) and 1 other vers")


@pytest.mark.parametrize(
    ("name", "by", "message"),
    [
        ("series.csv", lambda text: text.replace("6", "7"), "series.csv: SHA-256 is"),
        ("guard.in", lambda text: text + "shell echo\n", "guard.in: SHA-256 is"),
        ("parameters.in", lambda text: text + "\n", "parameters.in: SHA-256 is"),
        (
            "case.json",
            lambda text: text.replace('"gravity_m_s2": 9.81', '"gravity_m_s2": 9.82'),
            "case.json: is not the one that campaign.json records",
        ),
    ],
)
def test_a_changed_file_of_an_older_version_is_found(older, name, by, message):
    changed(older, name, by)
    done = older("verify")
    assert done.returncode == 1 and f"{BALL}/{message}" in done.stdout


def test_a_deck_that_no_version_recorded_is_found(older):
    (older.case(BALL) / "more.in").write_text("shell echo\n")
    assert f"{BALL}/more.in: no digest recorded" in older("verify").stdout


def test_a_changed_copy_of_the_campaign_is_found_in_an_older_folder(older):
    copy = older.runs / "campaign.toml"
    copy.write_text(copy.read_text() + "# another\n")
    assert "campaign.toml: changed since campaign.json was written" in older("verify").stdout


def test_a_missing_product_and_another_campaign_are_reported(finished):
    (finished.case(BALL) / "result.json").unlink()
    copy = finished.runs / "campaign.toml"
    copy.write_text(TEXT.replace("speed_rad_s = 2.0", "speed_rad_s = 2.1"))
    done = finished("verify")
    assert f"{BALL}/result.json: missing" in done.stdout
    assert f"{CHARGE}/case.json: differs from the campaign in physical.omega_rad_s" in done.stdout


def test_a_product_made_from_another_input_is_reported(finished):
    case, other = finished.case(BALL), finished.case(SINGLE_BALLS[1])
    stages = records(case)
    stages["rotate"]["products"]["series.csv"] = digest_of(other / "series.csv")
    content = {"schema": 1, "stages": stages}
    (case / "provenance.json").write_text(json.dumps(content))
    shutil.copyfile(other / "series.csv", case / "series.csv")
    assert f"{BALL}/result.json: stage result has read another series.csv" in (
        finished("verify").stdout
    )


def test_a_stage_refuses_an_input_that_was_damaged(finished):
    changed(finished, "series.csv", lambda text: text[:-40])
    case = finished.case(BALL)
    assert run_stage(case, "result") == 1
    cause = "damaged file: series.csv does not match its digest"
    assert stage_record.read_record(case).cause.startswith(cause)
    assert not (case / "result.json").exists()


def test_a_damaged_product_is_made_again(finished):
    before = (finished.case(BALL) / "series.csv").read_text()
    changed(finished, "series.csv", lambda text: text[:-40])
    message = "rotate  (series.csv is not what stage rotate made)"
    assert message in finished("run", "--dry-run").stdout
    assert finished("run").returncode == 0
    assert (finished.case(BALL) / "series.csv").read_text() == before
    assert "no differences" in finished("verify").stdout


def test_a_damaged_restart_does_not_reach_the_engine(finished):
    case = finished.case(CHARGE)
    restart = case / "settled.restart"
    date = restart.stat().st_mtime_ns
    whole = restart.read_bytes()
    restart.write_bytes(whole[:-3])
    os.utime(restart, ns=(date, date))
    assert finished("run").returncode == 0
    assert restart.read_bytes() == whole


@pytest.mark.parametrize(
    "content",
    ["[]", "{", '{"schema": 1, "stages": {"mesh": {"inputs": {}, "products": {"../x": "a"}}}}',
     '{"schema": 1, "stages": {"mesh": {"inputs": {}, "products": {"/etc/passwd": "a"}}}}',
     '{"schema": 1, "stages": {"mesh": 3}}', "[" * 10**6],
)  # fmt: skip
def test_a_damaged_record_or_one_that_leads_outside_counts_as_none(tmp_path, content):
    (tmp_path / "provenance.json").write_text(content)
    assert read_provenance(tmp_path) == {}
