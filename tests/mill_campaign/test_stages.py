"""A stage by itself: what it publishes, what it leaves when it fails, and the folder's lock."""

import json

import pytest

from mill_campaign import stage_work, stages
from mill_campaign.errors import CampaignError
from mill_campaign.folder_lock import LOCK_FILE, hold
from mill_campaign.stage_record import read_record


@pytest.fixture
def case(tmp_path):
    (tmp_path / "case.json").write_text(json.dumps({"id": "c", "kind": "multi-ball"}))
    return tmp_path


def work(monkeypatch, function):
    monkeypatch.setitem(stage_work.WORK, "charge", function)


def test_products_appear_only_when_the_stage_has_ended(case, monkeypatch):
    def charge(task):
        (task.part / "charge.data").write_text("new")
        assert not (task.folder / "charge.data").exists()

    (case / "charge.data").write_text("old")
    work(monkeypatch, charge)
    assert stages.run_stage(case, "charge") == 0
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
        assert stages.run_stage(case, "charge") == 1
    assert not (case / "charge.data").exists()
    record = read_record(case)
    assert (record.state, record.log) == ("failed", "out.charge")
    assert record.cause == (cause.replace("\n", " ") or "RuntimeError")
    log = (case / "out.charge").read_text()
    assert "on the way" in log and "Traceback" in log


def test_a_stage_without_its_product_has_failed(case, monkeypatch):
    work(monkeypatch, lambda task: None)
    assert stages.run_stage(case, "charge") == 1
    assert read_record(case).cause == "stage charge ended without charge.data"


def test_an_interrupted_stage_says_so(case, monkeypatch):
    def charge(task):
        raise KeyboardInterrupt

    work(monkeypatch, charge)
    assert stages.run_stage(case, "charge") == 130
    assert read_record(case).state == "interrupted"


def test_a_case_is_worked_on_by_one_stage_at_a_time(case, monkeypatch):
    work(monkeypatch, lambda task: (task.part / "charge.data").touch())
    with hold(case), pytest.raises(CampaignError, match="in use by process"):
        stages.run_stage(case, "charge")
    assert stages.run_stage(case, "charge") == 0


def test_a_lock_file_without_a_holder_is_no_lock(tmp_path):
    (tmp_path / LOCK_FILE).write_text("process 1 on elsewhere since long ago")
    with hold(tmp_path):
        assert "elsewhere" not in (tmp_path / LOCK_FILE).read_text()
