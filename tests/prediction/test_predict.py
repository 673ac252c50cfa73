"""The physical mill predicted from made-up charges whose errors follow known powers of S."""

import json
import math
import re
from dataclasses import replace

import pytest
from typer.testing import CliRunner

from millscale.analysis.charge.measured import measure
from millscale.analysis.finished_campaign import load_campaign
from millscale.cli.main import app
from millscale.errors import PredictionError
from millscale.prediction.of_report import predicted_numbers
from millscale.prediction.predict import predict, predict_charges
from millscale.prediction.selection import usable_charges
from millscale.report.overview import LEVEL
from paper_campaign import REPOSITORY
from synthetic_mills import BALLS_AT_1, SEEDS, TORQUE, charge_case, write_mills


@pytest.fixture(scope="module")
def mills(tmp_path_factory):
    """S = 1, 1.696 and 2.6, two seeds each. Read only."""
    runs = tmp_path_factory.mktemp("mills")
    return write_mills(runs, *(charge_case(S, seed) for S in (1.0, 1.696, 2.6) for seed in SEEDS))


def named(prediction):
    return {number.observable.name: number for number in prediction.numbers}


def test_power_and_torque_of_the_whole_mill_are_in_their_units(mills):
    """M g R omega of all its balls, by hand."""
    found = named(predict([mills], leave_out_physical=True))
    ball = 2678.0 * 4.0 / 3.0 * math.pi * 0.02**3
    scale = BALLS_AT_1 * ball * 9.81 * 3.9
    power, torque = found["power"], found["torque"]
    assert power.scale == pytest.approx(1e-3 * scale, rel=1e-4)
    assert power.check == pytest.approx(1e-3 * scale * TORQUE, rel=1e-3)
    assert power.value == pytest.approx(torque.value, rel=1e-9)  # omega is 1 rad/s
    assert power.is_inside and torque.is_inside
    assert abs(power.value / power.check - 1.0) < 0.02
    nearest = next(value for value in power.measured if value.S == 1.696)
    assert abs(power.value - power.check) < 0.5 * abs(nearest.mean - power.check)


def test_the_report_has_the_numbers_of_the_prediction(mills):
    campaign = load_campaign(mills)
    found = {x.name: (x.value, x.half_width) for x in predicted_numbers(campaign)}
    expected = {
        name: (x.value, x.half_width)
        for name, x in named(predict([mills], level=LEVEL)).items()
        if x.value is not None and x.half_width is not None
    }
    assert "power" in found and found == expected
    one_S = replace(campaign, charges=[x for x in campaign.charges if x.S == 2.6])
    assert predicted_numbers(one_S) == []


def test_specific_power_is_kilowatts_over_tonnes(mills):
    prediction = predict([mills], leave_out_physical=True)
    tonnes = 1e-3 * prediction.mill.mass
    assert prediction["specific_power"].value == pytest.approx(prediction["power"].value / tonnes)
    assert prediction["specific_power"].observable.restates == "power"


def test_a_wrong_name_names_the_nearest(mills):
    with pytest.raises(KeyError, match="powr, nearest is power; accepted: power, "):
        predict([mills])["powr"]


def test_as_many_figures_are_shown_as_the_interval_has(mills):
    power = predict([mills], leave_out_physical=True)["power"]
    shown = power.cells[3]
    assert float(shown) == pytest.approx(power.half_width, rel=0.05)
    assert len(shown.replace(".", "").lstrip("0")) == 2


def bent_mills(runs, bent):
    """Write mills whose torque number has other errors than a power of S."""
    return write_mills(
        runs,
        *(charge_case(S, seed) for S in bent for seed in SEEDS),
        torque=lambda S, seed: (TORQUE + bent[S]) * (1.0 + SEEDS[seed]),
    )


def test_an_observable_that_rises_and_falls_is_a_warning(tmp_path):
    bent_mills(tmp_path, {1.0: 0.0, 1.696: -0.02, 2.6: 0.02})
    warnings = predict([tmp_path]).warnings
    assert sum("not monotonic in S" in line for line in warnings) >= 1
    assert any(line.startswith("power is not monotonic in S: ") for line in warnings)


def test_an_interval_is_wider_at_a_higher_level(mills):
    narrow, wide = (
        named(predict([mills], level=level, leave_out_physical=True))["power"].interval
        for level in (0.6, 0.99)
    )
    assert wide[0] < narrow[0] < narrow[1] < wide[1]


