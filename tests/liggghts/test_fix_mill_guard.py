"""fix mill/guard: a run that goes wrong stops with the ball and the reason, before the engine loses
anything; a run that does not is not changed."""

import math

import numpy as np
import pytest

from scene import SLICE, STOCK_CONTACTS, loose_bed, mill_deck, read_dump, run, with_contacts

S = 2.6
RADIUS = 3.9 / S
GUARD = (
    "fix guard all mill/guard mill mill lifters 25 "
    f"lifter_top_radius {3.61 / S!r} lifter_top_width {0.25 / S!r} groove_width {0.635 / S!r}"
)
BELOW = [0.0, SLICE / 2, -RADIUS + 0.021]  # a ball on the bottom groove
AIR = [0.3, SLICE / 2, 0.2]
# 2 sqrt((2 omega R)^2 + 4 g R) with the scaled speed and radius, evaluated by hand here.
LIMIT = float(2.0 * np.sqrt((2.0 * np.sqrt(S) * RADIUS) ** 2 + 4.0 * 9.81 * RADIUS))


def _deck(folder, positions, edit="", guard=GUARD, **more):
    folder.mkdir(exist_ok=True)
    return mill_deck(folder, np.array(positions), S, "constant-gravity", **more) + edit + guard


def _stopped(folder, deck, steps, ranks=1):
    """The guard's words; the run must have failed by them."""
    result = run(folder, deck + f"\nrun {steps}\n", ranks)
    assert result.code != 0
    lines = [line for line in result.text.splitlines() if "fix mill/guard: " in line]
    assert lines, result.text[-1500:]
    assert lines[0].startswith("ERROR")
    return lines[0][lines[0].index("fix mill/guard: ") :]


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_ball_too_fast_for_the_mill_stops_the_run(tmp_path, ranks):
    fast = f"velocity all set {1.001 * LIMIT!r} 0 0\n"
    words = _stopped(tmp_path, _deck(tmp_path, [AIR], fast, wall="analytic"), 1, ranks)
    limit = f"is faster than the limit of {LIMIT:.9g} m/s, twice what"
    assert words.startswith(f"fix mill/guard: ball 1 {limit}")
    assert "; step 0, position (0.3, 0.1, 0.2) m, speed " in words
    assert "nearest wall the top of lifter" in words
    slow = _deck(tmp_path, [AIR], f"velocity all set {0.999 * LIMIT!r} 0 0\n", wall="analytic")
    assert run(tmp_path, slow + "\nrun 1\n").code == 0


def test_the_speed_may_be_given(tmp_path):
    deck = _deck(tmp_path, [AIR], "velocity all set 3 0 0\n", f"{GUARD} speed 2.5", wall="analytic")
    assert "limit of 2.5 m/s" in _stopped(tmp_path, deck, 1)


@pytest.mark.parametrize("contacts", ["stock", "fast"])
def test_a_ball_that_lies_in_another_stops_the_run(tmp_path, contacts):
    for apart, stops in ((0.0299, True), (0.0301, False)):
        deck = _deck(tmp_path, [AIR, [AIR[0] + apart, *AIR[1:]]], wall="analytic")
        deck = with_contacts(deck, contacts)
        if stops:
            words = _stopped(tmp_path, deck, 0)
            said = "ball 1 overlaps ball 2 by 0.505 of the smaller radius, the limit is 0.5"
            assert said in words
        else:
            assert run(tmp_path, deck + "\nrun 0\n").code == 0


def test_balls_overlap_over_the_periodic_seam_too(tmp_path):
    deck = _deck(tmp_path, [[0.3, 0.005, 0.2], [0.3, SLICE - 0.005, 0.2]], wall="analytic")
    assert "overlaps ball 2 by 1.5 of" in _stopped(tmp_path, deck, 0)


@pytest.mark.parametrize("wall", ["mesh", "analytic"])
def test_a_ball_that_sinks_into_the_wall_stops_the_run_at_the_limit(tmp_path, wall):
    # The modulus is so low that nothing holds the ball; every step is looked at.
    edit = "velocity all set 0 0 -2\n"
    deck = _deck(
        tmp_path, [BELOW], edit, f"{GUARD} every 1", wall=wall, youngs_modulus=6e3, start="never"
    )
    deck = f"soft_particles yes\n{deck}".replace("units si", "", 1)
    words = _stopped(tmp_path, "units si\n" + deck, 400)
    over = float(words.split(" by ")[1].split(" of its radius")[0])
    # It goes 0.005 radii a step.
    assert 0.5 < over < 0.506
    assert "ball 1 overlaps groove 0 by" in words


