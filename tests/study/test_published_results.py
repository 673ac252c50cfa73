"""Results of several studies in one committed file."""

from millscale.study.results import with_study


def document(*names, commit, **more):
    rows = [{"study": name, "setting": commit} for name in names]
    return {"schema": 1, "rows": rows, "studies": dict.fromkeys(names, commit), **more}


def test_a_study_replaces_its_own_rows_and_keeps_the_others_and_other_keys():
    before = document("one", "two", commit="old", withdrawn="Power is withdrawn.")
    after = with_study(before, document("two", commit="new"))
    assert after["withdrawn"] == before["withdrawn"]
    assert [row["study"] for row in after["rows"]] == ["one", "two"]
    assert [row["setting"] for row in after["rows"]] == ["old", "new"]
    assert after["studies"] == {"one": "old", "two": "new"}
