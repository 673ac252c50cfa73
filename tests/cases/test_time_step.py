import math

import pytest

from millscale import _core
from millscale.cases.time_step import impact_speed
from paper_campaign import cases

MULTI = {
    "single_ball": None,
    "multi_ball": {"count": [231461, 13370], "rotation_angle_rad": 12.0, "settle_s": 1.0},
}


def times(folder, **changes):
    return {case.id: case.time for case in cases(folder, **changes)}


def test_impact_speed_is_that_of_the_parabola_back_to_the_circle():
    """Fly the parabola from the release at phi until the ball reaches the circle R - a again."""
    mill = _core.OperatingPoint(3.9, 0.02, 9.81, 1.0)
    radius = 3.88
    phi = math.acos(radius / 9.81)
    x, z = -radius * math.sin(phi), radius * math.cos(phi)
    vx, vz = radius * math.cos(phi), radius * math.sin(phi)
    low, high = 0.1, 4.0

    def outside(t):
        return math.hypot(x + vx * t, z + vz * t - 0.5 * 9.81 * t * t) > radius

    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if outside(middle) else (middle, high)
    assert impact_speed(mill) == pytest.approx(math.hypot(vx, vz - 9.81 * low), rel=1e-9)


def test_a_centrifuging_ball_runs_with_the_mill():
    assert impact_speed(_core.OperatingPoint(1.0, 0.1, 9.81, 10.0)) == pytest.approx(9.0)


def test_fixed_stiffness_gives_every_scaled_mill_the_same_step(tmp_path):
    found = times(tmp_path, **MULTI)
    assert len({time.step_s for time in found.values()}) == 1


def test_the_advised_steps_are_those_measured_to_be_accurate(tmp_path):
    """5e-5 s for one ball; a fifth of the Rayleigh time in beds; with plain damping 1e-4 s in
    the S = 2.6 bed, less where the bed is deeper."""
    single = times(tmp_path, single_ball__step_s="advised")
    assert single["sb-cg-paper-S1.000"].step_s == pytest.approx(5e-5, rel=0.1)
    charge = {"S": [2.6], "count": 13370, "rotation_angle_rad": 1.0}
    small = times(tmp_path, single_ball=None, multi_ball=charge)["mb-cg-paper-S2.600"]
    assert small.step_s == pytest.approx(1.4e-4, rel=0.03)
    assert "Rayleigh" in small.step_choice
    assert small.mean_overlap_m == pytest.approx(1.6e-4, rel=0.02)
    plain = {"model__tangential_damping": "plain"}
    of_s26 = times(tmp_path, single_ball=None, multi_ball=charge, **plain)
    small = of_s26["mb-cg-paper-S2.600"]
    assert small.step_s == pytest.approx(1e-4, rel=0.05)
    both = times(tmp_path, **MULTI, **plain)["mb-cg-paper-S1.000"]
    assert 8e-5 < both.step_s < small.step_s
    assert "damping limit" in both.step_choice


def test_advised_steps_stay_within_every_limit(tmp_path):
    advised = {"single_ball__step_s": "advised", "multi_ball": MULTI["multi_ball"]}
    for matched in ("fixed", "overlap-matched"):
        for case in cases(tmp_path, scaling__stiffness=matched, **advised):
            time = case.time
            assert time.rayleigh_fraction <= 0.2
            assert time.limit_fraction <= 1.0
            assert time.steps_per_contact >= 8.0
            assert case.warnings == ()


def test_matched_stiffness_keeps_every_ratio_of_step_and_contact_time(tmp_path):
    found = times(tmp_path, scaling__stiffness="overlap-matched", **MULTI).values()
    for key in ("rayleigh_fraction", "limit_fraction", "steps_per_contact"):
        values = [getattr(time, key) for time in found]
        # Froude numbers of R and of R - a differ a little, so does the impact speed.
        assert values == pytest.approx([values[0]] * len(values), rel=0.01)


def test_a_step_above_the_damping_limit_is_warned_of(tmp_path):
    changes = {**MULTI["multi_ball"], "step_s": 2.4e-4}
    found = cases(tmp_path, single_ball=None, multi_ball=changes)
    assert all("times the damping limit" in case.warnings[0] for case in found)


