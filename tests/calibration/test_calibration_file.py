"""Calibration files: what they come to, and the errors of those that are not accepted."""

import math

import pytest

import small_campaign
from millscale.calibration.file import (
    CALIBRATION_KEYS,
    EXPERIMENT_KEYS,
    PARAMETER_KEYS,
    TARGET_KEYS,
    is_calibration,
    load_calibration,
)
from millscale.calibration.targets import read_table
from millscale.errors import CampaignError
from paper_campaign import CAMPAIGNS, REPOSITORY

CALIBRATIONS = sorted(CAMPAIGNS.rglob("calibrate-*.toml"))
TEXT = """
[calibration]
about = "for tests"
base = "small.toml"

[[parameter]]
keys = ["material.static_friction_pp", "material.static_friction_pw"]
name = "friction"
least = 0.1
most = 0.9

[[parameter]]
keys = ["material.rolling_friction_pp"]
least = 1e-3
most = 0.1
scale = "logarithmic"

[[target]]
torque = 0.3
uncertainty = 0.01

[[target]]
toe_deg = 220.0
uncertainty = 2.0
"""


def write(folder, text=TEXT, base=small_campaign.TEXT):
    (folder / "small.toml").write_text(base)
    file = folder / "calibrate-small.toml"
    file.write_text(text)
    return file


def test_samples_are_the_base_with_the_values_of_the_parameters(tmp_path):
    calibration = load_calibration(write(tmp_path))
    (setting,) = calibration.settings("sample-001", "", (0.3, 0.02)).values()
    material = setting.tree["material"]
    assert material["static_friction_pp"] == material["static_friction_pw"] == 0.3
    assert material["rolling_friction_pp"] == 0.02
    assert material["rolling_friction_pw"] == 0.01
    assert [case.kind for case in setting.cases] == ["multi-ball"]
    assert (calibration.samples, calibration.later, calibration.rounds) == (16, 6, 4)
    assert [one.name for one in calibration.parameters] == ["friction", "rolling_friction_pp"]


def test_targets_are_in_si_and_shown_in_their_unit(tmp_path):
    torque, toe = load_calibration(write(tmp_path)).targets
    assert (torque.measured[0], torque.uncertainty, torque.name) == (0.3, 0.01, "torque number")
    assert toe.measured[0] == pytest.approx(math.radians(220.0))
    assert toe.uncertainty == pytest.approx(math.radians(2.0))
    assert toe.text(toe.measured[0]) == "220" and toe.unit == "deg"
    spelt = TEXT.replace("toe_deg = 220.0", f"toe_rad = {math.radians(220.0)}")
    other = load_calibration(write(tmp_path, spelt.replace("2.0\n", "0.04\n"))).targets[1]
    assert other.uncertainty == 0.04


def test_experiments_are_mills_of_their_own(tmp_path):
    text = TEXT.replace("[[target]]", '[[target]]\nexperiment = "slow"', 1)
    text = text.replace("[[target]]\ntoe", '[[target]]\nexperiment = "fast"\ntoe')
    text += '[[experiment]]\nname = "slow"\nmill.speed_rad_s = 1.0\n'
    text += '[[experiment]]\nname = "fast"\nmill.speed_rad_s = 2.0\n'
    calibration = load_calibration(write(tmp_path, text))
    made = calibration.settings("sample-001", "", (0.3, 0.02))
    assert {name: one.name for name, one in made.items()} == {
        "slow": "sample-001-slow",
        "fast": "sample-001-fast",
    }
    speeds = [one.cases[0].physical.omega_rad_s for one in made.values()]
    assert speeds == [1.0, 2.0]
    assert [one.name for one in calibration.targets] == ["torque number (slow)", "toe (fast)"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("torque = 0.3\n", "", r"target\[1\]: got none; accepted: one of power_w"),
        ("torque = 0.3\n", "torque = 0.3\nkinetic = 0.1\n", "got torque, kinetic"),
        ("uncertainty = 0.01", "uncertainty = 0", r"target\[1\]\.uncertainty"),
        ("torque = 0.3", "tork = 0.3", r"tork: unknown key, nearest is torque"),
        ("least = 0.1\n", "least = 0.95\n", "least = 0.95, most = 0.9"),
        ("least = 1e-3", "least = 0.0", "least > 0 on a logarithmic scale"),
        ("most = 0.9", "most = 90.0", "static_friction_pp"),
        ("material.rolling_friction_pp", "material.rolling", "nearest is"),
        ("material.rolling_friction_pp", "material.static_friction_pp", "is in two parameters"),
        ("material.rolling_friction_pp", "stuff.rolling", "unknown"),
        ('base = "small.toml"', 'base = "small.toml"\nsamples = 3', "3 samples for 2 parameters"),
        ('base = "small.toml"', 'base = "small.toml"\nsample = 30', "nearest is samples"),
        ("[[target]]", '[[target]]\nexperiment = "slow"', "no experiment: there is one"),
        ("toe_deg = 220.0", "torque = 0.2", "torque number is given twice"),
        ("toe_deg = 220.0", 'surface = "none.csv"', "none.csv"),
        ("[calibration]", "[calibrations]", "unknown section"),
    ],
)
def test_what_is_not_accepted_is_named(tmp_path, old, new, message):
    assert old in TEXT
    with pytest.raises(CampaignError, match=message):
        load_calibration(write(tmp_path, TEXT.replace(old, new, 1)))


