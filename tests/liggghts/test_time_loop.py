"""The time loop on rows gives the bits of the engine's loop, or leaves the run to it."""

import re

import numpy as np
import pytest

from bed import BALLS, RADIUS, SIZES_AND_MATERIALS, bed_deck
from scene import SLICE, loose_bed, read_dump, run

OURS = "Time loop: millscale's"
ENGINES_LOOP = "run_style verlet\n"
STEPS = 600
COLUMNS = "id x y z vx vy vz omegax omegay omegaz fx fy fz tqx tqy tqz " + " ".join(
    f"c_detach[{k}]" for k in range(1, 25)
)
SHOW = f'dump_modify end format "%d{" %.17g" * (len(COLUMNS.split()) - 1)}"\n'
GUARD = "fix guard all mill/guard mill mill\n"
DRIVE = "fix drive all mill/drive mill mill wall liner every 40\n"
CHARGE = (
    "compute charge all mill/charge mill mill\n"
    "group found id > 0\n"  # all balls: searched, not noted by the kernel
    "compute searched found mill/charge mill mill\n"
    'fix series all print 40 "$(step),$(c_charge[3]),$(f_drive[1]),$(f_drive[3]),$(c_detach[12]),'
    '$(c_charge[13]),$(c_searched[13])" file series.csv screen no\n'
)
CAMPAIGN = GUARD + DRIVE + CHARGE
OCCUPANCY = (
    "fix occupancy all mill/occupancy mill mill every 10 rings 5 sectors 8 from 0 to 0.03 "
    "file occupancy.csv\n"
)
AVERAGE = (
    "variable energy equal ke\nthermo_style custom step ke\n"
    "fix average all ave/time 2 5 20 v_energy c_detach[10] file average.csv\n"
)


def _deck(folder, options="", edit="", **more):
    """The bed, its liner stated once, by the mill."""
    deck = bed_deck(folder, "fast", options, edit=edit, **more)
    liner = re.search(r" lifters 25 .*groove_width \S+", deck)[0]
    deck = deck.replace(liner, "", 1).replace("start now ", f"start now {liner} ")
    return re.sub(r"(mill/detach mill mill).*", r"\1", deck)


def _end(folder, deck, ranks=1, runs=f"run {STEPS}\n", expected=OURS):
    """Run a deck. Return its last state, the text of its files, and what it printed."""
    dump = f"dump end all custom 100000 end.dump {COLUMNS}\n{SHOW}"
    last = "dump last all custom 1 last.dump id x\nundump last\n"
    deck = deck + dump + runs + last + "write_restart end.restart\n"
    deck = deck.replace("dump end all custom 100000", f"dump end all custom {STEPS}")
    result = run(folder, deck, ranks)
    assert result.code == 0, result.text[-900:]
    assert expected in result.text, result.text[:2000]
    state = read_dump(folder / "end.dump")
    files = {path.name: path.read_text() for path in sorted(folder.glob("*.csv"))}
    return state, files, result.text


def _assert_same(got, expected):
    assert got[1] == expected[1]
    for name in COLUMNS.split():
        np.testing.assert_array_equal(got[0][name], expected[0][name], err_msg=name)


def _both(tmp_path, options="", edit="", *, ranks=1, runs=f"run {STEPS}\n", **more):
    """Run a bed in both loops; expect the same bits."""
    deck = _deck(tmp_path / "ours", options, edit=edit, **more)
    ours = _end(tmp_path / "ours", deck, ranks, runs)
    deck = _deck(tmp_path / "engine", options, edit=edit + ENGINES_LOOP, **more)
    engine = _end(tmp_path / "engine", deck, ranks, runs, expected="")
    assert "Time loop" not in engine[2]
    _assert_same(ours, engine)
    return ours


@pytest.mark.parametrize("ranks", [1, 2, 4])
@pytest.mark.parametrize("precision", ["double", "mixed"])
@pytest.mark.parametrize("damping", ["on", "bounded"])
def test_both_loops_have_the_same_bits(tmp_path, ranks, precision, damping):
    options = f"tangential_damping {damping} precision {precision}"
    ours = _both(tmp_path, options, CAMPAIGN, ranks=ranks)
    assert (ours[0]["z"] - BALLS[:, 2] < -1e-3).any()
    assert ours[0]["c_detach[12]"].max() >= 0
    rows = [line.split(",") for line in ours[1]["series.csv"].splitlines()[1:]]
    assert len(rows) > 10
    assert [row[-1] for row in rows] == [row[-2] for row in rows]
    assert max(float(row[-1]) for row in rows) > 0


