import csv
import io
import json
import math
import os
import re
import subprocess
import sys

import pytest
from rich.console import Console

from millscale import _core
from millscale.campaign.build import load_campaign
from millscale.engine.machine import CoreWish
from millscale.workflow.plan import plan_rows
from millscale.workflow.plan_display import render_plan
from paper_campaign import CAMPAIGNS, MULTI_BALL, PAPER, write_campaign

ROW_KEYS = {
    "id", "scheme", "policy", "S", "radius_m", "lifter_top_radius_m", "lifter_top_width_m",
    "groove_width_m", "length_m", "gravity_m_s2", "omega_rad_s", "froude", "balls", "time_step_s",
    "steps", "predicted_energy_ratio", "percent_of_critical", "rayleigh_fraction",
    "limit_fraction", "predicted_wall_time_s", "model",
}  # fmt: skip
IN_MM = {
    "R_mm": "radius_m",
    "r_mm": "lifter_top_radius_m",
    "D1_mm": "lifter_top_width_m",
    "D2_mm": "groove_width_m",
    "L_mm": "length_m",
}
IN_SI = {
    "S": "S",
    "R_m": "radius_m",
    "gravity_m_s2": "gravity_m_s2",
    "omega_rad_s": "omega_rad_s",
    "froude": "froude",
}


def table(name: str) -> list[dict[str, str]]:
    lines = (PAPER / name).read_text().splitlines()
    return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def of_scheme(rows, scheme):
    return [row for row in rows if row["scheme"] == scheme and row["policy"] == "paper"]


def as_printed(value: float, printed: str) -> bool:
    """Return whether a value rounds to the printed digits."""
    decimals = len(printed.partition(".")[2])
    return f"{value:.{decimals}f}" == printed


@pytest.fixture(scope="module")
def single_ball_rows():
    return plan_rows(load_campaign(CAMPAIGNS / "paper-single-ball.toml"))


@pytest.mark.parametrize("scheme", ["constant-gravity", "constant-speed"])
def test_plan_reproduces_table_4_to_its_printed_millimetre(single_ball_rows, scheme):
    rows = of_scheme(single_ball_rows, scheme)
    for row, printed in zip(rows, table("table4_geometry.csv"), strict=True):
        assert as_printed(row["S"], printed["S"])
        for column, key in IN_MM.items():
            assert as_printed(1000.0 * row[key], printed[column]), (row["id"], column)


@pytest.mark.parametrize(
    ("scheme", "name"),
    [
        ("constant-gravity", "table6_constant_gravity.csv"),
        ("constant-speed", "table7_constant_speed.csv"),
    ],
)
def test_plan_reproduces_tables_6_and_7_to_their_printed_digits(single_ball_rows, scheme, name):
    rows = of_scheme(single_ball_rows, scheme)
    for row, printed in zip(rows, table(name), strict=True):
        for column, key in IN_SI.items():
            assert as_printed(row[key], printed[column]), (row["id"], column)


def test_plan_holds_the_counts_of_table_10():
    rows = plan_rows(load_campaign(CAMPAIGNS / "paper-multi-ball.toml"))
    for scheme in ("constant-gravity", "constant-speed"):
        counts = [row["balls"] for row in of_scheme(rows, scheme) if row["seed"] == 1]
        assert counts == [int(row["particles"]) for row in table("table10_wall_time.csv")]


def test_predicted_ratios_are_those_of_tables_8_and_9(single_ball_rows):
    for scheme, name, column in (
        ("constant-gravity", "table8_energy_constant_gravity.csv", "inverse_S"),
        ("constant-speed", "table9_energy_constant_speed.csv", "inverse_S_squared"),
    ):
        for row, printed in zip(of_scheme(single_ball_rows, scheme), table(name), strict=True):
            # The paper rounds 1 / S before it squares, and 2.3 / 3.9 down.
            assert row["predicted_energy_ratio"] == pytest.approx(float(printed[column]), abs=1e-3)


