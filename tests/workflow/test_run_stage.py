"""A single stage: its products, its record if it fails, and the lock of the case."""

import json

import pytest

from millscale.campaign.build import load_campaign
from millscale.cases.case import cases_of
from millscale.engine.resume import begin
from millscale.errors import CampaignError
from millscale.runs.digests import digest_of
from millscale.runs.layout import stage_of
from millscale.runs.lock import LOCK_FILE, hold
from millscale.runs.provenance import read_provenance, write_provenance
from millscale.runs.untrusted import RunFolderError
from millscale.workflow import stage_work
from millscale.workflow.run_stage import run_stage
from millscale.workflow.stage_record import read_record
from small_campaign import TEXT


@pytest.fixture(scope="session")
def cases(tmp_path_factory):
    """A case of each kind."""
    file = tmp_path_factory.mktemp("small") / "small.toml"
    file.write_text(TEXT)
    return {case.kind: case for case in cases_of(load_campaign(file))}


@pytest.fixture
def case(tmp_path, cases):
    (tmp_path / "case.json").write_text(cases["multi-ball"].text())
    return tmp_path


def work(monkeypatch, function):
    monkeypatch.setitem(stage_work.WORK, "charge", function)


def test_products_appear_only_when_the_stage_has_ended(case, monkeypatch):
    def charge(task):
        (task.part / "charge.data").write_text("new")
        assert not (task.folder / "charge.data").exists()

    (case / "charge.data").write_text("old")
    work(monkeypatch, charge)
    assert run_stage(case, "charge") == 0
    assert (case / "charge.data").read_text() == "new"
    assert {path.name for path in case.iterdir()} == {
        "case.json", "charge.data", "stage.json", "provenance.json", LOCK_FILE,
    }  # fmt: skip
    assert read_record(case).state == "done" and not (case / LOCK_FILE).read_text()


@pytest.mark.parametrize("cause", ["too many\nballs", ""])
def test_a_failed_stage_leaves_its_cause_and_log_but_no_product(case, monkeypatch, capfd, cause):
    def charge(task):
        (task.part / "charge.data").write_text("half")
        print("on the way")
        raise RuntimeError(cause)

    work(monkeypatch, charge)
    with capfd.disabled():
        assert run_stage(case, "charge") == 1
    assert not (case / "charge.data").exists()
    record = read_record(case)
    assert (record.state, record.log) == ("failed", "out.charge")
    assert record.cause == (cause.replace("\n", " ") or "RuntimeError")
    log = (case / "out.charge").read_text()
    assert "on the way" in log and "Traceback" in log


def test_a_stage_without_its_product_has_failed(case, monkeypatch):
    work(monkeypatch, lambda task: None)
    assert run_stage(case, "charge") == 1
    assert read_record(case).cause == "stage charge ended without charge.data"


def test_an_interrupted_stage_is_recorded_as_interrupted(case, monkeypatch):
    def charge(task):
        raise KeyboardInterrupt

    work(monkeypatch, charge)
    assert run_stage(case, "charge") == 130
    assert read_record(case).state == "interrupted"


def test_a_case_that_is_not_accepted_is_not_begun(case, monkeypatch):
    document = json.loads((case / "case.json").read_text())
    work(monkeypatch, None)
    for key in ("schema", "digest", "deck"):
        changed = {name: value for name, value in document.items() if name != key}
        changed |= {"ball": document["ball"] | {"radius_m": "$(step)"}} if key == "schema" else {}
        (case / "case.json").write_text(json.dumps(changed))
        with pytest.raises(RunFolderError):
            run_stage(case, "charge")
    assert not (case / "stage.json").exists()


