"""`millscale validate mixing`: rows of charges, means over seeds, lines in S."""

import json

import numpy as np
import pytest
from scipy.stats import linregress

from in_process import millscale
from millscale.analysis.finished_campaign import load_campaign
from millscale.validate.mixing import SIDES, line_in_S, lines_of, of_seeds, rows_of
from synthetic_case import finish_case, write_campaign
from synthetic_charge import write_charge


def row(S, seed, index, side=0.1, **more):
    made = {"campaign": "c", "scheme": "constant-gravity", "policy": "paper", "stiffness": "fixed"}
    made |= {"S": S, "seed": seed, "balls": 100, "side": side, "balls_per_cell": 20.0 / S}
    return (
        made
        | {"means": {"0 to 1": index, "3 to 4": None}, "revolutions_to": {"1 - 1/e": None}}
        | more
    )


def test_seeds_of_one_mill_and_side_give_a_mean_and_others_do_not_count():
    rows = [row(2.0, 1, 0.3), row(2.0, 2, 0.5), row(2.0, 1, 0.9, side=0.2), row(3.0, 1, 0.8)]
    found = {(x["S"], x["side"]): x for x in of_seeds(rows)}
    assert found[2.0, 0.1]["seeds"] == 2
    means = found[2.0, 0.1]["means"]
    assert means["0 to 1"]["mean"] == pytest.approx(0.4)
    assert means["0 to 1"]["deviation"] == pytest.approx(0.2 / np.sqrt(2.0))
    assert means["3 to 4"] == {"mean": None, "deviation": None}
    assert found[3.0, 0.1]["means"]["0 to 1"] == {"mean": 0.8, "deviation": None}


def test_a_mean_is_unknown_if_one_seed_lacks_it():
    rows = [row(2.0, 1, 0.3), row(2.0, 2, None)]
    assert of_seeds(rows)[0]["means"]["0 to 1"]["mean"] is None


def test_the_line_in_S_has_the_slope_and_error_of_least_squares():
    generator = np.random.default_rng(1)
    S = np.array([1.0, 1.7, 1.7, 2.6, 2.6, 4.0])
    index = 0.2 + 0.05 * (S - 1.0) + 0.01 * generator.normal(size=S.size)
    found, other = line_in_S(S, index), linregress(S - 1.0, index)
    assert found.at_1 == pytest.approx(other.intercept)
    assert found.at_1_error == pytest.approx(other.intercept_stderr)
    assert found.slope == pytest.approx(other.slope)
    assert found.slope_error == pytest.approx(other.stderr)
    assert line_in_S(np.full(5, 2.0), index[:5]) is None
    assert line_in_S(S[:2], index[:2]) is None


def test_lines_go_through_the_scaled_mills_of_one_scheme_and_policy():
    rows = [row(S, 1, 0.1 * S) for S in (2.0, 3.0, 5.0)]
    rows += [row(S, 1, 0.5, policy="friction-matched") for S in (2.0, 3.0, 4.0)]
    found = {x["policy"]: x for x in lines_of([*rows, row(1.0, 1, 0.7)])}
    assert found["paper"]["slope"] == pytest.approx(0.1)
    assert found["paper"]["at_1"] == pytest.approx(0.1)
    assert found["friction-matched"]["slope"] == pytest.approx(0.0)
    assert [x["physical"] for x in found.values()] == [0.7, 0.7]
    assert {x["span"] for x in found.values()} == {"0 to 1"}


@pytest.fixture
def runs(tmp_path):
    folders = [write_charge(tmp_path, scheme) for scheme in ("constant-gravity", "constant-speed")]
    for folder in folders:
        finish_case(folder)
    write_campaign(tmp_path, [folder.name for folder in folders])
    return tmp_path


def test_each_charge_has_a_row_for_each_side(runs):
    rows = list(rows_of(load_campaign(runs).charges))
    assert [row["side"] for row in rows] == [*SIDES, *SIDES]
    assert {row["scheme"] for row in rows} == {"constant-gravity", "constant-speed"}
    # The block turns by 1 rad, less than one revolution.
    assert rows[0]["means"]["0 to 1"] is None
    assert rows[0]["index"][0] == 0.0
    assert len(rows[0]["index"]) == len(rows[0]["revolutions"]) == 3


def test_the_command_writes_file_and_figure_and_prints_tables(runs):
    file = runs / "docs" / "mixing.json"
    done = millscale("validate", "mixing", runs, "--to", file)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("| campaign | scheme |")
    document = json.loads(file.read_text())
    assert document["command"] == "millscale validate mixing DIR... --to JSON"
    assert len(document["rows"]) == len(document["mills"]) == 2 * len(SIDES)
    assert file.with_suffix(".png").stat().st_size > 10_000


def test_campaigns_of_two_physical_mills_are_refused(runs, tmp_path_factory):
    other = tmp_path_factory.mktemp("other")
    folder = write_charge(other, "constant-gravity")
    text = (folder / "case.json").read_text()
    (folder / "case.json").write_text(text.replace('"length_m": 1.0', '"length_m": 2.0', 1))
    finish_case(folder)
    write_campaign(other, [folder.name])
    done = millscale("validate", "mixing", runs, other, "--to", runs / "mixing.json")
    assert done.returncode == 2
    assert "give campaigns of one physical mill" in done.stderr
    assert not (runs / "mixing.json").exists()