def test_a_base_of_several_mills_is_refused(tmp_path):
    base = small_campaign.TEXT.replace("S = [2.0]\ncount = [50]", "S = [1.0, 2.0]\ncount = [50, 9]")
    with pytest.raises(CampaignError, match=r"2 mills: .*state one S"):
        load_calibration(write(tmp_path, base=base))


def test_a_table_is_read_by_the_names_of_its_columns(tmp_path):
    file = tmp_path / "profile.csv"
    file.write_text("# measured\nvelocity_m_s, distance_m\n0.3,-0.03\n0.2,-0.04\n0.1,-0.05\n")
    assert read_table(file, ("distance_m", "velocity_m_s")).tolist() == [
        [-0.03, 0.3],
        [-0.04, 0.2],
        [-0.05, 0.1],
    ]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("x_m,z_m\n1,2\n", "1 points"),
        ("x_m,y_m\n1,2\n1,2\n1,2\n", "no column z_m"),
        ("x_m,z_m\n1,2\n1,a\n1,2\n", "could not convert"),
        ("x_m,z_m\n1,2\n1\n1,2\n", "NoneType"),
        ("x_m,z_m\n1,2\n1,nan\n1,2\n", "not finite"),
    ],
)
def test_a_table_that_is_none_is_refused(tmp_path, text, message):
    file = tmp_path / "profile.csv"
    file.write_text(text)
    with pytest.raises(CampaignError, match=message):
        read_table(file, ("x_m", "z_m"))


@pytest.mark.parametrize("file", CALIBRATIONS, ids=lambda path: path.stem)
def test_the_files_that_come_with_it_are_accepted(file):
    assert is_calibration(file) and load_calibration(file).targets
    assert file.name in (REPOSITORY / "docs/guide/calibrate.md").read_text(encoding="utf-8")


def test_a_campaign_is_no_calibration(tmp_path):
    write(tmp_path)
    assert not is_calibration(tmp_path / "small.toml")


GUIDE = REPOSITORY / "docs/guide/calibrate.md"


def test_the_examples_of_the_guide_are_accepted_and_every_key_is_in_it(tmp_path):
    text = GUIDE.read_text(encoding="utf-8")
    one, several = (part.partition("```")[0] for part in text.split("```toml\n")[1:3])
    (tmp_path / "laboratory-300-mm.toml").write_text(
        (CAMPAIGNS / "calibration/laboratory-300-mm.toml").read_text(encoding="utf-8")
    )
    file = tmp_path / "example.toml"
    file.write_text(one)
    assert [target.name for target in load_calibration(file).targets] == ["power", "shoulder"]
    file.write_text(one.partition("[[target]]")[0] + several)
    assert [x.name for x in load_calibration(file).experiments] == ["slow", "fast"]
    for key in (*CALIBRATION_KEYS, *PARAMETER_KEYS, *EXPERIMENT_KEYS, *TARGET_KEYS):
        assert f"`{key}`" in text, key
