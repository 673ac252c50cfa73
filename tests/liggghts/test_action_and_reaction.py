"""What balls put on each other adds up to nothing, also across the periodic ends: the forces on all
balls are those of gravity and wall, and so are the torques about the mill's axis."""

import numpy as np
import pytest

from bed import RADIUS, bed_deck
from scene import loose_bed, read_dump, run

# Four balls fill the length, so that balls touch others across the ends, and pass the ends.
LENGTH = 0.1625
BALLS = loose_bed(RADIUS, 100, LENGTH, seed=5)
ALONG = "velocity all set NULL 2.0 NULL units box\n"
LAST_STEP = (
    "dump end all custom 1 end.dump id x z fx fy fz tqy\n"
    'dump_modify end format "%d %.17g %.17g %.17g %.17g %.17g %.17g"\n'
    "run 1\n"
    'print "wall $(f_liner[1]) $(f_liner[2]) $(f_liner[3]) $(f_liner[5])"\n'
)
WEIGHT = 4.0 / 3.0 * np.pi * 0.02**3 * 2678.0 * 9.81


@pytest.mark.engine
@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize(
    "options",
    ["", "tangential_damping bounded", "precision mixed", "memory stock", "stock"],
    ids=lambda text: text or "double",
)
def test_forces_and_torques_are_those_of_gravity_and_wall(tmp_path, options, ranks):
    contacts, words = ("stock", "") if options == "stock" else ("fast", options)
    deck = bed_deck(tmp_path, contacts, words, balls=BALLS, skin=0.004, length=LENGTH)
    deck += "run 1500\n" + ALONG + "run 400\n" + LAST_STEP
    ran = run(tmp_path, deck, ranks)
    assert ran.code == 0, ran.text[-600:]
    balls, (fx, fy, fz, torque) = read_dump(tmp_path / "end.dump"), ran.printed("wall")
    weight = len(balls["x"]) * WEIGHT
    rounding = 1e-5 if "mixed" in options else 1e-12
    by_balls = [balls["fx"].sum() + fx, balls["fy"].sum() + fy, balls["fz"].sum() + fz + weight]
    assert np.abs(by_balls).max() < rounding * weight
    moments = balls["z"] * balls["fx"] - balls["x"] * balls["fz"] + balls["tqy"]
    by_balls = moments.sum() - (balls["x"] * WEIGHT).sum() + torque
    assert abs(by_balls) < rounding * weight * RADIUS
    assert np.abs(balls["tqy"]).max() > 1e-3
