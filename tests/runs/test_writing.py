"""Files appear complete or not at all, and no link is followed."""

import json
import os

import pytest

from millscale.runs.writing import (
    write_copy,
    write_json,
    write_over,
    write_text,
    writing,
    writing_by_name,
    writing_folder,
)


@pytest.fixture
def victim(tmp_path):
    path = tmp_path / "victim"
    path.write_text("precious")
    return path


@pytest.mark.parametrize("name", ["a.json", "a.json.part"])
@pytest.mark.parametrize("make", [os.symlink, os.link])
def test_a_link_of_the_name_is_replaced_and_its_target_stays(tmp_path, victim, name, make):
    make(victim, tmp_path / name)
    write_json(tmp_path / "a.json", {"a": "ü"})
    assert victim.read_text() == "precious"
    assert not (tmp_path / "a.json").is_symlink()
    assert json.loads((tmp_path / "a.json").read_bytes()) == {"a": "ü"}
    assert sorted(x.name for x in tmp_path.iterdir()) == ["a.json", "victim"]


def test_a_pipe_of_the_name_is_replaced_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "a.part")
    write_text(tmp_path / "a", "x")
    assert (tmp_path / "a").read_text() == "x"


def test_a_failed_write_leaves_the_earlier_file_and_nothing_else(tmp_path):
    write_text(tmp_path / "a", "before")
    with pytest.raises(RuntimeError), writing(tmp_path / "a") as file:
        file.write(b"half")
        raise RuntimeError
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_json(tmp_path / "a", float("nan"))
    assert (tmp_path / "a").read_text() == "before"
    assert [x.name for x in tmp_path.iterdir()] == ["a"]


def test_a_file_gets_the_rights_of_any_new_file(tmp_path):
    write_text(tmp_path / "a", "x")
    (tmp_path / "b").touch()
    assert (tmp_path / "a").stat().st_mode == (tmp_path / "b").stat().st_mode


def test_a_copy_is_of_regular_files_only(tmp_path, victim):
    write_copy(victim, tmp_path / "a", 3)
    assert (tmp_path / "a").read_text() == "pre"
    (tmp_path / "link").symlink_to(victim)
    with pytest.raises(OSError, match="is a link"):
        write_copy(tmp_path / "link", tmp_path / "b")
    assert not (tmp_path / "b").exists()


def test_a_link_is_not_written_through(tmp_path, victim):
    write_over(victim, "new")
    assert victim.read_text() == "new"
    (tmp_path / "link").symlink_to(victim)
    with pytest.raises(OSError):
        write_over(tmp_path / "link", "x")
    assert victim.read_text() == "new"


@pytest.mark.parametrize("is_link", [True, False])
def test_a_folder_is_replaced_and_the_target_of_a_link_is_not(tmp_path, is_link):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "kept").touch()
    for name in ("report", "report.part"):
        if is_link:
            (tmp_path / name).symlink_to(elsewhere)
        else:
            (tmp_path / name).mkdir()
            (tmp_path / name / "old").touch()
    with writing_folder(tmp_path / "report") as part:
        (part / "new").touch()
    assert [x.name for x in (tmp_path / "report").iterdir()] == ["new"]
    assert [x.name for x in elsewhere.iterdir()] == ["kept"]
    assert not (tmp_path / "report").is_symlink()


def test_a_folder_is_replaced_only_by_a_complete_one(tmp_path):
    with writing_folder(tmp_path / "report") as part:
        (part / "before").touch()
    with pytest.raises(RuntimeError), writing_folder(tmp_path / "report") as part:
        (part / "half").touch()
        raise RuntimeError
    assert [x.name for x in (tmp_path / "report").iterdir()] == ["before"]


@pytest.mark.parametrize("make", [os.symlink, os.link])
def test_a_file_that_a_library_opens_by_name_appears_whole_or_not_at_all(tmp_path, victim, make):
    make(victim, tmp_path / "part-a.vtp")
    with writing_by_name(tmp_path / "a.vtp") as part:
        assert part.suffix == ".vtp"
        part.write_text("whole")
    with pytest.raises(RuntimeError), writing_by_name(tmp_path / "a.vtp") as part:
        part.write_text("half")
        raise RuntimeError
    assert (tmp_path / "a.vtp").read_text() == "whole" and victim.read_text() == "precious"
    assert sorted(x.name for x in tmp_path.iterdir()) == ["a.vtp", "victim"]
