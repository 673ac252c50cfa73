"""Kinds of failure, recognised in logs and provoked in the real engine."""

import json
import os
import time

import pytest

import provoked_failures
from millscale.runs.case_file import load_case
from millscale.workflow import display, stage_record, stage_work
from millscale.workflow.failures import KINDS, UNKNOWN, Traces, advice_of, classify
from millscale.workflow.run_stage import run_stage
from millscale.workflow.status import case_status
from paper_campaign import cases
from provoked_failures import PROVOCATIONS, provoke
from small_campaign import SINGLE_BALLS

# The quick ones run always; the rest with -m validate.
QUICK = {
    *("nan", "damaged file", "mesh error", "wrong deck", "disk full", "overlap too large"),
    *("not settled", "does not fit", "missing library", "by hand", "mpi does not start"),
}
CRASH = "the engine crashed: rank 1 exited on signal {}"


@pytest.mark.parametrize(
    ("kind", "traces"),
    [
        # As fix mill/guard reports it, from one rank or from all.
        ("nan", Traces("ERROR: fix mill/guard: position of ball 7 is nan at step 900 (a.cpp:1)")),
        ("nan", Traces("ERROR on proc 1: fix mill/guard: ball 7 is not a number at step 9")),
        (
            "overlap too large",
            Traces("ERROR on proc 0: fix mill/guard: overlap of ball 3 is 0.4 radii at step 12"),
        ),
        (
            "nan",
            Traces("ERROR: fix mill/guard: ball 3 has no finite position; step 12, position ("),
        ),
        (
            "overlap too large",
            Traces("ERROR: fix mill/guard: ball 3 overlaps the drum by 0.5 of its radius; step 1"),
        ),
        ("lost ball", Traces("ERROR: fix mill/guard: ball 3 is outside the mill, its centre 1 m")),
        ("lost ball", Traces("ERROR: Lost atoms: original 2 current 1 (thermo.cpp:427)")),
        ("nan", Traces("ERROR: Lost atoms: original 2 current 1", last_row="3,0.1,nan,-1")),
        ("nan", Traces("series.csv: x_m is nan in line 30; run the case again")),
        ("mesh error", Traces("liner mesh not fit for use: 3 open edges")),
        ("out of memory", Traces(CRASH.format(6), "terminate called\n  what():  std::bad_alloc")),
        ("out of memory", Traces(CRASH.format(9), memory_kills=2)),
        ("out of memory", Traces("mpirun ended by signal 9", memory_kills=1)),
        ("out of memory", Traces("Unable to allocate 7 TiB for an array")),
        ("out of memory", Traces(CRASH.format(9), "slurmstepd: error: Detected 1 oom_kill event")),
        ("killed", Traces(CRASH.format(9))),
        ("killed", Traces("the engine was ended by a signal")),
        ("time out", Traces("mpirun ended by signal 15", "CANCELLED AT x DUE TO TIME LIMIT")),
        ("disk full", Traces("[Errno 28] No space left on device: 'a'")),
        # The engine does not check whether its output was written.
        ("disk full", Traces("log.rotate holds no finished run", free_bytes=0)),
        (
            "wrong deck",
            Traces(
                "ERROR: Fix mill/guard (id guard): unknown keyword 'x'; accepted are mill, overlap",
                "run 0",
                runs_engine=True,
            ),
        ),
        ("wrong deck", Traces("ERROR: Unknown command: fx (input.cpp:1)")),
        ("wrong deck", Traces("ERROR: Never seen before", "run 0", runs_engine=True)),
        (UNKNOWN, Traces("ERROR: Never seen before", "Step Atoms KinEng", runs_engine=True)),
        ("crash", Traces(CRASH.format(11))),
        (
            "mpi does not start",
            Traces("mpirun ended with exit code 1", "[n:1] PMIX ERROR: NOT_AVAILABLE in file a.c"),
        ),
        ("damaged file", Traces("series.csv: 3 rows: cut short, or written to")),
        (UNKNOWN, Traces("ERROR: Something else", last_row="1,2.0,-3e5")),
    ],
)
def test_the_log_decides_the_kind_of_failure(kind, traces):
    failure = classify(traces)
    assert failure.kind == kind
    assert traces.error in failure.cause and "\n" not in failure.cause
    assert failure.advice == advice_of(kind, traces.error) and failure.advice


