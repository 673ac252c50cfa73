"""Runs that allow no prediction: one line with what, value, accepted, where and what next."""

import json
import math
import re
import shutil

import pytest

from in_process import millscale
from millscale.errors import PredictionError
from millscale.prediction.predict import predict
from synthetic_case import finish_case, write_campaign, write_case
from synthetic_mills import SEEDS, charge_case, columns_of, write_mills


def pair_with(**changes):
    return charge_case(1.696, 1), charge_case(2.6, 1, **changes)


def refusal(runs, *options):
    """Run the command, which must end with code 2 and one line that names the folder."""
    done = millscale("predict", runs, *options)
    assert done.returncode == 2, done.stdout
    assert not done.stdout
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"error: {runs}: "), line
    assert re.search(r"; accepted: .+; next: .+", line), line
    return line


def test_one_mill_only(tmp_path):
    line = refusal(write_mills(tmp_path, charge_case(2.6, 1), charge_case(2.6, 2)))
    assert "S = 2.6 alone is finished and steady; accepted: two values of S or more" in line


def test_two_physical_mills(tmp_path):
    line = refusal(write_mills(tmp_path, *pair_with(physical__radius_m=4.0)))
    assert "not of one physical mill: physical.radius_m is 3.9 and 4.0" in line


def test_unequal_filling(tmp_path):
    line = refusal(write_mills(tmp_path, *pair_with(ball__count=1000)))
    assert (
        "not filled alike: 0.879 times the balls per length, scaled; accepted: within 1 %" in line
    )


def test_unsteady_runs(tmp_path):
    cases = pair_with()
    line = refusal(write_mills(tmp_path, *cases, unsteady={cases[0]["id"]}))
    assert f"S = 2.6 alone is finished and steady; not used: {cases[0]['id']} (" in line
    assert "centre of mass drifts by" in line


@pytest.mark.parametrize("ratios", [(2.5, 2.6), (4.0, 4.4)])
def test_values_of_S_too_close_together(tmp_path, ratios):
    """The smallest weights are those of dilation, in the middle of its prior; by hand."""
    line = refusal(write_mills(tmp_path, *(charge_case(S, s) for S in ratios for s in SEEDS)))
    assert f"S = {ratios[0]:g}, {ratios[1]:g} lie too close together" in line
    near, far = (S**0.875 for S in ratios)
    weight = (far - 1.0) / (far - near)
    found = float(re.search(r"weights of norm ([\d.]+); accepted: at most 5", line)[1])
    assert found == pytest.approx(math.hypot(weight, 1.0 - weight), rel=5e-3)


def test_values_of_S_far_enough_apart_are_not_refused(tmp_path):
    runs = write_mills(tmp_path, *(charge_case(S, 1) for S in (2.0, 2.6)))
    assert predict([runs])["power"].value


def test_a_stale_run(tmp_path):
    cases = pair_with()
    runs = write_mills(tmp_path, *cases)
    path = runs / "cases" / cases[0]["id"] / "case.json"
    content = json.loads(path.read_text())
    content["ball"]["count"] += 1
    path.write_text(json.dumps(content))
    line = refusal(runs)
    assert f"not used: {cases[0]['id']} (" in line and "stale" in line


def test_a_failed_run(tmp_path):
    cases = pair_with()
    runs = write_mills(tmp_path, *cases)
    (runs / "cases" / cases[0]["id"] / "result.json").unlink()
    line = refusal(runs)
    assert f"not used: {cases[0]['id']} (" in line


def test_a_failed_run_among_enough_others_is_listed(tmp_path):
    cases = [charge_case(S, seed) for S in (1.696, 2.6) for seed in SEEDS]
    runs = write_mills(tmp_path, *cases)
    (runs / "cases" / cases[0]["id"] / "result.json").unlink()
    done = millscale("predict", runs)
    assert done.returncode == 0
    assert any(x.startswith(f"not used: {cases[0]['id']}: ") for x in done.stdout.splitlines())


def test_more_unusable_runs_than_fit_a_line_are_counted(tmp_path):
    cases = [charge_case(S, seed) for S in (1.696, 2.0, 2.3) for seed in SEEDS]
    keep = charge_case(2.6, 1)
    unsteady = {case["id"] for case in cases}
    line = refusal(write_mills(tmp_path, *cases, keep, unsteady=unsteady))
    assert ") and 3 more; accepted" in line


def test_no_scaled_mill(tmp_path):
    line = refusal(write_mills(tmp_path, charge_case(1.0, 1)))
    assert "no finished and steady charge of a scaled mill; accepted" in line


def test_two_schemes(tmp_path):
    other = charge_case(2.6, 1, scheme="constant-speed")
    line = refusal(write_mills(tmp_path, *pair_with(), other))
    assert "choose with --scheme and --policy" in line


def test_nothing_to_check_against(tmp_path):
    line = refusal(write_mills(tmp_path, *pair_with()), "--check")
    assert "no finished charge of S = 1 to compare with" in line


@pytest.mark.parametrize("level", ["0.2", "1", "95"])
def test_a_level_that_is_none(tmp_path, level):
    done = millscale("predict", tmp_path, "--level", level)
    assert done.returncode == 2
    assert f"level: got {float(level):g}; accepted: 0.5 to below 1" in done.stderr


def test_a_folder_without_runs(tmp_path):
    done = millscale("predict", tmp_path)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1
    assert "campaign.json" in done.stderr


def test_a_folder_given_twice_counts_once(tmp_path):
    runs = write_mills(tmp_path, *pair_with())
    assert len(predict([runs, runs / "."]).runs) == 2


def test_a_copy_of_a_run_is_no_second_seed(tmp_path):
    runs = write_mills(tmp_path / "runs", *pair_with())
    shutil.copytree(runs, tmp_path / "copy")
    with pytest.raises(PredictionError, match=r"are the same run; accepted: each run once"):
        predict([runs, tmp_path / "copy"])


def test_one_seed_in_slices_of_two_lengths_is_no_copy(tmp_path):
    """The same S and seed, but not the same run."""
    whole, half = charge_case(2.6, 1), charge_case(2.6, 1)
    half["mill"]["simulated_length_m"] *= 0.5
    half["ball"]["count"] = round(0.5 * half["ball"]["count"])
    first = write_mills(tmp_path / "first", charge_case(1.696, 1), whole)
    second = tmp_path / "second"
    folder = write_case(second, half, columns_of(half))
    finish_case(folder)
    write_campaign(second, [folder.name])
    assert len(predict([first, second]).runs) == 3
