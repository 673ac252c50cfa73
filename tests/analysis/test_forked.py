"""Work in forked processes."""

import os

import pytest

from millscale.analysis import forked as module
from millscale.analysis.forked import forked
from millscale.runs.untrusted import RunFolderError


@pytest.fixture(autouse=True)
def two_processors(monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1})


def test_results_are_in_order_and_of_other_processes():
    found = forked(lambda x: (x * x, os.getpid()), list(range(20)))
    assert [square for square, _ in found] == [x * x for x in range(20)]
    assert os.getpid() not in {process for _, process in found}


def test_a_single_item_and_nested_work_stay_in_the_process():
    assert forked(lambda _: os.getpid(), [1]) == [os.getpid()]
    nested = forked(lambda _: (os.getpid(), forked(lambda _: os.getpid(), [1, 2])), [1, 2])
    assert all(inner == [outer, outer] for outer, inner in nested)


def test_an_error_of_a_runs_folder_comes_back_whole():
    def fails(path):
        raise RunFolderError(path, "damaged", "run again")

    with pytest.raises(RunFolderError, match="damaged; run again") as caught:
        forked(fails, ["a/b", "c"])
    assert str(caught.value.path) == "a/b"
    assert module._work is None