@pytest.mark.parametrize(
    ("error", "advice"),
    [
        # A library that is not there, of gmsh and of any other.
        (
            "libGLU.so.1: cannot open shared object file: No such file",
            "apt-get install libglu1-mesa",
        ),
        ("libXft.so.2: cannot open shared object file: No such file", "apt-get install libxft2"),
        ("libfoo.so: cannot open shared object file", "the Debian package of the named library"),
        ("No module named 'gmsh'", "scripts/setup"),
        # fix mill/guard reports more than a kind of failure.
        (
            "ERROR: fix mill/guard: ball 4 is outside the box in z; step 22, ...; likeliest first: "
            "a hole in the mesh, a radius that is not the mesh's, a step too long",
            "the remedies of the message in their order",
        ),
        # A ball that does not fit is not an error of the decks.
        (
            "ERROR: Fix wall/mill (id liner): balls of radius 0.02 m do not fit: the groove of the "
            "liner takes less than 0.015875 m",
            "smaller balls, a smaller S or wider grooves",
        ),
        ("the charge hangs in the air after settling: 0% of its balls touch", "increase settle_s"),
        ("the charge still moves after settling: rms speed 3 m/s", "increase settle_s"),
        ("balls of the settled bed overlap by 0.006 m", "increase youngs_modulus_pa"),
        (
            "liner mesh not fit for use: smallest angle of a triangle is 0.01",
            "leave out wall.axial_divisions",
        ),
        ("liner mesh not fit for use: 3 open edges", "wall.chord_error_m"),
    ],
)
def test_advice_fits_the_cause(error, advice):
    failure = classify(Traces(error, runs_engine=error.startswith("ERROR")))
    assert advice in failure.advice


def test_every_kind_but_the_unknown_is_provoked():
    assert {x.kind for x in PROVOCATIONS} == set(KINDS) - {UNKNOWN}


def test_a_full_disk_still_takes_the_record_of_the_failure(tmp_path, monkeypatch):
    record = stage_record.begin(tmp_path, "mesh")

    def full(self, text, *arguments, **more):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(type(tmp_path), "write_text", full)
    stage_record.end(tmp_path, record, "failed", "disk full: no space", "out.mesh")
    read = stage_record.read_record(tmp_path)
    assert (read.state, read.cause) == ("failed", "disk full: no space")


@pytest.mark.parametrize(
    "text",
    ["", "{", "[]", "[" * 100_000, '{"stage": 1}', '{"a": "' + "x" * 100_000 + '"}'],
)
def test_a_damaged_record_counts_as_none(tmp_path, text):
    (tmp_path / stage_record.RECORD_FILE).write_text(text)
    assert stage_record.read_record(tmp_path) is None


def test_a_record_of_wrong_types_counts_as_none(tmp_path):
    stage_record.begin(tmp_path, "mesh")
    file = tmp_path / stage_record.RECORD_FILE
    good = json.loads(file.read_text())
    for key, value in (("started", "soon"), ("process", None), ("state", "odd"), ("cause", [])):
        file.write_text(json.dumps(good | {key: value}))
        assert stage_record.read_record(tmp_path) is None


def test_a_record_is_printed_without_control_characters(tmp_path):
    record = stage_record.begin(tmp_path, "mesh")
    stage_record.end(tmp_path, record, "failed", "\x1b[2Jgone\x07")
    assert stage_record.read_record(tmp_path).cause == "[2Jgone"