def test_rows_are_json_with_every_documented_number(tmp_path):
    rows = plan_rows(load_campaign(write_campaign(tmp_path, **MULTI_BALL)))
    for row in json.loads(json.dumps(rows, allow_nan=False)):
        assert set(row) >= ROW_KEYS
        for side in ("in", "out"):
            assert all(entry["what"] and entry["reason"] for entry in row["model"][side])


def test_more_ranks_are_predicted_to_take_less_time_for_a_charge_only(tmp_path):
    charge = {**MULTI_BALL["multi_ball"], "count": [231461, 13370]}
    campaign = load_campaign(write_campaign(tmp_path, multi_ball=charge))
    wishes = [CoreWish(ranks, oversubscribe=True) for ranks in (2, 4)]
    for two, four in zip(*(plan_rows(campaign, x) for x in wishes), strict=True):
        ratio = four["predicted_wall_time_s"] / two["predicted_wall_time_s"]
        if two["kind"] == "single-ball":
            assert ratio == 1.0
        else:
            # Every further rank spends part of its time on ghost balls.
            assert 0.5 < ratio < 0.75


def many(folder, count):
    """A campaign of so many single balls: half as many mills, both schemes."""
    ratios = [round(1.0 + 0.002 * i, 3) for i in range(count // 2)]
    return write_campaign(folder, scaling__S=ratios)


def many_seeds(folder, count):
    """A campaign of so many packings of one mill."""
    seeds = {"S": [2.6], "filling": 0.3, "slice_diameters": 4.0, "seeds": list(range(count))}
    charge = {"multi_ball": {**seeds, "rotation_angle_rad": 8.0}}
    schemes = {"scaling__schemes": ["constant-gravity"]}
    return write_campaign(folder, single_ball=None, **schemes, **charge)


def seconds_of_plan(file, kind, count):
    """Processor time of `millscale plan` [s], which is its wall time on a free core."""
    begin = os.times()
    command = [sys.executable, "-m", "millscale", "plan", str(file)]
    shown = subprocess.run(command, capture_output=True, text=True, check=True)
    assert f"{kind}: {count} cases" in shown.stdout
    end = os.times()
    return end.children_user + end.children_system - begin.children_user - begin.children_system


def test_a_thousand_single_balls_are_planned_in_seconds(tmp_path):
    # A tenth of the campaign below in half of its time: the start is a second of it.
    assert seconds_of_plan(many(tmp_path, 1000), "single-ball", 1000) < 5.0


def test_ten_thousand_seeds_are_planned_in_ten_seconds(tmp_path):
    # The cases differ in their packing alone: the mill is computed once.
    assert seconds_of_plan(many_seeds(tmp_path, 10_000), "multi-ball", 10_000) < 10.0


@pytest.mark.validate
def test_ten_thousand_single_balls_are_planned_in_ten_seconds(tmp_path):
    took = seconds_of_plan(many(tmp_path, 10_000), "single-ball", 10_000)
    print(f"\n10,000 single balls planned in {took:.1f} s")
    assert took < 10.0


def shown(campaign, width=180, **options):
    """Return the plan of a campaign in a terminal of a width."""
    console = Console(width=width, record=True, file=io.StringIO())
    console.print(render_plan(campaign, plan_rows(campaign), **options))
    return console.export_text()


def test_plan_shows_the_time_of_all_cases_on_this_machine(tmp_path):
    text = shown(load_campaign(many(tmp_path, 10)))
    assert "together about" in text and "of memory at most" in text


def test_the_plan_of_one_case_at_a_time_is_what_a_run_of_one_at_a_time_does(
    tmp_path, monkeypatch, millscale
):
    """`run --jobs 1` gives a case all cores, so its ranks and its time are others."""
    monkeypatch.setattr("millscale.workflow.placement.available_cores", lambda: 2)
    charge = {**MULTI_BALL["multi_ball"], "count": [40_000, 20_000]}
    campaign = write_campaign(tmp_path, single_ball=None, multi_ball=charge)
    millscale.file.write_text(campaign.read_text())
    ranks = {}
    for options in ((), ("--jobs", "1")):
        rows = json.loads(millscale("plan", "--json", *options).stdout)
        ranks[options] = [row["ranks"] for row in rows]
        printed = millscale("run", "--dry-run", *options).stdout
        assert [int(x) for x in re.findall(r"-np (\d+) .*mill\.in", printed)] == ranks[options]
    assert ranks[()] != ranks["--jobs", "1"]
    text = shown(load_campaign(millscale.file), jobs=1)
    assert "of this machine, one at a time" in text


def test_the_plan_leads_with_the_mill(tmp_path):
    charge = {"filling": 0.27, "rotation_angle_rad": 8.0, "slice_diameters": 4.0}
    campaign = load_campaign(write_campaign(tmp_path, single_ball=None, multi_ball=charge))
    first = [line.rstrip() for line in shown(campaign).splitlines()[:3]]
    # The balls of the whole mill, J (1 - 0.4) A L / V, and their mass, independently.
    area = _core.Lifters(3.9, 3.61, 0.25, 0.635, 25).area
    volume = 4.0 / 3.0 * math.pi * 0.02**3
    count = 0.27 * 0.6 * area / volume
    assert first[0] == "mill    D 7.8 m, L 1 m inside the liner; 25 lifters 290 mm high"
    assert first[1] == "speed   9.549 rpm, 62.9 % of critical, Fr 0.398"
    found = re.fullmatch(
        r"charge  J 0\.27: ([\d,]+) balls, ([\d.]+) t, of 40 mm, 2,678 kg/m\^3", first[2]
    )
    # The slice has whole balls.
    assert int(found[1].replace(",", "")) == pytest.approx(count, rel=1e-4)
    assert float(found[2]) == pytest.approx(1e-3 * count * volume * 2678.0, rel=1e-3)


@pytest.mark.parametrize("path", sorted(CAMPAIGNS.glob("[!s]*.toml")), ids=lambda path: path.stem)
def test_a_plan_fits_80_columns(path):
    text = shown(load_campaign(path), width=80)
    # Rich cuts what does not fit, with an ellipsis.
    assert "…" not in text
    assert max(len(line.rstrip()) for line in text.splitlines()) <= 80
    ids = {re.sub(r"-seed\d+$", "", row["id"]) for row in plan_rows(load_campaign(path))}
    assert ids == {line.split()[0] for line in text.splitlines() if re.match("[sm]b-", line)}


def test_seeds_of_a_mill_are_one_row_and_details_show_each(tmp_path):
    campaign = load_campaign(many_seeds(tmp_path, 3))
    short, whole = shown(campaign), shown(campaign, details=True)
    row = next(line for line in short.splitlines() if line.startswith("mb-cg-paper-S2.600"))
    assert row.split()[:2] == ["mb-cg-paper-S2.600", "3"]
    assert all(f"mb-cg-paper-S2.600-seed{seed} " in whole for seed in range(3))
    assert "dt/T_R" in whole and "dt/T_R" not in short


def test_warnings_that_differ_in_numbers_alone_are_shown_once():
    campaign = load_campaign(CAMPAIGNS / "slices.toml")
    rows = plan_rows(campaign)
    texts = {text for row in rows for text in row["warnings"] if "damping limit" in text}
    assert len(texts) == 3
    lines = [line for line in shown(campaign).splitlines() if "damping limit" in line]
    (line,) = lines
    # The first is that of the largest mill, where the step is longest over its limit.
    assert line.startswith("warning mb-cg-paper-S1.000-seed1 and 6 more: step 0.0002 s is 1.36 ")


def test_rendered_plan_shows_every_case_its_warnings_and_omitted_terms(tmp_path):
    charge = {**MULTI_BALL["multi_ball"], "step_s": 2e-4}
    campaign = load_campaign(write_campaign(tmp_path, multi_ball=charge))
    text = shown(campaign, details=True)
    for row in plan_rows(campaign):
        assert row["id"] in text
    assert "warning mb-cg-paper-S1.000" in text
    assert "left out:" in text
    assert "air drag" in text
    assert "pair style, neighbour list, ghost balls: a single ball has no other to touch" in text
    assert "left out:" not in shown(campaign)
