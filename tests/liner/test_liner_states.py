"""New and worn liners: cases side by side, each compared within its state."""

import pytest

from liner_files import families, write_csv, write_dxf
from millscale.analysis.charge.scaled_mills import Charges, mill_name
from millscale.analysis.finished import Charge
from millscale.campaign.build import load_campaign
from millscale.cases.case import cases_of
from millscale.errors import CampaignError
from millscale.runs.case_folder import FinishedCase
from small_campaign import TEXT

FAMILIES = families()
STATES = """
[liner]
turns = "counter-clockwise"

[[liner.state]]
name = "new"
hours = 0
profile = "new.dxf"

[[liner.state]]
name = "worn"
tonnes = 1e6
profile = "worn.csv"
tolerance_mm = 0.5
"""


@pytest.fixture
def campaign(tmp_path):
    write_dxf(tmp_path / "new.dxf", FAMILIES["rib"])
    write_csv(tmp_path / "worn.csv", FAMILIES["worn"], error=2e-4)
    head, _, tail = TEXT.partition("[liner]")
    text = (head + STATES + "[ball]" + tail.partition("[ball]")[2]).replace(
        "S = [2.0]\ncount = [50]", "S = [1.0, 2.0]\ncount = [200, 50]"
    )
    (tmp_path / "c.toml").write_text(text)
    return tmp_path / "c.toml"


def test_each_state_makes_every_case(campaign):
    cases = cases_of(load_campaign(campaign))
    new, worn = cases[:4], cases[4:]
    assert [case.id for case in new][:2] == ["sb-cg-paper-S1.000-new", "sb-cg-paper-S2.000-new"]
    assert [case.id.replace("-new", "-worn") for case in new] == [case.id for case in worn]
    assert {case.liner_state.name for case in worn} == {"worn"}
    assert (new[0].liner_state.hours, worn[0].liner_state.tonnes) == (0.0, 1e6)
    assert (new[0].liner_file.name, worn[0].liner_file.name) == ("new.dxf", "worn.csv")
    # Wear makes the cavity larger.
    assert worn[0].mill.area_m2 > new[0].mill.area_m2
    assert any("points are" in text for text in worn[0].warnings)
    assert not any("points are" in text for text in new[0].warnings)


def test_the_digest_of_the_file_does_not_decide_a_case(campaign):
    first = cases_of(load_campaign(campaign))[4]
    path = campaign.parent / "worn.csv"
    path.write_text("# measured in May\n" + path.read_text())
    second = cases_of(load_campaign(campaign))[4]
    assert first.liner_file.sha256 != second.liner_file.sha256
    assert first.digest == second.digest


def test_a_mill_is_compared_with_the_physical_mill_of_its_state(campaign, tmp_path):
    cases = [case for case in cases_of(load_campaign(campaign)) if case.kind == "multi-ball"]
    charges = [Charge(FinishedCase(tmp_path / case.id, case, {}, {}), "c") for case in cases]
    compared = Charges(tuple(charges))
    for charge in charges:
        assert compared.reference_of(charge).state == charge.state
        assert compared.reference_of(charge).is_physical
    assert len({mill_name(charge) for charge in charges}) == 4
    # Without its own physical mill, a worn mill is not compared with the new one.
    left = Charges(tuple(charges[:2] + charges[3:]))
    assert left.reference_of(charges[3]) is charges[3]
    assert [charge.label for charge in charges][2:] == ["S = 1, worn", "S = 2, worn"]


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ('"worn"', '"new"', r'liner\.state\[2\]\.name: got "new" twice'),
        ('"worn"', '"Worn 1"', r"up to 20 lower-case letters"),
        ('profile = "new.dxf"', "", r"liner\.state\[1\]\.profile: and stl missing"),
        ('turns = "counter', 'preset = "plain"\nturns = "counter', r"given beside \[\[liner"),
        ("tolerance_mm", "preset = 1\ntolerance_mm", "unknown key"),
    ],
)
def test_states_with_mistakes_are_refused(campaign, old, new, text):
    campaign.write_text(campaign.read_text().replace(old, new))
    with pytest.raises(CampaignError, match=text):
        load_campaign(campaign)
