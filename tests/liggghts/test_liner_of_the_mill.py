"""The liner is stated once, in fix mill/similarity; the other styles take it from there."""

import numpy as np
import pytest

from millscale import _core
from scene import SLICE, analytic_wall, loose_bed, mill_deck, run

S = 2.6
RADIUS = 3.9 / S
LINER = _core.Lifters(RADIUS, 3.61 / S, 0.25 / S, 0.635 / S, 25)
SHAPE = (
    f"lifters 25 lifter_top_radius {3.61 / S!r} lifter_top_width {0.25 / S!r} "
    f"groove_width {0.635 / S!r}"
)
WALL = "fix liner all wall/mill mill mill type 2"
DETACH = f"lifters 25 lifter_top_radius {3.61 / S!r}"
OTHERS = "compute charge all mill/charge mill mill\nfix guard all mill/guard mill mill every 1\n"
RUN = (
    'run 200\nprint "values $(c_charge[8]) $(c_charge[12]) $(c_detach[10]) $(f_liner[5]) '
    '$(f_mill[1]) $(c_charge[16])"\n'
)
THERMO = "thermo_style custom step c_charge[1] c_detach[1] f_liner[5]\n"


def _deck(folder, of_mill, wall=WALL, detach="", others=OTHERS):
    """A bed in the turning mill; the arguments that state the liner are where a test wants them."""
    deck = mill_deck(
        folder, loose_bed(RADIUS, 60, SLICE, 1), S, "constant-gravity", wall="analytic"
    )
    for old, new in (
        (analytic_wall(S).strip(), wall),
        (f"mill/detach mill mill {DETACH}", f"mill/detach mill mill {detach}"),
        (f"scale {S!r}", f"scale {S!r} {of_mill}"),
    ):
        assert old in deck
        deck = deck.replace(old, new)
    return deck + others + THERMO + RUN


def _values(folder, deck):
    result = run(folder, deck)
    assert result.error == ""
    return result.printed("values")


def test_styles_without_arguments_do_what_styles_with_the_same_arguments_do(tmp_path):
    once = _values(tmp_path, _deck(tmp_path, SHAPE))
    others = OTHERS.replace("mill/charge mill mill", f"mill/charge mill mill {SHAPE}")
    others = others.replace("mill/guard mill mill", f"mill/guard mill mill {SHAPE}")
    each = _deck(tmp_path, "", f"{WALL} {SHAPE}", DETACH, others)
    both = _deck(tmp_path, SHAPE, f"{WALL} {SHAPE}", DETACH, others)
    assert once[0] > 0.0 and once[2] > 0.0 and once[3] != 0.0
    np.testing.assert_array_equal(_values(tmp_path, each), once)
    np.testing.assert_array_equal(_values(tmp_path, both), once)


def test_a_profile_file_is_the_same_liner(tmp_path):
    (tmp_path / "liner.csv").write_text(LINER.text)
    from_file = _values(tmp_path, _deck(tmp_path, "profile liner.csv"))
    np.testing.assert_array_equal(from_file, _values(tmp_path, _deck(tmp_path, SHAPE)))


STYLES = {
    "wall": ({"wall": f"{WALL} {SHAPE}"}, "Fix wall/mill (id liner): "),
    "detach": ({"detach": DETACH}, "Fix mill/detach/track"),
    "charge": (
        {"others": OTHERS.replace("charge mill mill", f"charge mill mill {SHAPE}")},
        "Compute mill/charge",
    ),
    "guard": (
        {"others": OTHERS.replace("guard mill mill", f"guard mill mill {SHAPE}")},
        "Fix mill/guard",
    ),
}


@pytest.mark.parametrize("style", STYLES)
def test_arguments_of_another_liner_are_refused(tmp_path, style):
    changed, name = STYLES[style]
    other = SHAPE.replace("lifters 25", "lifters 24")
    result = run(tmp_path, _deck(tmp_path, other, **changed))
    assert result.code != 0 and name in result.error
    assert (
        "lifters: got 25, fix mill/similarity (id mill) of the same mill has 24; state the liner "
        "once, in fix mill/similarity" in result.error
    )


@pytest.mark.parametrize("style", STYLES)
def test_arguments_beside_a_profile_file_are_refused(tmp_path, style):
    (tmp_path / "liner.csv").write_text(LINER.text)
    result = run(tmp_path, _deck(tmp_path, "profile liner.csv", **STYLES[style][0]))
    assert result.code != 0
    assert "has its liner from a profile file; leave out the arguments lifters" in result.error


FILES = {
    "none": ("", "profile: cannot open 'liner.csv'"),
    "another radius": (LINER.scaled(1.1).text, "has a radius of 1.36363636 m, the scaled mill of"),
    "a word for a number": (LINER.text.replace("sectors,25", "sectors,x"), "line 1: expected a"),
    "another face": (LINER.text.replace("groove", "grove"), "line 6: face: got 'grove', accepted"),
    "a column less": (LINER.text.replace(",groove,0", ",groove"), "line 6: expected `sectors,N`"),
    "no piece": (
        "\n".join(LINER.text.splitlines()[:3]),
        "file 'liner.csv': profile: must have 1 to 100000 pieces, got 0",
    ),
}


@pytest.mark.parametrize("file", FILES)
def test_a_profile_file_with_faults_is_refused(tmp_path, file):
    text, error = FILES[file]
    if text:
        (tmp_path / "liner.csv").write_text(text)
    result = run(tmp_path, _deck(tmp_path, "profile liner.csv"))
    assert result.code != 0 and error in result.error


def test_the_liner_is_stated_once(tmp_path):
    (tmp_path / "liner.csv").write_text(LINER.text)
    result = run(tmp_path, _deck(tmp_path, f"profile liner.csv {SHAPE}"))
    assert "profile: the liner is stated twice; give either a file or lifters" in result.error
