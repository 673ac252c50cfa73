"""`millscale validate fidelity` on made-up studies whose correlation and bias are known."""

import json

import numpy as np
import pytest

from in_process import millscale
from millscale.analysis.finished import Charge
from millscale.runs.case_folder import load_finished
from millscale.validate.fidelity import (
    Fidelity,
    compare,
    fidelities_of,
    pairs_of,
    slice_lengths,
    steady_windows,
    step_bias,
    window_means,
)
from synthetic_case import case_document, finish_case, write_case
from synthetic_charge import block, charge_columns, write_dump

SEEDS = (1, 2, 3, 4, 5)
STEPS = {"fine": 5e-5, "coarse": 1e-4}
BIAS = 0.01  # of x_c / R, of the coarse step


def write_run(runs, name, seed, offset, balls=40):
    """Make a run whose x_c / R is -0.37 plus an offset, and whose balls lie at random places."""
    case = case_document("multi-ball", "constant-gravity", "paper", 2.6, balls, 0.02)
    case |= {"id": f"{case['id']}-seed{seed}", "seed": seed}
    case["time"]["step_s"] = STEPS[name]
    case["ball"]["radius_m"] = 0.06
    columns = charge_columns(case, 12.0)
    ones = np.ones_like(columns["time_s"])
    columns["centre_x_m"] = columns["centre_x_m"] + offset * case["mill"]["radius_m"]
    columns["toe_angle_rad"] = (3.8 + offset) * ones
    columns["kinetic_translation_J"] = columns["kinetic_translation_J"] * (1.0 + offset)
    folder = write_case(runs, case, columns)
    (folder / "dump").mkdir()
    places = np.random.default_rng(seed).permutation(block(case, 2 * balls))
    for angle in (0.0, 0.5):
        step = round(angle / (case["mill"]["omega_rad_s"] * STEPS[name]))
        # The runs of a seed begin with the same packing and end with different ones.
        of_run = places[:balls] if angle == 0.0 or name == "fine" else places[balls:]
        write_dump(folder / f"dump/charge.{step:09d}.liggghts", step, of_run, case)
    finish_case(folder)
    return folder


def write_study(runs, offsets):
    """Make a study of two steps; offsets: of x_c / R by setting and seed."""
    settings = []
    for name, of_seeds in offsets.items():
        folder = runs / "settings" / name
        cases = [write_run(folder, name, seed, x) for seed, x in zip(SEEDS, of_seeds, strict=True)]
        entries = [{"id": case.name, "folder": str(case.relative_to(runs))} for case in cases]
        settings.append({"name": name, "about": "", "cases": entries})
    about = {"name": "made-up", "about": "", "reference": "fine", "default": "coarse"}
    (runs / "study.json").write_text(json.dumps({"schema": 1, **about, "settings": settings}))
    return runs


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """The coarse runs differ from the fine ones of their seed by the bias alone. Read only."""
    offsets = 0.004 * np.random.default_rng(1).normal(size=len(SEEDS))
    runs = tmp_path_factory.mktemp("study")
    return write_study(runs, {"fine": offsets, "coarse": offsets - BIAS})


@pytest.fixture(scope="module")
def fidelities(study):
    return fidelities_of(study)


def test_window_means_are_those_of_the_charge(study):
    charge = Charge(load_finished(next((study / "settings/fine/cases").iterdir())), "fine")
    means = window_means(charge)
    assert {len(values) for values in means.values()} == {11}
    whole = charge.result.dimensionless
    assert means["minus_centre_x"] == pytest.approx(-whole["centre_x"])
    assert means["kinetic"] == pytest.approx(whole["kinetic"])
    assert means["power"].mean() == pytest.approx(0.37, abs=2e-3)


def test_runs_that_differ_by_a_bias_alone_correlate_by_one(fidelities):
    found = compare(*fidelities, steady_windows(fidelities))
    for name in ("minus_centre_x", "kinetic", "toe"):
        steady = found["observables"][name]["steady"]
        assert steady["value"] == pytest.approx(1.0)
        assert steady["variance_left"] == pytest.approx(0.0, abs=1e-9)
        assert steady["cost_at_equal_variance"] == pytest.approx(found["cost_ratio"], abs=1e-4)
    # The power does not vary between these seeds.
    assert found["observables"]["power"]["steady"]["value"] is None


