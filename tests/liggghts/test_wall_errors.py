"""Liners, ends, boxes and balls that do not go together stop the run with their cause."""

from dataclasses import replace

import pytest

from millscale import _core
from scene import run
from wall_bench import INTEGRATE, Balls, Materials, Mill, deck

LINER = _core.Lifters(1.5, 1.39, 0.096, 0.244, 25)
DRUM = _core.Lifters(1.5, 0.0, 0.0, 0.0, 0)
NARROW_MOUTH = _core.Lifters.from_face_angle(1.5, 1.3, 0.2, 0.0, 25)
CLOSED = Mill("arc", LINER, 0.0, words="ends 0.1 0.4", boundary="f f f")
OPEN = Mill("arc", LINER, 0.0)
BALL = Balls.of([[0.0, 0.25, -1.2]])


def _with(mill, words):
    return replace(mill, words=words)


WRONG = {
    "lifters overlap at the foot": (
        _with(OPEN, "groove_width 0.4"),
        BALL,
        "groove width: must be < 2 R sin(pi / n) = 0.375999701 m",
    ),
    "lifters overlap at the top": (
        _with(OPEN, "lifter_top_width 0.36"),
        BALL,
        "lifter top width: must be > 0 and < 0.351195672 m",
    ),
    "r > R": (
        _with(OPEN, "lifter_top_radius 1.6"),
        BALL,
        "lifter top radius: must be > 0 and < 1.5 m (the axis and the liner), got 1.6",
    ),
    "ball larger than the groove": (
        OPEN,
        Balls.of([[0.0, 0.1, -1.0], [0.0, 0.4, -1.0]], radius=[0.02, 0.13]),
        "balls of radius 0.13 m do not fit: the groove of the liner takes less than 0.122 m",
    ),
    "ball larger than the groove's mouth": (
        replace(OPEN, liner=NARROW_MOUTH),
        Balls.of([[0.0, 0.25, -1.0]], radius=0.064),
        "balls of radius 0.064 m do not fit: the groove of the liner takes less than 0.0637",
    ),
    "ball larger than the drum": (
        replace(OPEN, liner=DRUM),
        Balls.of([[0.0, 0.25, 0.0]], radius=1.51),
        "balls of radius 1.51 m do not fit: the drum takes less than 1.5 m",
    ),
    "ball larger than the space between the ends": (
        _with(CLOSED, "ends 0.2 0.23"),
        Balls.of([[0.0, 0.215, -1.2]]),
        "balls of radius 0.02 m do not fit between the ends, 0.03 m apart",
    ),
    "ends in the wrong order": (
        _with(CLOSED, "ends 0.4 0.1"),
        BALL,
        "ends: the upper end must be > the lower end 0.4 m, got 0.1",
    ),
    "an end outside the box": (
        _with(CLOSED, "ends -0.1 0.4"),
        BALL,
        "the ends of the mill must lie in the box, 0 to 0.5 m in y, got -0.1 to 0.4 m",
    ),
    "a liner outside the box": (
        replace(OPEN, start="never origin 0.1 0 0"),
        BALL,
        "the liner must lie in the box, -1.53 to 1.53 m in x, got -1.4 to 1.6 m",
    ),
    "a ball in the wall": (
        OPEN,
        Balls.of([[0.0, 0.1, -1.2], [0.1, 0.25, 1.51]]),
        "balls with their centre outside the liner: 1, first ball 2 at (0.1, 0.25, 1.51) m",
    ),
    "a ball beyond an end": (
        CLOSED,
        Balls.of([[0.0, 0.45, -1.2]]),
        "balls with their centre outside the liner: 1, first ball 1 at (0, 0.45, -1.2) m",
    ),
    "a polygon with corners": (
        _with(replace(OPEN, liner=DRUM), "groove polygon 0.4"),
        BALL,
        "a wall takes folds < pi/3 rad, so chord errors < 0.200961894 m",
    ),
    "no such type": (_with(OPEN, "type 3"), BALL, "the wall's atom type must be 1 to 2, got 3"),
    "no such mill": (
        _with(OPEN, "mill nobody"),
        BALL,
        "'nobody' is not the id of a fix mill/similarity",
    ),
    "no such rolling friction": (
        _with(OPEN, "rolling_friction epsd"),
        BALL,
        "accepted are cdt, off",
    ),
    "no such keyword": (_with(OPEN, "width 3"), BALL, "unknown keyword 'width'; accepted are mill"),
    "neither arc nor polygon": (
        _with(OPEN, "groove round"),
        BALL,
        "groove: got 'round', accepted are polygon, arc",
    ),
    "neither mill nor rest": (
        _with(CLOSED, "ends 0.1 0.4 end_motion still"),
        BALL,
        "end_motion: got 'still', accepted are mill, rest",
    ),
    "one end only": (_with(CLOSED, "ends 0.1"), BALL, "ends, upper: expected a value"),
}


@pytest.mark.parametrize("name", WRONG)
def test_what_does_not_fit_is_an_error_that_says_so(tmp_path, name):
    mill, balls, cause = WRONG[name]
    result = run(tmp_path, deck(tmp_path, mill, balls, Materials(), 1e-5) + INTEGRATE + "run 1\n")
    assert result.code != 0
    assert cause in result.error, result.text[-1000:]


def test_ends_at_the_box_and_a_periodic_box_with_ends_are_taken(tmp_path):
    for boundary in ("f f f", "f p f"):
        mill = replace(CLOSED, words="ends 0 0.5", boundary=boundary)
        text = deck(tmp_path, mill, BALL, Materials(), 1e-5)
        assert run(tmp_path, text + INTEGRATE + "run 1\n").code == 0


def test_on_two_ranks_the_message_is_the_same(tmp_path):
    mill, balls, cause = WRONG["a ball in the wall"]
    text = deck(tmp_path, mill, balls, Materials(), 1e-5) + INTEGRATE + "run 1\n"
    result = run(tmp_path, text, ranks=2)
    assert result.code != 0
    assert cause in result.error
