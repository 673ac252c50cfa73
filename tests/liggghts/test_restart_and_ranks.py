"""A restart and the number of ranks change nothing: mesh phase, positions, detachment records."""

import numpy as np
import pytest

from scene import (
    HEAD,
    SLICE,
    about_to_be_thrown,
    analytic_wall,
    loose_bed,
    material,
    mesh_wall,
    mill_deck,
    read_dump,
    run,
    wall_and_drive,
    with_contacts,
)

S = 2.6
RADIUS = 3.9 / S
TOP = 3.61 / S
DT = 1e-4
STEPS = 4000
CARRY_FORCES = "fix forces all mill/forces\n"
COLUMNS = "id x y z vx vy vz omegax omegay omegaz " + " ".join(
    f"c_detach[{k}]" for k in range(1, 25)
)
STOCK = (("stock",), ("stock",))
FAST = (("fast",), ("fast",))
BOUNDED = (("fast", "tangential_damping bounded"),) * 2
STOCK_THEN_FAST = (("stock",), ("fast", "memory stock"))
FAST_THEN_STOCK = (("fast", "memory stock"), ("stock",))
FLIGHTS = COLUMNS.split().index("c_detach[12]")


def _save(steps, end=STEPS):
    fields = '"%d' + " %.17g" * (len(COLUMNS.split()) - 1) + '"'
    return (
        f"dump end all custom {end} end.dump {COLUMNS}\ndump_modify end format {fields}\n"
        f'run {steps}\nprint "mill $(f_mill[1]) $(f_mill[2])"\nprint "torque $(f_liner[5])"\n'
    )


def _state(folder):
    dump = read_dump(folder / "end.dump")
    return np.column_stack([dump[name] for name in COLUMNS.split()])


def _restart_deck(deck):
    words = deck.split()
    if "curvature" in words:
        liner = mesh_wall(float(words[words.index("curvature") + 1]))
    else:
        liner = analytic_wall(S)
    return (
        HEAD
        + "read_restart half.restart\n"
        + material(0.02, DT)
        + wall_and_drive(
            S, "constant-gravity", liner, "now", f"lifters 25 lifter_top_radius {TOP!r}"
        )
    )


