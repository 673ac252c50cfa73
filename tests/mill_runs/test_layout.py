"""Which stages have to run, from the files alone."""

import os

import pytest

from mill_runs.layout import CASE_FILE, STAGES, unfinished


@pytest.fixture(params=sorted(STAGES))
def kind(request):
    return request.param


@pytest.fixture
def folder(tmp_path, kind):
    """A finished case whose products are a second apart, stage after stage."""
    names = [[CASE_FILE], *(stage.products for stage in STAGES[kind])]
    for second, products in enumerate(names, 1):
        for name in products:
            (tmp_path / name).touch()
            os.utime(tmp_path / name, (second, second))
    return tmp_path


def left(folder, kind, **options):
    return [stage.name for stage, _ in unfinished(folder, kind, **options)]


def names_of(kind):
    return [stage.name for stage in STAGES[kind]]


def test_every_stage_reads_a_product_of_the_one_before(kind):
    for before, stage in zip(STAGES[kind], STAGES[kind][1:], strict=False):
        assert set(before.products) & set(stage.inputs), stage.name


def test_every_input_is_made_before_it_is_read(kind):
    made = {CASE_FILE}
    for stage in STAGES[kind]:
        assert set(stage.inputs) <= made, stage.name
        made.update(stage.products)


def test_a_finished_case_has_nothing_left(folder, kind):
    assert left(folder, kind) == []


def test_an_empty_folder_has_everything_left(tmp_path, kind):
    assert left(tmp_path, kind) == names_of(kind)


def test_any_missing_product_leaves_its_stage_and_all_later_ones(folder, kind):
    for number, stage in enumerate(STAGES[kind]):
        for product in stage.products:
            (folder / product).rename(folder / "away")
            assert left(folder, kind) == names_of(kind)[number:], product
            (folder / "away").rename(folder / product)


def test_a_newer_case_leaves_everything(folder, kind):
    os.utime(folder / CASE_FILE, (100, 100))
    assert left(folder, kind) == names_of(kind)


def test_a_case_about_to_change_leaves_everything(folder, kind):
    assert left(folder, kind, case_changed=True) == names_of(kind)


def test_an_edited_deck_leaves_the_stages_that_run_it(folder, kind):
    deck = "mill.in" if kind == "multi-ball" else "single_ball.in"
    os.utime(folder / deck, (100, 100))
    assert left(folder, kind) == ["rotate", "result"]
