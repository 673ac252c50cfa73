"""Words of captions, and the curves that a figure of many cases has."""

from types import SimpleNamespace

from millscale.report.captions import charges_of, scales_of, words
from millscale.report.images import MOST_CURVES, spread


def case(S, balls=1, seed=1):
    return SimpleNamespace(S=S, balls=balls, seed=seed)


def test_few_values_of_S_are_listed_and_many_by_their_ends():
    assert scales_of([case(2.6), case(1.0), case(1.3), case(1.3)]) == "S = 1, 1.3, 2.6"
    many = [case(1.0 + 0.1 * i) for i in range(17)]
    assert scales_of(many) == "17 S from 1 to 2.6"
    assert words("constant-gravity") == "constant gravity"


def test_charges_are_named_with_their_balls_and_seeds():
    one = [case(2.6, 13370, 2)]
    assert charges_of(one) == "S = 2.6; 13,370 balls; seed 2"
    several = [*one, case(1.0, 231461, 1)]
    assert charges_of(several) == "S = 1, 2.6; 13,370 to 231,461 balls; seeds 1, 2"


def test_a_figure_of_many_cases_has_curves_from_the_first_to_the_last():
    cases = [case(1.0 + 0.01 * i) for i in range(167)]
    shown = spread(cases)
    assert len(shown) == MOST_CURVES == len({x.S for x in shown})
    assert (shown[0], shown[-1]) == (cases[0], cases[-1])
    assert spread(cases[:MOST_CURVES]) == cases[:MOST_CURVES]
