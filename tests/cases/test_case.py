import json
import math

import numpy as np
import pytest

from millscale import _core
from millscale.cases.parameters import parameters
from millscale.errors import CampaignError
from millscale.runs.case_digest import case_digest
from millscale.runs.case_file import Case, load_case
from millscale.runs.untrusted import RunFolderError
from paper_campaign import MULTI_BALL, cases

EVERY_SCHEME = {"scaling__schemes": ["constant-gravity", "constant-speed"]}
EVERY_POLICY = {"scaling__policies": ["offset-liner", "corrected", "paper"]}
SECTIONS = {
    "schema", "id", "campaign", "kind", "scheme", "policy", "S", "time_factor", "seed", "physical",
    "mill", "factors", "predicted_energy_ratio", "centre_path_energy_ratio", "ball", "material",
    "time", "wall", "output", "model", "predicted", "versions",
}  # fmt: skip


def by_id(found: list[Case]) -> dict[str, Case]:
    return {case.id: case for case in found}


def test_ids_hold_kind_scheme_policy_and_s_in_a_fixed_order(tmp_path):
    found = cases(tmp_path, **EVERY_SCHEME, **EVERY_POLICY, scaling__S=[2.6, 1.0, 1.0833333])
    assert [case.id for case in found] == [
        "sb-cg-paper-S1.000", "sb-cg-paper-S1.083", "sb-cg-paper-S2.600",
        "sb-cs-paper-S1.000", "sb-cs-paper-S1.083", "sb-cs-paper-S2.600",
        "sb-cg-corrected-S1.083", "sb-cg-corrected-S2.600",
        "sb-cs-corrected-S1.083", "sb-cs-corrected-S2.600",
        "sb-cg-offset-liner-S1.083", "sb-cg-offset-liner-S2.600",
        "sb-cs-offset-liner-S1.083", "sb-cs-offset-liner-S2.600",
    ]  # fmt: skip


def test_the_physical_mill_has_the_first_policy_of_the_campaign(tmp_path):
    found = cases(tmp_path, scaling__S=[1.0, 2.0], scaling__policies=["corrected"])
    assert "sb-cg-corrected-S1.000" in by_id(found)


def test_ids_hold_the_seed_only_if_there_are_several(tmp_path):
    charge = MULTI_BALL["multi_ball"]
    one = cases(tmp_path, single_ball=None, multi_ball=charge, scaling__schemes=["constant-speed"])
    assert [case.id for case in one] == ["mb-cs-paper-S1.000", "mb-cs-paper-S2.600"]
    several = cases(tmp_path, single_ball=None, multi_ball={**charge, "seeds": [3, 4]})
    assert "mb-cg-paper-S1.000-seed4" in by_id(several)
    assert {case.seed for case in several} == {3, 4}


def test_expensive_scaled_mills_may_use_the_first_seed_only(tmp_path):
    charge = {**MULTI_BALL["multi_ball"], "seeds": [3, 4], "seeds_from_S": 2.6}
    found = cases(tmp_path, single_ball=None, multi_ball=charge)
    assert [case.id for case in found if case.scheme == "constant-gravity"] == [
        "mb-cg-paper-S1.000-seed3",
        "mb-cg-paper-S2.600-seed3",
        "mb-cg-paper-S2.600-seed4",
    ]


def test_a_case_holds_every_section_of_its_schema(tmp_path):
    for case in cases(tmp_path, **MULTI_BALL):
        assert set(case.document) >= SECTIONS
        assert ("charge" in case.document) == (case.kind == "multi-ball")


def test_the_law_in_a_case_is_that_of_the_core(tmp_path):
    physical = _core.OperatingPoint(3.9, 0.02, 9.81, 1.0)
    for case in cases(tmp_path, **EVERY_SCHEME, **EVERY_POLICY):
        scaled = _core.scale(physical, case.S, case.scheme, case.policy)
        assert case.mill.omega_rad_s == scaled.mill.omega
        assert case.mill.gravity_m_s2 == scaled.mill.gravity
        assert case.mill.radius_m == pytest.approx(scaled.mill.radius, rel=1e-14)
        assert case.predicted_energy_ratio == scaled.predicted_energy_ratio