def test_the_same_ball_is_in_one_place_at_the_start_and_anywhere_later(fidelities):
    at_rest, later = compare(*fidelities, steady_windows(fidelities))["distance"]
    assert (at_rest["mill_angle_rad"], later["mill_angle_rad"]) == (0.0, 0.5)
    assert at_rest["same"] == 0.0 < at_rest["unrelated"]
    assert later["same"] == pytest.approx(later["unrelated"], rel=0.2)


def test_the_bias_of_the_step_is_found_and_removed_by_its_order(fidelities):
    found = step_bias(fidelities, steady_windows(fidelities))["minus_centre_x"]
    assert found["bias"] == pytest.approx(BIAS, rel=1e-6)
    first, second = found["richardson"]
    assert first["value"] == pytest.approx(found["fine"]["mean"] - BIAS)
    assert second["value"] == pytest.approx(found["fine"]["mean"] - BIAS / 3.0)
    assert first["error"] == pytest.approx(found["fine"]["error"] * np.sqrt(5.0))


def test_a_pair_has_the_seeds_that_both_settings_have(study, tmp_path):
    about = json.loads((study / "study.json").read_text())
    for setting in about["settings"]:
        for case in setting["cases"]:
            case["folder"] = str(study / case["folder"])
    about["settings"][0]["cases"] = about["settings"][0]["cases"][1:]
    (tmp_path / "study.json").write_text(json.dumps(about))
    fidelities = fidelities_of(tmp_path)
    assert [len(x.charges) for x in fidelities] == [4, 5]
    ((first, second),) = pairs_of(fidelities)
    assert list(first.charges) == list(second.charges) == [2, 3, 4, 5]


def test_extrapolation_in_length_is_exact_for_an_error_of_one_over_length():
    def of(diameters):
        return {"of_seeds": [1.0 + 0.2 / diameters + x for x in (-0.001, 0.0, 0.001)]}

    quantities = {"kinetic": {f"{d} diameters": of(d) for d in (6, 4, 2)}}
    quantities["kinetic"]["whole length"] = of(1e9)
    measured = {"slices": {"reference": "whole length", "quantities": quantities}}
    rows = {tuple(row["from"]): row for row in slice_lengths(measured)["kinetic"]}
    assert rows[2.0,]["error"] == pytest.approx(0.1)
    assert rows[2.0, 4.0]["error"] == pytest.approx(0.0, abs=1e-9)
    assert rows[2.0, 4.0]["standard_error"] > rows[4.0,]["standard_error"]


def test_the_command_writes_file_and_figure_and_prints_tables(study, tmp_path):
    file = tmp_path / "fidelity.json"
    done = millscale("validate", "fidelity", study, "--to", file)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("| runs | observable |")
    document = json.loads(file.read_text())
    assert [pair["seeds"] for pair in document["pairs"]] == [list(SEEDS)]
    assert document["slice_length"] == {}
    assert file.with_suffix(".png").stat().st_size > 10_000


@pytest.mark.parametrize(("settings", "seeds"), [(2, 1), (1, 5), (0, 0)])
def test_a_study_without_two_settings_that_share_two_seeds_is_refused(
    study, tmp_path, settings, seeds
):
    about = json.loads((study / "study.json").read_text())
    for number, setting in enumerate(about["settings"]):
        kept = seeds if number < settings else 0
        setting["cases"] = setting["cases"][:kept]
        for case in setting["cases"]:
            case["folder"] = str(study / case["folder"])
    (tmp_path / "study.json").write_text(json.dumps(about))
    done = millscale("validate", "fidelity", tmp_path)
    assert done.returncode == 2
    assert "no two settings share two finished seeds" in done.stderr


def test_the_first_case_stands_for_the_step_of_a_setting(fidelities):
    fine = next(x for x in fidelities if x.name == "fine")
    assert isinstance(fine, Fidelity)
    assert (fine.step, fine.precision) == (5e-5, "double")
