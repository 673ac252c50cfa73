import math

import mill_core
import pytest
from paper_campaign import cases

from mill_campaign.time_step import impact_speed

MULTI = {
    "single_ball": None,
    "multi_ball": {"count": [231461, 13370], "rotation_angle_rad": 1.0, "settle_s": 1.0},
}


def times(folder, **changes):
    return {case.id: case["time"] for case in cases(folder, **changes)}


def test_impact_speed_is_that_of_the_parabola_back_to_the_circle():
    """Fly the parabola from the release at phi until the circle R - a is met again."""
    mill = mill_core.OperatingPoint(3.9, 0.02, 9.81, 1.0)
    path = 3.88
    phi = math.acos(path / 9.81)
    x, z = -path * math.sin(phi), path * math.cos(phi)
    vx, vz = path * math.cos(phi), path * math.sin(phi)
    low, high = 0.1, 4.0

    def outside(t):
        return math.hypot(x + vx * t, z + vz * t - 0.5 * 9.81 * t * t) > path

    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if outside(middle) else (middle, high)
    assert impact_speed(mill) == pytest.approx(math.hypot(vx, vz - 9.81 * low), rel=1e-9)


def test_a_centrifuging_ball_runs_with_the_mill():
    assert impact_speed(mill_core.OperatingPoint(1.0, 0.1, 9.81, 10.0)) == pytest.approx(9.0)


def test_fixed_stiffness_gives_every_model_the_same_step(tmp_path):
    found = times(tmp_path, **MULTI)
    assert len({time["step_s"] for time in found.values()}) == 1


def test_advice_for_the_papers_ball_is_what_was_measured_to_be_accurate(tmp_path):
    """5e-5 s for one ball; a fifth of the Rayleigh time in beds; with plain damping 1e-4 s in
    the S = 2.6 bed, less where the bed is deeper."""
    single = times(tmp_path, single_ball__step_s="advised")
    assert single["sb-cg-paper-S1.000"]["step_s"] == pytest.approx(5e-5, rel=0.1)
    charge = {"S": [2.6], "count": 13370, "rotation_angle_rad": 1.0}
    small = times(tmp_path, single_ball=None, multi_ball=charge)["mb-cg-paper-S2.600"]
    assert small["step_s"] == pytest.approx(1.4e-4, rel=0.03)
    assert "Rayleigh" in small["step_choice"]
    assert small["mean_overlap_m"] == pytest.approx(1.6e-4, rel=0.02)
    plain = {"model__tangential_damping": "plain"}
    of_s26 = times(tmp_path, single_ball=None, multi_ball=charge, **plain)
    small = of_s26["mb-cg-paper-S2.600"]
    assert small["step_s"] == pytest.approx(1e-4, rel=0.05)
    both = times(tmp_path, **MULTI, **plain)["mb-cg-paper-S1.000"]
    assert 8e-5 < both["step_s"] < small["step_s"]
    assert "damping limit" in both["step_choice"]


def test_advised_steps_stay_within_every_limit(tmp_path):
    advised = {"single_ball__step_s": "advised", "multi_ball": MULTI["multi_ball"]}
    for matched in ("fixed", "overlap-matched"):
        for case in cases(tmp_path, scaling__stiffness=matched, **advised):
            time = case["time"]
            assert time["rayleigh_fraction"] <= 0.2
            assert time["limit_fraction"] <= 1.0
            assert time["steps_per_contact"] >= 8.0
            assert case["warnings"] == []


def test_matched_stiffness_keeps_every_ratio_of_step_and_contact_time(tmp_path):
    found = times(tmp_path, scaling__stiffness="overlap-matched", **MULTI).values()
    for key in ("rayleigh_fraction", "limit_fraction", "steps_per_contact"):
        values = [time[key] for time in found]
        # Froude numbers of R and of R - a differ a little, so does the impact speed.
        assert values == pytest.approx([values[0]] * len(values), rel=0.01)


def test_a_step_above_the_damping_limit_is_warned_of(tmp_path):
    changes = {**MULTI["multi_ball"], "step_s": 2.4e-4}
    found = cases(tmp_path, single_ball=None, multi_ball=changes)
    assert all("times the damping limit" in case["warnings"][0] for case in found)
