"""A runs folder belongs to one campaign, and only chosen cases are replaced."""

import json
import os
import shutil

import pytest

from millscale.cases.generate import generate
from millscale.runs.case_digest import case_digest
from millscale.runs.provenance import read_provenance, write_provenance
from millscale.workflow import stage_record
from small_campaign import CHARGE, SINGLE_BALLS, TEXT

OTHER_STEP = TEXT.replace("step_s = 1e-4", "step_s = 0.5e-4", 1)


def content(folder):
    return {p: p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def states(command):
    rows = json.loads(command("status", "--json").stdout)
    return {row["id"]: (row["state"], row["stages_left"]) for row in rows}


@pytest.mark.parametrize(
    ("old", "new", "cause"),
    [
        ('name = "small"', 'name = "other"', 'belongs to campaign "small", '),
        ("speed_rad_s = 2.0", "speed_rad_s = 2.1", "its omega_rad_s is 2.0, not 2.1"),
        ("radius_m = 1.0", "radius_m = 1.1", "its radius_m is 1.0, not 1.1"),
        ("radius_m = 0.02", "radius_m = 0.021", "its ball_radius_m is 0.02, not 0.021"),
    ],
    ids=["name", "speed", "mill", "ball"],
)
@pytest.mark.parametrize("summary", [True, False], ids=["", "without campaign.json"])
def test_another_campaign_is_refused_before_anything_is_written(finished, old, new, cause, summary):
    finished.file.write_text(TEXT.replace(old, new, 1))
    if not summary:
        (finished.runs / "campaign.json").unlink()
    before = content(finished.runs)
    for line in (("run",), ("run", "--dry-run"), ("run", "--only", CHARGE), ("generate",)):
        refused = finished(*line)
        assert refused.returncode == 2 and refused.stderr.count("\n") == 1
        assert cause in refused.stderr and "another folder after --runs" in refused.stderr
    assert content(finished.runs) == before


def test_a_campaign_file_changed_by_hand_in_the_folder_is_not_overwritten(finished):
    copy = finished.runs / "campaign.toml"
    copy.write_text(TEXT.replace("count = [50]", "count = [51]"))
    before = content(finished.runs)
    for line in (("run",), ("generate",)):
        refused = finished(*line)
        assert refused.returncode == 2 and f"{copy}: changed by hand" in refused.stderr
        assert f"mv {copy} mine.toml and run that, or rm {copy}" in refused.stderr
    assert content(finished.runs) == before
    # Nothing is lost if the copy equals the campaign file or was deleted.
    finished.file.write_text(copy.read_text())
    assert finished("generate").returncode == 0
    copy.unlink()
    finished.file.write_text(TEXT)
    assert finished("generate").returncode == 0
    assert copy.read_text() == TEXT


def test_only_the_chosen_cases_are_replaced_and_the_others_are_known_as_outdated(finished):
    one, other = SINGLE_BALLS
    finished.file.write_text(OTHER_STEP)
    before = content(finished.runs)
    done = finished("run", "--only", one)
    assert done.returncode == 0, done.stdout
    after = content(finished.runs)
    changed = {p.relative_to(finished.runs / "cases").parts[0] for p in after
               if "cases" in p.parts and after[p] != before.get(p)}  # fmt: skip
    assert changed == {one}
    assert states(finished) == {one: ("done", 0), other: ("waiting", 4), CHARGE: ("done", 0)}
    verified = finished("verify")
    assert verified.returncode == 1
    assert f"{other}/case.json: differs from the campaign in time.step_s" in verified.stdout
    assert f"{one}/" not in verified.stdout and f"{CHARGE}/" not in verified.stdout
    assert f"{other}\n  mesh    (new case.json)" in finished("run", "--dry-run").stdout
    # With the first text again, the other case is outdated.
    finished.file.write_text(TEXT)
    assert finished("run", "--only", other).returncode == 0
    assert states(finished) == {one: ("waiting", 4), other: ("done", 0), CHARGE: ("done", 0)}
    assert finished("run").returncode == 0
    assert "no differences" in finished("verify").stdout


def test_cases_written_and_not_run_are_not_done(finished):
    """As Ctrl-C in a rerun leaves them: the new case.json beside the products of the old one."""
    finished.file.write_text(OTHER_STEP)
    assert finished("generate").returncode == 0
    series = finished.case(SINGLE_BALLS[0]) / "series.csv"
    assert series.exists()
    assert states(finished)[SINGLE_BALLS[0]][0] == "waiting"
    assert "0 of" not in finished("run", "--dry-run").stdout.splitlines()[-1]
    assert finished("run").returncode == 0
    assert {state for state, _ in states(finished).values()} == {"done"}


def test_a_failure_of_the_case_before_it_was_changed_is_no_longer_shown(finished):
    case = finished.case(SINGLE_BALLS[0])
    (case / "liner.stl").unlink()
    digest = case_digest(json.loads((case / "case.json").read_text()))
    record = stage_record.begin(case, "mesh", digest)
    stage_record.end(case, record, "failed", "no memory")
    # Copied, so that every date is later than the failure.
    shutil.copytree(finished.runs, finished.runs.with_name("copy"), copy_function=shutil.copyfile)
    shutil.rmtree(finished.runs)
    finished.runs.with_name("copy").rename(finished.runs)
    assert states(finished)[SINGLE_BALLS[0]][0] == "failed"
    finished.file.write_text(OTHER_STEP)
    generate(finished.file, finished.runs)
    assert states(finished)[SINGLE_BALLS[0]][0] == "waiting"


@pytest.mark.parametrize("way", ["cp -r", "future"])
def test_a_copied_campaign_is_done_and_stays_so(finished, way):
    copy = finished.runs.with_name("copy")
    shutil.copytree(finished.runs, copy, copy_function=shutil.copyfile)
    shutil.rmtree(finished.runs)
    copy.rename(finished.runs)
    if way == "future":
        for number, path in enumerate(sorted(finished.runs.rglob("*"), reverse=True)):
            os.utime(path, (4e9 + number, 4e9 + number))
    before = finished.dates()
    lines = finished("run", "--dry-run").stdout.splitlines()
    assert lines[:3] == [f"{x}: done" for x in (*SINGLE_BALLS, CHARGE)]
    assert finished("run").returncode == 0
    assert finished.dates() == before


def test_a_folder_of_an_earlier_version_is_done_and_gets_what_it_lacks(finished):
    """Without the digests of cases in campaign.json and provenance.json, and of included decks."""
    file = finished.runs / "campaign.json"
    summary = json.loads(file.read_text())
    kept = {k: x for k, x in summary.items() if k not in ("digests", "physical", "copy")}
    file.write_text(json.dumps(kept))
    for case_id in (*SINGLE_BALLS, CHARGE):
        folder = finished.case(case_id)
        records = {name: dict(record) for name, record in read_provenance(folder).items()}
        for record in records.values():
            del record["case"]
            record["inputs"] = {
                name: digest
                for name, digest in record["inputs"].items()
                if not name.endswith(".in") or name in ("parameters.in", "settle.in", "mill.in")
                or name == "single_ball.in"
            }  # fmt: skip
        write_provenance(folder, records)
    before = finished.dates()
    assert {state for state, _ in states(finished).values()} == {"done"}
    assert finished("run").returncode == 0
    assert finished.dates() == before
    assert json.loads(file.read_text()) == summary
    # case.json holds the name of its campaign.
    file.write_text(json.dumps(kept))
    finished.file.write_text(TEXT.replace("speed_rad_s = 2.0", "speed_rad_s = 2.1"))
    assert "belongs to another physical mill" in finished("run").stderr
