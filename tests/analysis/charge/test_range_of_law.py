"""Scaled mills whose liner no longer holds whole balls are not used."""

import pytest

from millscale.analysis.charge.range_of_law import outside_range
from millscale.errors import PredictionError
from millscale.prediction.predict import predict
from millscale.runs.case_file import Case
from millscale.runs.typed import as_typed
from synthetic_mills import SEEDS, charge_case, write_mills

INSIDE = {
    "lifter_height_over_ball_diameter": 2.0,
    "groove_width_over_ball_diameter": 4.0,
    "ball_radius_over_mill_radius": 0.02,
}


def case_with(S=2.0, lifters=None, **groups):
    case = charge_case(S, 1)
    case["groups"] |= INSIDE | groups
    if lifters is not None:
        case["mill"]["lifters"] = lifters
    return as_typed(Case, case)


def test_a_mill_inside_all_limits_is_used():
    assert outside_range(case_with()) == ""


@pytest.mark.parametrize(
    ("groups", "words"),
    [
        ({"lifter_height_over_ball_diameter": 0.8}, ["0.8 ball diameters high", "S up to 1.6"]),
        ({"groove_width_over_ball_diameter": 1.5}, ["1.5 ball diameters wide", "S up to 1.5"]),
        ({"ball_radius_over_mill_radius": 0.04}, ["radius is 25 ball radii", "S up to 1.66"]),
        ({"lifter_height_over_ball_diameter": 0.4}, ["run the physical mill, S = 1"]),
        (
            {"lifter_height_over_ball_diameter": 0.8, "groove_width_over_ball_diameter": 1.2},
            ["high, at least 1 are needed and its grooves", "S up to 1.2"],
        ),
    ],
)
def test_a_mill_beyond_a_limit_says_which_and_the_largest_S(groups, words):
    reason = outside_range(case_with(**groups))
    assert all(word in reason for word in words), reason


def test_the_physical_mill_is_always_inside():
    assert outside_range(case_with(S=1.0, lifter_height_over_ball_diameter=0.3)) == ""


def test_a_plain_drum_has_no_limit_of_lifters():
    assert (
        outside_range(
            case_with(
                lifters=0,
                lifter_height_over_ball_diameter=0.0,
                groove_width_over_ball_diameter=0.0,
            )
        )
        == ""
    )


def test_a_prediction_leaves_such_mills_out_and_says_why(tmp_path):
    flat = {"groups__lifter_height_over_ball_diameter": 0.8}
    write_mills(
        tmp_path,
        *(charge_case(1.696, seed) for seed in SEEDS),
        *(charge_case(2.6, seed, **flat) for seed in SEEDS),
    )
    with pytest.raises(PredictionError) as error:
        predict([tmp_path])
    assert "S = 1.696 alone" in str(error.value)
    assert "its lifters are 0.8 ball diameters high, at least 1 are needed" in str(error.value)
