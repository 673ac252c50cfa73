"""Power models of the physical mill of a case, in the plan and in the documentation."""

from __future__ import annotations

import io
import math
import re
from pathlib import Path

import pytest
from rich.console import Console

import millscale as ms
from millscale.campaign.build import load_campaign
from millscale.cases.case import cases_of
from millscale.power_models import ModelPower, mill_of, models_for
from millscale.runs.case_file import Case
from millscale.workflow.plan import plan_rows
from millscale.workflow.plan_display import render_plan

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs/theory/power-models.md"
SLICES = ROOT / "campaigns/slices.toml"


def cases(name: str) -> list[Case]:
    return cases_of(load_campaign(ROOT / "campaigns" / name))


@pytest.fixture(scope="module")
def of_paper() -> list[ModelPower]:
    return models_for(cases("slices.toml")[0])


def test_every_slice_is_of_the_same_physical_mill():
    """A slice of four ball diameters, scaled by 1, 1.696 and 2.6: 231,461 balls of 89.74 g."""
    mills = [mill_of(case) for case in cases("slices.toml")]
    mass = 231461 * 2678.0 * 4.0 / 3.0 * math.pi * 0.02**3
    for mill in mills:
        assert mill.mass == pytest.approx(mass, rel=1e-3)  # slices have whole balls
        assert (mill.diameter, mill.length, mill.omega) == pytest.approx((7.8, 1.0, 1.0))
        assert mill.bulk_density == pytest.approx(0.6 * 2678.0)


def test_a_filling_is_counted_over_the_circle_of_the_grooves(tmp_path):
    text = (ROOT / "campaigns/unseen/regrind-2400-mm.toml").read_text(encoding="utf-8")
    file = tmp_path / "porous.toml"
    file.write_text(text.replace("filling = 0.40", "filling = 0.40\nporosity = 0.45"))
    case = next(case for case in cases_of(load_campaign(file)) if case.charge)
    mill, radius = mill_of(case), case.physical.radius_m
    area = case.mill.area_m2 * case.S**2  # inside the liner of the physical mill
    assert mill.filling == pytest.approx(0.40 * area / (math.pi * radius**2), rel=1e-3)
    assert mill.bulk_density == pytest.approx(0.55 * case.ball.density_kg_m3)
    assert mill.fraction_of_critical == pytest.approx(
        case.physical.omega_rad_s * math.sqrt(radius / case.physical.gravity_m_s2)
    )


def test_a_single_ball_has_no_power():
    assert models_for(cases("paper-single-ball.toml")[0]) == []


def test_the_page_has_the_powers_of_the_mill_of_the_paper(of_paper):
    section = PAGE.read_text(encoding="utf-8").split("## The mill of the paper")[1]
    mill = mill_of(cases("slices.toml")[0])
    for row in of_paper:
        found = re.search(rf"\| {row.name} \| ([\d.]+) \| ([\d.]+) \|", section)
        assert found, row.name
        power, torque = map(float, found.groups())
        assert power == pytest.approx(row.power_kw, abs=0.05)
        assert torque == pytest.approx(mill.torque_number(row.power_w), abs=0.0005)


def test_the_plan_shows_the_models_with_its_details(of_paper):
    campaign = load_campaign(SLICES)
    rows = plan_rows(campaign)
    printed = text_of(render_plan(campaign, rows, details=True))
    for row in of_paper:
        assert re.search(rf"{row.name} +{row.power_kw:.4g} kW +at the {row.measured_at}", printed)
    assert "published models" not in text_of(render_plan(campaign, rows))


def test_the_plan_states_the_limits_that_a_small_mill_lies_outside_of(tmp_path):
    small = tmp_path / "small.toml"
    text = SLICES.read_text(encoding="utf-8").replace('name = "slices"', 'name = "small"')
    small.write_text(re.sub(r"(?m)^speed_rad_s = 1.0", "speed_rad_s = 0.7", text))
    campaign = load_campaign(small)
    printed = text_of(render_plan(campaign, plan_rows(campaign), details=True))
    assert "outside: share of the critical speed 0.441, below 0.5" in printed


def test_the_plan_of_a_single_ball_has_no_models():
    campaign = load_campaign(ROOT / "campaigns/paper-single-ball.toml")
    assert "published models" not in text_of(render_plan(campaign, plan_rows(campaign), True))
    assert ms.plan(ROOT / "campaigns/paper-single-ball.toml").power_models.empty


def test_the_plan_of_python_has_a_table_of_the_models(of_paper):
    table = ms.plan(SLICES).power_models
    assert table["power_w"].tolist() == [row.power_w for row in of_paper]
    assert table.attrs["units"]["power_w"] == "W"


def text_of(shown) -> str:
    console = Console(file=io.StringIO(), width=200, color_system=None)
    console.print(shown)
    return console.file.getvalue()
