"""fix mill/similarity with changes of the speed: angle, speed, marks, restarts, drive and guard."""

import math

import numpy as np
import pytest

from bed import RADIUS, S, again_deck, bed_deck
from millscale import _core
from scene import loose_bed, run

pytestmark = pytest.mark.engine

DT = 5e-5
LENGTH = 0.1625
BALLS = loose_bed(RADIUS, 100, LENGTH, seed=5)
OMEGA = math.sqrt(S)
CONTACTS = ("fast", "tangential_damping bounded")
# From rest over 0.04 rad, slower at once, faster over 0.05 rad.
CHANGES = ((0.0, 0.04, 1.0), (0.1, 0.0, 0.6), (0.12, 0.05, 1.3))
WORDS = " ".join(f"speed_change {x!r} {over!r} {to!r}" for x, over, to in CHANGES)


def _deck(folder, words, **more):
    deck = bed_deck(folder, *CONTACTS, balls=BALLS, length=LENGTH, **more)
    assert " start now" in deck
    return deck.replace(" start now", f" start now {words}")


def _rows(folder, name="rows.txt"):
    return np.loadtxt(folder / name, comments="#")


def _printing(every, names, file="rows.txt"):
    values = " ".join(f"$({name})" for name in names)
    return f'fix rows all print {every} "$(step) {values}" screen no file {file}\n'


def test_angle_speed_and_time_are_those_of_the_schedule(tmp_path):
    names = ("f_mill[1]", "f_mill[2]", "f_mill[15]")
    deck = _deck(tmp_path, WORDS) + _printing(7, names) + "run 4000\n"
    done = run(tmp_path, deck)
    assert done.code == 0, done.text[-600:]
    step, angle, speed, turned = _rows(tmp_path).T
    schedule = _core.SpeedSchedule(list(CHANGES))
    phase = OMEGA * step * DT
    np.testing.assert_allclose(angle, [schedule.angle(x) for x in phase], rtol=1e-13)
    np.testing.assert_allclose(turned, step * DT, rtol=1e-12)
    expected = np.array([OMEGA * schedule.speed(x) for x in phase])
    np.testing.assert_allclose(speed[step > 0], expected[step > 0], rtol=1e-12)
    assert angle[-1] > 0.2  # beyond the last change


def test_dumps_are_at_the_steps_nearest_to_the_marks(tmp_path):
    deck = _deck(tmp_path, f"{WORDS} mark 0.03")
    deck += (
        "dump balls all custom 1000 ball.*.dump id x\nvariable next equal f_mill[16]\n"
        "dump_modify balls every v_next first yes\n" + _printing(1, ("f_mill[1]",)) + "run 4000\n"
    )
    assert run(tmp_path, deck).code == 0
    step, angle = _rows(tmp_path).T
    dumps = sorted(int(path.name.split(".")[1]) for path in tmp_path.glob("ball.*.dump"))
    wanted = 0.03 * np.arange(1, int(angle[-1] / 0.03) + 1)
    nearest = [int(step[np.argmin(np.abs(angle - x))]) for x in wanted]
    assert dumps == [0, *nearest]
    assert len(dumps) > 6


def test_a_restart_in_the_ramp_changes_nothing(tmp_path):
    names = ("f_mill[1]", "f_mill[2]", "f_drive[1]", "f_drive[2]", "c_kinetic")
    more = "compute kinetic all ke\nfix drive all mill/drive mill mill wall liner every 50\n"
    for name in ("whole", "halves"):
        (tmp_path / name).mkdir()
    deck = _deck(tmp_path / "whole", WORDS) + more + _printing(50, names) + "run 2000\n"
    assert run(tmp_path / "whole", deck).code == 0
    folder = tmp_path / "halves"
    deck = _deck(folder, WORDS) + more + "run 400\nwrite_restart half.restart\n"
    assert run(folder, deck).code == 0
    again = again_deck(*CONTACTS, deck)
    again = again.replace(" start now", f" start now {WORDS}")
    again += more + _printing(50, names) + "run 1600\n"
    done = run(folder, again)
    assert done.code == 0, done.text[-600:]
    whole, halves = _rows(tmp_path / "whole"), _rows(folder)
    whole_rows, rows = whole[whole[:, 0] > 400], halves[halves[:, 0] > 400]
    np.testing.assert_array_equal(whole_rows[:, :3], rows[:, :3])
    # Sums over the balls, which are in another order after a restart.
    np.testing.assert_allclose(whole_rows[:, 3:], rows[:, 3:], rtol=1e-13)
    assert whole[8, 2] < OMEGA  # the restart is in the ramp


def test_a_restart_with_another_schedule_goes_on_from_its_angle(tmp_path):
    deck = _deck(tmp_path, WORDS) + "run 3000\nwrite_restart half.restart\n"
    deck += 'print "before $(f_mill[1])"\n'
    before = float(run(tmp_path, deck).printed("before")[0])
    words = f"speed_change {before + 0.01!r} 0.0 0.5"
    again = again_deck(*CONTACTS, deck)
    again = again.replace(" start now", f" start now {words}")
    again += _printing(1, ("f_mill[1]", "f_mill[2]")) + "run 1000\n"
    assert run(tmp_path, again).code == 0
    _, angle, speed = _rows(tmp_path).T
    assert angle[0] == pytest.approx(before + OMEGA * DT, rel=1e-13)
    at = angle < before + 0.01
    np.testing.assert_allclose(speed[at], OMEGA, rtol=1e-12)
    np.testing.assert_allclose(speed[~at], 0.5 * OMEGA, rtol=1e-12)
    assert 0 < at.sum() < len(at)


def test_a_bed_on_a_ramp_overlaps_less_than_one_that_is_struck(tmp_path):
    found = {}
    for name, words in {"struck": "", "ramp": "speed_change 0.0 0.1 1.0"}.items():
        folder = tmp_path / name
        folder.mkdir()
        deck = _deck(folder, words)
        deck += "compute charge all mill/charge mill mill " + _SHAPE
        deck += _printing(1, ("c_charge[12]",)) + "run 600\n"
        done = run(folder, deck)
        assert done.code == 0, done.text[-600:]
        found[name] = _rows(folder)[:, 1].max()
    assert found["ramp"] < 0.8 * found["struck"]


_SHAPE = (
    f"lifters 25 lifter_top_radius {3.61 / S!r} lifter_top_width {0.25 / S!r} "
    f"groove_width {0.635 / S!r}\n"
)


def test_the_speed_of_a_drive_with_changes_makes_its_work(tmp_path):
    names = ("f_drive[1]", "f_liner[5]", "f_mill[2]")
    deck = _deck(tmp_path, WORDS) + "fix drive all mill/drive mill mill wall liner every 1\n"
    deck += _printing(1, names) + "run 3000\n"
    assert run(tmp_path, deck).code == 0
    _, work, on_wall, speed = _rows(tmp_path).T
    # Each step does half a step of the work with the torque and speed of either of its ends.
    power = -on_wall * speed
    np.testing.assert_allclose(
        np.diff(work)[1:], 0.5 * DT * (power[1:] + power[:-1])[1:], rtol=1e-6, atol=1e-9
    )


@pytest.mark.parametrize(
    ("words", "cause"),
    [
        ("speed_change 0 1 0", "ratio: must be > 0"),
        ("speed_change 1 1 2 speed_change 1.5 0 1", "where the change before ends"),
        ("speed_change 0 1", "the command ends here"),
        ("mark 0", "expected a number > 0"),
    ],
)
def test_wrong_changes_are_refused(tmp_path, words, cause):
    assert cause in run(tmp_path, _deck(tmp_path, words) + "run 1\n").error
