"""fix mill/liner_loads: sums against the energy budget and the torque on the wall, files, ranks,
restarts, ends; its errors."""

import numpy as np
import pandas as pd
import pytest
from numpy.testing import assert_allclose

from bed import BALLS, DT, RADIUS, SIZES_AND_MATERIALS, S, assert_same, bed_deck, run_bed
from scene import HEAD, analytic_wall, material, run, wall_and_drive, with_contacts

OMEGA = float(np.sqrt(S))
LOADS = "fix loads all mill/liner_loads mill mill wall liner from 0 to 1\n"
LEDGER = "fix ledger all mill/ledger mill mill\n"
OPTIONS = "tangential_damping bounded"
NAMES = (
    *("normal_impulse_Ns", "tangential_impulse_Ns", "torque_impulse_Nms"),
    *("slip_work_J", "normal_dissipation_J", "impacts", "impact_energy_J", "finnie_energy_J"),
)
TELL = 'print "loads ' + " ".join(f"$(f_loads[{k + 1}])" for k in range(len(NAMES))) + '"\n'
# Dissipation by the normal dashpot, slip, impacts and their energy, of ball and wall.
OF_WALL = 'print "wall $(f_ledger[15]) $(f_ledger[19]) $(f_ledger[24]) $(f_ledger[25])"\n'
# As far apart that they touch the balls at both ends.
ENDS = "type 2 ends 0.0052 0.1948"


def told(result):
    assert result.code == 0, result.text[-2000:]
    return dict(zip(NAMES, result.printed("loads "), strict=True))


def files(folder):
    return pd.read_csv(folder / "lifter_loads.csv"), pd.read_csv(folder / "liner_loads.csv")


@pytest.mark.engine
@pytest.mark.parametrize("edit", ["", SIZES_AND_MATERIALS], ids=["equal", "classes"])
@pytest.mark.parametrize("ends", [False, True], ids=["endless", "ends"])
def test_sums_are_those_of_the_energy_budget_and_of_the_wall(tmp_path, edit, ends):
    deck = bed_deck(tmp_path, "fast", OPTIONS, edit=edit + LEDGER + LOADS)
    if ends:
        deck = deck.replace("boundary        f p f", "boundary        f f f")
        deck = deck.replace("wall/mill mill mill type 2", f"wall/mill mill mill {ENDS}")
    deck += 'fix torque all print 1 "$(f_liner[5])" screen no file torque.txt\nrun 2000\n'
    result = run(tmp_path, deck + TELL + OF_WALL)
    found = told(result)
    dissipated, slip, impacts, energy = result.printed("wall ")
    assert slip > 0.01
    assert found["slip_work_J"] == pytest.approx(slip, rel=1e-9)
    assert found["impacts"] == impacts
    assert found["impact_energy_J"] == pytest.approx(energy, rel=1e-9)
    # The budget takes the mean velocities of velocity Verlet.
    assert found["normal_dissipation_J"] == pytest.approx(dissipated, rel=0.05)
    torque = np.loadtxt(tmp_path / "torque.txt", comments="#")
    assert found["torque_impulse_Nms"] == pytest.approx(torque[-2000:].sum() * DT, rel=1e-9)
    lifters, places = files(tmp_path)
    of_liner = lifters[~lifters.face.isin(["lower_end", "upper_end"])]
    for name in NAMES:
        scale = np.abs(lifters[name]).sum()
        assert lifters[name].sum() == pytest.approx(found[name], abs=1e-9 * scale)
        assert places[name].sum() == pytest.approx(of_liner[name].sum(), abs=1e-9 * scale)
        by_bin = of_liner.groupby("bin")[name].sum()
        assert_allclose(
            places.groupby("bin")[name].sum().reindex(by_bin.index, fill_value=0.0),
            by_bin,
            rtol=0.0,
            atol=1e-9 * scale,
        )
    on_ends = lifters[~lifters.face.isin(of_liner.face)]
    assert (on_ends.normal_impulse_Ns.sum() > 0.0) == ends
    assert set(lifters.ball_class) == ({1, 2} if edit else {1})
    if edit:
        assert (lifters.groupby("ball_class").normal_impulse_Ns.sum() > 0.0).all()


@pytest.mark.engine
def test_a_ball_at_rest_loads_the_bin_below_it(tmp_path):
    steps, weight = 4000, 4.0 / 3.0 * np.pi * 0.02**3 * 2678.0 * 9.81
    ball = np.array([[0.0, 0.1, -RADIUS + 0.01999]])
    deck = bed_deck(tmp_path, "fast", OPTIONS, balls=ball, lifters=0, start="never")
    found = told(run(tmp_path, deck + LOADS + f"run {steps}\n" + TELL))
    # It bounces until its weight is carried.
    assert found["normal_impulse_Ns"] == pytest.approx(weight * steps * DT, rel=0.01)
    assert found["torque_impulse_Nms"] == pytest.approx(0.0, abs=1e-9)
    lifters, places = files(tmp_path)
    loaded = lifters[lifters.normal_impulse_Ns != 0.0]
    # The drum's arc begins at the top.
    middle = 0.5 * 2.0 * np.pi * RADIUS
    assert ((loaded.arc_low_m <= middle + 1e-6) & (loaded.arc_high_m >= middle - 1e-6)).all()
    assert len(places.sector_angle_low_rad.unique()) == 1
    assert places.sector_angle_low_rad.iloc[0] == 0.0
    assert places.sectors_time_s.iloc[0] == pytest.approx(steps * DT)


