"""Groups of seeds against each other."""

import itertools
from dataclasses import dataclass

import pytest

from millscale.analysis.charge.groups import agreement, compare_groups, markdown
from millscale.analysis.charge.measured import Measured
from millscale.analysis.charge.pair_errors import OF_DUMPS, PairErrors
from millscale.analysis.measures import ERRORS, NUMBERS
from millscale.runs.untrusted import RunFolderError


@dataclass(frozen=True)
class Seed:
    """A charge that is a place and a torque: its errors against another are their distance."""

    id: str
    place: float = 0.0
    torque: float = 0.37
    folder: str = "cases"


def distance(a, b):
    apart = abs(a.place - b.place)
    values = dict.fromkeys(error.name for error in ERRORS)
    values |= {"massflow_correlation": 1.0 - apart, "power_error": -apart}
    return PairErrors(values, dict.fromkeys(OF_DUMPS) | {"contour_error_mean": apart})


def compared(first, second):
    seeds = [*first, *second]
    nothing = dict.fromkeys(number.name for number in NUMBERS)
    measured = Measured(
        numbers={seed: nothing | {"torque": seed.torque} for seed in seeds},
        errors={(a, b): distance(a, b) for a, b in itertools.product(seeds, repeat=2)},
    )
    return agreement(first, second, measured)


def test_a_shift_below_the_spread_of_seeds_agrees_and_one_above_does_not():
    first = [Seed("a1", 0.0), Seed("a2", 0.1)]
    near = [Seed("b1", 0.02), Seed("b2", 0.12)]
    far = [Seed("b1", 0.2), Seed("b2", 0.3)]
    for second, agree in ((near, True), (far, False)):
        found = compared(first, second).distances
        assert set(found) == {"contour_error_mean", "power_error", "1 - massflow_correlation"}
        assert {entry.agree for entry in found.values()} == {agree}
    one = found["contour_error_mean"]
    assert one.between == pytest.approx(0.2)  # 0.2, 0.3, 0.1, 0.2
    assert one.within_largest == pytest.approx(0.1)


def test_means_agree_within_the_range_of_seeds():
    first = [Seed("a1", 0.0, 0.370), Seed("a2", 0.1, 0.372)]
    for shift, agree in ((0.001, True), (0.005, False)):
        second = [Seed(f"b{i}", seed.place, seed.torque + shift) for i, seed in enumerate(first)]
        table = compared(first, second)
        (found,) = table.means.values()
        assert found.difference == pytest.approx(-shift)
        assert found.range_of_seeds == pytest.approx(0.002)
        assert found.agree is agree
        assert f"| torque | {-shift:.4f} | 0.0020 | {'yes' if agree else 'no'} |" in markdown(table)


def test_a_case_alone_is_an_error():
    with pytest.raises(RunFolderError, match="one case alone has no spread"):
        compare_groups([Seed("a")], [Seed("b"), Seed("c")])
