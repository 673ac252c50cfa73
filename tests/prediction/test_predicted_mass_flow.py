"""Mass in the monitoring box over a lifter pitch, from made-up series that follow a known law."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from millscale.analysis.charge import groove_flow
from millscale.analysis.charge.groove_flow import PHASES, box_angle, pitch_masses
from millscale.prediction.extrapolation import ExtrapolationError, scale_function
from millscale.prediction.mass_flow import predict_mass_flow
from millscale.prediction.predict import predict
from millscale.prediction.selection import usable_charges
from synthetic_mills import SEEDS, charge_case, columns_of, write_mills

SHARE, SLOPE, EXPONENT, LIFTERS = 0.010, -1e-3, 0.9, 25


def share(S, seed, angle):
    """The mass rises and falls once in a pitch; the seeds lie a thousandth apart."""
    mean = (SHARE + SLOPE * float(scale_function(S, EXPONENT))) * (1.0 + SEEDS[seed])
    return mean * (1.0 + 0.4 * np.cos(LIFTERS * angle))


@pytest.fixture
def mills(tmp_path, monkeypatch):
    """Writes mills of S = 1, 1.696 and 2.6 whose toe is at an angle [rad]; returns the folder."""

    def write(toe=3.9, seeds=SEEDS, ratios=(1.0, 1.696, 2.6), **changes):
        def columns(case, *given):
            found = columns_of(case, *given)
            angle = found["mill_angle_rad"]
            found["toe_angle_rad"] = toe * np.ones_like(angle)
            found["box_fixed_mass_fraction"] = share(case["S"], case["seed"], angle)
            return found

        monkeypatch.setattr("synthetic_mills.columns_of", columns)
        return write_mills(
            tmp_path, *(charge_case(S, seed, **changes) for S in ratios for seed in seeds)
        )

    return write


def split(runs):
    charges, _ = usable_charges([runs])
    return [x for x in charges if x.S > 1.0], [x for x in charges if x.S == 1.0]


def test_the_angle_of_the_box_is_that_of_a_groove(mills):
    """Between a groove's foot and its mouth over their radii, by hand from the paper's liner."""
    (charge, *_), _ = split(mills())
    angle = box_angle(charge.case)
    assert 0.635 / 3.9 < angle < 2.0 * math.pi / LIFTERS


def test_the_curve_of_the_physical_mill_is_found_at_each_phase(mills):
    used, physical = split(mills())
    found = predict_mass_flow(used, physical)
    assert found.angles.shape == (PHASES,)
    expected = np.mean([pitch_masses(charge).mean(axis=0) for charge in physical], axis=0)
    # The samples lie an eighth of a pitch apart, which flattens the wave by a fortieth.
    wave = SHARE * (1.0 + 0.4 * np.cos(LIFTERS * found.angles))
    assert_allclose(expected, wave, atol=0.03 * SHARE)
    assert_allclose(found.values, expected, rtol=5e-3)
    assert (np.abs(found.values - expected) <= found.half_widths).all()
    assert found.inside == 1.0
    assert found.check < 0.2 * found.nearest


def test_the_nearest_curve_differs_by_the_error_of_its_mill(mills):
    used, physical = split(mills())
    error = abs(SLOPE * float(scale_function(1.696, EXPONENT))) / SHARE
    rms = error * math.sqrt(1.0 + 0.5 * 0.4**2)
    assert predict_mass_flow(used, physical).nearest == pytest.approx(rms, rel=0.02)


def test_single_seeds_take_their_noise_from_the_pitches(mills):
    used, _ = split(mills(seeds=(1,)))
    assert predict_mass_flow(used).noise_from == "lifter pitches"


def test_the_mass_flow_is_the_mass_in_the_box_times_speed_over_angle(mills):
    prediction = predict([mills()], leave_out_physical=True)
    flow, mill = prediction["mass_flow"], prediction.mill
    by_hand = SHARE * mill.mass * mill.omega / box_angle(prediction.runs[0].case)
    assert flow.check == pytest.approx(by_hand, rel=1e-3)
    assert flow.value == pytest.approx(by_hand, rel=0.01)
    assert flow.is_inside
    masses = prediction.document()["mass_in_box"]["masses_kg"]
    assert np.mean(masses) == pytest.approx(SHARE * mill.mass, rel=0.01)


def test_a_toe_at_the_box_is_refused(mills):
    """The box of this liner ends about 5 degrees behind the bottom."""
    toe = math.pi + math.radians(6.0)
    used, _ = split(mills(toe=toe))
    with pytest.raises(ExtrapolationError, match=r"toe of S = 1.696, at 186.0 deg, has reached"):
        predict_mass_flow(used)


def test_grooves_that_hold_one_layer_of_balls_are_refused(mills):
    shallow = {"groups__lifter_height_over_ball_diameter": 1.9}
    used, _ = split(mills(**shallow))
    with pytest.raises(
        ExtrapolationError, match=r"S = 1.696 are 1.9 ball diameters deep, at least 2"
    ):
        predict_mass_flow(used)


def test_the_mean_flow_is_refused_with_the_curve(mills):
    prediction = predict([mills(toe=math.pi)])
    assert "has reached the monitoring box" in prediction["mass_flow"].refused
    assert "has reached the monitoring box" in prediction.mass_flow_refused


def test_a_series_without_the_box_is_refused(tmp_path):
    used, _ = split(write_mills(tmp_path, charge_case(1.696, 1), charge_case(2.6, 1)))
    with pytest.raises(ExtrapolationError, match="no box"):
        predict_mass_flow(used)


def test_the_error_of_the_mass_flow_is_that_of_the_pitches(mills, monkeypatch):
    (charge, *_), _ = split(mills())
    means = np.array([1.0, 3.0, 1.0, 3.0, 1.0, 3.0, 1.0, 3.0])
    masses = means[:, None] * np.ones((8, PHASES))
    monkeypatch.setattr(groove_flow, "pitch_masses", lambda _: masses)
    by_hand = np.std(means, ddof=1) / math.sqrt(8.0) / box_angle(charge.case)
    assert groove_flow.groove_flow_error(charge) == pytest.approx(by_hand)
