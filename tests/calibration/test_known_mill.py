"""Known friction of a simulated mill is found again: a thousand balls, the engine, some minutes."""

import json
import tomllib
from pathlib import Path

import pytest

import in_process
from millscale.analysis.finished import Charge
from millscale.calibration.file import load_calibration
from millscale.campaign.writer import toml_text
from millscale.runs.case_folder import finished_or_reason
from paper_campaign import CAMPAIGNS

FOLDER = CAMPAIGNS / "calibration"
FILE, BASE = "calibrate-friction.toml", "laboratory-300-mm.toml"
UNCERTAINTIES = {
    "power_w": 1.5,
    "shoulder_rad": 0.026,
    "toe_rad": 0.017,
    "kinetic": 0.003,
    "centre_z": 0.003,
}


def millscale(*words):
    done = in_process.millscale(*words, "--ranks", "1", "--jobs", "1")
    assert done.returncode == 0, done.stdout + done.stderr


def measured(folder: Path) -> list[dict[str, float]]:
    """Targets from a run of the mill itself, of another packing."""
    tree = tomllib.loads((FOLDER / BASE).read_text(encoding="utf-8"))
    tree["campaign"]["name"] = "truth"
    tree["multi_ball"]["seeds"] = [2]
    (folder / "truth.toml").write_text(toml_text(tree))
    millscale("run", folder / "truth.toml", "--runs", folder / "truth")
    (case,) = (folder / "truth/cases").iterdir()
    charge = Charge(finished_or_reason(case), "truth")
    targets = load_calibration(FOLDER / FILE).targets
    return [
        {key: float(target.simulated(charge)[0]), "uncertainty": UNCERTAINTIES[key]}
        for key, target in zip(UNCERTAINTIES, targets, strict=True)
    ]


@pytest.mark.engine
@pytest.mark.validate
def test_friction_of_a_simulated_mill_is_found_again(tmp_path):
    tree = tomllib.loads((FOLDER / FILE).read_text(encoding="utf-8"))
    tree["calibration"] |= {"samples": 10, "samples_per_round": 4, "rounds": 3}
    tree["target"] = measured(tmp_path)
    (tmp_path / FILE).write_text(toml_text(tree))
    base = (FOLDER / BASE).read_text(encoding="utf-8")
    (tmp_path / BASE).write_text(base)
    millscale("calibrate", tmp_path / FILE, "--runs", tmp_path / "runs")
    content = json.loads((tmp_path / "runs/calibration.json").read_text())
    material = tomllib.loads(base)["material"]
    for found in content["parameters"]:
        truth = material[found["keys"][0].removeprefix("material.")]
        assert found["lower"] < truth < found["upper"], found
    # An even density has 0.95. docs/results/calibration.md: 0.46 and 0.72.
    assert [found["width"] < 0.8 for found in content["parameters"]] == [True, True]
    for target in content["targets"]:
        assert abs(target["difference_over_uncertainty"]) < 3.0
