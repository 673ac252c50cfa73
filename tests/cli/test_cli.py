"""Errors, exit codes and the dry run of the command line."""

import json
from itertools import takewhile

import pytest

from millscale.runs.layout import STAGES
from small_campaign import CHARGE, SINGLE_BALLS, TEXT


def test_dry_run_prints_stages_and_mpirun_lines_and_writes_nothing(millscale):
    done = millscale("run", "--dry-run", "--ranks", "1")
    assert done.returncode == 0 and done.stderr == ""
    lines = [line.strip() for line in done.stdout.splitlines()]
    assert f"{millscale.case(CHARGE)}: mpirun -np 1 --bind-to none" in done.stdout
    for deck, log in (("single_ball", "rotate"), ("settle", "settle"), ("mill", "rotate")):
        assert any(line.endswith(f"liggghts_mill -in {deck}.in -log log.{log}") for line in lines)
    assert [line.split()[0] for line in lines[1:6]] == ["mesh", "deck", "rotate", "in", "result"]
    assert not millscale.runs.exists()


def test_dry_run_of_a_finished_run_has_nothing_to_do(finished):
    before = finished.dates()
    done = finished("run", "--dry-run")
    assert "0 of 3 cases to do" in done.stdout and "mpirun" not in done.stdout
    assert finished.dates() == before


def test_dry_run_shows_which_cases_a_campaign_edit_changes(finished):
    finished.file.write_text(TEXT.replace("count = [50]", "count = [40]"))
    done = finished("run", "--dry-run")
    assert "1 of 3 cases to do" in done.stdout
    assert f"{SINGLE_BALLS[0]}: done" in done.stdout and "mesh    (new case.json)" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "cause"),
    [
        (
            ("--only", "sb-cg-paper-S1.00"),
            f"no case sb-cg-paper-S1.00; accepted: {SINGLE_BALLS[0]}",
        ),
        (("--ranks", "0"), "--ranks: got 0; accepted: a whole number >= 1"),
        (("--jobs", "-1"), "--jobs: got -1; accepted: a whole number >= 1"),
        (("--time-limit", "inf"), "--time-limit: got inf; accepted: 0.1 to 1e+09 s"),
        (("--time-limit", "nan"), "--time-limit: got nan; accepted: 0.1 to 1e+09 s"),
        (("--time-limit", "-5"), "--time-limit: got -5; accepted: 0.1 to 1e+09 s"),
        (("--time-limit", "0"), "--time-limit: got 0; accepted: 0.1 to 1e+09 s"),
        (("--ranks", "99999"), "needs 99999 cores, this machine offers"),
        (("--profile", "."), "--profile: got one without a batch system"),
        (("--target", "slum"), "--target: got slum, nearest is slurm; accepted: local, slurm"),
        (("--target", "slurm", "--profile", "x"), "--profile: no config.yaml in x"),
        (("--slurm", "--profile", "nowhere"), "--profile: no config.yaml in nowhere"),
    ],
)
def test_wrong_run_options_give_one_line_and_write_nothing(millscale, arguments, cause):
    done = millscale("run", *arguments)
    assert done.returncode == 2 and done.stdout == ""
    assert cause in done.stderr and len(done.stderr.splitlines()) == 1
    assert not millscale.runs.exists()


@pytest.mark.parametrize("option", ["--every", "--silence"])
@pytest.mark.parametrize("seconds", ["inf", "nan", "-1", "0"])
def test_intervals_of_status_must_be_times(finished, option, seconds):
    done = finished("status", "--watch", option, seconds)
    assert done.returncode == 2 and done.stdout == ""
    assert f"millscale status: {option}: got {seconds}; accepted: 0.1 to 1e+09 s" in done.stderr


def test_a_machine_without_slurm_is_refused_with_what_is_missing(millscale):
    done = millscale("run", "--slurm", PATH="")
    assert done.returncode == 2 and "millscale run: --target slurm: " in done.stderr
    assert "no sbatch on the PATH" in done.stderr or " -m pip install snakemake-" in done.stderr
    assert not millscale.runs.exists()


