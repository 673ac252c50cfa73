import math

from paper_campaign import MULTI_BALL, cases


def listed(case, side: str) -> dict[str, str]:
    statements = {"in": case.model.inside, "out": case.model.outside}[side]
    return {entry.what: entry.reason for entry in statements}


def test_values_that_the_paper_omits_are_reported_as_assumed(tmp_path):
    for case in cases(tmp_path, **MULTI_BALL):
        assert "assumption" in listed(case, "in")["wall with the elastic constants of the balls"]


def test_the_unscaled_ball_radius_is_left_out_of_scaled_mills_only(tmp_path):
    for case in cases(tmp_path, scaling__policies=["corrected", "paper"]):
        reason = listed(case, "out").get("scaling of the ball radius")
        assert (reason is None) == (case.S == 1.0)
        assert reason is None or case.policy in reason


def test_a_lowered_friction_is_stated_with_its_power(tmp_path):
    scaling = {"scaling__policies": ["friction-matched"], "scaling__schemes": ["constant-speed"]}
    for k, said in ((1.0, "divided by S"), (1.2, "divided by S^1.2")):
        changes = {"single_ball": None, "scaling__friction_exponent": k, **scaling, **MULTI_BALL}
        for case in cases(tmp_path, **changes):
            stated = f"sliding friction between balls {said}" in listed(case, "in")
            assert stated == (case.S > 1.0)


def test_air_drag_is_weighed_against_the_ball(tmp_path):
    drag = 0.5 * 1.2 * 0.47 * math.pi * 0.02**2
    weight = 4.0 / 3.0 * math.pi * 0.02**3 * 2678.0 * 9.81
    for case in cases(tmp_path)[:1]:
        speed = case.time.impact_speed_m_s
        assert listed(case, "out")["air drag"].startswith(f"{drag * speed**2 / weight:.1%} ")
