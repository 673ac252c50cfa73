"""Campaigns side by side."""

from millscale.analysis.single_ball.variants import variant_rows


def test_each_campaign_and_scheme_has_a_row_with_its_lifter_and_phase(runs):
    rows = variant_rows([runs, runs], S=2.6, policy="corrected")
    assert [row["scheme"] for row in rows] == 2 * ["constant-gravity", "constant-speed"]
    assert {row["id"] for row in rows} == {"sb-cg-corrected-S2.600", "sb-cs-corrected-S2.600"}
    assert all(9.0 < row["face_angle_deg"] < 9.6 and row["phase_deg"] == 0.0 for row in rows)
