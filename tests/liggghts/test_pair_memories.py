"""Tangential memories of `surface fast` go where their balls go: to other ranks and into files."""

import numpy as np
import pytest

from bed import SIZES_AND_MATERIALS, again_deck, assert_same, bed_deck, differ, run_bed
from scene import run

# Along the mill, over a rank's whole part of it within the run; ends are periodic.
ALONG = "velocity all set NULL 4.0 NULL units box\n"


@pytest.mark.parametrize("ranks", [2, 4])
@pytest.mark.parametrize("edit", ["", SIZES_AND_MATERIALS], ids=["equal", "sizes and materials"])
def test_balls_that_change_their_rank_take_their_memories_along(tmp_path, edit, ranks):
    settle = "run 600\n" + ALONG  # contacts first: it is their memory that goes along
    one, many = (
        run_bed(tmp_path, bed_deck(tmp_path, "fast", edit=edit) + settle, 400, n)
        for n in (1, ranks)
    )
    # 8 cm along the mill, two ranks' parts are 10 cm long. Rounding, which contacts amplify.
    assert_same(many, one, 1e-7)
    assert np.abs(one["tqx tqy tqz"]).max() > 1e-3


@pytest.mark.parametrize("ranks", [1, 2])
def test_files_of_the_engine_itself_hold_the_memories(tmp_path, ranks):
    # Without fix mill/restart, which asks for them: the engine writes those of a step before.
    deck = bed_deck(tmp_path, "fast")
    whole = run_bed(tmp_path, deck + "run 900\n", 1, ranks)
    written = run(tmp_path, deck + "restart 900 half.restart half.restart\nrun 900\n", ranks)
    assert written.code == 0, written.text[-600:]
    again = run_bed(tmp_path, again_deck("fast", "", deck), 1, ranks)
    forgetful = run_bed(tmp_path, again_deck("stock", "", deck).replace("history", "no_history"), 1)
    # The memory of a step before lacks one of the many steps of a contact.
    assert differ(again, whole) < 0.2 * differ(forgetful, whole)
