"""Campaigns side by side."""

from millscale.analysis.variants import variant_rows


def test_each_campaign_and_scheme_has_a_row_with_its_lifter_and_phase(runs):
    rows = variant_rows([runs, runs], S=2.6, policy="corrected")
    assert [one.row.scheme for one in rows] == 2 * ["constant-gravity", "constant-speed"]
    assert {one.row.id for one in rows} == {"sb-cg-corrected-S2.600", "sb-cs-corrected-S2.600"}
    assert all(9.0 < one.face_angle_deg < 9.6 and one.phase_deg == 0.0 for one in rows)