def test_the_overlap_at_rest_follows_from_pressure_and_contacts(tmp_path):
    """The mean contact force follows from the stress, the overlap from Hertz; the measured factor
    in use is smaller by a seventh."""
    solid, contacts, depth, nu, a = 0.6, 5.5, 0.3, 0.3, 0.02
    for case in cases(tmp_path, **MULTI):
        mill, modulus = case.mill, case.material.youngs_modulus_pa
        pressure = depth * solid * 2678.0 * mill.gravity_m_s2 * mill.radius_m
        per_volume = contacts * solid / (2.0 * 4.0 / 3.0 * math.pi * a**3)
        force = 3.0 * pressure / (per_volume * 2.0 * a)
        effective = modulus / (2.0 * (1.0 - nu**2))
        # Two balls of radius a: effective radius a / 2, F = 4/3 E* sqrt(a / 2) delta^1.5.
        overlap = (force / (4.0 / 3.0 * effective * math.sqrt(0.5 * a))) ** (2.0 / 3.0)
        assert case.time.mean_overlap_m == pytest.approx(overlap, rel=0.15)


def test_soft_balls_are_warned_of_before_they_are_refused(tmp_path):
    schemes = {"scaling__S": [1.0], "scaling__schemes": ["constant-gravity"]}
    charge = {**MULTI, **schemes, "multi_ball__count": [231461]}
    # 1.06 (rho g R / E)^(2/3) is 0.05 at 1.0e7 Pa.
    (stiff,), (soft,) = (
        cases(tmp_path, **charge, material__shear_modulus_pa=None, material__youngs_modulus_pa=E)
        for E in (1.02e7, 0.98e7)
    )
    assert not any("on average" in text for text in stiff.warnings)
    assert any(text.startswith("at rest balls overlap by 0.0507") for text in soft.warnings)


def test_impacts_deeper_than_a_quarter_radius_are_warned_of(tmp_path):
    (case,) = cases(tmp_path, scaling__S=[1.0], scaling__schemes=["constant-gravity"],
                    material__shear_modulus_pa=1e7, single_ball__step_s="advised")  # fmt: skip
    warned = [text for text in case.warnings if text.startswith("impacts at")]
    # delta = (15 m* v^2 / (16 sqrt(R*) E*))^(2/5) of two balls.
    mass, effective = 4.0 / 3.0 * math.pi * 0.02**3 * 2678.0, 2.6e7 / (2.0 * 0.91)
    speed = case.time.impact_speed_m_s
    depth = (15.0 * 0.5 * mass * speed**2 / (16.0 * 0.1 * effective)) ** 0.4
    assert f"overlap by {depth / 0.02:.2g} of the ball radius" in warned[0]


def test_the_modulus_that_a_warning_of_impacts_states_is_the_least_of_two_digits(tmp_path):
    def warnings(E):
        (case,) = cases(tmp_path, scaling__S=[1.0], scaling__schemes=["constant-gravity"],
                        material__shear_modulus_pa=None, material__youngs_modulus_pa=E,
                        single_ball__step_s="advised")  # fmt: skip
        return [text for text in case.warnings if text.startswith("impacts at")]

    stated = float(warnings(1e7)[0].split("youngs_modulus_pa of ")[1].split()[0])
    digit = 10.0 ** (math.floor(math.log10(stated)) - 1)
    assert not warnings(stated)
    assert warnings(stated - digit)


def test_thin_slices_are_warned_of(tmp_path):
    charge = {**MULTI["multi_ball"], "S": [2.6], "count": [13370]}
    for diameters, warned in ((3.9, True), (4.0, False)):
        (case,) = cases(tmp_path, single_ball=None, scaling__schemes=["constant-gravity"],
                        multi_ball={**charge, "slice_diameters": diameters})  # fmt: skip
        assert any("a slice of" in x for x in case.warnings) == warned


def test_default_waits_follow_from_the_sizes_and_gravity(tmp_path):
    """0.8 s and 0.1 s in the paper's mill; the sqrt of length over gravity elsewhere."""
    charge = {"S": [1.0], "count": 100, "rotation_angle_rad": 1.0}
    for scale, settle, rest in ((1.0, 0.8, 0.1), (1e-4, 80.0, 10.0)):
        found = cases(tmp_path, mill__gravity_m_s2=9.81 * scale, mill__speed_rad_s=scale**0.5,
                      scaling__schemes=["constant-gravity"], scaling__S=[1.0],
                      single_ball__step_s="advised", multi_ball=charge)  # fmt: skip
        waits = [case.time.start_s for case in found]
        assert waits == pytest.approx([rest, settle], rel=1e-3)
