"""Decks with loads on the liner: their files, the same series without them, the wall they need."""

import numpy as np
import pytest
from test_left_out import CHARGE, NOTHING_FORCED, ran

from millscale.analysis.wear.loads import LIFTERS, read_liner_loads
from millscale.analysis.wear.rate import wear_rate
from millscale.campaign.build import load_campaign
from millscale.cases.case import cases_of
from millscale.errors import CampaignError
from millscale.runs.series import read_series
from paper_campaign import cases

STUDY = CHARGE | {"count": [300], "settle_s": 0.11, "rotation_angle_rad": 0.3}
LOADS = STUDY | {"liner_loads": True}


def one_case(folder, study, wall="analytic"):
    """Return the case of a charge in one scaled mill."""
    return cases(
        folder,
        scaling__S=[2.6],
        scaling__schemes=["constant-gravity"],
        wall__kind=wall,
        single_ball=None,
        multi_ball=study,
    )[0]


@pytest.mark.engine
def test_the_decks_record_the_loads_on_request(tmp_path):
    kept = ran(tmp_path / "kept", "analytic", {"multi_ball": LOADS}, NOTHING_FORCED)
    plain = ran(tmp_path / "plain", "analytic", {"multi_ball": STUDY}, NOTHING_FORCED)
    assert not (plain / LIFTERS).exists()
    assert (kept / "series.csv").read_text() == (plain / "series.csv").read_text()
    case = cases_of(load_campaign(kept / "campaign.toml"))[0]
    loads, series = read_liner_loads(kept, case), read_series(kept / "series.csv", "multi-ball")
    angle, time = series["mill_angle_rad"], series["time_s"]
    end = np.interp(loads.to_rad, angle, time)
    assert end - np.interp(loads.from_rad, angle, time) == pytest.approx(loads.duration, rel=0.01)
    # The torque on the mill is against that of the drive.
    work = np.interp([loads.from_rad, loads.to_rad], angle, series["drive_work_J"])
    torque = loads.total("torque_impulse_Nms") / loads.duration
    assert -torque == pytest.approx(np.diff(work)[0] / (loads.to_rad - loads.from_rad), rel=0.02)
    slip = loads.by_place[..., 3].sum()
    assert slip == pytest.approx(loads.total("slip_work_J"), rel=1e-9)
    assert wear_rate(loads, case, "archard").mean > 0.0
    assert len(loads.bins.faces) >= 100


def test_a_mesh_wall_records_no_loads(tmp_path):
    with pytest.raises(CampaignError, match=r"multi_ball\.liner_loads: got true with wall\.kind"):
        one_case(tmp_path, LOADS, wall="mesh")


def test_cases_without_the_key_stay_as_they_were(tmp_path):
    without, off, on = (
        one_case(tmp_path, STUDY | key)
        for key in ({}, {"liner_loads": False}, {"liner_loads": True})
    )
    assert without.digest == off.digest != on.digest
    assert "liner_loads" not in without.document["deck"]
    assert on.predicted.output_bytes > off.predicted.output_bytes