def test_a_ball_outside_the_mill_is_named_with_the_wall_it_went_through(tmp_path):
    beyond = [0.0, SLICE / 2, -RADIUS - 0.001]
    words = _stopped(tmp_path, _deck(tmp_path, [beyond], wall="mesh"), 0)
    assert "ball 1 is outside the mill, its centre 0.001 m beyond groove 0" in words
    in_lifter = np.pi / 25
    inside = [
        -0.97 * RADIUS * np.sin(in_lifter),
        SLICE / 2,
        -0.97 * RADIUS * np.cos(in_lifter),
    ]
    words = _stopped(tmp_path, _deck(tmp_path, [inside], wall="mesh"), 0)
    assert "is outside the mill" in words
    assert "lifter 0" in words or "lifter 1" in words


@pytest.mark.parametrize("contacts", ["stock", "fast"])
def test_a_ball_is_named_before_the_engine_loses_it(tmp_path, contact_row, contacts):
    # Out of an end that is open. Without the guard the engine only counts the balls it has left.
    deck = _deck(tmp_path, [AIR, BELOW], "velocity all set 0 5 0\n", wall="analytic")
    deck = with_contacts(deck.replace("boundary f p f", "").replace("f p f", "f f f"), contacts)
    words = _stopped(tmp_path, deck + " every 100000", 2000)
    named = [f"ball {ball} is outside the box in y; step" in words for ball in (1, 2)]
    contact_row(
        "fault: balls are lost without a name",
        contacts,
        "analytic",
        "balls named with step, position and nearest wall",
        expected=1.0,
        got=sum(named),
        tolerance=0.0,
        reason="the first one stops the run",
    )
    assert "Lost atoms" in run(tmp_path, deck.replace(GUARD, "") + "\nrun 2000\n").text


@pytest.mark.parametrize("contacts", ["stock", "fast"])
@pytest.mark.parametrize("wall", ["mesh", "analytic"])
@pytest.mark.parametrize("first_run", [0, 2])
def test_a_force_that_is_no_number_stops_the_run_soon(tmp_path, first_run, wall, contacts):
    # An infinite force less an infinite force: in the set-up, or from step 3 on.
    edit = (
        f"variable huge equal (step>{first_run}.5)*1e200*1e200\nvariable minus equal -v_huge\n"
        "fix up all addforce v_huge 0 0\nfix down all addforce v_minus 0 0\n"
    ).replace("(step>0.5)", "1")
    deck = with_contacts(_deck(tmp_path, [AIR, BELOW], edit, wall=wall), contacts)
    words = _stopped(tmp_path, deck, 50)
    what = "force" if first_run == 0 else "velocity"
    step = 0 if first_run == 0 else 3 if wall == "mesh" else 5
    assert f"has no finite {what}; step {step}, position" in words


@pytest.mark.parametrize("contacts", ["stock", "fast"])
def test_the_guard_changes_nothing(tmp_path, contacts):
    balls, states = loose_bed(RADIUS, 60, SLICE, seed=5), []
    for guard in ("", GUARD):
        deck = with_contacts(_deck(tmp_path, balls, "", guard, wall="analytic"), contacts)
        deck += (
            "\ndump end all custom 300 end.dump id x y z vx vy vz\n"
            'dump_modify end format "%d %.17g %.17g %.17g %.17g %.17g %.17g"\nrun 300\n'
        )
        assert run(tmp_path, deck).code == 0
        dump = read_dump(tmp_path / "end.dump")
        states.append(np.column_stack([dump[n] for n in ("x", "y", "z", "vx", "vy", "vz")]))
    np.testing.assert_array_equal(states[1], states[0])


def test_a_ball_alone_needs_no_pair_style(tmp_path):
    deck = _deck(tmp_path, [AIR], wall="analytic")
    deck = deck.replace(STOCK_CONTACTS, "atom_modify sort 0 0.0").replace("pair_coeff      * *", "")
    assert run(tmp_path, deck + "\nrun 100\n").code == 0


def _causes(words):
    listed = words.split("likeliest first: ")[1]
    return listed.split("; see docs/results/hard-cases.md")[0].split("; ")


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_mill_without_a_wall_or_an_end_is_named_first(tmp_path, ranks):
    fall = "velocity all set 0 3 -3\n"
    deck = _deck(tmp_path, [AIR], fall, f"{GUARD} every 1", wall="analytic")
    open_end = deck.replace("boundary        f p f", "boundary        f f f")
    causes = _causes(_stopped(tmp_path, open_end, 2000, ranks))
    assert causes[0].startswith("no wall closes this end of the mill (`ends` of fix wall/mill")
    assert len(causes) == 2
    deck = "".join(x for x in deck.splitlines(keepends=True) if not x.startswith("fix liner"))
    causes = _causes(_stopped(tmp_path, deck, 20000, ranks))
    assert causes[0].startswith("no wall holds the balls")
    assert causes[1].startswith("the time step, ")


