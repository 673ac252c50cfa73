"""Damaged inputs give a one-line error or a result, never a traceback, hang or write outside.

Few in the normal run; the full number, and docs/results/fuzz.json:

    python -m pytest tests/fuzz -m validate --fuzz-results docs/results/fuzz.json
"""

import json
import re
import shutil
import tomllib
import zlib
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from hypothesis import strategies as st
from mutations import (
    as_json,
    as_saved_elsewhere,
    as_toml,
    at_the_ends,
    damaged,
    documents,
    hostile,
)
from trials import NUMBERS, REFUSALS, run

from millscale.analysis.case import analyse_case
from millscale.analysis.finished_campaign import load_campaign as load_runs
from millscale.campaign.build import load_campaign
from millscale.cases.case import cases_of
from millscale.cases.cost import BUILT_IN, learned
from millscale.cases.generate import generate
from millscale.cases.parameters import write_parameters
from millscale.engine.attempts import Attempt, Attempts, Cost, write_attempts
from millscale.engine.machine import hardware
from millscale.mesh import read_stl
from millscale.runs.case_file import load_case
from millscale.runs.digests import keep
from millscale.runs.dumps import read_dump
from millscale.runs.layout import stage_of
from millscale.workflow import stage_record
from millscale.workflow.failures import diagnose
from millscale.workflow.jobs import read_jobs, write_jobs
from millscale.workflow.placement import OPEN, place
from millscale.workflow.plan import plan_rows
from millscale.workflow.predictions import error_line, record_predictions
from millscale.workflow.run_stage import run_stage
from millscale.workflow.snakemake_run import last_problem
from millscale.workflow.stage_work import attempt_of, run_of
from millscale.workflow.status import campaign_status
from millscale.workflow.verify import verify
from small_campaign import TEXT
from synthetic_ball import usual_motion
from synthetic_case import case_document, finish_case, timing_document, write_case, write_series
from synthetic_charge import block, write_charge, write_dump

CAMPAIGNS = sorted((Path(__file__).parents[2] / "campaigns").glob("*.toml"))


@pytest.mark.parametrize("number", NUMBERS)
def test_campaign_files(tallies, number, tmp_path):
    texts = [TEXT.encode(), *(path.read_bytes() for path in CAMPAIGNS)]
    trees = [tomllib.loads(text.decode()) for text in texts]
    inputs = st.one_of(damaged(texts), documents(trees).map(as_toml))

    def read(folder, data):
        (folder / "c.toml").write_bytes(data)
        campaign = load_campaign(folder / "c.toml")
        plan_rows(campaign)
        generate(folder / "c.toml", folder / "runs")

    run(tallies, "campaign", number, inputs, read, tmp_path)


@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.parametrize("kind", ["at the ends", "saved elsewhere"])
def test_campaign_files_of_other_kinds(tallies, number, kind, tmp_path):
    texts = [TEXT.encode(), *(path.read_bytes() for path in CAMPAIGNS)]
    trees = [tomllib.loads(text.decode()) for text in texts]
    inputs = {
        "at the ends": at_the_ends(trees).map(as_toml),
        "saved elsewhere": as_saved_elsewhere(texts),
    }

    def read(folder, data):
        (folder / "c.toml").write_bytes(data)
        rows = plan_rows(load_campaign(folder / "c.toml"))
        json.dumps(rows, allow_nan=False)

    run(tallies, f"campaign, {kind}", number, inputs[kind], read, tmp_path)


def stl_files(folder):
    from millscale.cases.wall_panels import panels_of
    from millscale.mesh import write_stl
    from millscale.runs.liner import liner_of

    (folder / "small.toml").write_text(TEXT)
    case = cases_of(load_campaign(folder / "small.toml"))[0]
    surface = panels_of(liner_of(case.mill), 0.3, 0.02, 1)
    write_stl(folder / "liner.stl", surface)
    text = (folder / "liner.stl").read_bytes()
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    triangles = np.zeros(len(surface.triangles), record)
    triangles["corners"] = surface.corners
    binary = bytes(80) + np.uint32(len(triangles)).tobytes() + triangles.tobytes()
    return [text[:4000] + b"endsolid liner\n", text, binary]


@pytest.mark.parametrize("number", NUMBERS)
def test_stl_files(tallies, number, tmp_path):
    inputs = damaged(stl_files(tmp_path))

    def read(folder, data):
        (folder / "a.stl").write_bytes(data)
        read_stl(folder / "a.stl")

    run(tallies, "stl", number, inputs, read, tmp_path, (*REFUSALS, ValueError))


