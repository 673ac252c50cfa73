"""Lacey's mixing index of arrangements whose index is known."""

import itertools

import numpy as np
import pytest
from numpy.testing import assert_allclose

from millscale.analysis.shapes.mixing import (
    Mixing,
    cells_of,
    index_after,
    mixing,
    mixing_index,
)
from millscale.runs.case_file import load_case
from millscale.runs.untrusted import RunFolderError
from synthetic_case import case_document, finish_case
from synthetic_charge import block, write_charge, write_dump


def test_cells_of_one_kind_each_have_the_index_zero_and_relabelled_cells_the_same():
    cells = np.array([0, 0, 0, 5, 5, 9, 9, 9])
    marked = np.array([1, 1, 1, 0, 0, 1, 1, 1], bool)
    assert mixing_index(cells, marked) == 0.0
    other = np.roll(marked, 1)
    assert mixing_index(cells, other) == mixing_index(-3 * cells, ~other) > 0.0


def test_the_mean_over_all_arrangements_is_one_whatever_the_cells_hold():
    cells = np.array([0, 1, 1, 2, 2, 2, 2, 3])
    found = []
    for chosen in itertools.combinations(range(len(cells)), 3):
        marked = np.isin(np.arange(len(cells)), chosen)
        found.append(mixing_index(cells, marked))
    assert_allclose(np.mean(found), 1.0, rtol=1e-12)


def test_it_is_laceys_index_of_variances():
    generator = np.random.default_rng(3)
    cells, marked = generator.integers(0, 12, 200), generator.random(200) < 0.3
    share, total, kinds = marked.mean(), len(cells), np.unique(cells)
    variance = sum(
        np.mean(cells == cell) * (marked[cells == cell].mean() - share) ** 2 for cell in kinds
    )
    segregated = share * (1.0 - share)
    random = segregated * (len(kinds) - 1) / (total - 1)
    lacey = (segregated - variance) / (segregated - random)
    assert_allclose(mixing_index(cells, marked), lacey, rtol=1e-12)


def test_it_is_how_often_two_balls_of_a_cell_differ_over_two_of_the_charge():
    generator = np.random.default_rng(4)
    cells, marked = np.repeat(np.arange(10), 6), generator.random(60) < 0.5
    pairs = list(itertools.combinations(range(60), 2))
    differ = np.array([marked[i] != marked[j] for i, j in pairs])
    near = np.array([cells[i] == cells[j] for i, j in pairs])
    assert_allclose(mixing_index(cells, marked), differ[near].mean() / differ.mean(), rtol=1e-12)


def test_half_of_the_cells_mixed_gives_about_half_for_any_number_of_balls():
    for balls in (2, 8, 50):
        generator = np.random.default_rng(5)
        cells = np.repeat(np.arange(4000), balls)
        marked = np.where(cells % 4 < 2, cells % 2 == 0, generator.random(cells.size) < 0.5)
        assert_allclose(mixing_index(cells, marked), 0.5, atol=0.02)


@pytest.mark.parametrize(
    ("cells", "marked"), [([0, 1, 2], [1, 0, 1]), ([0, 0, 1], [1, 1, 1]), ([], [])]
)
def test_without_two_balls_in_a_cell_or_two_kinds_there_is_no_index(cells, marked):
    with pytest.raises(ValueError, match="no mixing index"):
        mixing_index(np.array(cells, int), np.array(marked, bool))


def test_two_points_are_in_one_cell_if_no_line_of_the_grid_is_between_them():
    points = np.random.default_rng(6).uniform(-1.0, 1.0, (300, 2))
    cells, corners = cells_of(points, 0.25), np.floor(points / 0.25)
    same = (corners[:, None] == corners).all(axis=2)
    assert ((cells[:, None] == cells) == same).all()


@pytest.fixture
def curve():
    return Mixing(0.1, np.array([0.0, 0.5, 1.0, 1.5]), np.array([0.0, 0.4, 0.3, 0.8]), 20.0)


def test_the_time_to_a_level_is_the_first_between_dumps(curve):
    assert curve.time_to(0.2) == pytest.approx(0.25)
    assert curve.time_to(0.35) == pytest.approx(0.4375)
    assert curve.time_to(0.55) == pytest.approx(1.25)
    assert curve.time_to(0.0) == 0.0
    assert curve.time_to(0.9) is None


def test_the_mean_index_is_that_of_the_lines_between_dumps(curve):
    fine = np.linspace(0.25, 1.4, 100001)
    lines = np.interp(fine, curve.revolutions, curve.index)
    assert curve.mean(0.25, 1.4) == pytest.approx(lines.mean(), rel=1e-4)
    assert curve.mean(0.0, 0.5) == pytest.approx(0.2)
    assert curve.mean(0.6, 0.9) == pytest.approx(0.35)
    assert curve.mean(0.6, 1.6) is None


def test_a_block_that_turns_as_a_whole_mixes_only_in_cells_on_its_dividing_line(tmp_path):
    """The balls of each half stay together."""
    folder = write_charge(tmp_path, "constant-gravity", balls=600)
    finish_case(folder)
    case = load_case(folder)
    (found,) = mixing(folder, case, [0.05])
    assert_allclose(found.revolutions, np.array([0.0, 0.5, 1.0]) / (2.0 * np.pi), atol=2e-3)
    assert found.index[0] == 0.0
    assert (found.index[1:] < 0.2).all()


def test_balls_at_random_places_are_mixed_and_each_dump_counts_its_cells(tmp_path):
    folder = write_charge(tmp_path, "constant-gravity", balls=600)
    document = case_document("multi-ball", "constant-gravity", "paper", 2.6, 600)
    last = sorted((folder / "dump").iterdir())[-1]
    places = np.random.default_rng(7).permutation(block(document, 600))
    write_dump(last, int(last.name.split(".")[1]), places, document | {"ball": {"radius_m": 0.06}})
    finish_case(folder)
    (found,) = mixing(folder, load_case(folder), [0.2])
    assert found.index[-1] == pytest.approx(1.0, abs=0.1)
    assert 600 / 60 < found.balls_per_cell < 600 / 30


def test_a_dump_with_a_strange_ball_is_refused(tmp_path):
    folder = write_charge(tmp_path, "constant-gravity", balls=20)
    last = sorted((folder / "dump").iterdir())[-1]
    last.write_text(last.read_text().replace("\n20 1 ", "\n21 1 "))
    finish_case(folder)
    with pytest.raises(RunFolderError, match="ball 21 of step"):
        mixing(folder, load_case(folder), [0.2])


def test_the_index_of_reports_is_that_of_the_curve(tmp_path):
    folder = write_charge(tmp_path, "constant-gravity", balls=600)
    finish_case(folder)
    case = load_case(folder)
    (curve,) = mixing(folder, case, [0.05])
    for revolutions in (0.03, 0.1, 0.15):
        found = index_after(folder, case, revolutions, 0.05)
        expected = np.interp(revolutions, curve.revolutions, curve.index)
        assert found == pytest.approx(expected)
    assert index_after(folder, case, 1.0, 0.05) is None
    assert index_after(folder, case, 0.1, 1e-6) is None