@pytest.mark.parametrize("command", ["plan", "generate", "run"])
def test_a_wrong_campaign_gives_a_line_for_each_mistake_and_writes_nothing(millscale, command):
    text = TEXT.replace("lifters = 8", "lifter = 8").replace(
        "poisson_ratio = ", "poisson_ratio = -"
    )
    millscale.file.write_text(text)
    done = millscale(command)
    assert done.returncode == 2 and done.stdout == ""
    lines = text.splitlines()
    liner, material = done.stderr.splitlines()
    line = lines.index("lifter = 8") + 1
    assert f"small.toml:{line}: liner.lifter: unknown key, nearest is lifters; " in liner
    line = next(i for i, line in enumerate(lines, 1) if line.startswith("poisson_ratio"))
    assert liner.startswith("error: ") and material.startswith("error: ")
    assert f"small.toml:{line}: material.poisson_ratio: nu of balls and wall: got -0" in material
    assert [path.name for path in millscale.file.parent.iterdir()] == ["small.toml"]


def test_a_missing_engine_is_reported_before_anything_is_written(millscale):
    done = millscale("run", MILLSCALE_ENGINE="/nosuch/liggghts_mill")
    assert done.returncode == 2
    assert "MILLSCALE_ENGINE: got /nosuch/liggghts_mill; accepted:" in done.stderr
    assert not millscale.runs.exists()


@pytest.mark.parametrize("command", ["status", "report"])
def test_a_folder_without_campaign_is_reported(millscale, command):
    done = millscale(command)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1
    assert "campaign.json" in done.stderr


def test_a_runs_folder_that_is_a_file_is_reported(millscale):
    millscale.runs.write_text("a file")
    done = millscale("run")
    assert done.returncode == 2 and "cannot be made" in done.stderr


def test_plan_prints_json_rows(millscale):
    rows = json.loads(millscale("plan", "--json").stdout)
    assert [row["id"] for row in rows] == [*SINGLE_BALLS, CHARGE]


def test_generate_makes_complete_folders_and_runs_no_engine(millscale):
    done = millscale("generate")
    assert done.returncode == 0 and "3 cases: 3 written, 0 unchanged" in done.stdout
    assert (millscale.runs / "campaign.json").exists()
    for case_id, kind in ((SINGLE_BALLS[0], "single-ball"), (CHARGE, "multi-ball")):
        before_engine = takewhile(lambda stage: not stage.deck, STAGES[kind])
        products = {product for stage in before_engine for product in stage.products}
        names = {path.name for path in millscale.case(case_id).iterdir()}
        assert {"case.json", "mpirun.sh", *products} <= names
        assert not {"series.csv", "settled.restart", "result.json"} & names
    assert (millscale.case(CHARGE) / "dump").is_dir()


def test_generate_again_touches_nothing(millscale):
    assert millscale("generate").returncode == 0
    before = millscale.dates()
    done = millscale("generate")
    assert "3 cases: 0 written, 3 unchanged" in done.stdout
    assert millscale.dates() == before


def test_generate_names_the_stage_that_failed(millscale):
    assert millscale("generate").returncode == 0
    folder = millscale.case(CHARGE)
    (folder / "mesh.json").unlink()
    (folder / "mesh.part").write_text("in the way of the stage")
    done = millscale("generate")
    assert done.returncode == 1
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"{CHARGE}: mesh failed: ") and "to do: " in line
    (folder / "mesh.part").unlink()
    assert "3 cases: 1 written, 2 unchanged" in millscale("generate").stdout


def test_status_of_waiting_and_finished_cases(finished):
    rows = json.loads(finished("status", "--json").stdout)
    assert [row["id"] for row in rows] == [*SINGLE_BALLS, CHARGE]
    assert {row["state"] for row in rows} == {"done"} and {row["percent"] for row in rows} == {
        100.0
    }
    (finished.case(CHARGE) / "settled.restart").unlink()
    row = json.loads(finished("status", "--json").stdout)[2]
    assert (row["state"], row["stage"], row["stages_left"]) == ("waiting", "settle", 3)
    assert row["step"] == 0 and row["percent"] == 0.0


def test_report_json_is_results_json(finished):
    output, _ = finished.start("report", "--json").communicate(timeout=60)
    assert json.loads(output) == json.loads((finished.runs / "report/results.json").read_text())
    assert (finished.runs / "report" / "index.html").exists()
