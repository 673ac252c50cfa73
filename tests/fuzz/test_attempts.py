"""The record of attempts finds each kind of fault."""

import os
import pickle
import subprocess

import attempts
import pytest
from attempts import Tally, attempt


def tried(folder, act, refusals=(ValueError,)):
    tally = Tally()
    attempt(tally, folder, "input", act, refusals)
    return tally


def refuse(text):
    raise ValueError(text)


def test_a_refusal_of_one_line_is_no_fault(tmp_path):
    tally = tried(tmp_path, lambda: refuse("file: wrong"))
    assert (tally.refused, tally.faults) == (1, [])


def test_a_refusal_of_two_lines_and_another_error_are_tracebacks(tmp_path):
    assert len(tried(tmp_path, lambda: refuse("file:\nwrong")).tracebacks) == 1
    assert len(tried(tmp_path, lambda: {}["x"]).tracebacks) == 1


@pytest.mark.parametrize(
    "act",
    [
        lambda outside: (outside / "a").write_text("x"),
        lambda outside: (outside / "b").mkdir(),
        lambda outside: (outside / "kept").unlink(),
        lambda outside: (outside / "kept").rename(outside / "c"),
        lambda outside: (outside / "d").symlink_to("x"),
        lambda outside: subprocess.run(["true"], check=True),
        lambda outside: pickle.loads(pickle.dumps(print)),
    ],
)
def test_what_is_done_outside_the_folder_is_noted(tmp_path, act):
    (tmp_path / "inside").mkdir()
    (tmp_path / "kept").touch()
    assert len(tried(tmp_path / "inside", lambda: act(tmp_path)).writes_outside) == 1


def test_a_link_that_leads_outside_does_not_hide_a_write(tmp_path):
    (tmp_path / "inside").mkdir()
    (tmp_path / "inside" / "link").symlink_to(tmp_path / "target")
    tally = tried(tmp_path / "inside", lambda: (tmp_path / "inside/link").write_text("x"))
    assert len(tally.writes_outside) == 1


@pytest.mark.parametrize("kind", ["COMPUTING_S", "WAITING_S"])
def test_a_hang_is_noted(tmp_path, monkeypatch, kind):
    monkeypatch.setattr(attempts, kind, 0.3)
    os.mkfifo(tmp_path / "pipe")

    def compute():
        while True:
            pass

    act = compute if kind == "COMPUTING_S" else (tmp_path / "pipe").read_text
    assert len(tried(tmp_path, act).hangs) == 1