def test_a_result_appears_only_when_it_is_published(tmp_path, cases, monkeypatch):
    """A killed stage leaves either no product, or products with their record."""
    (tmp_path / "case.json").write_text(cases["single-ball"].text())
    for name in ("series.csv", "timing.json"):
        (tmp_path / name).write_text("{}")
    monkeypatch.setattr("millscale.analysis.case.analyse_case", lambda folder: {"rows": 1})

    def kill(task):
        assert not (tmp_path / "result.json").exists() and (task.part / "result.json").exists()
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("millscale.workflow.run_stage._publish", kill)
        assert run_stage(tmp_path, "result") == 130
    assert not (tmp_path / "result.json").exists()
    assert run_stage(tmp_path, "result") == 0
    made = read_provenance(tmp_path)["result"]["products"]
    assert made == {"result.json": digest_of(tmp_path / "result.json")}


@pytest.fixture
def rotated(tmp_path, cases, monkeypatch):
    """A rotation that was stopped when all but its last products were in place."""
    monkeypatch.setenv("MILLSCALE_ENGINE", "/bin/true")
    document = cases["multi-ball"]
    (tmp_path / "case.json").write_text(cases["multi-ball"].text())
    (tmp_path / "mill.in").write_text("run")
    task = stage_work.Task(stage_of("multi-ball", "rotate"), document, tmp_path, ranks=1, lock=0)
    begin(stage_work.run_of(task.stage, task.case, task.folder, 1))
    for name in ("dump", "rotate.part"):
        (tmp_path / name).mkdir(exist_ok=True)
    for name in ("dump/charge.0", "series.csv", "rotate.part/timing.json"):
        (tmp_path / name).write_text(name)
    # Published before the products.
    made = {"inputs": {}, "products": {"series.csv": digest_of(tmp_path / "series.csv")}}
    write_provenance(tmp_path, {"rotate": made})
    return tmp_path


def test_a_complete_stage_is_only_renamed_and_not_done_again(rotated, monkeypatch):
    monkeypatch.setitem(stage_work.WORK, "rotate", None)
    assert run_stage(rotated, "rotate") == 0
    assert (rotated / "timing.json").read_text() == "rotate.part/timing.json"
    assert (rotated / "series.csv").exists() and (rotated / "dump" / "charge.0").exists()
    assert not (rotated / "rotate.part").exists() and not (rotated / "attempts.json").exists()


def test_a_stage_that_was_complete_is_done_again_when_an_input_has_changed(rotated, monkeypatch):
    def rotate(task):
        begin(stage_work.run_of(task.stage, task.case, task.folder, 1))
        for name in task.stage.products:
            (task.part / name).write_text("again")

    (rotated / "mill.in").write_text("run longer")
    monkeypatch.setitem(stage_work.WORK, "rotate", rotate)
    assert run_stage(rotated, "rotate") == 0
    assert (rotated / "timing.json").read_text() == "again"


def test_an_engine_stage_keeps_its_folder_for_the_next_attempt(rotated, monkeypatch):
    def rotate(task):
        assert (task.part / "mill.1.restart").exists()
        raise KeyboardInterrupt

    (rotated / "rotate.part" / "timing.json").unlink()
    (rotated / "rotate.part" / "mill.1.restart").touch()
    monkeypatch.setitem(stage_work.WORK, "rotate", rotate)
    assert run_stage(rotated, "rotate") == 130
    assert (rotated / "rotate.part" / "mill.1.restart").exists()


def test_a_case_is_worked_on_by_one_stage_at_a_time(case, monkeypatch):
    work(monkeypatch, lambda task: (task.part / "charge.data").touch())
    monkeypatch.setattr("millscale.workflow.run_stage.PATIENCE_S", 0.5)
    with hold(case), pytest.raises(CampaignError, match="in use by process"):
        run_stage(case, "charge")
    assert run_stage(case, "charge") == 0


def test_a_lock_file_without_a_holder_is_no_lock(tmp_path):
    (tmp_path / LOCK_FILE).write_text("process 1 on elsewhere since long ago")
    with hold(tmp_path):
        assert "elsewhere" not in (tmp_path / LOCK_FILE).read_text()