def test_a_stage_that_fails_records_kind_and_advice(tmp_path, monkeypatch):
    charge = {"count": 10, "rotation_angle_rad": 1.0}
    one = {"scaling__S": [2.6], "scaling__schemes": ["constant-gravity"], "single_ball": None}
    (case,) = cases(tmp_path, **one, multi_ball=charge)
    (tmp_path / "case.json").write_text(case.text())

    def charge(task):
        raise MemoryError

    monkeypatch.setitem(stage_work.WORK, "charge", charge)
    assert run_stage(tmp_path, "charge") == 1
    record = stage_record.read_record(tmp_path)
    assert (record.kind, record.advice) == ("out of memory", advice_of("out of memory"))


def running(command, case_id):
    """Let a case look as if this process worked on its rotation."""
    case = command.case(case_id)
    (case / "timing.json").unlink()
    part = case / "rotate.part"
    part.mkdir()
    (part / "series.csv").write_text("step,time_s\n60,0.1\n")
    return stage_record.begin(case, "rotate"), part


def test_a_run_without_progress_is_reported(finished):
    record, part = running(finished, SINGLE_BALLS[0])
    assert not json.loads(finished("status", "--json").stdout)[0]["failure"]
    old = time.time() - 900.0
    record = stage_record.replace(record, started=old)
    stage_record._write(part.parent, record)
    os.utime(part / "series.csv", (old, old))
    os.utime(part.parent / "case.json", (old - 9.0, old - 9.0))
    row = json.loads(finished("status", "--json").stdout)[0]
    assert (row["state"], row["failure"]) == ("running", "no progress")
    assert row["silent_s"] == pytest.approx(900.0, abs=60.0)
    text = finished("status").stdout
    assert "rotate running: no progress: nothing written for 9" in text and "to do:" in text
    assert not json.loads(finished("status", "--json", "--silence", "2000").stdout)[0]["failure"]


def test_a_stage_whose_process_is_gone_was_killed(finished):
    record, part = running(finished, SINGLE_BALLS[0])
    stage_record._write(part.parent, stage_record.replace(record, process_started=1.0))
    row = json.loads(finished("status", "--json").stdout)[0]
    assert (row["state"], row["failure"]) == ("interrupted", "killed")


def test_watching_ends_when_nothing_runs(finished):
    lines = finished("status", "--watch", "--json").stdout.splitlines()
    assert len(lines) == 1 and {x["state"] for x in json.loads(lines[0])} == {"done"}


def test_a_run_reads_the_files_of_a_case_until_it_is_done(finished, monkeypatch):
    running(finished, SINGLE_BALLS[0])
    folders = sorted((finished.runs / "cases").iterdir())
    read = []

    def status(folder, case):
        read.append(case.id)
        return case_status(folder, case)

    monkeypatch.setattr(display, "case_status", status)
    statuses = display.Statuses(finished.runs, [load_case(folder) for folder in folders])
    first, again = statuses(), statuses()
    assert [x.state for x in first] == [x.state for x in again]
    counts = {x.id: read.count(x.id) for x in first}
    assert counts == {x.id: 1 if x.state == "done" else 2 for x in first}
    assert set(counts.values()) == {1, 2}


@pytest.fixture(scope="module")
def ready(tmp_path_factory):
    return provoked_failures.prepared(tmp_path_factory.mktemp("provoked"))


@pytest.mark.engine
@pytest.mark.parametrize(
    "it",
    [
        pytest.param(x, id=x.how, marks=[] if x.kind in QUICK else pytest.mark.validate)
        for x in PROVOCATIONS
    ],
)
def test_a_provoked_failure_is_recognised(it, ready, tmp_path):
    try:
        lines = provoke(it, ready, tmp_path / "runs")
    except PermissionError as error:
        pytest.skip(str(error))
    assert len(lines) == 2
    assert f": {it.stage} " in lines[0] and f": {it.kind}: " in lines[0]
    assert lines[1].startswith("  to do: ") and it.advice in lines[1]
