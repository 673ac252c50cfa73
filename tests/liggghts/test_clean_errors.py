"""Errors are one readable line: nothing of freed memory follows, and what is refused is named."""

import ctypes
import time

import numpy as np
import pytest

from scene import (
    HEAD,
    SLICE,
    analytic_wall,
    loose_bed,
    mill_deck,
    run,
    with_contacts,
)

S = 2.6
RADIUS = 3.9 / S
TOP = f"lifter_top_radius {3.61 / S!r}"
SHAPE = f"lifters 25 {TOP} lifter_top_width {0.25 / S!r} groove_width {0.635 / S!r}"
PHASE = "phase 0.0"
AIR = np.array([[0.3, SLICE / 2, 0.2]])
BOX = "region box block -1.6 1.6 0 0.2 -1.6 1.6 units box\ncreate_box 2 box\n"


def _deck(folder, more=""):
    return mill_deck(folder, AIR, S, "constant-gravity", wall="analytic") + more


def _wait_for_a_remark_of_the_engine():
    """The engine follows an error by a remark if the number drawn with the clock's second as the
    seed is 1 or 2 of 10."""
    library = ctypes.CDLL(None)
    second = int(time.time()) + 1
    while True:
        library.srand(second)
        if library.rand() % 10 + 1 <= 2:
            break
        second += 1
    time.sleep(second + 0.05 - time.time())


ERRORS = {
    "of a fix of ours": HEAD + BOX + "fix mill all mill/similarity radius 3\n",
    "of a pair style of ours": HEAD + BOX + "pair_style gran model hooke surface fast\n",
    "of the engine": HEAD + BOX + "run some\n",
}


@pytest.mark.parametrize("kind", ERRORS)
def test_no_freed_memory_follows_an_error(tmp_path, monkeypatch, kind):
    monkeypatch.setenv("MALLOC_PERTURB_", "165")  # freed bytes become 0xa5, which is no UTF-8
    _wait_for_a_remark_of_the_engine()
    result = run(tmp_path, ERRORS[kind])
    assert result.error
    log = (tmp_path / "log.liggghts").read_bytes().decode(errors="replace")
    for text in (result.text, log):
        after = text[text.index("ERROR") :]
        assert "\ufffd" not in after
        assert [line for line in after.splitlines() if line.strip()][1:] == []


def test_a_mill_that_centrifuges_is_refused_with_the_words_of_a_deck(tmp_path):
    words = "radius 3.9 gravity 9.81 omega 10 ball_radius 0.02"
    result = run(tmp_path, HEAD + BOX + f"fix mill all mill/similarity {words}\n")
    assert "`centrifuging allow` in a deck" in result.error


TWICE = {
    "wall/mill": analytic_wall(S).replace("fix liner", "fix again"),
    "mill/similarity": "fix again all mill/similarity radius 3.9 gravity 9.81 omega 1.0 "
    f"ball_radius 0.02 scale {S!r} scheme constant-gravity start never\n",
}


@pytest.mark.parametrize("style", TWICE)
@pytest.mark.parametrize("ranks", [1, 2])
def test_two_of_a_kind_on_the_same_balls_are_refused(tmp_path, style, ranks):
    result = run(tmp_path, _deck(tmp_path, TWICE[style]) + "run 1\n", ranks)
    assert result.code != 0
    assert f"on which fix {style} (id again) of group all acts too" in result.error


@pytest.mark.parametrize("style", TWICE)
def test_two_of_a_kind_on_groups_that_share_a_ball_are_refused(tmp_path, style):
    one = "fix liner all" if style == "wall/mill" else "fix mill all"
    groups = "group one type 1\ngroup same id 1\ngroup none type 2\n"
    deck = _deck(tmp_path, TWICE[style].replace("again all", "again {}"))
    deck = deck.replace("set type 1 diameter", f"{groups}set type 1 diameter")
    deck = deck.replace(one, one.replace("all", "one")) + "run 1\n"
    assert (
        f"acts on balls of group one, on which fix {style}"
        in run(tmp_path, deck.format("same")).error
    )
    assert run(tmp_path, deck.format("none")).error == ""


