"""compute mill/detach: states, the two events, their statistics, and what it refuses."""

import numpy as np
import pytest

from scene import SLICE, about_to_be_thrown, mill_deck, run

S = 2.6
DT = 1e-4
GRAVITY = 9.81
EVERY_STEP = (
    'fix track all print 1 "$(step) $(f_mill) $(x[1]) $(z[1]) $(vx[1]) $(vz[1]) $(c_d[1][1])" '
    "file track.csv screen no\n"
).replace("c_d", "c_detach")
RECORD = 'print "record ' + " ".join(f"$(c_detach[1][{k}])" for k in range(1, 25)) + '"\n'
GLOBAL = 'print "global ' + " ".join(f"$(c_detach[{k}])" for k in range(1, 13)) + '"\n'
THERMO = "thermo_style custom step c_detach[1]\nthermo 4000\n"


def _throw(folder):
    position, velocity = about_to_be_thrown(S)
    deck = mill_deck(folder, position, S, "constant-gravity", dt=DT)
    result = run(folder, deck + velocity + EVERY_STEP + THERMO + "run 3600\n" + RECORD + GLOBAL)
    assert result.code == 0, result.text[-2000:]
    return result, np.loadtxt(folder / "track.csv")


def test_a_throw_is_recorded_at_the_step_contact_was_lost(tmp_path):
    result, track = _throw(tmp_path)
    record = dict(zip(range(1, 25), result.printed("record"), strict=True))
    step, angle, x, z, vx, vz, state = track.T
    # The last spell of flight in the track, found without the compute's own memory.
    begin = np.flatnonzero((state == 3) & (np.roll(state, 1) != 3))[-1]
    assert record[12] >= 1
    assert record[14] == angle[begin]
    np.testing.assert_array_equal(
        [record[16], record[18], record[19], record[21]],
        [x[begin], z[begin], vx[begin], vz[begin]],
    )
    assert record[13] == pytest.approx(np.arctan2(-x[begin], z[begin]), rel=1e-14)
    assert record[15] == 9  # placed ahead of the lifter that trails groove 9
    assert record[24] == 9
    assert record[22] == pytest.approx((step[-1] - step[begin]) * DT, rel=1e-12)
    assert record[1] == state[-1] == 3


def test_the_ball_follows_the_parabola_from_its_record(tmp_path):
    result, track = _throw(tmp_path)
    record = result.printed("record")
    x, z, vx, vz, time = record[15], record[17], record[18], record[20], record[21]
    at_end = [x + vx * time, z + vz * time - GRAVITY * time**2 / 2]
    np.testing.assert_allclose(at_end, track[-1, 2:4], rtol=1e-12)


def test_statistics_of_one_throw_are_its_angle(tmp_path):
    result, _ = _throw(tmp_path)
    total, record = result.printed("global"), result.printed("record")
    assert total[3] == record[11] == 1
    assert total[4] == record[12]
    assert total[5] == 0.0  # one sample has no deviation
    assert total[6] == 0.0  # it never was on the groove: not of the outermost layer
    np.testing.assert_array_equal(total[9:], [0, 0, 1])


def test_a_ball_resting_on_the_liner_is_on_the_wall_and_never_detached(tmp_path):
    rest = np.array([[0.0, SLICE / 2, -(3.9 / S - 0.02) + 1e-5]])
    deck = mill_deck(tmp_path, rest, S, "constant-gravity", dt=DT, start="never")
    result = run(tmp_path, deck + THERMO + "run 4000\n" + GLOBAL)
    np.testing.assert_array_equal(result.printed("global")[[0, 3, 9, 10, 11]], [0, 0, 1, 0, 0])


def test_a_ball_on_another_ball_is_in_the_bed(tmp_path):
    foot = -(3.9 / S - 0.02) + 1e-5
    pile = np.array([[0.0, 0.1, foot], [0.0, 0.1, foot + 0.04]])
    deck = mill_deck(tmp_path, pile, S, "constant-gravity", dt=DT, start="never")
    result = run(tmp_path, deck + THERMO + "run 400\n" + GLOBAL)
    np.testing.assert_array_equal(result.printed("global")[9:], [1, 1, 0])


WRONG = [
    ("mill nobody", "'nobody' is not the id of a fix mill/similarity"),
    ("lifters 25", "mill: the id of a fix mill/similarity is needed"),
    ("mill mill lifters 25", "lifter_top_radius: needed"),
    ("mill mill lifters 2.5 lifter_top_radius 1.3", "expected a whole number"),
    ("mill mill lifters 25 lifter_top_radius 4", "must be below the scaled mill's radius 1.5 m"),
    ("mill mill gap -1", "gap: expected a number > 0, got -1"),
    ("mill mill angle 3", "unknown keyword 'angle'; accepted are"),
]


@pytest.mark.parametrize(("words", "cause"), WRONG, ids=[words for words, _ in WRONG])
def test_wrong_arguments_give_one_line_of_cause(tmp_path, words, cause):
    rest = np.array([[0.0, SLICE / 2, -1.4]])
    deck = mill_deck(tmp_path, rest, S, "constant-gravity")
    line = next(row for row in deck.splitlines() if row.startswith("compute detach"))
    result = run(
        tmp_path, deck.replace(line, f"compute detach all mill/detach {words}") + "run 1\n"
    )
    assert result.code != 0
    assert cause in result.error