@pytest.mark.parametrize("ranks", [1, 2])
def test_balls_of_all_sizes_and_materials(tmp_path, ranks):
    _both(tmp_path, "tangential_damping bounded", SIZES_AND_MATERIALS + CAMPAIGN, ranks=ranks)


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_thousand_balls_that_turn_with_the_mill(tmp_path, ranks):
    balls = loose_bed(RADIUS, 1000, 2 * SLICE, seed=3)
    more = {"balls": balls, "length": 2 * SLICE}
    options = "tangential_damping bounded precision mixed"
    ours = _both(tmp_path, options, CAMPAIGN + OCCUPANCY, ranks=ranks, **more)
    assert "occupancy.csv" in ours[1]


@pytest.mark.parametrize(
    "output",
    [
        "thermo 1\n",
        "thermo 7\n",
        f"dump often all custom 3 often.dump id x\n{CHARGE.replace('print 40', 'print 1')}",
        AVERAGE,
        "restart 50 a.restart b.restart\nfix restarts all mill/restart\n",
        f"{OCCUPANCY}fix more all ave/time 1 1 1 c_detach[10] file more.csv\n",
        "compute near all coord/atom 0.05\ncompute sum all reduce sum c_near fx vz\n"
        "fix ghosts all ave/time 7 1 7 c_sum[1] c_sum[2] c_sum[3] file ghosts.csv\n",
    ],
    ids=[
        "every step",
        "every seventh",
        "dumps and prints",
        "ave/time",
        "restarts",
        "each step",
        "ghosts",
    ],
)
def test_output_changes_no_bit(tmp_path, output):
    quiet = _deck(tmp_path / "quiet", "tangential_damping bounded", edit=DRIVE)
    expected = _end(tmp_path / "quiet", quiet)
    edit = DRIVE + output
    ours = _both(tmp_path, "tangential_damping bounded", edit)
    if "restart" in output:  # lists are built anew for a restart file
        return
    for name in COLUMNS.split():
        np.testing.assert_array_equal(ours[0][name], expected[0][name], err_msg=name)


@pytest.mark.parametrize(
    "runs",
    [
        f"run 0\nrun {STEPS}\n",
        "run 1\n" * 5 + f"run {STEPS - 5}\n",
        f"run 200\ntimestep 4e-5\nfix integrate all nve/sphere\nrun {STEPS - 200}\n",
        f"run 200 post no\nrun {STEPS - 200} pre no\n",
        "run 150\nunfix guard\nfix push all addforce 0.1 0 0\nrun 100\nunfix push\n"
        f"run {STEPS - 250}\n",
        f"run {STEPS} every 150 \"print 'now'\"\n",
        f"fix still all momentum 70 linear 1 1 1\nthermo 35\nrun {STEPS}\n",
    ],
    ids=["run 0", "run 1", "time step", "pre no", "changed fix", "every", "fix momentum"],
)
def test_several_runs(tmp_path, runs):
    _both(tmp_path, "tangential_damping bounded", CAMPAIGN, runs=runs)


@pytest.mark.parametrize(
    ("edit", "reason"),
    [
        ("fix push all addforce 0.1 0 0\n", "fix addforce (id push) acts within every step"),
        ("fix ledger all mill/ledger mill mill\n", "fix mill/ledger records every contact"),
        ("unfix integrate\ngroup some id 1:50\nfix integrate some nve/sphere\n", "acts on a group"),
        ("neigh_modify every 2\n", "neigh_modify does not check distances at every step"),
    ],
)
def test_what_needs_the_engines_loop_says_so_and_runs(tmp_path, edit, reason):
    deck = _deck(tmp_path / "deck", edit=edit)
    result = run(tmp_path / "deck", deck + "run 20\n")
    assert result.code == 0, result.text[-900:]
    assert f"Time loop: the engine's, because {reason}" in result.text or (
        "Time loop: the engine's" in result.text and reason in result.text
    ), result.text[:3000]


def test_other_contacts_and_mesh_walls_run_in_the_engines_loop(tmp_path):
    for wall, contacts in (("analytic", "stock"), ("mesh", "fast")):
        folder = tmp_path / wall
        deck = bed_deck(folder, contacts, wall=wall)
        result = run(folder, deck + "run 20\n")
        assert result.code == 0, result.text[-900:]
        assert "Time loop: the engine's, because" in result.text


def test_a_ball_that_is_too_fast_is_named_as_by_the_engines_loop(tmp_path):
    errors = []
    for name, loop in (("ours", ""), ("engine", ENGINES_LOOP)):
        edit = "fix guard all mill/guard mill mill speed 0.05 every 1000\n" + loop
        deck = _deck(tmp_path / name, edit=edit)
        result = run(tmp_path / name, deck + f"run {STEPS}\n")
        assert result.code != 0
        errors.append(result.error)
    assert "is faster than the limit" in errors[0]
    assert errors[0] == errors[1]