OTHER_LINERS = {
    "lifters": ("lifters 25", "lifters 24", "24", "25"),
    "lifter_top_radius": (TOP, f"lifter_top_radius {3.6 / S!r}", "1.38461538", "1.38846154"),
    "phase": (PHASE, "phase 0.1", "0.1", "0"),
    "lifter_top_width": (
        f"lifter_top_width {0.25 / S!r}",
        "lifter_top_width 0.1",
        "0.1",
        "0.0961538462",
    ),
}


STYLES = {
    "compute detach all mill/detach": f"lifters 25 {TOP}",
    "compute charge all mill/charge": SHAPE,
    "fix guard all mill/guard": SHAPE,
}


@pytest.mark.parametrize(
    ("style", "key"),
    [(s, k) for s in STYLES for k in OTHER_LINERS if OTHER_LINERS[k][0] in f"{STYLES[s]} {PHASE}"],
)
def test_a_liner_that_is_not_the_walls_is_refused(tmp_path, style, key):
    said, instead, ours, its = OTHER_LINERS[key]
    deck = _deck(tmp_path).splitlines(keepends=True)
    deck = "".join(line for line in deck if not line.startswith("compute detach"))
    fix = f"{style} mill mill {STYLES[style]} {PHASE}"
    assert run(tmp_path, f"{deck}{fix}\nrun 1\n").error == ""
    result = run(tmp_path, f"{deck}{fix.replace(said, instead)}\nrun 1\n")
    assert result.code != 0
    assert f"{key}: got {ours}, fix wall/mill (id liner) of the same mill has {its};" in (
        result.error
    )


@pytest.mark.parametrize("words", ["rings 1000000000", "sectors 1000000000", "rings 60000"])
def test_a_grid_that_no_memory_holds_is_refused(tmp_path, words):
    fix = f"fix grid all mill/occupancy mill mill every 1 to 1 file a {words}\n"
    result = run(tmp_path, _deck(tmp_path, fix) + "run 1\n")
    assert result.code != 0
    assert "rings times sectors must be <= 10000000" in result.error


@pytest.mark.parametrize("style", STYLES)
def test_more_lifters_than_any_mill_has_are_refused(tmp_path, style):
    # So thin that they fit; each takes memory.
    thin = "lifter_top_width 3e-9 groove_width 3e-9" if "detach" not in style else ""
    deck = _deck(tmp_path).splitlines(keepends=True)
    deck = "".join(x for x in deck if not x.startswith(("compute detach", "fix liner")))
    fix = f"{style} mill mill lifters 1000000000 {TOP} {thin}\n"
    result = run(tmp_path, deck + fix + "run 1\n")
    assert result.code != 0
    assert "lifters: expected a whole number from 0 to 10000, got 1000000000" in result.error


@pytest.mark.parametrize("contacts", ["stock", "fast"])
def test_the_contact_history_cannot_be_removed_from_under_the_pair_style(tmp_path, contacts):
    deck = mill_deck(
        tmp_path, loose_bed(RADIUS, 60, SLICE, 1), S, "constant-gravity", wall="analytic"
    )
    deck = with_contacts(deck, contacts) + "run 5\n"
    result = run(tmp_path, deck + "unfix contacthistory\nrun 5\n")
    assert result.code != 0
    assert "the contacts of pair_style gran need it, it cannot be removed" in result.error
    # The pair style itself removes it.
    another = "pair_style gran model hertz tangential off\npair_coeff * *\nrun 5\n"
    assert run(tmp_path, deck + another).error == ""


def test_an_energy_budget_without_its_mill_says_so_between_runs(tmp_path):
    deck = with_contacts(_deck(tmp_path)) + "fix budget all mill/ledger mill mill\nrun 2\n"
    result = run(tmp_path, deck + 'unfix mill\nprint "$(f_budget[4])"\n')
    assert result.code != 0
    assert "Fix mill/ledger (id budget): mill: 'mill' is not the id of a fix mill/similarity" in (
        result.error
    )
