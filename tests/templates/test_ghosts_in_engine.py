"""Ghost balls of a rank, which the predicted cost of many ranks counts."""

import re

import pytest

from millscale.cases.cost import GHOST_SHARE, ghost_factor
from millscale.cases.decks import copy_decks
from millscale.cases.parameters import write_parameters
from millscale.packing.charge import write_charge
from paper_campaign import cases
from scene import run_file

CHARGE = {"count": [3000], "settle_s": 0.11, "rotation_angle_rad": 0.02, "step_s": 1e-4}


@pytest.mark.engine
@pytest.mark.parametrize("ranks", [1, 2])
def test_the_engine_has_the_ghosts_that_the_predicted_cost_counts(tmp_path, ranks):
    (case,) = cases(
        tmp_path,
        scaling__S=[2.6],
        scaling__schemes=["constant-gravity"],
        single_ball=None,
        multi_ball=CHARGE,
    )
    copy_decks(("settle.in",), tmp_path)
    write_parameters(case, tmp_path)
    write_charge(case, tmp_path)
    done = run_file(tmp_path, "settle.in", ranks=ranks)
    assert done.code == 0, done.text[-2000:]
    found = float(re.search(r"Nghost: +([\d.]+) ave", done.text)[1])
    local = case.ball.count / ranks
    # The work of a rank is that of its balls times this factor.
    counted = (ghost_factor(case, ranks) - 1.0) / GHOST_SHARE * local
    # At random, balls near a cut are g within sqrt(g): 3 %.
    assert counted == pytest.approx(found, rel=0.05)
