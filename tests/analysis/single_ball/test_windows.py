"""Mill angles between which the models of a scheme are compared."""

import copy

import pytest
from numpy.testing import assert_allclose

from millscale.analysis.finished_campaign import load_campaign
from millscale.analysis.single_ball.windows import common_windows
from synthetic_result import with_case, with_result, with_throw


@pytest.fixture
def thrown(runs):
    """Function (id, begin, length, scheme) -> a ball thrown once, at `begin` [rad]."""
    ball = load_campaign(runs).single[0]

    def make(name, begin, length, scheme="constant-gravity"):
        named = with_case(copy.copy(ball), id=name, scheme=scheme)
        if not length:
            return with_result(named, throws=[])
        return with_throw(named, mill_angle_rad=begin, flight_length_rad=length)

    return make


def test_window_begins_with_the_last_throw_and_is_as_long_as_the_paper_s(thrown):
    window = common_windows([thrown("a", 2.5, 1.3), thrown("b", 2.6, 1.2)])["constant-gravity"]
    assert_allclose([window.begin, window.end, window.from_throw], [2.6, 3.577, 0.977])
    assert window.limited_by is None


@pytest.mark.parametrize(
    ("length", "end", "from_throw"), [(0.9, 3.4, 0.9), (1.0, 3.5, 0.977), (0.05, 2.6, 0.05)]
)
def test_window_ends_with_the_first_impact(thrown, length, end, from_throw):
    window = common_windows([thrown("a", 2.5, length), thrown("b", 2.6, 1.2)])["constant-gravity"]
    assert_allclose([window.begin, window.end, window.from_throw], [2.6, end, from_throw])
    assert window.limited_by == "a"


def test_schemes_have_windows_of_their_own_and_idle_cases_none(thrown):
    cases = [thrown("a", 2.5, 0.5), thrown("b", 2.7, 1.2, "constant-speed"), thrown("c", 0.0, 0.0)]
    windows = common_windows([*cases, thrown("d", 0.0, 0.0, "froude")])
    assert set(windows) == {"constant-gravity", "constant-speed"}
    assert windows["constant-speed"].limited_by is None
