"""The step at which an engine stage begins, from the files that earlier attempts left."""

import os
from dataclasses import replace

import pytest

from millscale.engine import resume
from millscale.engine.attempts import Cost, digests, read_attempts
from millscale.engine.output_files import check_output, series_length
from millscale.engine.restart_file import NotWholeError, read_restart
from millscale.engine.resume import RESUME_FILE, OtherRanksError, Run, begin, look
from signed_restart import restart_file

FIRST, EVERY, STEPS = 95, 10, 1000
HEADER = "step,time_s\n"


def cut(path, by=3):
    os.truncate(path, path.stat().st_size - by)


def series(part, last, without=()):
    steps = (step for step in range(100, last + 1, EVERY) if step not in without)
    (part / "series.csv").write_text(HEADER + "".join(f"{step},{step}.5\n" for step in steps))


def ledger(part, last, without=()):
    series(part, last, without)
    (part / "series.csv").rename(part / "ledger.csv")


def dump(part, step, balls=2, lines=2):
    (part / "dump").mkdir(exist_ok=True)
    text = (
        f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{balls}\n" + "x\n" * 5 + "ball\n" * lines
    )
    (part / "dump" / f"charge.{step:09d}.liggghts").write_text(text)


@pytest.fixture
def run(tmp_path):
    (tmp_path / "mill.in").write_text("run")
    inputs = digests([tmp_path / "mill.in"])
    return Run(tmp_path / "rotate.part", inputs, FIRST, STEPS, FIRST + STEPS, ranks=2)


@pytest.fixture
def stopped(run):
    """Return the run after an attempt with restart files at 200 and 300 that ended at 345."""
    begin(run)
    restart_file(run.part, "mill.1.restart", 200)
    restart_file(run.part, "mill.2.restart", 300)
    series(run.part, 340)
    return run


def test_a_first_attempt_has_no_note(run):
    beginning = begin(run)
    assert beginning.restart is None and beginning.note == ""
    assert beginning.attempts.starts[-1].step == FIRST
    assert read_attempts(run.part) == beginning.attempts


def test_an_attempt_resumes_from_the_newest_restart_file(stopped):
    beginning = begin(stopped)
    assert beginning.restart.step == 300
    assert beginning.note == "goes on from step 300 of 1,095 (mill.2.restart)"


def test_an_attempt_resumes_only_on_the_ranks_it_began_with(stopped):
    before = {path.name: path.read_bytes() for path in stopped.part.iterdir()}
    with pytest.raises(OtherRanksError, match="ran on 2 ranks, not on 1: set --ranks 2, or"):
        begin(replace(stopped, ranks=1))
    assert {path.name: path.read_bytes() for path in stopped.part.iterdir()} == before
    # Without a restart file any number of ranks is accepted.
    for name in ("mill.1.restart", "mill.2.restart"):
        (stopped.part / name).unlink()
    assert begin(replace(stopped, ranks=1)).restart is None


def test_an_attempt_is_recorded_before_anything_can_fail(stopped, monkeypatch):
    def full(*_):
        raise OSError("no space left on device")

    for name in ("_cut", "_put_aside"):
        with monkeypatch.context() as patch, pytest.raises(OSError, match="no space"):
            patch.setattr(resume, name, full)
            begin(stopped)
    assert [start.step for start in read_attempts(stopped.part).starts] == [FIRST, 300, 300]
    beginning = begin(stopped)
    assert beginning.restart.step == 300 and len(beginning.attempts.starts) == 4


def test_the_restart_file_of_an_attempt_is_not_overwritten(stopped):
    begin(stopped)
    assert read_restart(stopped.part / RESUME_FILE).step == 300
    assert not (stopped.part / "mill.2.restart").exists()
    cut(stopped.part / "mill.1.restart")  # killed while it writes the next
    assert begin(stopped).restart.step == 300


def test_an_older_restart_file_is_used_if_the_newest_is_cut(stopped):
    cut(stopped.part / "mill.2.restart")
    beginning = begin(stopped)
    assert beginning.restart.step == 200
    assert "mill.2.restart is not whole" in beginning.note


def test_an_attempt_begins_anew_if_no_restart_file_is_complete(stopped):
    for name in ("mill.1.restart", "mill.2.restart"):
        cut(stopped.part / name)
    beginning = begin(stopped)
    assert beginning.restart is None and beginning.note.startswith("begins anew: no restart file")
    assert "mill.1.restart is not whole" in beginning.note
    assert {path.name for path in stopped.part.iterdir()} == {"attempts.json"}


