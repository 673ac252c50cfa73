"""Classes of balls: the ways to state them, their mean, and how they reach case.json and decks."""

import math
from itertools import pairwise

import pytest

from millscale.campaign.ball_classes import BOND_EXPONENT, equilibrium_charge
from millscale.campaign.build import load_campaign
from millscale.cases.case import cases_of
from millscale.cases.parameters import parameters
from millscale.errors import CampaignError
from millscale.packing.ball_sizes import mean_volume
from millscale.runs.atom_types import atom_types
from paper_campaign import campaign_text

CHARGE = {"filling": 0.2, "slice_length_m": 0.3, "rotation_angle_rad": 1.0, "step_s": "advised"}
CLASSES = """
[[ball.class]]
diameter_mm = 100
mass_share = 0.5
[[ball.class]]
diameter_mm = 60
mass_share_percent = 30
density_kg_m3 = 4000
[[ball.class]]
diameter_mm = 40
mass_share = 0.2
youngs_modulus_pa = 1.2e8
static_friction_pp = 0.2
"""


def campaign(folder, tail, **changes):
    changes = {"ball__radius_m": None, "single_ball": None, "multi_ball": CHARGE} | changes
    path = folder / "classes.toml"
    path.write_text(campaign_text(**changes) + tail)
    return load_campaign(path)


def shares_by_mass(ball):
    mass = [one.share * one.density * one.volume for one in ball.classes]
    return [m / sum(mass) for m in mass]


def test_shares_by_mass_become_shares_by_number_and_the_mean_is_by_mass(tmp_path):
    ball = campaign(tmp_path, CLASSES).ball
    assert shares_by_mass(ball) == pytest.approx([0.5, 0.3, 0.2])
    assert sum(one.share for one in ball.classes) == pytest.approx(1.0)
    assert ball.radius == pytest.approx(0.5 * 0.05 + 0.3 * 0.03 + 0.2 * 0.02)
    assert (ball.smallest, ball.largest) == (0.02, 0.05)
    # Mass of all over volume of all.
    volume = 0.5 / 2678.0 + 0.3 / 4000.0 + 0.2 / 2678.0
    assert ball.density == pytest.approx(1.0 / volume)


def test_a_table_states_the_same_as_the_campaign(tmp_path):
    rows = "diameter_mm, count_share\n100, 0.25\n60, 0.75\n"
    (tmp_path / "sizes.csv").write_text(rows)
    of_table = campaign(tmp_path, "", ball__sizes="sizes.csv").ball
    tail = "[[ball.class]]\nradius_m = 0.05\ncount_share = 0.25\n"
    tail += "[[ball.class]]\nradius_m = 0.03\ncount_share = 0.75\n"
    assert of_table == campaign(tmp_path, tail).ball


def test_the_equilibrium_charge_has_the_shares_of_its_formula():
    classes = equilibrium_charge(0.05, 7800.0, 3)
    assert [one.radius for one in classes] == pytest.approx([0.01875, 0.03125, 0.04375])
    volume = [one.share * one.volume for one in classes]
    below = [x**BOND_EXPONENT for x in (0.25, 0.5, 0.75, 1.0)]
    expected = [(b - a) / (1.0 - below[0]) for a, b in pairwise(below)]
    assert [v / sum(volume) for v in volume] == pytest.approx(expected)


