"""Decks that record impacts: the file, its sum, and the same series without it."""

import pytest
from test_left_out import CHARGE, NOTHING_FORCED, ran

from millscale.analysis.charge.impacts import SPECTRA, read_impacts
from millscale.campaign.build import load_campaign
from millscale.cases.case import cases_of

pytestmark = pytest.mark.engine

STUDY = CHARGE | {"count": [300], "settle_s": 0.11, "rotation_angle_rad": 0.3}


def test_the_decks_record_impacts_on_request(tmp_path):
    recorded = ran(tmp_path / "recorded", "analytic", {"multi_ball": STUDY | {"impacts": True}}, [])
    plain = ran(tmp_path / "plain", "analytic", {"multi_ball": STUDY}, NOTHING_FORCED)
    assert not (plain / SPECTRA).exists()
    assert (recorded / "series.csv").read_bytes() == (plain / "series.csv").read_bytes()
    case = cases_of(load_campaign(recorded / "campaign.toml"))[0]
    found = read_impacts(recorded, case)
    assert found.to_rad - found.from_rad == pytest.approx(0.15, rel=0.05)
    for pairing in found.pairings.values():
        assert pairing.contacts_per_s > 0.0
        assert pairing.sum_error < 1e-9
