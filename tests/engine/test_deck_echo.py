"""The log of a deck is recognised, and that of another deck is not."""

import pytest

from millscale.engine.deck_echo import difference

DECKS = {
    "mill.in": """# A deck.
variable resume index 0 # 1: go on
include parameters.in
if "${resume} == 0" then "read_restart a.restart" else "read_restart b.restart"
include wall_${wall}.in
timestep ${time_step}
fix mill all mill/similarity &
    radius ${radius} turned ${turned}
run $(v_began+round(f_mill[1]/(f_mill[6]*v_step))) upto
""",
    "parameters.in": """variable wall string mesh
variable time_step string 1e-05
variable radius string 3.9
variable began string $(step)
""",
    "wall_mesh.in": 'variable turned string "mesh liner"\nfix liner all mesh\n',
    "wall_analytic.in": "fix liner all wall/mill\n",
}
# As the engine prints the deck: lines joined, variables replaced one by one, results between.
LOG = """LIGGGHTS (Version LIGGGHTS-PUBLIC 3.8.0)
# A deck.
variable resume index 0 # 1: go on
include parameters.in
variable wall string mesh
variable time_step string 1e-05
variable radius string 3.9
variable began string $(step)
variable began string 707
if "${resume} == 0" then "read_restart a.restart" else "read_restart b.restart"
read_restart a.restart
  50 atoms
include wall_${wall}.in
include wall_mesh.in
variable turned string "mesh liner"
fix liner all mesh
timestep ${time_step}
timestep 1e-05
fix mill all mill/similarity     radius ${radius} turned ${turned}
fix mill all mill/similarity     radius 3.9 turned ${turned}
fix mill all mill/similarity     radius 3.9 turned mesh liner
run $(v_began+round(f_mill[1]/(f_mill[6]*v_step))) upto
run 4243 upto
Setting up run at Mon Nov 30 02:19:58 2026
    Step    Atoms         KinEng        mill[1]
Loop time of 0.1 on 2 procs for 3536 steps with 50 atoms
"""


def test_the_log_of_a_deck_does_not_differ():
    assert difference(LOG, DECKS, "mill.in") == ""


@pytest.mark.parametrize(
    ("line", "by", "found"),
    [
        ("timestep 1e-05", "timestep 1e-06", "it has the line `timestep 1e-06`"),
        ("run 4243 upto", "run 4243 upto\nrun 10", "it has the line `run 10`"),
        ("  50 atoms", "shell rm x", "it has the line `shell rm x`"),
        ("radius 3.9 turned mesh", "radius 4.0 turned mesh", "it has the line `fix mill all"),
        ("variable radius string 3.9", "", "repeat the line `variable radius string 3.9` of param"),
        ("fix liner all mesh", "fix liner all mesh type 1", "repeat the line `fix liner all mesh`"),
        ("read_restart a.restart\n", "read_restart c.restart\n", "it has the line `read_restart c"),
    ],
)
def test_the_log_of_another_deck_differs(line, by, found):
    assert line in LOG
    head, _, tail = LOG.rpartition(line)
    assert found in difference(f"{head}{by}{tail}", DECKS, "mill.in")


def test_lines_of_a_file_that_was_not_included_need_not_be_there():
    assert difference(LOG, DECKS | {"wall_other.in": "fix other all x\n"}, "mill.in") == ""