@pytest.mark.engine
def test_loads_change_nothing(tmp_path):
    states = [
        run_bed(tmp_path / name, bed_deck(tmp_path / name, "fast", OPTIONS, edit=loads), 400)
        for name, loads in (("off", ""), ("on", LOADS))
    ]
    assert_same(states[1], states[0], 0.0)


@pytest.mark.engine
def test_loads_are_the_same_on_two_ranks(tmp_path):
    found = []
    for ranks in (1, 2):
        folder = tmp_path / str(ranks)
        deck = bed_deck(folder, "fast", OPTIONS, edit=LOADS)
        found.append(told(run(folder, deck + "run 400\n" + TELL, ranks)))
        lifters, _ = files(folder)
        assert lifters.slip_work_J.sum() == pytest.approx(found[-1]["slip_work_J"], rel=1e-12)
    one, two = (np.array(list(each.values())) for each in found)
    # Forces are summed in another order: 1e-16 a step, which the contacts amplify.
    assert_allclose(two, one, rtol=1e-7, atol=1e-9)


@pytest.mark.engine
@pytest.mark.parametrize("ranks", [1, 2])
def test_a_restart_gives_the_same_files(tmp_path, ranks):
    whole, rest = tmp_path / "whole", tmp_path / "rest"
    rest.mkdir()
    loads = LOADS.replace("from 0 to 1", "from 0.005 to 0.025")
    exact = "fix restarts all mill/restart\nrestart 200 a.restart b.restart\n"
    deck = bed_deck(whole, "fast", OPTIONS, edit=loads + exact)
    assert run(whole, deck + "run 400\n", ranks).code == 0
    (rest / "a.restart").write_bytes((whole / "a.restart").read_bytes())
    properties = with_contacts(material(0.02, DT), "fast", OPTIONS)
    drive = wall_and_drive(
        S, "constant-gravity", analytic_wall(S), "now", f"lifters 25 lifter_top_radius {3.61 / S!r}"
    )
    again = f"{HEAD}read_restart a.restart\n{properties}{drive}{loads}{exact}run 400 upto\n"
    result = run(rest, again, ranks)
    assert result.code == 0, result.text[-2000:]
    for name in ("lifter_loads.csv", "liner_loads.csv"):
        assert (rest / name).read_text() == (whole / name).read_text()
    steps = files(rest)[0].steps.iloc[0]
    assert 0.005 < OMEGA * DT * steps <= 0.0201


@pytest.mark.engine
def test_a_window_that_is_over_is_not_written_again(tmp_path):
    loads = LOADS.replace("to 1", "to 0.01")
    deck = bed_deck(tmp_path, "fast", OPTIONS, edit=loads)
    first = told(run(tmp_path, deck + "run 200\n" + TELL))
    longer = told(run(tmp_path, deck + "run 200\nshell rm lifter_loads.csv\nrun 200\n" + TELL))
    assert longer == first
    assert not (tmp_path / "lifter_loads.csv").exists()


WRONG = [
    ("mill nobody wall liner from 0 to 1", "'nobody' is not the id of a fix mill/similarity"),
    ("mill mill wall nobody from 0 to 1", "'nobody' is not the id of a fix wall/mill"),
    ("mill mill wall mill from 0 to 1", "'mill' is not the id of a fix wall/mill"),
    ("mill mill wall liner", "mill angles 0 <= from < to are needed [rad], got 0 and -1"),
    ("mill mill wall liner from 2 to 1", "got 2 and 1"),
    ("mill mill wall liner from 0 to 1 bins 0", "expected 1 to 10000 bins in a pitch, got 0"),
    ("mill mill wall liner colour 3", "unknown keyword 'colour'; accepted are mill, wall, from"),
]


@pytest.mark.engine
@pytest.mark.parametrize(("words", "cause"), WRONG, ids=[words for words, _ in WRONG])
def test_wrong_arguments_give_one_line_of_cause(tmp_path, words, cause):
    deck = bed_deck(tmp_path, "fast", OPTIONS, balls=BALLS[:2])
    result = run(tmp_path, deck + f"fix loads all mill/liner_loads {words}\n")
    assert result.code != 0
    assert cause in result.error


@pytest.mark.engine
def test_the_loads_of_a_wall_are_recorded_once(tmp_path):
    deck = bed_deck(tmp_path, "fast", OPTIONS, balls=BALLS[:2], edit=LOADS)
    result = run(tmp_path, deck + LOADS.replace("fix loads", "fix two"))
    assert "fix mill/liner_loads (id loads) has the loads of 'liner'" in result.error


@pytest.mark.engine
def test_other_bins_than_those_of_the_restart_file_are_refused(tmp_path):
    deck = bed_deck(tmp_path, "fast", OPTIONS, edit=LOADS)
    assert run(tmp_path, deck + "run 20\nwrite_restart half.restart\n").code == 0
    properties = with_contacts(material(0.02, DT), "fast", OPTIONS)
    lifters = f"lifters 25 lifter_top_radius {3.61 / S!r}"
    drive = wall_and_drive(S, "constant-gravity", analytic_wall(S), "now", lifters)
    again = f"{HEAD}read_restart half.restart\n{properties}{drive}"
    result = run(tmp_path, again + LOADS.replace("to 1", "to 1 bins 7") + "run 20\n")
    assert "the restart file holds 1 classes, 25 sectors of" in result.error
    assert "give the fix another id to begin again" in result.error


@pytest.mark.engine
def test_a_file_that_cannot_be_written_stops_the_run(tmp_path):
    deck = bed_deck(
        tmp_path, "fast", OPTIONS, edit=LOADS.replace("to 1", "to 0.001 map no/map.csv")
    )
    result = run(tmp_path, deck + "run 100\n")
    assert result.code != 0
    assert "cannot write 'no/map.csv'" in result.error
