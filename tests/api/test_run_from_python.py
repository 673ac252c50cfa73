"""`ms.run` with the engine: a dictionary, a resume, a failure, the progress bar of a notebook."""

import json
import sys
import tomllib
from types import SimpleNamespace

import pytest

import millscale as ms
import small_campaign
from liner_files import families, write_csv
from millscale.api import running
from millscale.campaign.build import load_campaign
from millscale.cases.case import cases_of
from millscale.errors import CampaignError, EngineError

BALL = "sb-cg-paper-S2.000"

pytestmark = pytest.mark.engine


def content():
    return tomllib.loads(small_campaign.TEXT)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A run of a dictionary: one single ball. Read only."""
    folder = tmp_path_factory.mktemp("made") / "mine"
    return folder, ms.run(content(), folder, only=BALL, quiet=True)


def test_a_dictionary_is_run_and_opened(made):
    _, opened = made
    assert list(opened) == [BALL] and opened.name == "small"
    assert opened[BALL].series["mill_angle_rad"].iloc[-1] == pytest.approx(1.0, abs=0.01)
    assert set(opened.missing) == {"sb-cg-paper-S1.000", small_campaign.CHARGE}


def test_the_folder_keeps_campaign_and_command(made):
    folder, _ = made
    assert tomllib.loads((folder / "campaign.toml").read_text()) == content()
    record = json.loads((folder / "cases" / BALL / "provenance.json").read_text())
    line = f"millscale run {folder}/campaign.toml --runs {folder}"
    assert record["stages"]["rotate"]["command"] == line


def test_the_same_call_again_runs_nothing(made):
    folder, _ = made
    series = folder / "cases" / BALL / "series.csv"
    before = series.stat().st_mtime_ns
    again = ms.run(folder / "campaign.toml", str(folder), only=[BALL], quiet=True)
    assert list(again) == [BALL] and series.stat().st_mtime_ns == before


def test_progress_is_reported_unless_it_is_quiet(made, capsys):
    folder, _ = made
    ms.run(content(), folder, only=BALL, quiet=True)
    assert capsys.readouterr().out == ""
    ms.run(content(), folder, only=BALL)
    assert f"{BALL}" in capsys.readouterr().out


def test_a_campaign_that_is_not_accepted_writes_nothing(tmp_path):
    wrong = content()
    wrong["mill"]["radius_m"] = -1.0
    with pytest.raises(CampaignError, match=r"campaign: mill\.radius_m"):
        ms.run(wrong, tmp_path / "runs")
    with pytest.raises(CampaignError, match="no case sb-x"):
        ms.run(content(), tmp_path / "runs", only="sb-x")
    assert not (tmp_path / "runs").exists()


def test_a_case_that_fails_is_an_error_with_its_cause(tmp_path, monkeypatch):
    engine = tmp_path / "engine"
    engine.write_text("#!/bin/sh\nexit 3\n")
    engine.chmod(0o755)
    monkeypatch.setenv("MILLSCALE_ENGINE", str(engine))
    with pytest.raises(EngineError, match=f"{BALL}: rotate failed"):
        ms.run(content(), tmp_path / "runs", only=BALL, quiet=True)


def test_a_notebook_gets_a_bar(made, monkeypatch, tmp_path):
    """The handle of the display is replaced; tests of the notebooks use a kernel."""
    shown = []

    def keep(bar):
        shown.append(bar._repr_mimebundle_((), ()))

    def display(bar, display_id):
        assert display_id
        keep(bar)
        return SimpleNamespace(update=keep)

    monkeypatch.setattr("IPython.display.display", display)
    monkeypatch.setattr(running, "is_notebook", lambda: True)
    ms.run(content(), tmp_path / "runs", only=BALL)
    assert shown[0]["text/plain"].startswith("starting, 0 of 1 case done")
    assert shown[-1]["text/plain"].startswith("1 of 1 case done")
    assert "100%" in shown[-1]["text/plain"] and "100%" in shown[-1]["text/html"]


def test_no_kernel_is_no_notebook(monkeypatch):
    assert not running.is_notebook()
    kernel = SimpleNamespace(get_ipython=lambda: SimpleNamespace(kernel=object()))
    monkeypatch.setitem(sys.modules, "IPython", kernel)
    assert running.is_notebook()


def test_a_drawing_of_a_dictionary_is_found_from_any_folder(tmp_path, monkeypatch):
    """Its path is from the folder of the call, as that of a file is from the file's folder."""
    mine = content()
    write_csv(tmp_path / "hi-lo.csv", families()["hi-lo"], error=1e-3)
    mine["liner"] = {"profile": "hi-lo.csv"}
    monkeypatch.chdir(tmp_path)
    with running._campaign_file(mine) as file:
        asked = load_campaign(file)
        assert file.parent != tmp_path
    assert len(ms.plan(mine).rows) == len(cases_of(asked)) > 0
