"""Scaled mills and predictions against S = 1: made-up mills whose torque follows known laws."""

import itertools
import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import binom
from typer.testing import CliRunner

from millscale.cli.main import app
from millscale.errors import PredictionError
from millscale.prediction.extrapolation import scale_function
from millscale.prediction.observables import OBSERVABLES
from millscale.validate import differences
from millscale.validate.coverage import (
    ALL,
    ONE_NEAR,
    Interval,
    Trial,
    binomial_interval,
    coverage,
    trials_of,
)
from millscale.validate.differences import comparisons, deviations, error_of
from millscale.validate.friction_matched import medians, rows_of
from millscale.validate.gain import Single, cost_at_equal_error
from millscale.validate.mills import Mill, load_mills, processor_time
from synthetic_mills import COST_AT_1, SEEDS, SLOPE, TORQUE, charge_case, torque_number, write_mills

RATIOS = (1.696, 2.6)
RELATIVE_SEED = 1e-3 * math.sqrt(2.0)  # standard deviation of seeds that differ by +-1e-3


def campaign(runs, policy, ratios, share, scheme="constant-gravity", seeds=SEEDS, **changes):
    """Write scaled mills whose torque error is a share of that of `torque_number`."""

    def torque(S, seed):
        return TORQUE + share * (torque_number(S, seed) - TORQUE)

    cases = [charge_case(S, seed, scheme, policy, **changes) for S in ratios for seed in seeds]
    runs.mkdir()
    return write_mills(runs, *cases, torque=torque)


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """S = 1, scaled mills of the paper, and of matched friction with half of its error."""
    base = tmp_path_factory.mktemp("mills")
    return [
        campaign(base / "physical", "paper", (1.0,), 1.0),
        campaign(base / "paper", "paper", RATIOS, 1.0),
        campaign(base / "matched", "friction-matched", RATIOS, 0.5),
    ]


@pytest.fixture(scope="module")
def mill(folders) -> Mill:
    (found,), _ = load_mills(folders)
    return found


def power(mill):
    return next(one for one in comparisons(mill) if one.name == "power")


def test_half_of_the_error_is_a_ratio_of_one_half(mill):
    rows = [row for row in rows_of(mill) if row.observable == "power" and len(row.ratios) == 1]
    assert [row.ratios for row in rows] == [(1.696,), (2.6,)]
    for row in rows:
        law = SLOPE * float(scale_function(row.ratios[0], 0.3)) / TORQUE
        assert row.paper.value == pytest.approx(100.0 * law, rel=0.01)
        assert row.ratio == pytest.approx(0.5, abs=0.02)
        assert not row.only_chance
    by_name = {row.of: row for row in medians(rows)}
    assert by_name["S = 2.6"].ratio == pytest.approx(0.5, abs=0.02)
    assert by_name["median over mills"].rows == 1


def test_an_extrapolation_is_compared_as_well(mill):
    (row,) = (x for x in rows_of(mill) if x.observable == "power" and x.ratios == RATIOS)
    assert abs(row.paper.value) < 0.2 * 100.0 * (torque_number(2.6, 1) / TORQUE - 1.0)
    assert row.paper.chance > row.paper.standard_error > 0.0


def test_two_errors_by_chance_have_no_ratio(tmp_path):
    runs = [
        campaign(tmp_path / "physical", "paper", (1.0,), 1.0),
        campaign(tmp_path / "a", "paper", RATIOS, 1e-3),
        campaign(tmp_path / "b", "friction-matched", RATIOS, -1e-3),
    ]
    (found,), _ = load_mills(runs)
    rows = [row for row in rows_of(found) if row.observable == "power" and len(row.ratios) == 1]
    assert rows and all(row.only_chance and row.ratio is None for row in rows)
    assert medians(rows)[0].chance == 1


def test_the_physical_mill_serves_both_schemes(tmp_path, folders):
    speed = [
        campaign(tmp_path / "a", "paper", RATIOS, 1.0, "constant-speed"),
        campaign(tmp_path / "b", "friction-matched", RATIOS, 0.5, "constant-speed"),
    ]
    (found,), excluded = load_mills([*folders, *speed])
    schemes = {row.scheme for row in rows_of(found)}
    assert schemes == {"constant-gravity", "constant-speed"}
    assert excluded == {}


def test_mills_are_told_apart_and_one_without_its_physical_mill_is_left_out(tmp_path, folders):
    other = campaign(tmp_path / "other", "paper", RATIOS, 1.0, physical__radius_m=4.0)
    mills, excluded = load_mills([*folders, other])
    assert [x.name for x in mills] == ["synthetic"]
    assert len(excluded) == 4
    assert "no run of S = 1 of its mill" in next(iter(excluded.values()))
    with pytest.raises(PredictionError, match="no mill has both"):
        load_mills([other])


