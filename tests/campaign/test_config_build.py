import math

import pytest

from millscale.campaign.build import load_campaign
from millscale.campaign.keys import REQUIRED, SECTIONS
from millscale.campaign.reader import read_value
from paper_campaign import MULTI_BALL, write_campaign


def test_shear_modulus_and_poisson_ratio_give_youngs_modulus(tmp_path):
    campaign = load_campaign(write_campaign(tmp_path))
    assert campaign.material.youngs_modulus == pytest.approx(5.98e7, rel=1e-14)


def test_name_follows_the_file_when_not_given(tmp_path):
    path = write_campaign(tmp_path).rename(tmp_path / "My Mill_2.toml")
    assert load_campaign(path).name == "my-mill-2"


@pytest.mark.parametrize("key", ["rotation_angle_rad", "revolutions", "rotation_s"])
def test_rotation_may_be_an_angle_turns_or_a_time(tmp_path, key):
    whole_turn = {"rotation_angle_rad": math.tau, "revolutions": 1.0, "rotation_s": math.tau / 1.5}
    changes = {"single_ball__rotation_angle_rad": None, f"single_ball__{key}": whole_turn[key]}
    campaign = load_campaign(write_campaign(tmp_path, mill__speed_rad_s=1.5, **changes))
    assert campaign.parts[0].rotation_angle == pytest.approx(math.tau, rel=1e-15)


def test_scaled_radii_are_another_way_to_give_s(tmp_path):
    path = write_campaign(tmp_path, scaling__S=None, scaling__scaled_radius_m=[3.9, 3.0, 1.5])
    assert load_campaign(path).parts[0].ratios == pytest.approx((1.0, 1.3, 2.6), rel=1e-15)


def test_s_is_used_when_radii_agree_with_it_to_their_rounding(tmp_path):
    path = write_campaign(tmp_path, scaling__S=[1.696], scaling__scaled_radius_m=[2.3])
    assert load_campaign(path).parts[0].ratios == (1.696,)


def test_a_campaign_part_may_have_its_own_scaled_mills(tmp_path):
    own = {"S": [1.5], "schemes": ["constant-speed"], "policies": ["corrected"]}
    multi_ball = {"multi_ball": {**MULTI_BALL["multi_ball"], **own, "count": 50}}
    single, multi = load_campaign(write_campaign(tmp_path, **multi_ball)).parts
    assert (single.ratios, multi.ratios) == ((1.0, 2.6), (1.5,))
    assert multi.schemes == ("constant-speed",)
    assert multi.policies == ("corrected",)
    assert multi.charge.counts == (50,)


def test_a_missing_step_is_the_advised_step(tmp_path):
    campaign = load_campaign(write_campaign(tmp_path, single_ball__step_s=None))
    assert campaign.parts[0].step is None


def test_parallel_reading_ignores_the_groove_width_and_warns(tmp_path):
    campaign = load_campaign(write_campaign(tmp_path, liner__reading="parallel"))
    assert campaign.liner.groove_width is None
    assert campaign.liner.face_angle == 0.0
    assert "groove_width_m is not used" in campaign.warnings[0]


def test_a_mill_without_liner_section_is_a_plain_drum(tmp_path):
    assert load_campaign(write_campaign(tmp_path, liner=None)).liner.lifters == 0


def test_centrifuging_is_accepted_on_request(tmp_path):
    path = write_campaign(tmp_path, mill__speed_rad_s=2.0, mill__allow_centrifuging=True)
    assert load_campaign(path).mill.omega == 2.0


def test_a_length_may_be_a_whole_number(tmp_path):
    length = load_campaign(write_campaign(tmp_path, mill__length_m=1)).mill.length
    assert isinstance(length, float)


@pytest.mark.parametrize(
    ("where", "key"), [(f"{s}.{name}", key) for s in SECTIONS for name, key in SECTIONS[s].items()]
)
def test_every_default_is_a_value_its_key_accepts(where, key):
    if key.default is None or key.default is REQUIRED:
        return
    value = list(key.default) if key.many else key.default
    assert read_value("defaults", where, key, value) == key.default
