"""Slips typed into a campaign: each is warned of with the number that shows it."""

import math
import re

import pytest

from millscale.campaign.build import load_campaign
from millscale.cases.case import cases_of
from millscale.runs.soft_balls import impact_overlap, modulus_for
from millscale.workflow.plan import plan_rows
from paper_campaign import write_campaign

CHARGE = {"filling": 0.3, "slice_diameters": 4.0, "rotation_angle_rad": 12.0}
# The paper's mill with balls so stiff that impacts stay below a twentieth of the radius.
STIFF = {
    "material__shear_modulus_pa": None,
    "material__youngs_modulus_pa": 3e9,
    "single_ball": None,
    "multi_ball": CHARGE,
}


def warnings(folder, **changes):
    """Return the warnings of a plan, each once."""
    rows = plan_rows(load_campaign(write_campaign(folder, **{**STIFF, **changes})))
    return list(dict.fromkeys(text for row in rows for text in row["warnings"]))


def test_an_ordinary_mill_is_planned_without_warnings(tmp_path):
    assert warnings(tmp_path) == []


@pytest.mark.parametrize(
    ("speed", "said"),
    [
        ({"speed_rpm": 1.0}, "6.59 % of the critical speed; rad/s typed as rpm? speed_rad_s = 1 "
         "would be 62.9 %"),
        # 1.5708 rpm of this mill would be 10.3 %.
        ({"speed_rad_s": 0.03}, "mill.speed_rad_s = 0.03 is 1.9 % of the critical speed"),
        ({"percent_of_critical": 0.7}, "a share typed as percent? 70 would be that"),
        ({"percent_of_critical": 1.2}, "a share typed as percent? 120 would be that"),
        ({"period_s": 100.0}, "mill.period_s = 100 is 4 % of the critical speed"),
        ({"froude": 0.4}, None),
        ({"percent_of_critical": 10.0}, None),
    ],
)  # fmt: skip
def test_a_mill_below_a_tenth_of_critical(tmp_path, speed, said):
    given = {"mill__speed_rad_s": None, **{f"mill__{k}": v for k, v in speed.items()}}
    found = [text for text in warnings(tmp_path, **given) if "critical speed" in text]
    assert len(found) == (said is not None)
    assert said is None or said.replace("6.59", "6.6") in found[0]


def test_a_density_in_g_cm3_typed_as_kg_m3(tmp_path):
    (text,) = warnings(tmp_path, ball__density_kg_m3=7.8)
    assert text == (
        "balls of 7.8 kg/m^3 are lighter than those of any mill; g/cm^3 typed as kg/m^3? "
        "density_g_cm3 = 7.8 would be 7800 kg/m^3"
    )
    assert warnings(tmp_path, ball__density_kg_m3=500.0) == []
    assert warnings(tmp_path, ball__density_kg_m3=0.1)[0].endswith("of any mill")


def test_the_modulus_of_real_steel(tmp_path):
    steel = {"material__youngs_modulus_pa": 2.1e11, "ball__density_kg_m3": 7800.0}
    (text,) = warnings(tmp_path, **steel)
    rows = plan_rows(load_campaign(tmp_path / "campaign.toml"))
    assert text.startswith("youngs_modulus_pa = 2.1e+11 takes steps of")
    step = min(row["time_step_s"] for row in rows)
    assert f"steps of {step:.2g} s" in text
    # The modulus named makes the largest overlap that, and a little less more than that.
    softer = re.findall(r"(\S+) keeps it below (\S+) \(steps of", text)
    assert [overlap for _, overlap in softer] == ["0.05"]
    for modulus, overlap in softer:
        deepest = deepest_overlap(tmp_path, float(modulus))
        assert 0.97 * float(overlap) < deepest <= float(overlap)
    assert warnings(tmp_path, **steel | {"material__youngs_modulus_pa": 1e10}) == []
    # A fast mill needs more than that.
    fast = {"mill__radius_m": 6.0, "liner__lifter_top_radius_m": 5.71, "mill__length_m": 2.0}
    fast |= {"mill__speed_rad_s": None, "mill__percent_of_critical": 80, "scaling__S": [1.0]}
    assert warnings(tmp_path, **steel | fast | {"material__youngs_modulus_pa": 2e10}) == []