def test_unsteady_charges_are_used_if_asked_for(tmp_path):
    cases = [charge_case(S, seed) for S in (1.0, 2.6) for seed in SEEDS]
    write_mills(tmp_path, *cases, unsteady={cases[-1]["id"]})
    (steady,), excluded = load_mills([tmp_path])
    assert len(steady.charges) == 3
    assert "drifts" in excluded[f"{tmp_path.name}/{cases[-1]['id']}"]
    (every,), excluded = load_mills([tmp_path], every=True)
    assert len(every.charges) == 4 and excluded == {}


def test_the_chance_of_a_number_is_the_standard_error_of_a_difference(mill):
    """Two seeds each: s of a run is 0.14 % of the torque, and s sqrt(1/2 + 1/2) of a difference."""
    one = power(mill)
    deviation = deviations(one, mill, "constant-gravity")
    number = torque_number(2.6, 1) / (1.0 + SEEDS[1])
    # Seeds of the matched mill differ by half as much: their squares are pooled with the paper's.
    pooled = 100.0 * RELATIVE_SEED * number / TORQUE * math.sqrt(0.5 * (1.0 + 0.25))
    assert deviation.at(2.6) == pytest.approx(pooled, rel=1e-3)
    physical = deviation.at(1.0)
    assert physical == pytest.approx(100.0 * RELATIVE_SEED, rel=1e-3)
    seeds = mill.scaled["constant-gravity", "paper"][2.6]
    found = error_of(one, one.mean(seeds), [(1.0, seeds)], mill, deviation)
    assert found.chance == pytest.approx(math.sqrt(0.5 * pooled**2 + 0.5 * physical**2), rel=1e-3)
    assert found.standard_error == pytest.approx(pooled / math.sqrt(2.0), rel=1e-3)


def test_an_S_without_two_seeds_has_the_deviation_of_the_nearest(mill):
    one = power(mill)
    single = Mill(tuple(x for x in mill.charges if x.S != 1.696 or x.seed == 1), mill.values)
    both = deviations(one, mill, "constant-gravity")
    assert both.at(1.696) != both.at(2.6)
    assert deviations(one, single, "constant-gravity").at(1.696) == both.at(2.6)


def test_the_contour_is_compared_along_the_normals(mill, monkeypatch):
    turn = np.linspace(-2.0, 0.5, 2000)

    def arc(charge):
        return (0.7 - 0.01 * (charge.S - 1.0)) * np.column_stack([np.cos(turn), np.sin(turn)])

    monkeypatch.setattr(differences, "mean_contour", arc)
    found = {one.name: one for one in comparisons(mill)}
    seeds = mill.scaled["constant-gravity", "paper"][2.6]
    for name in ("contour_mean", "contour_largest"):
        difference = found[name].mean(seeds)
        for sign in (-1.0, 1.0):
            assert found[name].size(sign * difference) == pytest.approx(1.6, abs=0.01)
    surface = SimpleNamespace(contour=SimpleNamespace(points=arc(SimpleNamespace(S=1.5))))
    difference = found["contour_mean"].of_prediction(surface)
    assert found["contour_mean"].size(difference) == pytest.approx(0.5, abs=0.01)


def test_the_mass_in_the_box_is_compared_over_a_pitch(mill, monkeypatch):
    """A curve 2 % higher, and one that is as high but half a pitch late."""
    phases = 2.0 * math.pi * (np.arange(20) + 0.5) / 20

    def masses(charge):
        late = math.pi * (charge.S == 1.696)
        return (1.0 + 0.02 * (charge.S == 2.6)) * (0.1 + 0.01 * np.sin(phases + late))[None, :]

    monkeypatch.setattr(differences, "pitch_masses", masses)
    names = [x.name for x in comparisons(mill)]
    curves = [name for name in names if name not in {row.name for row in OBSERVABLES}]
    assert curves == ["mass_in_box"] and len(set(names)) == len(names)
    one = next(x for x in comparisons(mill) if x.name == "mass_in_box")
    of_paper = mill.scaled["constant-gravity", "paper"]
    higher = 2.0 * math.sqrt(1.0 + 0.5 * 0.1**2)
    assert one.size(one.mean(of_paper[2.6])) == pytest.approx(higher)
    assert one.size(one.mean(of_paper[1.696])) == pytest.approx(20.0 / math.sqrt(2.0))


def law_mills(ratios, b=0.04):
    """Mills of error b (S^p - 1) / p at p = 1/2 and cost 900 S^-3."""
    return [Single(S, COST_AT_1 * S**-3, b * float(scale_function(S, 0.5))) for S in ratios]


@pytest.mark.parametrize("S", [1.0, 1.2, 1.696, 2.0, 2.6])
def test_the_cost_at_equal_error_is_that_of_the_S_of_this_error(S):
    mills = law_mills((1.0, 1.696, 2.6))
    error = 0.04 * float(scale_function(S, 0.5))
    assert cost_at_equal_error(mills, error) == pytest.approx(COST_AT_1 * S**-3, rel=1e-9)


def test_a_large_error_costs_the_smallest_mill():
    mills = law_mills((1.0, 1.696, 2.6))
    assert cost_at_equal_error(mills, 1.0) == mills[-1].cost_s