def test_every_case_turns_the_same_angle_and_waits_the_same_scaled_time(tmp_path):
    for case in cases(tmp_path, **EVERY_SCHEME, **EVERY_POLICY, **MULTI_BALL):
        time, mill = case.time, case.mill
        step_angle = mill.omega_rad_s * time.step_s
        turned = time.rotation_steps * step_angle
        # The rotation of a charge is a whole number of dump intervals, each of whole steps.
        roundings = 1 if case.kind == "single-ball" else time.rotation_angle_rad / 0.5
        allowed = 0.51 * step_angle * roundings
        assert turned == pytest.approx(time.rotation_angle_rad, abs=allowed)
        wait = 0.1 if case.kind == "single-ball" else 0.8
        scaled_wait = wait * case.factors.time
        assert time.start_s == pytest.approx(scaled_wait, abs=0.51 * time.step_s)


def test_samples_fall_on_equal_mill_angles(tmp_path):
    for case in cases(tmp_path, **EVERY_SCHEME):
        step_angle = case.mill.omega_rad_s * case.time.step_s
        sampled = case.output.sample_steps * step_angle
        assert sampled == pytest.approx(case.time.sample_angle_rad, abs=0.51 * step_angle)


def test_a_sample_is_never_more_often_than_a_step(tmp_path):
    case = cases(tmp_path, single_ball__sample_angle_rad=1e-9)[0]
    assert case.output.sample_steps == 1


def test_the_single_ball_starts_just_clear_of_the_liner(tmp_path):
    for phase in (0.0, 3.6, 7.2):
        for case in cases(tmp_path, liner__phase_deg=phase):
            x, y, z = case.ball.start_m
            mill = case.mill
            liner = _core.Lifters(
                mill.radius_m, mill.lifter_top_radius_m, mill.lifter_top_width_m,
                mill.groove_width_m, mill.lifters, mill.phase_rad,
            )  # fmt: skip
            gap = float(liner.nearest(x, z).distance) - 0.02
            assert (x, y) == (0.0, mill.simulated_length_m / 2.0)
            # A panel is inside its arc by at most the chord error.
            assert 0.0 < gap <= 1.1e-3 * 0.02 + case.wall.chord_error_m


def test_with_a_lifter_at_the_bottom_the_ball_starts_on_it(tmp_path):
    case = cases(tmp_path, liner__phase_deg=7.2)[0]
    assert case.ball.start_m[2] == pytest.approx(-(3.61 - 0.02), abs=1e-4)


def test_overlap_matched_stiffness_follows_velocity_squared(tmp_path):
    changes = {"scaling__stiffness": "overlap-matched", **EVERY_SCHEME}
    found = by_id(cases(tmp_path, **changes))
    modulus = {key: case.material.youngs_modulus_pa for key, case in found.items()}
    assert modulus["sb-cg-paper-S1.000"] == pytest.approx(5.98e7, rel=1e-14)
    assert modulus["sb-cg-paper-S2.600"] == pytest.approx(5.98e7 / 2.6, rel=1e-14)
    assert modulus["sb-cs-paper-S2.600"] == pytest.approx(5.98e7 / 2.6**2, rel=1e-14)


def test_twin_cases_have_equal_groups(tmp_path):
    """Constant gravity with E and constant speed with E / S, steps in the ratio sqrt(S)."""
    found = by_id(cases(tmp_path, scaling__stiffness="overlap-matched", **EVERY_SCHEME))
    a, b = found["sb-cg-paper-S2.600"], found["sb-cs-paper-S2.600"]

    def stiffness_group(case):
        mill = case.mill
        speed = mill.omega_rad_s * mill.radius_m
        return case.material.youngs_modulus_pa / (2678.0 * speed**2)

    assert stiffness_group(a) == pytest.approx(stiffness_group(b), rel=1e-13)
    assert b.time.step_s / a.time.step_s == pytest.approx(math.sqrt(2.6), rel=1e-13)


def test_a_slice_takes_its_share_of_the_balls(tmp_path):
    charge = {**MULTI_BALL["multi_ball"], "count": [20000, 1000], "slice_length_m": 0.2}
    found = by_id(cases(tmp_path, multi_ball=charge))
    assert found["mb-cg-paper-S1.000"].ball.count == 4000
    assert found["mb-cg-paper-S2.600"].ball.count == 520
    assert found["mb-cg-paper-S2.600"].mill.simulated_length_m == 0.2


