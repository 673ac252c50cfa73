"""Reading files that the engine is still writing."""

import pytest

from mill_campaign.progress import last_value


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", 0.0),
        ("step,time_s\n", 0.0),
        ("step,time_s\n10,0.1\n20,0.2\n", 20.0),
        ("step,time_s\n10,0.1\n20,0", 10.0),
        ("step,time_s\n10,0.1\n2\n", 10.0),
        ("step,time_s\n" + "".join(f"{i},0.{i:06d}\n" for i in range(5000)), 4999.0),
    ],
)
def test_the_last_full_line_counts(tmp_path, text, expected):
    path = tmp_path / "series.csv"
    path.write_text(text)
    assert last_value(path, "step") == expected


def test_a_series_that_is_not_there_yet_is_zero(tmp_path):
    assert last_value(tmp_path / "series.csv", "step") == 0.0
