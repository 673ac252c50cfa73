"""`millscale study`: what is run, what is taken, what comes of it."""

import io
import json
import shutil

import pytest
from rich.console import Console

import in_process
from millscale.analysis.measures import STUDIED
from millscale.cases.generate import generate
from millscale.engine.machine import CoreWish
from millscale.runs.layout import STAGES
from millscale.study import command, pareto, running
from millscale.study.command import StudyCall, run_and_compare
from millscale.study.file import load_study
from millscale.study.folders import Places, found_cases, record, write_setting
from millscale.study.results import study_charges
from small_study import TEXT, write_study
from synthetic_case import record_stages

CASE = "mb-cg-paper-S2.000"


def millscale(*words):
    """Exit code, output and errors of a command."""
    done = in_process.millscale(*words)
    return done.returncode, done.stdout, done.stderr


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A study run to its end by the engine."""
    folder = tmp_path_factory.mktemp("study")
    file = write_study(folder)
    code, output, errors = millscale("study", file, "--runs", folder / "runs")
    assert code == 0, output + errors
    return folder, output


@pytest.fixture
def copied(finished, tmp_path):
    """A copy of it, dates included."""
    shutil.copytree(finished[0], tmp_path / "study", symlinks=True)
    return tmp_path / "study"


def dates(folder):
    return {p: p.stat().st_mtime_ns for p in folder.glob("runs/settings/*/cases/*/*.csv")}


@pytest.mark.engine
def test_every_setting_is_run_once_and_a_case_made_twice_is_taken(finished):
    folder, output = finished
    runs = folder / "runs"
    made = sorted(str(path.relative_to(runs)) for path in runs.rglob("series.csv"))
    assert made == [
        f"settings/default/cases/{CASE}/series.csv",
        *(f"settings/reference/cases/{CASE}-seed{seed}/series.csv" for seed in (1, 2)),
    ]
    assert "setting 3 of 3, same: done" in output
    named = json.loads((runs / "study.json").read_text())["settings"]
    (case,) = named[2]["cases"]
    assert (case["id"], case["folder"]) == (CASE, f"settings/default/cases/{CASE}")
    # By what it is: the same in both settings.
    assert case["identity"] == named[1]["cases"][0]["identity"]


@pytest.mark.engine
def test_rows_have_times_and_all_errors(finished):
    content = json.loads((finished[0] / "runs/report/speed-against-error.json").read_text())
    rows = {row["setting"]: row for row in content["rows"]}
    assert list(rows) == ["reference", "default", "same"]
    for row in rows.values():
        assert row["study"] == "small-study"
        assert row["wall_time_s"] > row["processor_time_s"] > 0.0
        assert set(row["errors"]) == set(STUDIED)
        assert isinstance(row["on_front"], bool)
    assert rows["reference"]["is_reference"] and not rows["reference"]["on_front"]
    # One and the same run: equal in time and error, so both are on the front or none is.
    for key in ("wall_time_s", "errors", "on_front_of"):
        assert rows["same"][key] == rows["default"][key]
    assert rows["default"]["on_front"]
    for name in ("contour", "mass_flow", "power"):
        told = rows["default"]["errors"][name]
        assert told["error"] >= 0.0 and told["spread"] > 0.0
    told = content["studies"]["small-study"]
    assert {r["wanted"] for r in told["recommendations"]} == set(pareto.WANTED)
    assert told["missing"] == {} and told["time_to_solution"] == []
    assert set(told["provenance"]) >= {"command", "commit", "machine", "date"}


@pytest.mark.engine
def test_the_page_stands_alone(finished):
    page = (finished[0] / "runs/report/index.html").read_text()
    assert page.count("data:image/webp;base64,") == 1 + 3  # the worst; no curtains, no throws
    assert 'src="time' not in page and "half the step" in page


@pytest.mark.engine
def test_the_same_command_runs_nothing_and_says_the_same(copied, finished):
    before = dates(copied)
    code, output, _ = millscale("study", copied / "small-study.toml", "--runs", copied / "runs")
    assert code == 0 and dates(copied) == before
    assert [line for line in output.splitlines() if ": done" in line] == [
        f"setting {i} of 3, {name}: done"
        for i, name in enumerate(("reference", "default", "same"), 1)
    ]


@pytest.mark.engine
def test_json_is_all_that_is_printed_and_goes_beside_other_studies(copied):
    file = copied / "all.json"
    other = {"study": "other", "setting": "x"}
    content = {"schema": 1, "rows": [other], "studies": {"other": {}}}
    file.write_text(json.dumps(content))
    call = ("study", copied / "small-study.toml", "--runs", copied / "runs", "--no-run")
    for _ in range(2):  # the second replaces the first
        code, output, errors = millscale(*call, "--json", "--to", file)
        assert code == 0 and "page:" in errors
    printed = json.loads(output)
    content = json.loads(file.read_text())
    assert content["rows"] == [other, *printed["rows"]]
    assert list(content["studies"]) == ["other", "small-study"]


def pretend_finished(folder, setting):
    """Generate a setting, with a file and a record for every product."""
    cases = generate(write_setting(setting, folder), folder)
    for case in cases:
        for stage in STAGES["multi-ball"]:
            for product in stage.products:
                text = json.dumps({"torque_balance": {}} if product == "result.json" else {})
                (folder / "cases" / case.id / product).write_text(text)
        record_stages(folder / "cases" / case.id)
    return folder


def test_finished_cases_are_taken_from_elsewhere_by_what_they_are(tmp_path):
    study = load_study(write_study(tmp_path))
    elsewhere = pretend_finished(tmp_path / "elsewhere", study.settings[1])
    places = Places(tmp_path / "new", (elsewhere,))
    for setting, taken in zip(study.settings, ({}, {CASE}, {CASE}), strict=True):
        found = found_cases(study.settings, setting, places)
        assert set(found) == set(taken)
        assert all(folder == elsewhere / "cases" / CASE for folder in found.values())
    code, output, _ = millscale(
        *("study", study.file, "--plan", "--json", "--from", elsewhere, "--runs", tmp_path / "new")
    )
    assert code == 0 and not (tmp_path / "new").exists()
    assert [len(row["left"]) for row in json.loads(output)] == [2, 0, 0]
    assert json.loads(output)[1]["core_time_s"] == 0.0
    # What is not finished is not taken.
    (elsewhere / "cases" / CASE / "result.json").unlink()
    assert found_cases(study.settings, study.settings[1], places) == {}


def test_a_case_of_another_setting_is_taken_and_its_own_comes_first(tmp_path):
    study = load_study(write_study(tmp_path))
    places = Places(tmp_path / "runs")
    other = pretend_finished(places.of(study.settings[2]), study.settings[2])
    assert found_cases(study.settings, study.settings[1], places) == {CASE: other / "cases" / CASE}
    own = pretend_finished(places.of(study.settings[1]), study.settings[1])
    assert found_cases(study.settings, study.settings[1], places) == {CASE: own / "cases" / CASE}
    record(study, places)
    named = json.loads((places.runs / "study.json").read_text())["settings"]
    assert named[1]["cases"] == [
        {
            "id": CASE,
            "folder": f"settings/default/cases/{CASE}",
            "identity": study.settings[1].cases[0].identity,
        }
    ]
    # Not finished: where it will be.
    assert named[0]["cases"][1] == {
        "id": f"{CASE}-seed2",
        "folder": f"settings/reference/cases/{CASE}-seed2",
        "identity": study.settings[0].cases[1].identity,
    }


def test_a_case_that_is_not_the_settings_is_named_and_left_out(tmp_path):
    """What a study finds in the place of a case, before the changed setting was run."""
    study = load_study(write_study(tmp_path))
    places = Places(tmp_path / "runs")
    for setting in study.settings:
        pretend_finished(places.of(setting), setting)
    changed = TEXT.replace('about = "as the default"', "multi_ball.rotation_angle_rad = 0.6")
    again = load_study(write_study(tmp_path, changed))
    record(again, places)
    about = json.loads((places.runs / "study.json").read_text())
    _, missing = study_charges(places.runs, about)
    name = f"{again.settings[2].name}/{CASE}"
    assert "not that of the study's setting" in missing[name]
    assert not any("not that of" in why for other, why in missing.items() if other != name)


def test_a_changed_setting_alone_is_run_again(tmp_path):
    study = load_study(write_study(tmp_path))
    places = Places(tmp_path / "runs")
    for setting in study.settings:
        pretend_finished(places.of(setting), setting)
    changed = TEXT.replace('about = "as the default"', "multi_ball.rotation_angle_rad = 0.6")
    file = write_study(tmp_path, changed)
    _, output, _ = millscale("study", file, "--runs", places.runs, "--plan", "--json")
    assert [len(row["left"]) for row in json.loads(output)] == [0, 0, 1]
    again = load_study(file)
    assert found_cases(again.settings, again.settings[2], places) == {}
    # A case.json that somebody edited is another case, too; that of the other setting, as it was
    # before the change, is still the same.
    path = places.of(study.settings[1]) / "cases" / CASE / "case.json"
    path.write_text(path.read_text().replace('"seed": 1', '"seed": 7'))
    before = places.of(study.settings[2]) / "cases" / CASE
    assert found_cases(again.settings, again.settings[1], places) == {CASE: before}


def test_an_identity_is_that_of_the_case_and_not_of_its_names(tmp_path):
    reference, default, same = load_study(write_study(tmp_path)).settings
    assert default.cases[0].digest != same.cases[0].digest
    assert default.cases[0].identity == same.cases[0].identity
    assert reference.cases[0].identity != default.cases[0].identity


def test_the_plan_tells_the_cost_of_every_setting_and_writes_nothing(tmp_path):
    file = write_study(tmp_path)
    before = sorted(tmp_path.rglob("*"))
    code, output, _ = millscale("study", file, "--plan", "--json")
    rows = json.loads(output)
    assert code == 0 and sorted(tmp_path.rglob("*")) == before
    assert [row["setting"] for row in rows] == ["reference", "default", "same"]
    reference, default, _ = rows
    assert reference["is_reference"] and default["is_default"]
    # Two seeds of half the step; half a second a run is mpirun's.
    assert 3.0 < reference["core_time_s"] / default["core_time_s"] < 4.0 or (
        default["core_time_s"] < 2.0
    )
    assert default["core_time_s"] == default["cases"][0]["predicted_wall_time_s"]
    code, output, _ = millscale("study", file, "--plan", "--only", "re*")
    assert "reference (reference)" in output and "same" not in output
    assert "core hours" in output


def test_a_setting_that_fails_does_not_stop_the_others(tmp_path, monkeypatch):
    ran = []

    def fail_first(asked, console):
        ran.append(asked.runs.name)
        return len(ran) > 1

    monkeypatch.setattr(running, "run_campaign", fail_first)
    monkeypatch.setattr(command, "build_study", lambda runs, about: {"rows": []})
    monkeypatch.setattr(command, "tables", lambda results: [])
    call = StudyCall(write_study(tmp_path), tmp_path / "runs", cores=CoreWish(1, 1))
    done, _ = run_and_compare(call, Console(file=io.StringIO()))
    assert ran == ["reference", "default", "same"] and not done


def test_ctrl_c_ends_the_study_with_its_code(tmp_path, monkeypatch):
    def interrupted(asked, console):
        raise KeyboardInterrupt

    monkeypatch.setattr(running, "run_campaign", interrupted)
    code, _, errors = millscale("study", write_study(tmp_path), "--runs", tmp_path / "runs")
    assert code == 130 and "repeat the command to resume" in errors
    assert (tmp_path / "runs/study.json").exists()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "error: millscale study: --runs: missing; accepted: a folder, or --plan"),
        (["--plan", "--no-run"], "--plan: with --no-run or --to; accepted: one of them"),
        (
            ["--plan", "--only", "defalt"],
            "--only: no setting defalt, nearest is default; accepted: reference, default, same",
        ),
        (["--plan", "--from", "nowhere"], "--from: got nowhere, which has no campaign.json"),
        (["--runs", "RUNS", "--to", "nowhere/x.json"], "--to: no folder nowhere"),
        (
            ["--runs", "RUNS", "--no-run"],
            "none of its cases is finished; accepted: run them with: millscale study FILE",
        ),
    ],
)
def test_a_wrong_call_is_told_in_a_line(tmp_path, arguments, said):
    file = write_study(tmp_path)
    arguments = [str(tmp_path / "runs") if word == "RUNS" else word for word in arguments]
    code, _, errors = millscale("study", file, *arguments)
    assert code == 2
    assert said in errors and len(errors.splitlines()) == 1