def _whole_and_in_halves(
    tmp_path, balls, velocity, wall, ranks=1, without="", steps=STEPS, contacts=STOCK
):
    """contacts: arguments of with_contacts for the whole and the first half, for the second."""
    whole, halves = tmp_path / "whole", tmp_path / "halves"
    for folder in (whole, halves):
        folder.mkdir()
        deck = mill_deck(folder, balls, S, "constant-gravity", dt=DT, wall=wall)
        deck = deck.replace(without, "")
    again = with_contacts(_restart_deck(deck), *contacts[1]).replace(without, "")
    deck = with_contacts(deck, *contacts[0])
    first = run(whole, deck + velocity + _save(steps, steps), ranks)
    half = f"run {steps // 2}\nwrite_restart half.restart\n"
    run(halves, deck + velocity + half, ranks)
    second = run(halves, again + _save(steps // 2, steps), ranks)
    assert first.code == second.code == 0, second.text[-2000:]
    return _state(whole), _state(halves), first, second


@pytest.mark.parametrize("wall", ["analytic", "mesh"])
@pytest.mark.parametrize("ranks", [1, 2])
def test_n_steps_restart_n_steps_equal_2n_steps(tmp_path, ranks, wall):
    thrown = about_to_be_thrown(S)
    whole, halves, first, second = _whole_and_in_halves(tmp_path, *thrown, wall, ranks)
    assert first.printed("mill")[0] == second.printed("mill")[0]
    assert first.printed("mill")[0] == pytest.approx(np.sqrt(S) * STEPS * DT, rel=1e-14)
    assert whole[0, FLIGHTS] >= 1
    # The restart rounds the mesh's nodes once more, 1e-16 R; rolling on a face does not amplify it.
    np.testing.assert_allclose(whole, halves, rtol=1e-9, atol=1e-11)


@pytest.mark.parametrize(
    ("contacts", "wall", "ranks"),
    [
        (STOCK, "analytic", 1),
        (FAST, "analytic", 1),
        (FAST, "analytic", 2),
        (BOUNDED, "analytic", 2),
        (FAST, "mesh", 1),
        (STOCK_THEN_FAST, "analytic", 1),
        (FAST_THEN_STOCK, "analytic", 1),
    ],
    ids=[
        "stock",
        "fast",
        "fast 2 ranks",
        "bounded",
        "fast mesh",
        "stock then fast",
        "fast then stock",
    ],
)
def test_a_charge_n_steps_restart_n_steps_equal_2n_steps(
    tmp_path, contact_row, contacts, wall, ranks
):
    balls = loose_bed(RADIUS, 100, SLICE, seed=5)
    whole, halves, *_ = _whole_and_in_halves(
        tmp_path, balls, "", wall, ranks, steps=400, contacts=contacts
    )
    contact_row(
        "fault: a restart changes the motion",
        " then ".join(dict.fromkeys(words[0] for words in contacts)),
        wall,
        f"difference of a collapsing bed on {ranks} ranks",
        dt=DT,
        expected=0.0,
        got=np.abs(whole[:, :7] - halves[:, :7]).max(),
        tolerance=1e-9,
        reason="forces are summed in another order: 1e-16 a step, which the contacts amplify",
    )
    assert (whole[:, 3] - balls[:, 2] < -1e-3).any()


def test_without_the_forces_carried_over_a_restart_leaves_a_trace(tmp_path):
    balls, velocity = about_to_be_thrown(S)
    whole, halves, *_ = _whole_and_in_halves(
        tmp_path, balls, velocity, "mesh", without=CARRY_FORCES
    )
    assert np.abs(whole - halves).max() > 1e-9


@pytest.mark.parametrize(("ranks", "wall"), [(2, "mesh"), (2, "analytic"), (4, "analytic")])
def test_a_throw_is_the_same_on_any_number_of_ranks(tmp_path, ranks, wall):
    balls, velocity = about_to_be_thrown(S)  # it drifts along the axis, over seam and ranks
    states, torques = [], []
    for count in (1, ranks):
        folder = tmp_path / str(count)
        folder.mkdir()
        deck = mill_deck(folder, balls, S, "constant-gravity", dt=DT, wall=wall)
        result = run(folder, deck + velocity + _save(STEPS), count)
        assert f"1 by {count} by 1 MPI processor grid" in result.text, result.text[-2000:]
        states.append(_state(folder))
        torques.append(result.printed("torque")[0])
    np.testing.assert_allclose(*states, rtol=1e-9, atol=1e-11)
    assert torques[0] == pytest.approx(torques[1], rel=1e-9, abs=1e-12)
    assert states[0][0, FLIGHTS] >= 1


@pytest.mark.parametrize(
    ("contacts", "wall", "ranks"),
    [
        (("stock",), "analytic", 2),
        (("stock",), "mesh", 2),
        (("fast",), "analytic", 2),
        (("fast",), "mesh", 2),
        (("fast",), "analytic", 4),
        (BOUNDED[0], "analytic", 4),
    ],
)
def test_a_charge_is_the_same_on_any_number_of_ranks(tmp_path, contact_row, contacts, wall, ranks):
    states = []
    for count in (1, ranks):
        folder = tmp_path / str(count)
        folder.mkdir()
        balls = loose_bed(RADIUS, 100, SLICE, seed=5)
        deck = mill_deck(folder, balls, S, "constant-gravity", dt=DT, wall=wall)
        result = run(folder, with_contacts(deck, *contacts) + _save(300, 300), count)
        assert result.code == 0, result.text[-2000:]
        states.append(_state(folder)[:, :7])
    contact_row(
        "fault: the result depends on the number of ranks",
        " ".join(contacts),
        wall,
        f"difference of a collapsing bed on {ranks} ranks from one",
        dt=DT,
        expected=0.0,
        got=np.abs(states[1] - states[0]).max(),
        tolerance=1e-9,
        reason="forces are summed in another order: 1e-16 a step, which the contacts amplify",
    )
    assert (states[0][:, 3] - loose_bed(RADIUS, 100, SLICE, seed=5)[:, 2] < -1e-4).any()


def test_a_changed_start_of_a_turning_mill_is_refused(tmp_path):
    balls, _ = about_to_be_thrown(S)
    deck = mill_deck(tmp_path, balls, S, "constant-gravity", dt=DT)
    run(tmp_path, deck + "run 100\nwrite_restart half.restart\n")
    again = _restart_deck(deck).replace("start now", "start 0.5")
    assert "the restart file's mill turns since" in run(tmp_path, again + "run 1\n").error


def test_a_resting_mill_takes_its_start_from_the_next_deck(tmp_path):
    balls, _ = about_to_be_thrown(S)
    deck = mill_deck(tmp_path, balls, S, "constant-gravity", dt=DT, start="never")
    run(tmp_path, deck + "run 100\nwrite_restart half.restart\n")
    again = _restart_deck(deck) + 'run 200\nprint "mill $(f_mill[1])"\n'
    angle = run(tmp_path, again).printed("mill")[0]
    assert angle == pytest.approx(np.sqrt(S) * 200 * DT, rel=1e-12)