def deepest_overlap(folder, modulus):
    """Return the largest overlap of impacts of the steel mill with another modulus."""
    changes = STIFF | {"ball__density_kg_m3": 7800.0, "material__youngs_modulus_pa": modulus}
    return max(map(impact_overlap, cases_of(load_campaign(write_campaign(folder, **changes)))))


def test_the_overlap_of_an_impact_is_that_of_hertz(tmp_path):
    (case, *_) = cases_of(load_campaign(write_campaign(tmp_path, **STIFF)))
    # Energy: 1/2 m* v^2 = 2/5 k delta^(5/2), k = 4/3 E* sqrt(R*), two equal balls.
    radius, modulus = case.ball.radius_m, case.material.youngs_modulus_pa
    mass = case.ball.mass_kg / 2.0
    stiffness = 4.0 / 3.0 * modulus / (2.0 * (1.0 - 0.3**2)) * math.sqrt(radius / 2.0)
    overlap = (5.0 / 4.0 * mass * case.time.impact_speed_m_s**2 / stiffness) ** 0.4
    assert impact_overlap(case) == pytest.approx(overlap / radius, rel=2e-3)
    least = modulus_for(case, 0.01)
    assert least >= modulus * (impact_overlap(case) / 0.01) ** 2.5 > 0.9 * least


@pytest.mark.parametrize("stiffness", ["fixed", "overlap-matched"])
def test_soft_balls_are_warned_of_with_the_modulus_that_is_enough(tmp_path, stiffness):
    soft = {"material__youngs_modulus_pa": 6e7, "scaling__stiffness": stiffness}
    text = next(text for text in warnings(tmp_path, **soft) if "impacts at" in text)
    assert "of the ball radius at S = 1;" in text
    enough = float(text.partition("a youngs_modulus_pa of ")[2].split()[0])
    assert "times shorter" in text
    stiff = soft | {"material__youngs_modulus_pa": enough}
    assert not any("impacts" in text for text in warnings(tmp_path, **stiff))
    stiff = soft | {"material__youngs_modulus_pa": 0.9 * enough}
    assert any("impacts" in text for text in warnings(tmp_path, **stiff))


def test_lifters_lower_than_a_ball_at_some_scale(tmp_path):
    (text,) = warnings(tmp_path, liner__lifter_top_radius_m=None, liner__lifter_height_mm=60)
    assert text == (
        "lifters are 0.58 ball diameters high at S = 2.6, and balls roll over them; S <= 1.5 "
        "keeps them a diameter high"
    )
    rows = plan_rows(load_campaign(tmp_path / "campaign.toml"))
    assert {row["S"] for row in rows if row["warnings"]} == {2.6}
    (text,) = warnings(tmp_path, liner__lifter_top_radius_m=None, liner__lifter_height_mm=30)
    assert text.endswith("balls roll over them")


def test_a_settling_in_which_balls_cannot_fall_a_diameter(tmp_path):
    # The fall of a diameter takes sqrt(2 d / g) = 0.0903 s, the refused one of a radius 0.0639 s.
    short = {**CHARGE, "settle_s": 0.08}
    (text,) = warnings(tmp_path, multi_ball=short, scaling__S=[1.0])
    assert text == (
        "in the settling of 0.08 s a ball falls by 0.031 m at S = 1, less than its diameter of "
        "0.04 m; a settle_s of 0.091 is enough for that"
    )
    assert warnings(tmp_path, multi_ball={**CHARGE, "settle_s": 0.091}, scaling__S=[1.0]) == []
    # The default follows gravity: on a small body as on Earth.
    low = {"mill__gravity_m_s2": 1e-3, "mill__speed_rad_s": None, "mill__percent_of_critical": 70}
    assert warnings(tmp_path, **low) == []
