"""Decks with an energy budget: its files, its closure, and the same series without it."""

import numpy as np
import pytest
from test_left_out import CHARGE, NOTHING_FORCED, ran

from millscale.analysis.charge.energy_budget import energy_budget, impact_spectrum, read_ledger
from millscale.campaign.build import load_campaign
from millscale.cases.case import cases_of
from millscale.runs.series import read_series
from millscale.validate.energy_budget import CONTACTS, turned

pytestmark = pytest.mark.engine

STUDY = CHARGE | {"count": [300], "settle_s": 0.11, "rotation_angle_rad": 0.3}


def test_the_decks_have_an_energy_budget_on_request(tmp_path):
    kept = ran(tmp_path / "kept", "analytic", {"multi_ball": STUDY | {"ledger": True}}, [])
    plain = ran(tmp_path / "plain", "analytic", {"multi_ball": STUDY}, NOTHING_FORCED)
    assert not (plain / "ledger.csv").exists()
    ledger, series = read_ledger(kept), read_series(kept / "series.csv", "multi-ball")
    np.testing.assert_array_equal(ledger["step"], series["step"])
    for name in ("kinetic_translation_J", "kinetic_rotation_J", "potential_J"):
        # The budget holds changes, the series values; both are printed with all digits.
        np.testing.assert_allclose(
            np.diff(ledger[name]), np.diff(series[name]), rtol=1e-6, atol=1e-8
        )
    found = energy_budget(ledger)
    assert abs(found.closure) < 0.01
    assert abs(found.closure_of_forces) < 1e-5
    assert impact_spectrum(kept / "impacts.csv")["ball_ball"].impacts


def test_the_energy_budget_closes_with_both_contact_backends(tmp_path):
    study = {"multi_ball": STUDY}
    settled = ran(tmp_path / "settled", "analytic", study, NOTHING_FORCED)
    case = cases_of(load_campaign(settled / "campaign.toml"))[0]
    (settled / "case.json").write_text(case.text())
    for name, contacts in CONTACTS.items():
        (tmp_path / name).mkdir()
        found = turned(settled, tmp_path / name, contacts, None)
        assert found["to_rad"] == pytest.approx(case.time.rotation_angle_rad, rel=0.05)
        assert found["step_s"] == contacts.step
        assert abs(found["closure"]) < 0.01
        assert found["mill_work_J"] > 0.0 and found["series_work_J"] > 0.0
