"""Errors and timing from the engine's log."""

import pytest

from millscale.engine.log import error_line, loop_timing, read_log

LOOP = """
Loop time of {time} on 2 procs for {steps} steps with {balls} atoms, finish time Sun Nov 22

Pair  time (%) = {pair} (13.207)
Neigh time (%) = 0 (0)
Comm  time (%) = 1.0 (39.3209)
Outpt time (%) = 0.5 (0.965745)
Other time (%) = 1.5 (46.5063)

Nlocal:    62.5 ave 75 max 50 min
"""


def test_timing_adds_up_over_the_runs_of_a_log():
    text = LOOP.format(time=4.0, steps=500, balls=125, pair=1.0)
    text += LOOP.format(time=5.0, steps=300, balls=100, pair=2.0)
    timing = loop_timing(text)
    assert (timing.ranks, timing.balls, timing.steps) == (2, 100, 800)
    assert timing.particle_steps == 500 * 125 + 300 * 100
    assert timing.loop_time == 9.0
    seconds = {"pair": 3.0, "neigh": 0.0, "comm": 2.0, "output": 1.0, "other": 3.0}
    assert timing.share == pytest.approx({name: value / 9.0 for name, value in seconds.items()})


def test_a_log_without_a_finished_run_has_no_timing():
    assert loop_timing("Step Atoms KinEng\n0 125 0\n") is None


def test_the_last_error_is_quoted_whole():
    text = "ERROR: first (a.cpp:1)\nrun 5\nERROR on proc 1: Neighbor list overflow (b.cpp:2)\n"
    assert error_line(text) == "ERROR on proc 1: Neighbor list overflow (b.cpp:2)"


def test_a_clean_log_has_no_error():
    assert error_line("WARNING: no ERROR here\nthermo_modify lost error\n") is None


def test_an_engine_that_was_asked_to_end_did_not_finish():
    text = "SIGINT/SIGTERM caught - Writing restart on next occasion and quitting after that.\n"
    assert "signal" in error_line(text)


def test_a_crash_is_reported_with_rank_and_signal():
    text = "mpirun noticed that process rank 3 with PID 0 on node a exited on signal 6 (Aborted).\n"
    assert error_line(text) == "the engine crashed: rank 3 exited on signal 6 (Aborted)"


def test_bytes_that_are_no_text_do_not_hide_the_error(tmp_path):
    log = tmp_path / "log.rotate"
    log.write_bytes(b"ERROR: bad\n \xff\x00{[ (modify.cpp:850)\n")
    assert error_line(read_log(log, tmp_path / "missing")) == "ERROR: bad"