@pytest.mark.parametrize("number", NUMBERS)
def test_dump_files(tallies, number, tmp_path):
    case = case_document("multi-ball", "constant-gravity", "paper", 2.6, 40)
    write_dump(tmp_path / "d", 500, block(case, 40), case)

    def read(folder, data):
        path = folder / "charge.000000500.liggghts"
        path.write_bytes(data)
        read_dump(path).positions  # noqa: B018

    run(tallies, "dump", number, damaged([(tmp_path / "d").read_bytes()]), read, tmp_path)


def analysed(folder, kind):
    """A case folder ready for the analysis."""
    if kind == "multi-ball":
        return write_charge(folder, "constant-gravity")
    case = case_document(kind, "constant-gravity", "paper", 1.0, sample_angle=0.02)
    return write_case(folder, case, usual_motion(case).series())


@pytest.mark.parametrize("kind", ["single-ball", "multi-ball"])
@pytest.mark.parametrize("number", NUMBERS)
def test_series(tallies, number, kind, tmp_path):
    good = analysed(tmp_path, kind)
    case, series = (good / "case.json").read_bytes(), (good / "series.csv").read_bytes()

    def read(folder, data):
        (folder / "case.json").write_bytes(case)
        (folder / "series.csv").write_bytes(data)
        analyse_case(folder)

    run(tallies, f"series of a {kind}", number, damaged([series]), read, tmp_path)


@pytest.mark.parametrize("kind", ["single-ball", "multi-ball"])
@pytest.mark.parametrize("number", NUMBERS)
def test_case_documents_in_the_analysis(tallies, number, kind, tmp_path):
    good = analysed(tmp_path, kind)
    case, series = (good / "case.json").read_bytes(), (good / "series.csv").read_bytes()
    inputs = st.one_of(damaged([case]), documents([json.loads(case)]).map(as_json))

    def read(folder, data):
        (folder / "case.json").write_bytes(data)
        (folder / "series.csv").write_bytes(series)
        analyse_case(folder)

    run(tallies, f"case.json of a {kind}, analysis", number, inputs, read, tmp_path)


@pytest.mark.parametrize("number", NUMBERS)
def test_case_documents_in_the_campaign(tallies, number, tmp_path):
    (tmp_path / "small.toml").write_text(TEXT)
    cases = [case.text() for case in cases_of(load_campaign(tmp_path / "small.toml"))]
    inputs = st.one_of(
        damaged([text.encode() for text in cases]),
        documents([json.loads(text) for text in cases]).map(as_json),
    )

    def read(folder, data):
        path = folder / "case.json"
        path.write_bytes(data)
        write_parameters(load_case(folder), folder)
        text = (folder / "parameters.in").read_text()
        assert all(
            line.startswith(("variable ", "#")) and "/" not in line for line in text.splitlines()
        )

    run(tallies, "case.json, campaign", number, inputs, read, tmp_path)


DONE, BEGUN = (f"cases/sb-cg-paper-S{S}" for S in ("1.000", "2.000"))
SIDE_FILES = (
    *("campaign.json", "campaign.toml", "predicted.json", ".jobs/1/jobs.json", "log.workflow"),
    *(
        f"{DONE}/{name}"
        for name in (
            *("case.json", "stage.json", "provenance.json", "timing.json", "result.json"),
            *("mesh.json", "series.csv", "single_ball.in", "parameters.in", ".digests"),
        )
    ),
    *(
        f"{BEGUN}/{name}"
        for name in (
            *("stage.json", "rotate.part/attempts.json", "rotate.part/series.csv"),
            *("rotate.part/log.rotate", "rotate.part/mill.1.restart", "out.rotate", "log.rotate"),
        )
    ),
)
LOG = """LIGGGHTS (Version LIGGGHTS-PUBLIC 3.8.0)
Setting up run at Mon Nov 30 01:02:03 2026
Step Atoms KinEng
       0       1       0.0
     100       1       0.0
ERROR: Lost atoms: original 1 current 0 (thermo.cpp:427)
"""


