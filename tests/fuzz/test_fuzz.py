"""Damaged inputs: an error of one line or a result, never a traceback, a hang, a write outside.

Few in the normal run; the full number, and docs/results/fuzz.json:

    python -m pytest tests/fuzz -m validate --fuzz-results docs/results/fuzz.json
"""

import json
import shutil
import tomllib
import warnings
from pathlib import Path

import numpy as np
import pytest
from attempts import Tally, attempt
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from mutations import as_json, as_toml, damaged, documents
from small_campaign import TEXT
from synthetic_ball import usual_motion
from synthetic_case import case_document, timing_document, write_case, write_series
from synthetic_charge import block, write_charge, write_dump

from liner_mesh import read_stl
from mill_analysis import RunFolderError, analyse_case
from mill_analysis.campaign import load_campaign as load_runs
from mill_analysis.dumps import read_dump
from mill_campaign.case import Case, cases_of
from mill_campaign.config_build import load_campaign
from mill_campaign.errors import CampaignError
from mill_campaign.generate import generate
from mill_campaign.parameters import write_parameters
from mill_campaign.plan import plan_rows
from mill_campaign.status import campaign_status
from mill_campaign.verify import verify

FULL, FEW = 1000, 40
REFUSALS = (CampaignError, RunFolderError, OSError)
CAMPAIGNS = sorted((Path(__file__).parents[2] / "campaigns").glob("*.toml"))
NUMBERS = [pytest.param(FEW, id="few"), pytest.param(FULL, id="full", marks=pytest.mark.validate)]


def run(tallies, name, number, strategy, act, folder, refusals=REFUSALS):
    """Try `number` inputs of a strategy."""
    tally = Tally()

    @settings(
        max_examples=number, deadline=None, database=None, derandomize=True,
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip
    @given(strategy)
    def each(data):
        inside = folder / "inside"
        shutil.rmtree(inside, ignore_errors=True)
        inside.mkdir()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            attempt(tally, inside, data, lambda: act(inside, data), refusals)

    each()
    tallies[name] = tally
    if tally.faults:
        pytest.fail(f"{len(tally.faults)} faults, the first:\n{tally.faults[0]}", pytrace=False)
    # Hypothesis tries some inputs once only, however often they come.
    assert tally.inputs_tried >= 0.9 * number


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


def stl_files(folder):
    from liner_mesh import write_stl
    from mill_campaign.charge import liner_of
    from mill_campaign.wall_panels import panels_of

    (folder / "small.toml").write_text(TEXT)
    case = cases_of(load_campaign(folder / "small.toml"))[0].document
    surface = panels_of(liner_of(case), 0.3, 0.02, 1)
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
        write_parameters(Case.load(path), folder)
        text = (folder / "parameters.in").read_text()
        assert all(
            line.startswith(("variable ", "#")) and "/" not in line for line in text.splitlines()
        )

    run(tallies, "case.json, campaign", number, inputs, read, tmp_path)


SIDE_FILES = (
    "campaign.json",
    "case.json",
    "stage.json",
    "provenance.json",
    "timing.json",
    "result.json",
)


def _finish(folder, S):
    """Give a generated case a result."""
    motion = case_document("single-ball", "constant-gravity", "paper", S, sample_angle=0.05)
    write_series(folder / "series.csv", usual_motion(motion).series())
    (folder / "timing.json").write_text(json.dumps(timing_document(1, 100)))
    analyse_case(folder)
    stage = {"stage": "result", "state": "failed", "started": 1.0, "ended": 2.0, "process": 1}
    stage |= {"process_started": 0.5, "cause": "c", "log": "out.result"}
    (folder / "stage.json").write_text(json.dumps(stage))
    made = {"inputs": {}, "products": {"result.json": "0" * 64}}
    (folder / "provenance.json").write_text(json.dumps({"schema": 1, "stages": {"result": made}}))


@pytest.mark.parametrize("number", NUMBERS)
def test_runs_folders(tallies, number, tmp_path):
    """status, verify and report on a folder of which one JSON file is damaged."""
    good = tmp_path / "good"
    (tmp_path / "small.toml").write_text(TEXT.split("[multi_ball]")[0])
    cases = generate(tmp_path / "small.toml", good)
    for case in cases:
        _finish(good / "cases" / case.id, case["S"])
    first = good / "cases" / cases[0].id
    originals = {
        name: (good if name == "campaign.json" else first).joinpath(name).read_bytes()
        for name in SIDE_FILES
    }
    inputs = st.sampled_from(SIDE_FILES).flatmap(
        lambda name: st.tuples(
            st.just(name),
            st.one_of(
                damaged([originals[name]]),
                documents([json.loads(originals[name])]).map(as_json),
            ),
        )
    )

    def read(folder, data):
        runs = folder / "runs"
        shutil.copytree(good, runs)
        name, content = data
        place = runs if name == "campaign.json" else runs / "cases" / first.name
        (place / name).write_bytes(content)
        refused = []
        for look in (campaign_status, verify, results):
            try:
                look(runs)
            except REFUSALS as error:
                refused.append(error)
        if refused:
            raise refused[0]

    run(tallies, "JSON files of a runs folder", number, inputs, read, tmp_path)


def results(runs):
    """What a report computes, without its pictures."""
    json.dumps(load_runs(runs).results())