@pytest.mark.parametrize("change", ["mill.in", "liner.stl"])
def test_an_attempt_begins_anew_if_an_input_has_changed(stopped, change):
    folder = stopped.part.parent
    (folder / change).write_text("changed")
    inputs = digests([folder / "mill.in", folder / "liner.stl"])
    now = Run(stopped.part, inputs, FIRST, STEPS, FIRST + STEPS, ranks=2)
    assert begin(now).note == f"starts over: {change} changed since the last attempt"
    assert not (stopped.part / "series.csv").exists()


def test_finding_the_attempt_changes_no_file(stopped):
    before = {path.name: path.read_bytes() for path in stopped.part.iterdir()}
    assert look(stopped)[0].step == 300
    assert {path.name: path.read_bytes() for path in stopped.part.iterdir()} == before


def test_the_series_continues_without_gap_or_repetition(stopped):
    with (stopped.part / "series.csv").open("a") as file:
        file.write("350,35")
    begin(stopped)
    series(stopped.part.parent, 300)
    expected = (stopped.part.parent / "series.csv").read_text()
    assert (stopped.part / "series.csv").read_text() == expected


@pytest.mark.parametrize("lost", [100, 210, 290, 300])
def test_a_restart_file_later_than_a_lost_row_is_not_used(stopped, lost):
    series(stopped.part, 340, without={lost})
    beginning = begin(stopped)
    assert "mill.2.restart cannot be used: series.csv" in beginning.note
    assert (beginning.restart is None) == (lost == 100)


def test_a_restart_file_later_than_a_cut_dump_is_not_used(stopped):
    dump(stopped.part, 150)
    dump(stopped.part, 250, lines=1)
    dump(stopped.part, 340, lines=0)  # will be written again
    beginning = begin(stopped)
    assert beginning.restart.step == 200
    assert "mill.2.restart cannot be used: dump/charge.000000250.liggghts" in beginning.note


def test_rows_that_the_engine_writes_when_asked_to_end_are_dropped(stopped):
    (stopped.part / "restart_forced_liggghts_345.data").touch()
    begin(stopped)
    assert not list(stopped.part.glob("restart_forced*"))


def test_the_cost_counts_the_steps_that_were_kept(run):
    """Attempts: steps 95 to 300, kept to 200; 200 to 400; from 400 on."""
    begins = []
    for step, loop, processor in ((200, 5.0, 12.0), (400, 8.0, 17.0)):
        begins.append(begin(run).attempts.starts[-1].began)
        series(run.part, step)
        restart_file(run.part, "mill.1.restart", step, loop, processor)
        os.utime(run.part / "mill.1.restart", (0, begins[-1] + 7.0))
    cost = begin(run).before
    assert cost.processor_time == 29.0 and cost.loop_time == 13.0
    assert cost.core_time == 26.0  # on 2 ranks
    assert cost.wall_time == pytest.approx(14.0, abs=1e-5)  # file dates are rounded


def test_a_restart_file_kept_by_a_later_attempt_keeps_its_cost(stopped):
    restart_file(stopped.part, "mill.2.restart", 300, 4.0, 9.0)
    for _ in range(3):  # ended before they wrote a file of their own
        beginning = begin(stopped)
        assert beginning.restart.step == 300 and beginning.before.loop_time == 4.0
    assert len(beginning.attempts.starts) == 4 and beginning.before != Cost()


def test_a_series_is_as_long_as_its_last_row_up_to_a_step(tmp_path):
    series(tmp_path, 200)
    path = tmp_path / "series.csv"
    assert series_length(path, FIRST, 200) == path.stat().st_size
    assert series_length(path, FIRST, 125) == len(HEADER) + 3 * len("100,100.5\n")


@pytest.mark.parametrize("text", ["", HEADER, HEADER + "100,1\n110\n120,1\n", HEADER + "90,1\n"])
def test_a_series_that_is_not_whole_is_refused(tmp_path, text):
    (tmp_path / "series.csv").write_text(text)
    with pytest.raises(NotWholeError, match=r"series\.csv"):
        check_output(tmp_path, FIRST, 125)


def test_the_energy_budget_is_cut_with_the_series(stopped):
    ledger(stopped.part, 340)
    series(stopped.part, 340)
    assert begin(stopped).restart.step == 300
    for name in ("series.csv", "ledger.csv"):
        assert (stopped.part / name).read_text().splitlines()[-1].startswith("300,")


def test_a_restart_file_is_not_used_if_the_energy_budget_lacks_a_row(stopped):
    ledger(stopped.part, 340, without=(250,))
    series(stopped.part, 340)
    beginning = begin(stopped)
    assert beginning.restart.step == 200
    assert "ledger.csv has step 260, expected 250" in beginning.note