def test_a_slice_in_ball_diameters_is_the_same_slice(tmp_path):
    charge = MULTI_BALL["multi_ball"]
    metres, diameters = (
        by_id(cases(tmp_path, multi_ball={**charge, "count": [20000, 1000], **given}))
        for given in ({"slice_length_m": 0.2}, {"slice_diameters": 5.0})
    )
    for name, case in diameters.items():
        assert case.digest == metres[name].digest


def skin_of(tmp_path, contacts="fast", **multi_ball):
    """Return the neighbour skin over the ball radius, and the way of the fastest ball in a step
    over it."""
    charge = {**MULTI_BALL["multi_ball"], "S": [1.0], "count": [1000], **multi_ball}
    (case,) = cases(
        tmp_path, single_ball=None, multi_ball=charge, model={"contacts": contacts},
        scaling__schemes=["constant-gravity"],
    )  # fmt: skip
    radius, time = case.ball.radius_m, case.time
    return case.domain.skin_m / radius, time.impact_speed_m_s * time.step_s / radius


def test_a_list_lasts_twelve_steps_of_the_fastest_ball(tmp_path):
    skin, way = skin_of(tmp_path, step_s=1.6e-4)
    assert 0.5 * skin / way == pytest.approx(12.0, rel=0.005)
    assert skin > 1.5


def test_slow_steps_and_stock_contacts_keep_the_least_skin(tmp_path):
    assert skin_of(tmp_path, step_s=5e-5)[0] == pytest.approx(1.0)
    assert skin_of(tmp_path, "stock", step_s=1.6e-4)[0] == pytest.approx(0.75)


def test_no_ball_of_a_thin_slice_reaches_beyond_half_its_length(tmp_path):
    skin, way = skin_of(tmp_path, step_s=2e-4, slice_diameters=4.0)
    assert skin == pytest.approx(2.0) and 24.0 * way > 2.5
    assert skin_of(tmp_path, step_s=2e-4, slice_diameters=2.0)[0] == pytest.approx(1.0)


def test_filling_and_porosity_give_the_count_from_the_liner_area(tmp_path):
    charge = {"filling": 0.3, "porosity": 0.35, "rotation_angle_rad": 1.0}
    case = by_id(cases(tmp_path, multi_ball=charge))["mb-cg-paper-S1.000"]
    nodes, _ = _core.Lifters(3.9, 3.61, 0.25, 0.635, 25).polygon(1e-7)
    x, z = nodes.T
    area = 0.5 * abs(np.sum(x * np.roll(z, -1) - z * np.roll(x, -1)))
    expected = 0.3 * 0.65 * area * 1.0 / (4.0 / 3.0 * math.pi * 0.02**3)
    assert case.ball.count == pytest.approx(expected, abs=1.0)
    assert case.charge.solid_fraction == pytest.approx(0.3 * 0.65, rel=1e-5)


def test_the_papers_count_of_a_plain_cylinder_is_found(tmp_path):
    """Section 2.2: 278,058 balls."""
    charge = {"filling": 0.3, "porosity": 0.35, "rotation_angle_rad": 1.0, "S": [1.0]}
    case = by_id(cases(tmp_path, liner=None, multi_ball=charge))["mb-cg-paper-S1.000"]
    assert case.ball.count == 278058


def test_froude_scheme_takes_its_time_factor_or_exponent(tmp_path):
    changes = {"scaling__schemes": ["froude"], "scaling__S": [4.0]}
    factor = cases(tmp_path, scaling__time_factor=0.25, **changes)[0]
    exponent = cases(tmp_path, scaling__time_exponent=-1.0, **changes)[0]
    assert factor.id == "sb-fr-paper-S4.000"
    assert factor.mill == exponent.mill
    assert factor.mill.omega_rad_s == pytest.approx(4.0, rel=1e-15)
    assert factor.mill.froude == pytest.approx(3.9 / 9.81, rel=1e-14)