def runs_folder(folder):
    """A folder with a case that is done and one whose rotation was interrupted."""
    (folder / "small.toml").write_text(TEXT.split("[multi_ball]")[0])
    runs = folder / "good"
    done, begun = generate(folder / "small.toml", runs)
    for case in (done, begun):
        for stage in ("mesh", "deck"):
            assert run_stage(runs / "cases" / case.id, stage) == 0
    _finish(runs / DONE, done.S)
    part = runs / BEGUN / "rotate.part"
    part.mkdir()
    motion = case_document("single-ball", "constant-gravity", "paper", 2.0, sample_angle=0.05)
    write_series(part / "series.csv", usual_motion(motion).series())
    for file in (part / "log.rotate", runs / BEGUN / "log.rotate", runs / BEGUN / "out.rotate"):
        file.write_text(LOG)
    run = run_of(stage_of("single-ball", "rotate"), begun, runs / BEGUN, 1)
    write_attempts(
        part, Attempts(run.inputs, (Attempt(0, 1.0, 1, Cost()), Attempt(5, 2.0, 1, Cost())))
    )
    content = b"balls" * 100
    signature = (
        f"\nmillscale restart step 400 bytes {len(content)} crc32 {zlib.crc32(content):08x} "
    )
    signature += "loop_time_s 1.5 processor_time_s 2.5\n"
    (part / "mill.1.restart").write_bytes(content + signature.encode())
    stage_record.end(runs / BEGUN, stage_record.begin(runs / BEGUN, "rotate"), "interrupted")
    record_predictions(runs, [done, begun], place([done, begun], OPEN), BUILT_IN)
    write_jobs(runs, []).parent.rename(runs / ".jobs" / "1")
    job = {"name": "a", "cases": [done.id], "ranks": 1, "time_s": 1.0, "minutes": 1, "memory_mb": 1}
    (runs / ".jobs" / "1" / "jobs.json").write_text(json.dumps([job]))
    (runs / "log.workflow").write_text("Building DAG of jobs...\nError: one\n")
    for case in ("", DONE, BEGUN):
        keep(runs / case)
    return runs


def _finish(folder, S):
    """Give a generated case a result."""
    motion = case_document("single-ball", "constant-gravity", "paper", S, sample_angle=0.05)
    write_series(folder / "series.csv", usual_motion(motion).series())
    (folder / "timing.json").write_text(json.dumps(timing_document(1, 100)))
    finish_case(folder)
    stage_record.end(folder, stage_record.begin(folder, "result"), "failed", "cause", "out.result")


def next_attempt(folder):
    found = attempt_of(folder, load_case(folder))
    return asdict(found) if found else None


def looks(runs):
    """Call every reader of a runs folder that changes nothing."""
    return {
        "status": lambda: [asdict(x) for x in campaign_status(runs)],
        "verify": lambda: list(map(str, verify(runs).differences)),
        "report": lambda: load_runs(runs).results(),
        "predictions": lambda: error_line(runs),
        "jobs": lambda: [asdict(x) for x in read_jobs(runs / ".jobs" / "1" / "jobs.json")],
        "next attempt": lambda: next_attempt(runs / BEGUN),
        "workflow": lambda: last_problem(runs),
        "failure": lambda: asdict(diagnose(RuntimeError("x"), runs / BEGUN, "rotate", 0)),
        "learned": lambda: asdict(learned(runs.glob("cases/*"), hardware()["cpu"])),
    }


@pytest.mark.parametrize("number", NUMBERS)
def test_runs_folders(tallies, number, tmp_path):
    """Every reader on a folder of which one file is damaged."""
    good = runs_folder(tmp_path)
    originals = {name: (good / name).read_bytes() for name in SIDE_FILES if (good / name).exists()}

    def kinds(name):
        some = [damaged([originals[name]]), hostile()]
        if name.endswith(".json"):
            some.append(documents([json.loads(originals[name])]).map(as_json))
        return st.tuples(st.just(name), st.one_of(some))

    def read(folder, data):
        runs = folder / "runs"
        shutil.copytree(good, runs)
        name, content = data
        (runs / name).write_bytes(content)
        refused = []
        for look in looks(runs).values():
            try:
                text = json.dumps(look(), allow_nan=False)
            except REFUSALS as error:
                refused.append(error)
                text = str(error)
            # Escapes of JSON, and of a terminal.
            assert not re.search(r"\\u00[01]|\\u007f|[\x00-\x1f\x7f]", text), text[:500]
        if refused:
            raise refused[0]

    inputs = st.sampled_from(sorted(originals)).flatmap(kinds)
    run(tallies, "files of a runs folder", number, inputs, read, tmp_path)
