"""A restart and the number of ranks change nothing: mesh phase, positions, detachment records."""

import numpy as np
import pytest
from scene import (
    HEAD,
    MATERIAL,
    SLICE,
    loose_bed,
    mill_deck,
    read_dump,
    run,
    wall_and_drive,
)

S = 2.6
RADIUS = 3.9 / S
TOP = 3.61 / S
COLUMNS = "id x y z vx vy vz omegax omegay omegaz " + " ".join(
    f"c_detach[{k}]" for k in range(1, 24)
)


def _save(steps):
    fields = '"%d' + " %.17g" * (len(COLUMNS.split()) - 1) + '"'
    return (
        f"dump end all custom {steps} end.dump {COLUMNS}\n"
        f"dump_modify end format {fields}\n"
        f"dump wall all mesh/stl {steps} wall*.stl\n"
        f'run {steps}\nprint "mill $(f_mill[1]) $(f_mill[2]) $(f_mill[13])"\n'
        'print "torque $(f_liner[5])"\n'
    )


def _state(folder):
    dump = read_dump(folder / "end.dump")
    return np.column_stack([dump[name] for name in COLUMNS.split()])


def _throw(seed=1):
    """A ball about to be thrown from a lifter, among a small bed: events happen in 4,000 steps."""
    bed = loose_bed(RADIUS, 27, SLICE, seed)
    thrown = np.array([[-0.62, SLICE / 2, 1.05]])
    return np.vstack([thrown, bed])


def _restart_deck(deck, curvature):
    detach = f"lifters 25 lifter_top_radius {TOP!r}"
    return (
        HEAD
        + "read_restart half.restart\n"
        + MATERIAL.format(youngs_modulus=5.98e7, skin=0.02, dt=5e-5)
        + wall_and_drive(S, "constant-gravity", curvature, "now", detach)
    )


def _curvature(deck):
    words = deck.split()
    return float(words[words.index("curvature") + 1])


def _run_whole_and_in_halves(tmp_path, balls, half, ranks=1):
    whole, halves = tmp_path / "whole", tmp_path / "halves"
    for folder in (whole, halves):
        folder.mkdir()
    deck = mill_deck(whole, balls, S, "constant-gravity")
    first = run(whole, deck + _save(2 * half), ranks)
    mill_deck(halves, balls, S, "constant-gravity")
    run(halves, deck + f"run {half}\nwrite_restart half.restart\n", ranks)
    second = run(halves, _restart_deck(deck, _curvature(deck)) + _save(2 * half).replace(
        f"run {2 * half}", f"run {half}"), ranks)  # fmt: skip
    return (whole, first), (halves, second)


@pytest.mark.parametrize("ranks", [1, 2])
def test_n_steps_restart_n_steps_equal_2n_steps(tmp_path, ranks):
    single = np.array([[0.0, SLICE / 2, -(RADIUS - 0.02) + 2e-5]])
    (whole, first), (halves, second) = _run_whole_and_in_halves(tmp_path, single, 10000, ranks)
    assert first.printed("mill")[0] == second.printed("mill")[0]
    assert first.printed("mill")[1] == pytest.approx(np.sqrt(S), rel=1e-15)
    # One more rounding of the mesh's position at the restart, 1e-16 R; contacts do not amplify it.
    np.testing.assert_allclose(_state(whole), _state(halves), rtol=1e-9, atol=1e-11)
    torques = [r.printed("torque")[0] for r in (first, second)]
    assert torques[0] == pytest.approx(torques[1], rel=1e-6)
    assert torques[0] != 0.0


def test_a_charge_goes_through_a_restart_unchanged(tmp_path):
    (whole, first), (halves, second) = _run_whole_and_in_halves(tmp_path, _throw(), 2000)
    assert first.code == second.code == 0
    np.testing.assert_allclose(_state(whole), _state(halves), rtol=1e-6, atol=1e-9)


def test_without_the_forces_carried_over_a_restart_leaves_a_trace(tmp_path):
    single = np.array([[0.0, SLICE / 2, -(RADIUS - 0.02) + 2e-5]])
    whole, halves = tmp_path / "whole", tmp_path / "halves"
    for folder in (whole, halves):
        folder.mkdir()
    deck = mill_deck(whole, single, S, "constant-gravity").replace("fix forces all mill/forces\n", "")
    mill_deck(halves, single, S, "constant-gravity")
    run(whole, deck + _save(6000))
    run(halves, deck + "run 3000\nwrite_restart half.restart\n")
    again = _restart_deck(deck, _curvature(deck)).replace("fix forces all mill/forces\n", "")
    run(halves, again + _save(6000).replace("run 6000", "run 3000"))
    assert np.abs(_state(whole) - _state(halves)).max() > 1e-9


@pytest.mark.parametrize("ranks", [2, 4])
def test_ranks_agree(tmp_path, ranks):
    one, more = tmp_path / "one", tmp_path / "more"
    for folder in (one, more):
        folder.mkdir()
    deck = mill_deck(one, _throw(), S, "constant-gravity")
    mill_deck(more, _throw(), S, "constant-gravity")
    alone, shared = run(one, deck + _save(4000)), run(more, deck + _save(4000), ranks)
    assert shared.code == 0, shared.text[-2000:]
    assert f"1 by {ranks} by 1 MPI processor grid" in shared.text
    # Forces are summed in another order: 1e-16 a step, grown by the contacts of 28 balls.
    np.testing.assert_allclose(_state(one), _state(more), rtol=1e-6, atol=1e-8)
    assert alone.printed("torque")[0] == pytest.approx(shared.printed("torque")[0], rel=1e-5)
    flights = _state(one)[:, COLUMNS.split().index("c_detach[12]")]
    assert flights.max() >= 1  # something was thrown, and both saw it


def test_a_ball_keeps_its_record_across_the_periodic_seam_and_ranks(tmp_path):
    deck = mill_deck(tmp_path, _throw()[:1], S, "constant-gravity")
    deck += "velocity all set NULL 3.0 NULL\n"
    result = run(tmp_path, deck + _save(4000), 2)
    assert result.code == 0, result.text[-2000:]
    state = dict(zip(COLUMNS.split(), _state(tmp_path)[0], strict=True))
    assert state["c_detach[1]"] in (1, 2, 3)
    assert 0 <= state["y"] <= SLICE


def test_a_changed_start_of_a_turning_mill_is_refused(tmp_path):
    single = np.array([[0.0, SLICE / 2, -(RADIUS - 0.02) + 2e-5]])
    deck = mill_deck(tmp_path, single, S, "constant-gravity")
    run(tmp_path, deck + "run 100\nwrite_restart half.restart\n")
    again = _restart_deck(deck, _curvature(deck)).replace("start now", "start 0.5")
    assert "the restart file's mill turns since" in run(tmp_path, again + "run 1\n").error


def test_a_resting_mill_takes_its_start_from_the_next_deck(tmp_path):
    single = np.array([[0.0, SLICE / 2, -(RADIUS - 0.02) + 2e-5]])
    deck = mill_deck(tmp_path, single, S, "constant-gravity", start="never")
    run(tmp_path, deck + "run 100\nwrite_restart half.restart\n")
    again = _restart_deck(deck, _curvature(deck)) + 'run 200\nprint "mill $(f_mill[1])"\n'
    angle = run(tmp_path, again).printed("mill")[0]
    assert angle == pytest.approx(np.sqrt(S) * 200 * 5e-5, rel=1e-12)