def test_an_error_that_changes_its_sign_is_no_gain():
    mills = [*law_mills((1.0, 1.696)), Single(2.6, COST_AT_1 * 2.6**-3, 0.0)]
    assert cost_at_equal_error(mills, mills[1].error) == pytest.approx(mills[2].cost_s)
    assert cost_at_equal_error(mills, 0.5 * mills[1].error) > mills[1].cost_s


@pytest.mark.parametrize(("inside", "count"), [(0, 8), (8, 8), (39, 42), (5, 9)])
def test_the_binomial_interval_has_tails_of_one_fortieth(inside, count):
    lower, upper = binomial_interval(inside, count)
    if inside > 0:
        assert binom.sf(inside - 1, count, lower) == pytest.approx(0.025)
    if inside < count:
        assert binom.cdf(inside, count, upper) == pytest.approx(0.025)
    assert lower <= inside / count <= upper


def test_every_pair_is_tried_with_all_seeds_and_with_single_near_ones(mill):
    trials = list(trials_of(mill))
    kinds = [(x.policy, x.runs, x.seeds) for x in trials if x.policy == "paper"]
    one = ("paper", ((1.696, 1), (2.6, 2)), ONE_NEAR)
    assert kinds == [("paper", ((1.696, 2), (2.6, 2)), ALL), one, one]


def test_a_trial_costs_settling_and_rotation_of_its_runs(mill):
    first = next(x for x in trials_of(mill) if x.policy == "paper")
    expected = sum(2 * 1.1 * COST_AT_1 / S**3 for S in RATIOS)
    assert first.cost_s == pytest.approx(expected)
    assert processor_time(mill.physical[0]) == pytest.approx(1.1 * COST_AT_1)


def test_power_and_torque_count_once_and_power_is_inside(mill):
    trial = next(x for x in trials_of(mill) if x.policy == "paper" and x.seeds == ALL)
    rows = {row.observable: row for row in trial.intervals}
    assert not {"torque", "specific_power"} & rows.keys()
    assert rows["power"].is_inside and rows["power"].half_width > abs(rows["power"].error)
    assert rows["power"].truth_error > 0.0


def test_intervals_inside_outside_and_refused_are_counted():
    def row(value, truth_error=None, refused=""):
        """Return an interval of half width 1 about a value; S = 1 has 0."""
        known = {} if refused else {"value": value, "lower": value - 1.0, "upper": value + 1.0}
        return Interval(
            "power", "power", "kW", refused, 0.0, truth_error, **known, single_cost_s=30.0
        )

    rows = (row(0.5), row(-0.25), row(-1.5, 0.3), row(1.5, 0.2), row(0.0, refused="no noise"))
    trial = Trial(
        "a", "constant-gravity", "paper", ((1.7, 1), (2.6, 2)), ONE_NEAR, 20.0, rows, None, None
    )
    found, *_ = coverage([trial], {"a": 100.0}, {"a": 500.0})
    assert (found.inside, found.intervals, found.refused, found.within_chance) == (2, 4, 1, 1)
    assert found.half_width_over_error == pytest.approx(0.5 * (1.0 / 1.5 + 1.0 / 0.5))
    assert (found.gain, found.cost_share) == (1.5, 0.2)
    assert (found.lower, found.upper) == binomial_interval(2, 4)
    within = [x.of for x in coverage([trial], {"a": 100.0}, {"a": 300.0}) if "whole" in x.of]
    assert within == ["constant-gravity, paper: at most 1/10 of the whole mill"]


def test_an_interval_that_misses_is_counted(folders, tmp_path):
    """At p = 3 the error grows faster than the prior of p allows."""

    def torque(S, seed):
        return (TORQUE + 0.01 * float(scale_function(S, 3.0))) * (1.0 + 0.1 * SEEDS[seed])

    cases = [charge_case(S, seed) for S in (1.0, *RATIOS) for seed in SEEDS]
    (found,), _ = load_mills([write_mills(tmp_path, *cases, torque=torque)])
    trials = [x for x in trials_of(found) if x.seeds == ALL]
    row = next(row for row in trials[0].intervals if row.observable == "power")
    assert row.is_inside is False
    by_label = {x.of: x for x in coverage(trials, {found.name: 1.0}, {found.name: 1.0})}
    of_power = by_label["constant-gravity, paper: power"]
    assert (of_power.inside, of_power.intervals) == (0, 1)


@pytest.mark.parametrize("command", ["friction-matched", "prediction"])
def test_the_commands_write_numbers_and_figures(folders, tmp_path, command):
    to = tmp_path / "found.json"
    line = ["validate", command, *map(str, folders), "--to", str(to)]
    done = CliRunner().invoke(app, line)
    assert done.exit_code == 0, done.output
    assert "| power | %" in done.output or "| constant-gravity, paper |" in done.output
    content = json.loads(to.read_text())
    assert {"command", "commit", "machine", "date", "mills", "excluded"} <= content.keys()
    assert to.with_suffix(".png").stat().st_size > 1000
    names = {row["observable"] for row in itertools.chain(
        content.get("rows", ()), *(x["intervals"] for x in content.get("trials", ()))
    )}  # fmt: skip
    assert "power" in names
