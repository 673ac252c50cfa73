"""JSON files of a run folder."""

import json

import pytest

from millscale.runs.case_folder import case_folders, missing_products, read_json
from millscale.runs.untrusted import RunFolderError
from millscale.runs.writing import write_json


def test_written_json_reads_back_and_leaves_no_part(tmp_path):
    content = {"schema": 1, "values": [0.1, None, "a"]}
    write_json(tmp_path / "x.json", content)
    assert read_json(tmp_path / "x.json", "x") == content
    assert [path.name for path in tmp_path.iterdir()] == ["x.json"]


def test_nan_is_not_written(tmp_path):
    write_json(tmp_path / "x.json", {"a": 1})
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_json(tmp_path / "x.json", {"a": float("nan")})
    assert read_json(tmp_path / "x.json", "x") == {"a": 1}


@pytest.mark.parametrize(
    ("text", "cause"),
    [
        (None, "no such file; make it with: COMMAND"),
        ('{"schema": 1, "id"', "not valid JSON .* cut short"),
        ("[1, 2]", "not a JSON object"),
        ('{"schema": 7}', "schema 7, accepted 1"),
    ],
)
def test_damaged_json_is_reported_with_file_cause_and_remedy(tmp_path, text, cause):
    if text is not None:
        (tmp_path / "case.json").write_text(text)
    with pytest.raises(RunFolderError, match=f"case.json: {cause}.*COMMAND|{cause}"):
        read_json(tmp_path / "case.json", "COMMAND")


def test_cases_are_in_the_order_of_the_campaign(tmp_path):
    (tmp_path / "campaign.json").write_text(json.dumps({"cases": ["b", "a"]}))
    assert [folder.name for folder in case_folders(tmp_path)] == ["b", "a"]


def test_folder_without_a_campaign_is_refused(tmp_path):
    with pytest.raises(RunFolderError, match=r"campaign.json: no such file.*millscale generate"):
        case_folders(tmp_path)


def test_products_missing_are_listed_in_their_order(folder):
    assert missing_products(folder) == ["result.json"]
    (folder / "series.csv").unlink()
    assert missing_products(folder) == ["series.csv", "result.json"]
