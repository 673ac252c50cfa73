"""Definitions compared by how they extrapolate, on values and maps that follow a known law."""

from dataclasses import dataclass

import numpy as np
import pytest

from millscale.analysis.shapes.curtain import RESOLUTION
from millscale.analysis.shapes.solid_fraction import Grid
from millscale.validate.definitions import Definition, Measured, maps_of, row_of

ANGLE = Definition("shoulder", "made up", 10.0, "deg")
AREA = Grid(RESOLUTION).step ** 2


@dataclass(frozen=True)
class Mill:
    S: float
    seed: int


def measured(value, field=None):
    """Two seeds of each S that differ by 1 % of their value; S = 1 has one."""
    nothing = np.zeros((1, 1))
    return {
        Mill(S, seed): Measured(
            {ANGLE: value(S) * (1.0 + 0.01 * (seed - 1.5))}, nothing if field is None else field(S)
        )
        for S, seed in ((1.0, 1.5), (1.7, 1), (1.7, 2), (2.6, 1), (2.6, 2))
    }


def test_values_that_follow_the_law_are_inside_and_those_that_do_not_are_not():
    follows = row_of(ANGLE, measured(lambda S: 1.2 + 0.1 * S))
    assert follows["physical"] == pytest.approx(13.0)
    assert follows["is_inside"] and follows["is_monotonic"]
    assert [value["runs"] for value in follows["by_S"]] == [1, 2, 2]
    assert follows["by_S"][1]["deviation"] == pytest.approx(10.0 * 1.37 * 0.01 / np.sqrt(2.0))
    assert len(follows["predicted"]["weights"]) == 2  # S = 1 is not used
    assert follows["predicted"]["lower"] < 13.0 < follows["predicted"]["upper"]
    bent = row_of(ANGLE, measured(lambda S: {1.0: 2.0, 1.7: 1.2, 2.6: 1.3}[S]))
    assert not bent["is_inside"] and not bent["is_monotonic"]


def blob(x, share):
    """A map with a share of the balls in a square."""
    nodes = Grid(RESOLUTION).nodes
    field = np.zeros((nodes.size, nodes.size))
    at = int(np.argmin(np.abs(nodes - x)))
    field[at : at + 4, at : at + 4] = share / 16.0 / AREA
    return field


def test_maps_that_differ_in_their_share_alone_are_equal_once_normalized():
    rows = {row["map"]: row for row in maps_of(measured(lambda S: 1.0, lambda S: blob(0.2, S)))}
    assert rows["S = 2.6"]["raw"] == pytest.approx(0.5 * 1.6)
    assert rows["S = 2.6"]["normalized"] == pytest.approx(0.0, abs=1e-12)
    assert rows["S = 2.6"]["between_two_seeds"] == pytest.approx(0.0, abs=1e-12)
    linear = rows["S = 1.7 and 2.6, p = 1"]
    assert linear["share"] == pytest.approx(1.0)
    assert linear["raw"] == pytest.approx(0.0, abs=1e-12)
    assert rows["S = 1.7 and 2.6, p = 0"]["share"] < 1.0


def test_maps_without_common_part_are_a_whole_distance_apart():
    rows = maps_of(measured(lambda S: 1.0, lambda S: blob(0.3 * S, 0.1)))
    near = next(row for row in rows if row["map"] == "S = 1.7")
    assert near["normalized"] == pytest.approx(1.0)
    (linear,) = (row for row in rows if row["map"].endswith("p = 1"))
    assert linear["normalized"] == pytest.approx(1.0)  # negative balls do not count
    assert near["raw"] == near["share_times_normalized"] == pytest.approx(1.0)