def test_a_case_reads_back_from_its_file_unchanged(tmp_path):
    for case in cases(tmp_path, **MULTI_BALL):
        path = tmp_path / "case.json"
        path.write_text(case.text())
        assert load_case(tmp_path) == case
        assert case_digest(json.loads(path.read_text())) == case.digest


def test_the_digest_follows_what_decides_a_case_and_nothing_else(tmp_path):
    case = cases(tmp_path)[0]
    informing = {**case.document, "versions": {"millscale": "9"}, "model": {}, "warnings": ["x"]}
    assert case_digest(informing) == case.digest
    assert case_digest({**case.document, "S": 1.5}) != case.digest


@pytest.mark.parametrize("content", ["", "[]", '{"schema": 2}', "[" * 100_000])
def test_what_is_not_a_case_is_refused(content, tmp_path):
    path = tmp_path / "case.json"
    path.write_text(content)
    with pytest.raises(RunFolderError, match=r"case\.json"):
        load_case(tmp_path)


def test_a_case_is_plain_json_without_nan(tmp_path):
    changes = {"mill__allow_centrifuging": True, "mill__speed_rad_s": 2.0}
    case = cases(tmp_path, **changes)[0]
    document = json.loads(case.text())
    assert document["mill"]["detach_angle_deg"] is None
    assert document["mill"]["regime"] == "centrifuging"


def test_a_case_json_of_an_analytic_wall_with_a_curvature_is_read(tmp_path):
    """As earlier versions wrote them."""
    case = cases(tmp_path)[0]
    old = case.document
    old["wall"]["curvature_deg"] = 2.3
    old["digest"] = case_digest(old)
    path = tmp_path / "case.json"
    path.write_text(json.dumps(old), encoding="utf-8")
    assert load_case(tmp_path).document == old
    assert "curvature_deg" not in parameters(load_case(tmp_path))


def test_a_case_json_of_a_mesh_without_a_curvature_is_refused(tmp_path):
    case = cases(tmp_path, wall__kind="mesh")[0]
    document = case.document
    del document["wall"]["curvature_deg"]
    (tmp_path / "case.json").write_text(json.dumps(document), encoding="utf-8")
    with pytest.raises(RunFolderError, match=r"wall\.curvature_deg is missing"):
        load_case(tmp_path)


def test_friction_matched_divides_the_friction_between_balls_alone(tmp_path):
    policies = {"scaling__policies": ["friction-matched", "paper"]}
    found = by_id(cases(tmp_path, **policies, multi_ball=MULTI_BALL["multi_ball"]))
    matched, paper = found["mb-cg-friction-matched-S2.600"], found["mb-cg-paper-S2.600"]
    ratio = matched.material.static_friction_pp / paper.material.static_friction_pp
    assert ratio == pytest.approx(1.0 / 2.6)
    assert matched.factors.friction == pytest.approx(1.0 / 2.6)
    assert matched.material.static_friction_pw == paper.material.static_friction_pw
    assert matched.mill == paper.mill
    assert "friction" not in json.loads(paper.text())["factors"]


def test_a_friction_exponent_is_of_the_scaled_mills_it_changes(tmp_path):
    def found(**changes):
        policies = {"scaling__policies": ["friction-matched", "paper"]}
        return by_id(cases(tmp_path, single_ball=None, **MULTI_BALL, **policies, **changes))

    usual, other = found(), found(scaling__friction_exponent=1.2)
    matched = other.pop("mb-cg-friction-matched-S2.600")
    assert matched.factors.friction == pytest.approx(2.6**-1.2, rel=1e-14)
    assert matched.material.static_friction_pp == pytest.approx(0.545 * 2.6**-1.2, rel=1e-14)
    assert matched.document["friction_exponent"] == 1.2
    for name, case in other.items():
        if "constant-speed" not in case.scheme and case.policy == "paper":
            assert case.digest == usual[name].digest
    assert "friction_exponent" not in usual["mb-cg-friction-matched-S2.600"].document


def test_friction_matched_is_no_policy_of_a_single_ball(tmp_path):
    """It has no contact with another ball."""
    found = cases(tmp_path, scaling__policies=["friction-matched", "paper"])
    assert {case.policy for case in found} == {"paper"}
    with pytest.raises(CampaignError, match="a single ball has no contact between balls"):
        cases(tmp_path, single_ball__policies=["friction-matched"])