def test_a_soft_material_and_a_long_step_are_given_with_their_numbers(tmp_path):
    pair = [AIR, [AIR[0] + 0.0299, *AIR[1:]]]
    # By hand: 1.06 (rho g R / E)^(2/3) and dt over pi a sqrt(rho / G) / (0.1631 nu + 0.8766).
    soft = 1.06 * (2678 * 9.81 * RADIUS / 6e4) ** (2 / 3)
    rayleigh = math.pi * 0.02 * math.sqrt(2678 * 2.6 / 5.98e7) / (0.1631 * 0.3 + 0.8766)
    deck = _deck(tmp_path, pair, wall="analytic", youngs_modulus=6e4)
    deck = deck.replace("units           si", "units si\nsoft_particles yes")
    causes = _causes(_stopped(tmp_path, deck, 0))
    assert causes[0].startswith(f"a soft material, in whose bed balls sink {soft:.2g} radii")
    assert causes[1].startswith("the time step, ")
    for dt in (0.1 * rayleigh, 0.4 * rayleigh):
        (cause,) = _causes(_stopped(tmp_path, _deck(tmp_path, pair, wall="analytic", dt=dt), 0))
        assert cause.startswith(f"the time step, {dt / rayleigh:.2g} Rayleigh times")


def _mesh_deck(folder):
    """A ball that flies to the wall in the direction -x, of a drum as a mesh."""
    folder.mkdir(exist_ok=True)
    deck = mill_deck(
        folder,
        np.array([[-1.3, SLICE / 2, 0.003]]),
        S,
        "constant-gravity",
        lifters=0,
        start="never",
    )
    return deck + "velocity all set -4 0 0\nfix guard all mill/guard mill mill every 1"


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_hole_in_the_mesh_is_named(tmp_path, ranks):
    deck = _mesh_deck(tmp_path)
    assert run(tmp_path, deck + "\nrun 2000\n", ranks).code == 0
    path = tmp_path / "liner.stl"
    head, *triangles = path.read_text().split("facet normal")
    places = [np.array([x.split()[1:] for x in t.splitlines() if "vertex" in x], float)
              for t in triangles]  # fmt: skip
    ahead = [np.hypot(t[:, 0].mean() + RADIUS, t[:, 2].mean()) < 0.1 for t in places]
    assert 0 < sum(ahead) < 0.05 * len(triangles)
    kept = [t for t, gone in zip(triangles, ahead, strict=True) if not gone]
    path.write_text("facet normal".join([head, *kept]))
    causes = _causes(_stopped(tmp_path, deck, 2000, ranks))
    assert causes[0].startswith("a hole in the mesh: in this direction from the axis")
    assert causes[1].startswith("a mesh that wobbles by 0.0")


def test_a_mesh_that_the_mill_does_not_turn_is_named(tmp_path):
    deck = _mesh_deck(tmp_path).replace("start never mesh liner", "start never")
    deck = deck.replace("liner.stl type 2", "liner.stl type 2 scale 1.5")
    deck = deck.replace(f"block -{1.02 * RADIUS!r} {1.02 * RADIUS!r}", "block -3 3")
    deck = deck.replace(f"-{1.02 * RADIUS!r} {1.02 * RADIUS!r} units", "-3 3 units")
    causes = _causes(_stopped(tmp_path, deck, 4000))
    assert causes[0].startswith("a mesh of another radius than the mill's (name it as `mesh` of")


WRONG = [
    ("colour 1", "unknown keyword 'colour'; accepted are mill, every, overlap, speed, lifters"),
    ("every 0", "every: expected a number of steps >= 1, got 0"),
    ("overlap -1", "overlap: expected a number > 0, got -1"),
    ("speed fast", "speed: expected a number, got 'fast'"),
]


@pytest.mark.parametrize(("words", "cause"), WRONG, ids=[w for w, _ in WRONG])
def test_a_wrong_word_gives_one_line_of_cause(tmp_path, words, cause):
    deck = _deck(tmp_path, [AIR], "", f"{GUARD} {words}", wall="analytic")
    assert cause in run(tmp_path, deck + "\nrun 1\n").error


def test_a_guard_without_its_mill_is_refused(tmp_path):
    for words, cause in (
        ("fix guard all mill/guard", "mill: the id of a fix mill/similarity is needed"),
        ("fix guard all mill/guard mill no", "mill: 'no' is not the id of a fix mill/similarity"),
    ):
        deck = _deck(tmp_path, [AIR], "", words, wall="analytic")
        assert cause in run(tmp_path, deck + "\nrun 1\n").error
