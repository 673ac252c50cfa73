"""Links that lead out of a runs folder are found at any depth, and quickly."""

import os
import time

import pytest

from millscale.runs.links import check_folder
from millscale.runs.untrusted import RunFolderError

# Measured: 0.2 s for each. The bound leaves room for a busy machine.
WITHIN_S = 5.0


def folder_at(runs, depth):
    folder = runs.joinpath(*["a"] * depth)
    folder.mkdir(parents=True)
    return folder


@pytest.mark.parametrize("depth", range(12))
def test_a_link_out_is_refused_at_any_depth(tmp_path, depth):
    (folder_at(tmp_path / "runs", depth) / "link").symlink_to(tmp_path / "victim")
    with pytest.raises(RunFolderError, match=r"link: is a link to .*victim; .*remove it"):
        check_folder(tmp_path / "runs")


def test_what_is_nested_too_deep_to_be_checked_is_refused_not_ignored(tmp_path):
    (folder_at(tmp_path / "runs", 12) / "link").symlink_to(tmp_path / "victim")
    with pytest.raises(RunFolderError, match="nested deeper than 12 folders"):
        check_folder(tmp_path / "runs")


@pytest.mark.parametrize(
    "target", ["../../outside", "/dev/zero", "b/../../../outside", "../runs-of-others"]
)
def test_a_link_out_by_any_path_is_refused(tmp_path, target):
    runs = tmp_path / "runs"
    (runs / "a").mkdir(parents=True)
    (runs / "a" / "link").symlink_to(target if target[0] != "." else f"../{target}")
    with pytest.raises(RunFolderError, match="is a link to"):
        check_folder(runs)


def test_a_link_to_a_link_that_leads_out_is_refused(tmp_path):
    runs = tmp_path / "runs"
    (runs / "a").mkdir(parents=True)
    (runs / "a" / "one").symlink_to("two")
    (runs / "a" / "two").symlink_to(tmp_path)
    with pytest.raises(RunFolderError, match="is a link to"):
        check_folder(runs)


def test_links_that_stay_inside_are_accepted_in_a_case_too(tmp_path):
    case = tmp_path / "runs" / "cases" / "one"
    (case / "rotate.part").mkdir(parents=True)
    (case / "rotate.part" / "liner.stl").symlink_to("../liner.stl")
    (case / "other").symlink_to("../two")
    (case / "loop").symlink_to("loop")
    check_folder(case)
    check_folder(tmp_path / "runs")


@pytest.mark.parametrize("what", ["a pipe", "a socket"])
def test_pipes_and_sockets_are_refused(tmp_path, what):
    (folder := tmp_path / "cases" / "one" / "dump").mkdir(parents=True)
    if what == "a pipe":
        os.mkfifo(folder / "x")
    else:
        os.mknod(folder / "x", 0o140600)
    with pytest.raises(RunFolderError, match="x: is a pipe, socket or device"):
        check_folder(tmp_path)


@pytest.mark.parametrize(("cases", "files"), [(10_000, 3), (5, 10_000)])
def test_many_cases_and_many_dumps_are_checked_quickly(tmp_path, cases, files):
    for i in range(cases):
        (folder := tmp_path / "cases" / f"case-{i}").mkdir(parents=True)
        for j in range(files):
            os.close(os.open(folder / f"charge.{j}", os.O_CREAT))
    begin = time.process_time()
    check_folder(tmp_path)
    assert time.process_time() - begin < WITHIN_S