WRONG = {
    "none": ("", {}, "ball.radius_m", "missing"),
    "two ways": (CLASSES, {"ball__radius_m": 0.02}, "ball.radius_m", "both given"),
    "sum": ("[[ball.class]]\nradius_m = 0.02\nmass_share = 0.9\n", {}, "ball.class", "add up"),
    "mixed": (
        "[[ball.class]]\nradius_m = 0.02\nmass_share = 0.5\n"
        "[[ball.class]]\nradius_m = 0.03\ncount_share = 0.5\n",
        {},
        "ball.class",
        "by mass and by number",
    ),
    "spread": (CLASSES, {"ball__radius_std_m": 0.001}, "ball.radius_std_m", "sizes of their own"),
    "poisson": (
        "[[ball.class]]\nradius_m = 0.02\nmass_share = 1\npoisson_ratio = 0.2\n",
        {},
        "ball.class[1].youngs_modulus_pa",
        "missing beside",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_classes_are_refused(tmp_path, name):
    tail, changes, key, cause = WRONG[name]
    with pytest.raises(CampaignError) as caught:
        campaign(tmp_path, tail, **changes)
    mistake = caught.value.mistakes[0]
    assert (mistake.key, cause in mistake.cause) == (key, True)


def test_a_wrong_table_is_refused_with_its_line(tmp_path):
    (tmp_path / "sizes.csv").write_text("diameter_mm,count_share\n100,half\n")
    with pytest.raises(CampaignError, match="line 2 is no row of numbers"):
        campaign(tmp_path, "", ball__sizes="sizes.csv")


def test_a_case_has_whole_balls_of_every_class_and_their_mass(tmp_path):
    loaded = campaign(tmp_path, CLASSES)
    for case in cases_of(loaded):
        ball = case.ball
        assert sum(one.count for one in ball.classes) == ball.count
        mass = sum(
            one.count * one.density_kg_m3 * 4.0 / 3.0 * math.pi * one.radius_m**3
            for one in ball.classes
        )
        assert ball.mass_kg * ball.count == pytest.approx(mass, rel=0.01)
        volume = case.charge.solid_fraction * case.mill.area_m2 * case.mill.simulated_length_m
        assert volume == pytest.approx(ball.count * mean_volume(loaded.ball))
        assert case.ball.radius_m == loaded.ball.radius


def test_the_step_is_that_of_the_smallest_ball_and_the_plan_names_it(tmp_path):
    case = cases_of(campaign(tmp_path, CLASSES))[0]
    assert case.time.step_choice.endswith("balls of 40 mm decide")
    small = "[[ball.class]]\nradius_m = 0.02\nmass_share = 1\nyoungs_modulus_pa = 1.2e8\n"
    alone = cases_of(campaign(tmp_path, small))[0]
    assert case.time.step_s == pytest.approx(alone.time.step_s, rel=0.05)
    assert case.time.rayleigh_time_s == pytest.approx(alone.time.rayleigh_time_s)


def test_decks_have_a_type_for_each_class_and_geometric_means(tmp_path):
    case = cases_of(
        campaign(tmp_path, CLASSES, mill__ends="turning", mill__end_static_friction=0.1)
    )[0]
    values = parameters(case)
    assert (values["types"], values["liner_type"]) == (5, 4)
    assert "type 4 ends 0.0 " in values["wall_words"] and "end_type 5" in values["wall_words"]
    friction = [float(x) for x in values["static_frictions"].strip('"').split()]
    rows = [friction[5 * k : 5 * k + 5] for k in range(5)]
    assert rows[0][0] == 0.545 and rows[2][2] == 0.2
    assert rows[0][2] == rows[2][0] == pytest.approx(math.sqrt(0.545 * 0.2))
    assert rows[2][3] == 0.5 and rows[2][4] == rows[4][2] == 0.1
    moduli = [float(x) for x in values["youngs_moduli"].strip('"').split()]
    assert moduli[2] == 1.2e8 and moduli[0] == moduli[3] == moduli[4] == 5.98e7
    assert atom_types(case).end_type == 5


def test_the_plan_warns_where_the_law_depends_on_the_mean(tmp_path):
    def warned(policy):
        loaded = campaign(tmp_path, CLASSES, scaling__policies=[policy], scaling__S=[1.0, 2.6])
        return [x for case in cases_of(loaded) for x in case.warnings if "mean by mass" in x]

    assert not warned("paper")
    assert len(warned("corrected")) == 2  # a scheme each, at S = 2.6 alone


def test_a_class_without_a_ball_is_refused(tmp_path):
    rare = "[[ball.class]]\nradius_m = 0.05\ncount_share = 0.00001\n"
    rare += "[[ball.class]]\nradius_m = 0.02\ncount_share = 0.99999\n"
    with pytest.raises(CampaignError, match=r"have none of radius 0\.05 m"):
        cases_of(campaign(tmp_path, rare))
