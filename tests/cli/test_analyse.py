"""`millscale analyse`: output, files and errors of each command."""

import json

from in_process import millscale
from millscale.analysis.case import analyse_case

CHARGES = "cases/mb-cg-paper-S2.600-fixed-seed"


def refused(*arguments):
    """Return the error line of a command with wrong input."""
    done = millscale("analyse", *arguments)
    assert done.returncode == 2 and done.stdout == ""
    (line,) = done.stderr.splitlines()
    return line


def test_case_writes_the_result_or_explains_the_damage(folder):
    done = millscale("analyse", "case", folder)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == str(folder / "result.json")
    assert json.loads((folder / "result.json").read_text()) == analyse_case(folder)
    (folder / "result.json").unlink()
    (folder / "series.csv").write_text("step,time_s\n1,2\n")
    assert "series.csv" in refused("case", folder)
    assert not (folder / "result.json").exists()
    (folder / "series.csv").unlink()
    assert "series.csv: no such file" in refused("case", folder)


def test_pair_prints_errors_of_the_first_against_the_second(throws):
    folders = [throws / f"{CHARGES}{seed}" for seed in (1, 2)]
    pair = json.loads(millscale("analyse", "pair", *folders).stdout)
    assert [case["id"] for case in pair["cases"]] == [folder.name for folder in folders]
    assert pair["contour_error_mean"] >= 0.0
    assert "no such file" in refused("pair", folders[0], throws)


def test_groups_takes_patterns_and_writes_the_comparison(throws, tmp_path):
    pattern, to = f"{throws / CHARGES}[12]", tmp_path / "groups.json"
    done = millscale("analyse", "groups", pattern, pattern, "--to", to)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("| quantity | between groups |")
    compared = json.loads(to.read_text())
    assert len(compared["first"]) == 2 and compared["first"] == compared["second"]
    assert all(found["difference"] == 0.0 for found in compared["means"].values())


def test_groups_refuses_what_matches_nothing_or_is_no_case(tmp_path):
    assert f"no folder {tmp_path}/x*; accepted: case folders" in refused(
        "groups", f"{tmp_path}/x*", f"{tmp_path}/y*"
    )
    assert str(tmp_path) in refused("groups", tmp_path, tmp_path)


def test_campaigns_writes_rows_with_their_origin(throws, tmp_path):
    to = tmp_path / "paper-multi-ball.json"
    arguments = ("campaigns", throws, "--to", to)
    done = millscale("analyse", *arguments, "--machine", "shared", "--commit", "abc")
    assert done.returncode == 0, done.stderr
    content = json.loads(to.read_text())
    assert content["commit"] == "abc"
    assert content["machine"] == "A made-up CPU, 2 cores; shared"
    assert content["date"].startswith("20")
    assert content["command"][-1] == f"millscale analyse campaigns {throws}"
    assert len(content["rows"]) == 4
    table = done.stdout.splitlines()
    assert len(table) == 2 + 3  # a line for each model
    assert len({line.count("|") for line in table}) == 1
    assert " ± " in table[3] and "(" in table[3]
    assert "| 12 | – | 1.0 | – | – |" in table[2]  # the physical mill against itself
    assert "a second campaign named 'synthetic'" in refused(
        "campaigns", throws, throws, *arguments[2:]
    )


def test_variants_prints_a_row_for_each_campaign_and_scheme(runs, tmp_path):
    table = millscale("analyse", "variants", runs).stdout.splitlines()
    assert len(table) == 2 + 2
    assert len({line.count("|") for line in table}) == 1
    assert "| 63.90 | 35.50 | 2.184 |" in table[2]
    assert table[2].endswith("* |")
    assert "no such file" in refused("variants", tmp_path)


def test_pictures_draws_the_dump_nearest_to_each_angle(throws, tmp_path):
    folder = throws / f"{CHARGES}1"
    to = tmp_path / "new" / "pictures"
    done = millscale("analyse", "pictures", folder, "--angle", "0.1", "--angle", "9", "--to", to)
    assert done.returncode == 0, done.stderr
    drawn = sorted(to.iterdir())
    assert [path.name for path in drawn] == [f"{folder.name}-{x}.png" for x in ("00000", "01000")]
    assert all(path.read_bytes().startswith(b"\x89PNG") for path in drawn)
    assert done.stdout.splitlines() == [f"{drawn[0]}: 0.000 rad", f"{drawn[1]}: 1.000 rad"]
