"""fix mill/restart: a run that goes on from a file written on the way is the same, bit by bit; a
file that is not whole is told from one that is."""

import resource
import shutil
import signal
import subprocess
import time

import numpy as np
import pytest

from millscale.engine.deck_run import engine_environment, find_engine
from millscale.engine.restart_file import NotWholeError, read_restart
from scene import (
    HEAD,
    SLICE,
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
RADIUS, TOP, DT = 3.9 / S, 3.61 / S, 1e-4
EVERY, STEPS = 600, 1500  # the first file at no step where the engine sorts by itself
RESTARTS = f"fix restarts all mill/restart\nrestart {EVERY} a.restart b.restart\n"
COLUMNS = "id x y z vx vy vz omegax omegay omegaz fx fy fz " + " ".join(
    f"c_detach[{k}]" for k in range(1, 25)
)


def _to_the_end(steps):
    fields = '"%d' + " %.17g" * (len(COLUMNS.split()) - 1) + '"'
    return (
        f"dump end all custom {steps} end.dump {COLUMNS}\ndump_modify end format {fields}\n"
        f"run {steps} upto\n"
    )


def _state(folder):
    dump = read_dump(folder / "end.dump")
    return np.column_stack([dump[name] for name in COLUMNS.split()])


def _whole_and_resumed(
    tmp_path, wall="analytic", contacts="fast", ranks=1, fix=RESTARTS, steps=STEPS
):
    """State of every ball at the end, of one run and of one that goes on from a file of it."""
    whole, resumed = tmp_path / "whole", tmp_path / "resumed"
    whole.mkdir()
    resumed.mkdir()
    # In an order in which no cells follow each other, so that sorting matters.
    balls = np.random.default_rng(3).permutation(loose_bed(RADIUS, 150, SLICE, seed=5))
    deck = mill_deck(whole, balls, S, "constant-gravity", dt=DT, wall=wall)
    liner = analytic_wall(S)
    if wall == "mesh":
        words = deck.split()
        liner = mesh_wall(float(words[words.index("curvature") + 1]))
        shutil.copy(whole / "liner.stl", resumed)
    again = (
        HEAD
        + "read_restart half.restart\n"
        + material(0.02, DT)
        + wall_and_drive(
            S, "constant-gravity", liner, "now", f"lifters 25 lifter_top_radius {TOP!r}"
        )
    )
    first = run(whole, with_contacts(deck, contacts) + fix + _to_the_end(steps), ranks)
    assert first.code == 0, first.text[-2000:]
    shutil.copy(whole / "a.restart", resumed / "half.restart")
    second = run(resumed, with_contacts(again, contacts) + fix + _to_the_end(steps), ranks)
    assert second.code == 0, second.text[-2000:]
    return _state(whole), _state(resumed)


@pytest.mark.parametrize(
    ("wall", "contacts", "ranks"),
    [
        ("analytic", "fast", 1),
        ("analytic", "fast", 2),
        ("analytic", "stock", 1),
    ],
)
def test_a_run_that_goes_on_is_the_same_run(tmp_path, wall, contacts, ranks):
    whole, resumed = _whole_and_resumed(tmp_path, wall, contacts, ranks)
    np.testing.assert_array_equal(whole, resumed)
    assert np.abs(whole[:, 4:7]).max() > 0.1  # it moves


def test_with_a_mesh_it_is_the_same_within_rounding(tmp_path):
    whole, resumed = _whole_and_resumed(tmp_path, "mesh", steps=EVERY + 200)
    # The file rounds the mesh's nodes once more, 1e-16 R, which the contacts amplify.
    np.testing.assert_allclose(whole[:, 1:4], resumed[:, 1:4], rtol=0.0, atol=1e-9)


def test_without_the_fix_the_memory_of_contacts_is_a_step_old(tmp_path):
    whole, resumed = _whole_and_resumed(tmp_path, fix=RESTARTS.split("\n", 1)[1])
    # Far beyond the sorting, which changes the order of sums: 1e-16, which contacts amplify.
    assert np.abs(whole - resumed)[:, 1:4].max() > 1e-9


def test_a_file_tells_its_step_and_that_it_is_whole(tmp_path):
    _whole_and_resumed(tmp_path)
    for name, step in (("a", EVERY), ("b", 2 * EVERY)):
        file = read_restart(tmp_path / "whole" / f"{name}.restart")
        assert file.step == step and file.loop_time > 0.0 and file.processor_time > 0.0


def test_a_file_cut_at_any_place_or_changed_is_not_whole(tmp_path):
    _whole_and_resumed(tmp_path)
    whole = (tmp_path / "whole" / "a.restart").read_bytes()
    cut = tmp_path / "cut.restart"
    random = np.random.default_rng(1)
    ends = [*range(400), *random.integers(0, len(whole), 300), *range(len(whole) - 300, len(whole))]
    for end in ends:
        cut.write_bytes(whole[:end])
        with pytest.raises(NotWholeError, match="is not whole"):
            read_restart(cut)
    for place in random.integers(0, len(whole) - 120, 50):
        cut.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :])
        with pytest.raises(NotWholeError, match="its signature differs"):
            read_restart(cut)


def test_a_full_disk_ends_the_run(tmp_path):
    """Stands for it: a limit on the size of files, beyond which writing fails without a signal."""
    balls = loose_bed(RADIUS, 150, SLICE, seed=5)
    deck = mill_deck(tmp_path, balls, S, "constant-gravity", dt=DT, wall="analytic")
    begun = tmp_path / "begun"
    deck += f'fix begun all print 1 "1" file {begun} screen no\n'
    (tmp_path / "deck.in").write_text(deck + RESTARTS + f"run {20 * STEPS}\n")
    engine = subprocess.Popen(
        [find_engine(), "-in", "deck.in"],
        cwd=tmp_path,
        env=engine_environment(),
        stdout=subprocess.PIPE,
        text=True,
        errors="replace",
        preexec_fn=lambda: signal.signal(signal.SIGXFSZ, signal.SIG_IGN),
    )
    while not (begun.exists() and begun.stat().st_size > 100) and engine.poll() is None:
        time.sleep(0.01)
    # From now on: MPI writes larger files when it begins.
    resource.prlimit(engine.pid, resource.RLIMIT_FSIZE, (1 << 15, 1 << 15))
    text, _ = engine.communicate(timeout=300)
    assert engine.returncode != 0
    assert "restart is not whole: is the disk full? It has 32768 bytes" in text.replace("' ", " ")


def test_arguments_are_refused(tmp_path):
    balls = loose_bed(RADIUS, 5, SLICE, seed=5)
    deck = mill_deck(tmp_path, balls, S, "constant-gravity", dt=DT, wall="analytic")
    assert "takes no arguments" in run(tmp_path, deck + "fix r all mill/restart 1\n").error
