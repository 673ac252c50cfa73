"""Results of several studies in one committed file."""

from millscale.study.results import published, with_study


def results(name):
    return {"name": name, "rows": [{"setting": "a"}], "missing": {}}


def test_a_study_replaces_its_own_rows_and_keeps_the_others_and_other_keys():
    before = published([results("one"), results("two")], {"commit": "old"})
    before["withdrawn"] = "Power and torque are withdrawn."
    after = with_study(before, published([results("two")], {"commit": "new"}))
    assert after["withdrawn"] == before["withdrawn"]
    assert [row["study"] for row in after["rows"]] == ["one", "two"]
    commits = {name: study["provenance"]["commit"] for name, study in after["studies"].items()}
    assert commits == {"one": "old", "two": "new"}
