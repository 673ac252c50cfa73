"""`millscale solve`: its folder, answer and errors, with made-up finished rounds."""

import json
from dataclasses import replace

import pytest

import in_process
from millscale.analysis.finished_campaign import load_campaign
from millscale.errors import CampaignError
from millscale.prediction.planned import PlannedMills, RunSize
from millscale.prediction.solve import Ask, Round
from millscale.prediction.solve_file import NAME, read_rounds, write_rounds
from millscale.prediction.solve_runs import cost_of
from paper_campaign import CAMPAIGNS, write_campaign
from synthetic_mills import charge_case, write_mills

SLICES = CAMPAIGNS / "slices.toml"
FIRST = Round(1, ((1.696, (1, 2)), (2.6, (1, 2))), RunSize(), 100.0, "a test", done=True)
ASK = Ask(("power",), 0.02)


def millscale(*words, **environment):
    """Exit code, output and errors of a command."""
    done = in_process.millscale(*words, **environment)
    return done.returncode, done.stdout, done.stderr


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder whose first round is done. An engine that were run would fail."""
    monkeypatch.setenv("MILLSCALE_ENGINE", "/bin/false")
    runs = tmp_path / "solve"
    write_mills(runs / "round-1", *(charge_case(S, seed) for S, seed in FIRST.runs))
    write_rounds(runs, SLICES, PlannedMills(SLICES).digest, ASK, [FIRST])
    return runs


def solve(folder, error, *more):
    return millscale("solve", SLICES, "--error", error, "--runs", folder, *more)


def test_what_is_met_runs_nothing_and_writes_the_answer(folder):
    code, output, errors = solve(folder, "10%", "--observable", "power")
    assert code == 0, errors
    assert "met: every interval is within 10 %" in output
    power = next(line for line in output.splitlines() if "│ power " in line)
    assert "kW" in power and "yes" in power
    content = json.loads((folder / "answer.json").read_text())
    assert {"command", "commit", "machine", "date"} <= content.keys()
    assert content["is_met"] and content["ended"]["kind"] == "met"
    assert content["rounds"][0]["half_widths"]["power"] == content["half_widths"]["power"]
    numbers = {row["name"]: row for row in content["prediction"]["numbers"]}
    assert numbers["power"]["lower"] < numbers["power"]["value"] < numbers["power"]["upper"]


def test_the_page_has_the_answer_first_and_needs_no_other_file(folder):
    solve(folder, "10%", "--observable", "power")
    page = (folder / "report/index.html").read_text()
    assert page.index("<h2>Answer</h2>") < page.index("<h2>How it was found</h2>")
    rows = page[page.index("<tbody>") :]
    assert rows.index("<b>power</b>") < rows.index("kinetic energy")
    assert "S = 1.696 seeds 1, 2, S = 2.6 seeds 1, 2" in page
    assert "data:image/webp;base64," in page and 'src="half' not in page


def test_json_alone_is_on_standard_output(folder):
    code, output, errors = solve(folder, "10%", "--observable", "power", "--json")
    assert code == 0
    assert json.loads(output)["is_met"]
    assert "met: every interval" in errors


def test_a_budget_that_is_spent_leaves_the_answer_so_far(folder):
    code, output, errors = solve(folder, "0.5%", "--observable", "power", "--budget", "5s")
    assert code == 1, errors
    assert "budget spent: the next run, S = " in output
    content = json.loads((folder / "answer.json").read_text())
    assert not content["is_met"]
    assert content["prediction"]["numbers"][0]["value"] > 0.0


def test_the_time_spent_is_that_of_all_runs(folder):
    solve(folder, "10%", "--observable", "power")
    charges = load_campaign(folder / "round-1").charges
    assert len(charges) == 4
    content = json.loads((folder / "answer.json").read_text())
    assert content["spent_s"] == pytest.approx(sum(map(cost_of, charges)))


def test_the_cost_of_a_run_counts_ranks_and_the_steps_before_it_resumed(folder):
    """12.5 s of 200 steps at least, on two ranks (`timing_document`)."""
    charge = load_campaign(folder / "round-1").charges[0]
    timing = charge.timing
    expected = 2.0 * 12.5 * charge.case.time.steps / timing.steps
    assert cost_of(charge) == pytest.approx(expected)


def test_a_dry_run_shows_the_next_round_and_writes_nothing(folder):
    before = {path: path.stat().st_mtime_ns for path in folder.rglob("*")}
    code, output, errors = solve(folder, "0.5%", "--observable", "power", "--dry-run")
    assert code == 0, errors
    assert "half widths after" in output and "round 2: S = " in output
    assert {path: path.stat().st_mtime_ns for path in folder.rglob("*")} == before


def test_a_dry_run_of_a_new_folder_shows_the_plan(tmp_path):
    code, output, _ = solve(tmp_path / "new", "3%", "--observable", "power", "--dry-run")
    assert code == 0
    assert "chosen" in output and "round 1: S = " in output
    assert not (tmp_path / "new").exists()


def test_rounds_are_read_back_as_they_were(tmp_path):
    second = replace(FIRST, number=2, mills=((1.5, (3,)),), done=False, expected=0.01)
    first = replace(FIRST, spent_s=3.0, half_widths={"power": 0.02, "contour": None})
    write_rounds(tmp_path, SLICES, "0", ASK, [first, second])
    assert read_rounds(tmp_path, SLICES, "0") == (first, second)


def test_a_folder_of_another_campaign_or_of_something_else_is_refused(folder, tmp_path):
    with pytest.raises(CampaignError, match=r"was made for slices.toml, which differs"):
        read_rounds(folder, CAMPAIGNS / "quick.toml", "another digest")
    code, _, errors = solve(folder / "round-1", "3%")
    assert code == 2
    assert "but no solve.json; accepted: a new folder" in errors
    assert len(errors.splitlines()) == 1


def test_a_damaged_record_is_one_line(folder):
    (folder / NAME).write_text('{"schema": 1}')
    code, _, errors = solve(folder, "3%")
    assert code == 2
    assert "solve.json" in errors and "missing" in errors and len(errors.splitlines()) == 1


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--error", "none"), '--error: got "none", accepted are 0.01% to 50%'),
        (("--error", "3%", "--budget", "10"), '--budget: got "10", accepted are'),
        (("--error", "3%", "--observable", "powr"), 'got "powr", nearest is "power"'),
        (("--error", "3%", "--observable", "impacts"), 'observable: got "impacts"'),
        (("--error", "3%", "--jobs", "0"), "--jobs"),
    ],
)
def test_wrong_options_are_one_line_and_make_no_folder(tmp_path, words, message):
    line = ("solve", SLICES, "--runs", tmp_path / "new", *words)
    code, _, errors = millscale(*line, MILLSCALE_ENGINE="/bin/false")
    assert code == 2, errors
    assert message in errors and len(errors.splitlines()) == 1
    assert not (tmp_path / "new").exists()


def test_a_campaign_without_a_charge_is_refused(tmp_path):
    file = write_campaign(tmp_path)
    code, _, errors = millscale("solve", file, "--error", "3%", "--runs", tmp_path / "new")
    assert code == 2
    assert "multi_ball: missing; accepted: a charge" in errors
