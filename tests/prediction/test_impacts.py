"""Impact spectra and dissipation of the physical mill, from made-up energy budgets."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from millscale.analysis.result_file import PAIRINGS, ImpactSpectrum
from millscale.cli.main import app
from millscale.prediction.extrapolation import ExtrapolationError, scale_function
from millscale.prediction.impacts import Scales, predict_spectra
from millscale.prediction.predict import predict
from millscale.runs.series import REQUIRED
from synthetic_case import finish_case, write_campaign, write_case
from synthetic_mills import charge_case, columns_of

EXPONENT, SLOPE, PER_BALL = 0.6, 0.3, 5.0
SEEDS = {1: 1e-3, 2: -1e-3}
DISSIPATED = 0.2  # of M g R omega, by ball-ball normal damping


def count(S, seed):
    """Impacts per ball and revolution in the decade of 1e-3 m (omega R)^2."""
    return PER_BALL * math.exp(SLOPE * float(scale_function(S, EXPONENT)) + SEEDS.get(seed, 0.0))


def spectrum(unit, impacts):
    """One bin in the middle of the decade, and one of a single impact in the next."""
    low, high = [10**-2.75 * unit, 10**-1.9 * unit], [10**-2.25 * unit, 10**-1.1 * unit]
    return ImpactSpectrum(tuple(low), tuple(high), (impacts, 1.0), (1.0, 1.0))


class Charge(SimpleNamespace):
    __hash__ = object.__hash__


def charge(S, seed=1, balls=1000, has_budget=True):
    mill = SimpleNamespace(omega_rad_s=math.sqrt(S), radius_m=3.9 / S)
    case = SimpleNamespace(mill=mill, ball=SimpleNamespace(mass_kg=0.09))
    found = spectrum(0.09 * (mill.omega_rad_s * mill.radius_m) ** 2, balls * count(S, seed))
    ledger = SimpleNamespace(impacts=dict.fromkeys(PAIRINGS, found)) if has_budget else None
    result = SimpleNamespace(ledger=ledger)
    return Charge(S=S, seed=seed, balls=balls, case=case, result=result)


SCALES = Scales(energy=2.0, rate=100.0)


def charges(*ratios, seeds=(1, 2), **of):
    return [charge(S, seed, **of) for S in ratios for seed in seeds]


def test_the_impacts_of_the_physical_mill_are_found():
    found = predict_spectra(charges(1.7, 2.6), charges(1.0, seeds=(0,)), 0.95, SCALES)
    assert [x.pairing for x in found] == list(PAIRINGS)
    (decade,) = found[0].decades
    assert (decade.low_J, decade.high_J) == pytest.approx((2.0e-3, 2.0e-2))
    assert decade.lower < SCALES.rate * PER_BALL < decade.upper
    assert decade.rate == pytest.approx(SCALES.rate * PER_BALL, rel=0.05)
    assert decade.check == pytest.approx(SCALES.rate * PER_BALL)
    assert decade.is_inside
    assert decade.measured[1.7] == pytest.approx(SCALES.rate * count(1.7, 0), rel=1e-6)


def test_few_impacts_widen_the_interval_as_counts_do():
    """A hundredth of the balls has a tenth of the accuracy, whatever the seeds say."""
    many, few = (
        predict_spectra(charges(1.0, 2.6, balls=balls), [], 0.95, SCALES)[0].decades[0]
        for balls in (10_000, 100)
    )
    width = [math.log(x.upper / x.lower) for x in (many, few)]
    assert width[1] == pytest.approx(10.0 * width[0], rel=0.2)


def test_decades_of_few_impacts_are_left_out():
    with pytest.raises(ExtrapolationError, match="fewer than 10 impacts"):
        predict_spectra(charges(1.7, 2.6, balls=1), [], 0.95, SCALES)


def test_charges_without_an_energy_budget_are_refused():
    some = [*charges(1.7), *charges(2.6, has_budget=False)]
    with pytest.raises(ExtrapolationError, match="ledger = true"):
        predict_spectra(some, [], 0.95, SCALES)


def test_single_seeds_are_refused():
    with pytest.raises(ExtrapolationError, match="no value of S has two seeds"):
        predict_spectra(charges(1.7, 2.6, seeds=(1,)), [], 0.95, SCALES)


def write_budget(folder, case):
    """A budget in which normal damping between balls takes a share of M g R omega."""
    mill, mass = case["mill"], case["ball"]["mass_kg"] * case["ball"]["count"]
    power = mass * mill["gravity_m_s2"] * mill["radius_m"] * mill["omega_rad_s"]
    angle = np.array([0.0, 2.0 * math.pi])
    time = angle / mill["omega_rad_s"]
    columns = {name: np.zeros(2) for name in REQUIRED["ledger"]}
    columns |= {"step": np.array([0, 1]), "time_s": time, "mill_angle_rad": angle}
    columns["mill_work_J"] = 0.36 * power * time
    share = DISSIPATED * (1.0 + 0.1 * float(scale_function(case["S"], EXPONENT)))
    columns["ball_ball_dissipated_normal_J"] = share * (1.0 + SEEDS[case["seed"]]) * power * time
    rows = zip(*columns.values(), strict=True)
    text = "\n".join([",".join(columns), *(",".join(f"{x:.17g}" for x in row) for row in rows), ""])
    (folder / "ledger.csv").write_text(text)
    unit = case["ball"]["mass_kg"] * (mill["omega_rad_s"] * mill["radius_m"]) ** 2
    impacts = case["ball"]["count"] * count(case["S"], case["seed"])
    head = (
        "mill_angle_from_rad,mill_angle_to_rad,pairing,energy_low_J,energy_high_J,impacts,energy_J"
    )
    rows = [f"0,{math.tau},{x},{3e-3 * unit},{6e-3 * unit},{impacts},1" for x in PAIRINGS]
    (folder / "impacts.csv").write_text("\n".join([head, *rows, ""]))


@pytest.fixture(scope="module")
def mills(tmp_path_factory):
    """S = 1, 1.696 and 2.6 with energy budgets, two seeds each. Read only."""
    runs, names = tmp_path_factory.mktemp("mills"), []
    for S in (1.0, 1.696, 2.6):
        for seed in SEEDS:
            case = charge_case(S, seed)
            case["deck"]["ledger"] = "on"
            folder = write_case(runs, case, columns_of(case))
            write_budget(folder, case)
            finish_case(folder)
            names.append(folder.name)
    write_campaign(runs, names)
    return runs


def test_the_dissipation_of_each_pairing_and_cause_is_predicted(mills):
    prediction = predict([mills], leave_out_physical=True)
    normal = prediction["dissipated_ball_ball_normal"]
    whole = DISSIPATED * 1e-3 * prediction.mill.power_scale
    assert normal.check == pytest.approx(whole, rel=2e-3)
    assert normal.value == pytest.approx(whole, rel=0.02) and normal.is_inside
    names = [row.observable.name for row in prediction.numbers]
    assert sum(name.startswith("dissipated_") for name in names) == 6
    assert prediction["dissipated_ball_wall_rolling"].value == pytest.approx(0.0, abs=1e-9)


def test_the_command_prints_the_impacts(mills):
    line = ["predict", str(mills), "--check"]
    done = CliRunner().invoke(app, line)
    assert done.exit_code == 0, done.output
    assert "Impacts per second, ball-ball" in done.output
    assert sum("dissipated," in line for line in done.output.splitlines()) >= 6


def test_the_physical_mill_has_the_impacts_of_all_its_balls(mills):
    """Impacts per ball and revolution times balls and revolutions per second, by hand."""
    prediction = predict([mills], leave_out_physical=True)
    mill = prediction.mill
    (decade,) = prediction.spectra[0].decades
    expected = PER_BALL * mill.balls * mill.omega / math.tau
    assert decade.rate == pytest.approx(expected, rel=0.05)
    ball = mill.mass / mill.balls
    low = 1e-3 * ball * (mill.omega * mill.radius) ** 2
    assert decade.low_J == pytest.approx(low, rel=1e-6)
    assert decade.check == pytest.approx(expected, rel=2e-3)
    document = prediction.document()["impacts"][0]
    assert document["decades"][0]["is_inside"] is True