def test_with_the_physical_mill_its_own_value_counts(mills):
    found = named(predict([mills]))["power"]
    assert [value.S for value in found.measured] == [1.0, 1.696, 2.6]
    scale = found.scale
    assert found.value == pytest.approx(scale * TORQUE, rel=2e-3)
    half = 0.5 * (found.interval[1] - found.interval[0])
    assert half < 0.01 * found.value


def test_what_is_not_measured_is_refused_with_its_reason(mills):
    found = named(predict([mills]))
    assert found["shoulder_angle_rad"].refused == "measured at fewer than two values of S"
    assert found["shoulder_angle_rad"].value is None


def test_values_that_no_power_fits_are_refused(tmp_path):
    bent_mills(tmp_path, {1.0: 0.0, 1.3: 0.03, 1.696: -0.03, 2.6: 0.03})
    assert "do not follow a power of S" in named(predict([tmp_path]))["power"].refused


def test_the_physical_mill_alone_has_the_interval_of_its_noise(tmp_path):
    charges, _ = usable_charges([write_mills(tmp_path, charge_case(1.0, 1))])
    found = predict_charges(charges, [], measure(charges, []).numbers)
    power = found["power"]
    assert power.value == pytest.approx(power.measured[0].mean)
    assert power.noise_from == "lifter pitches"
    assert 0.0 < power.half_width < 0.02 * power.value


def test_the_pitches_give_the_noise_of_single_seeds(tmp_path):
    write_mills(tmp_path, charge_case(1.696, 1), charge_case(2.6, 1))
    found = named(predict([tmp_path]))
    assert found["torque"].noise_from == "lifter pitches"
    assert found["torque"].value is not None
    assert found["kinetic_rotation"].noise_from == "lifter pitches"


def test_unsteady_charges_are_not_used(tmp_path):
    cases = [charge_case(S, seed) for S in (1.696, 2.6) for seed in SEEDS]
    name = cases[0]["id"]
    prediction = predict([write_mills(tmp_path, *cases, unsteady={name})])
    assert "drifts" in prediction.excluded[name]
    assert len(prediction.runs) == 3


def test_the_physical_friction_of_matched_mills_is_that_of_the_mill(tmp_path):
    cases = [charge_case(1.0, 1)]
    cases += [charge_case(S, 1, policy="friction-matched") for S in (1.696, 2.6)]
    prediction = predict([write_mills(tmp_path, *cases)])
    assert prediction.policy == "friction-matched"
    assert any("three in four of their intervals hold" in line for line in prediction.warnings)


def test_mills_of_two_friction_exponents_are_no_series(tmp_path):
    cases = [charge_case(S, 1, policy="friction-matched") for S in (1.696, 2.6)]
    for case, k in zip(cases, (1.0, 1.2), strict=True):
        case["friction_exponent"] = k
    with pytest.raises(PredictionError, match=r"of friction_exponent 1 and 1\.2; accepted"):
        predict([write_mills(tmp_path, *cases)])


def pair_with(**changes):
    return charge_case(1.696, 1), charge_case(2.6, 1, **changes)


@pytest.mark.parametrize(
    ("cases", "message"),
    [
        (pair_with(material__static_friction_pp=0.4), "static_friction_pp is 0.5 and 0.4"),
        (pair_with(ball__radius_std_m=0.001), "spread of ball radii is"),
    ],
)
def test_mills_of_other_materials_are_refused(tmp_path, cases, message):
    with pytest.raises(PredictionError, match=message):
        predict([write_mills(tmp_path, *cases)])


def test_the_command_prints_the_table_and_writes_the_numbers(mills, tmp_path):
    to = tmp_path / "prediction.json"
    done = CliRunner().invoke(app, ["predict", str(mills), "--check", "--to", str(to)])
    assert done.exit_code == 0, done.output
    power = next(line for line in done.output.splitlines() if " power " in line)
    assert "kW" in power and "yes" in power
    assert "not predicted: shoulder" in done.output
    assert "ledger = true in [multi_ball]" in done.output
    content = json.loads(to.read_text())
    assert {"command", "commit", "machine", "date"} <= content.keys()
    assert content["numbers"][0]["name"] == "power"


def test_every_key_of_the_file_is_described(mills):
    text = (REPOSITORY / "docs/reference/files.md").read_text(encoding="utf-8")
    section = text.partition("## The file of `millscale predict --to`")[2].partition("\n## ")[0]
    content = predict([mills], leave_out_physical=True).document()
    power = content["numbers"][0]
    refusals = {key for key in content if key.endswith("_refused")}
    keys = {*content, *power, *power["dimensionless"], *content["physical_mill"]} - refusals
    assert [key for key in sorted(keys) if not re.search(rf"\b{key}\b", section)] == []
