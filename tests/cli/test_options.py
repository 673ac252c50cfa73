"""What several commands share: the recorded command, the end by Ctrl-C, tables in a pipe."""

import os
import sys

import pytest
import typer
from rich.table import Table

from millscale.cli.options import print_whole, resumable
from millscale.engine.environment import COMMAND_VARIABLE


@pytest.mark.parametrize("caller", [None, "millscale study ladder.toml"])
def test_a_command_is_recorded_unless_its_caller_is(monkeypatch, caller):
    monkeypatch.setenv(COMMAND_VARIABLE, "")
    monkeypatch.delenv(COMMAND_VARIABLE)
    if caller:
        monkeypatch.setenv(COMMAND_VARIABLE, caller)
    monkeypatch.setattr(sys, "argv", ["/bin/millscale", "run", "a mill.toml"])
    with resumable():
        assert os.environ[COMMAND_VARIABLE] == (caller or "millscale run 'a mill.toml'")


def test_ctrl_c_ends_a_command_with_a_message_and_130(monkeypatch, capsys):
    monkeypatch.setenv(COMMAND_VARIABLE, "a test")
    with pytest.raises(typer.Exit) as ended, resumable():
        raise KeyboardInterrupt
    assert ended.value.exit_code == 130
    assert "repeat the command to resume" in capsys.readouterr().err


def test_no_column_is_cut_in_a_pipe(capsys):
    words = [f"{letter * 20}" for letter in "abcdefghij"]
    table = Table(box=None)
    for _ in words:
        table.add_column(no_wrap=True)
    table.add_row(*words)
    print_whole(table)
    assert capsys.readouterr().out.split() == words
