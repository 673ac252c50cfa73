import json
import os
from pathlib import Path

import pytest

from millscale.cases.generate import changed_cases, generate
from millscale.errors import CampaignError
from millscale.runs.case_digest import case_digest
from paper_campaign import MULTI_BALL, write_campaign


def files(folder: Path) -> dict[str, tuple[str, int]]:
    """Return content and date of every file."""
    return {
        str(path.relative_to(folder)): (path.read_text(), path.stat().st_mtime_ns)
        for path in folder.rglob("*")
        if path.is_file()
    }


def backdate(folder: Path) -> None:
    for path in folder.rglob("*"):
        os.utime(path, (1e9, 1e9))


def test_a_campaign_becomes_a_folder_for_each_case_and_a_list_of_cases(tmp_path):
    runs = tmp_path / "runs"
    found = generate(write_campaign(tmp_path, **MULTI_BALL), runs)
    campaign = json.loads((runs / "campaign.json").read_text())
    assert campaign["cases"] == [case.id for case in found]
    assert campaign["name"] == "campaign"
    cases = {f"cases/{case.id}/case.json" for case in found}
    assert set(files(runs)) == {"campaign.json", "campaign.toml", *cases}


def test_the_same_campaign_is_written_the_same_way_anywhere(tmp_path):
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        generate(write_campaign(tmp_path / name), tmp_path / name / "runs")
    texts = [
        {key: text for key, (text, _) in files(tmp_path / name / "runs").items()}
        for name in ("one", "two")
    ]
    assert texts[0] == texts[1]
    assert str(tmp_path) not in "".join(texts[0].values())


def test_an_unchanged_campaign_touches_no_file(tmp_path):
    path, runs = write_campaign(tmp_path), tmp_path / "runs"
    generate(path, runs)
    backdate(runs)
    before = files(runs)
    generate(path, runs)
    assert files(runs) == before


def test_a_changed_campaign_touches_only_the_cases_it_changes(tmp_path):
    path, runs = write_campaign(tmp_path, **MULTI_BALL), tmp_path / "runs"
    generate(path, runs)
    backdate(runs)
    before = files(runs)
    charge = {**MULTI_BALL["multi_ball"], "count": [100, 11]}
    path = write_campaign(tmp_path, multi_ball=charge)
    generate(path, runs)
    after = files(runs)
    changed = {key for key in after if after[key] != before[key]}
    ids = ("mb-cg-paper-S2.600", "mb-cs-paper-S2.600")
    assert changed == {
        "campaign.toml",
        "campaign.json",
        *(f"cases/{name}/case.json" for name in ids),
    }


def test_changed_cases_are_found_without_writing(tmp_path):
    path, runs = write_campaign(tmp_path), tmp_path / "runs"
    found = generate(path, runs)
    assert changed_cases(found, runs) == set()
    edited = runs / "cases" / found[0].id / "case.json"
    edited.write_text(edited.read_text().replace('"count": 1', '"count": 2'))
    assert changed_cases(found, runs) == {found[0].id}
    assert changed_cases(found, tmp_path / "none") == {case.id for case in found}
    assert not (tmp_path / "none").exists()


def test_a_case_that_differs_by_rounding_stays_as_it_is_written(tmp_path):
    """As if another version, compiler or machine had computed the last digits otherwise."""
    path, runs = write_campaign(tmp_path), tmp_path / "runs"
    file = runs / "cases" / generate(path, runs)[0].id / "case.json"
    document = json.loads(file.read_text())
    document["mill"]["area_m2"] *= 1 + 1e-15
    file.write_text(json.dumps(document))
    before = file.read_text()
    found = generate(path, runs)
    assert file.read_text() == before and found[0].digest == case_digest(document)
    summary = json.loads((runs / "campaign.json").read_text())
    assert summary["digests"][found[0].id] == case_digest(document)
    document["mill"]["area_m2"] *= 1 + 1e-9
    file.write_text(json.dumps(document))
    assert generate(path, runs)[0].digest != case_digest(document)
    assert file.read_text() != json.dumps(document)


def test_products_and_cases_that_left_the_campaign_stay(tmp_path):
    runs = tmp_path / "runs"
    generate(write_campaign(tmp_path), runs)
    product = runs / "cases" / "sb-cg-paper-S2.600" / "series.csv"
    product.write_text("kept")
    generate(write_campaign(tmp_path, scaling__S=[1.0]), runs)
    assert product.read_text() == "kept"
    campaign = json.loads((runs / "campaign.json").read_text())
    assert campaign["cases"] == ["sb-cg-paper-S1.000", "sb-cs-paper-S1.000"]


def test_a_damaged_case_file_is_written_again(tmp_path):
    path, runs = write_campaign(tmp_path), tmp_path / "runs"
    found = generate(path, runs)
    damaged = runs / "cases" / found[0].id / "case.json"
    damaged.write_text("{")
    generate(path, runs)
    assert json.loads(damaged.read_text())["id"] == found[0].id


def test_a_campaign_that_became_wrong_changes_nothing(tmp_path):
    runs = tmp_path / "runs"
    generate(write_campaign(tmp_path), runs)
    before = files(runs)
    with pytest.raises(CampaignError):
        generate(write_campaign(tmp_path, scaling__S=[1.0, 0.9]), runs)
    assert files(runs) == before
