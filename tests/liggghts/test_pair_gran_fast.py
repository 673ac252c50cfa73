"""pair_style gran ... surface fast: the same contacts as stock, and what it refuses."""

import itertools
import re

import numpy as np
import pytest

from bed import (
    BALLS,
    MEMORY_STOCK,
    SIZES_AND_MATERIALS,
    again_deck,
    assert_same,
    bed_deck,
    differ,
    run_bed,
)
from scene import (
    HEAD,
    STOCK_CONTACTS,
    material,
    run,
    with_contacts,
)


@pytest.mark.parametrize("wall", ["analytic", "mesh"])
@pytest.mark.parametrize("edit", ["", SIZES_AND_MATERIALS], ids=["equal", "sizes and materials"])
@pytest.mark.parametrize("steps", [0, 1])
def test_forces_and_torques_from_one_restart_are_those_of_stock(tmp_path, steps, edit, wall):
    deck = bed_deck(tmp_path, "stock", wall=wall, edit=edit)
    made = run(tmp_path, deck + "run 900\nwrite_restart half.restart\n")
    assert made.code == 0, made.text[-600:]
    states = []
    for contacts, options in (("stock", ""), ("fast", MEMORY_STOCK)):
        again = again_deck(contacts, options, deck)
        if steps == 0:  # the forces of set-up, which this fix would replace by those it carried
            again = again.replace("fix forces all mill/forces\n", "")
        states.append(run_bed(tmp_path, again, steps))
    stock, fast = states
    np.testing.assert_array_equal(fast["x y z"], stock["x y z"])
    assert np.abs(stock["fx fy fz"]).max() > 1.0
    assert np.abs(stock["tqx tqy tqz"]).max() > 1e-3
    # Rounding of 1e-16, of overlaps that are up to a thousand times smaller than the distance.
    assert_same(fast, stock, 1e-12)


@pytest.mark.parametrize("edit", ["", SIZES_AND_MATERIALS], ids=["equal", "sizes and materials"])
def test_mixed_precision_rounds_forces_and_no_more(tmp_path, edit):
    deck = bed_deck(tmp_path, "fast", edit=edit)
    made = run(tmp_path, deck + "run 900\nwrite_restart half.restart\n")
    assert made.code == 0, made.text[-600:]
    double, mixed = (
        run_bed(tmp_path, again_deck("fast", options, deck), 1)
        for options in ("", "precision mixed")
    )
    np.testing.assert_array_equal(mixed["x y z"], double["x y z"])
    # Numbers of single precision, 6e-8, some twenty on each other in the force of a contact; that
    # of a ball in a bed is what some four contacts, each as large, leave of each other.
    assert_same(mixed, double, 4 * 20 * 6e-8)
    assert differ(mixed, double) > 1e-9  # it was another kernel


def test_mixed_precision_does_not_depend_on_ranks(tmp_path):
    # Other ranks sum a ball's forces in another order. 50 steps leave rounding near its size.
    one, two = (
        run_bed(tmp_path, bed_deck(tmp_path, "fast", "precision mixed"), 50, ranks)
        for ranks in (1, 2)
    )
    assert_same(two, one, 1e-5)


@pytest.mark.parametrize("wall", ["analytic", "mesh"])
@pytest.mark.parametrize("edit", ["", SIZES_AND_MATERIALS], ids=["equal", "sizes and materials"])
def test_a_thousand_steps_are_those_of_stock(tmp_path, edit, wall):
    # A bed that collapses is chaotic: rounding of 1e-16 grows by 10^3 to 10^6 in these 0.05 s, so
    # 1e-8 leaves a hundredfold. Three times as many steps would need a tolerance of the order of 1.
    stock = run_bed(tmp_path, bed_deck(tmp_path, "stock", wall=wall, edit=edit), 1000)
    fast = run_bed(tmp_path, bed_deck(tmp_path, "fast", MEMORY_STOCK, wall=wall, edit=edit), 1000)
    assert_same(fast, stock, 1e-8)
    assert np.abs(stock["x y z"] - BALLS).max() > 2e-3  # it did collapse


def test_memory_of_contact_is_stock_with_a_list_at_every_step(tmp_path):
    # Stock forgets a contact that parted at its next neighbour list: here at once.
    every = "neigh_modify delay 0 every 1 check no\n"
    stock = run_bed(tmp_path, bed_deck(tmp_path, "stock", edit=every), 1400)
    fast = run_bed(tmp_path, bed_deck(tmp_path, "fast"), 1400)
    assert_same(fast, stock, 1e-8)
    stale = run_bed(tmp_path, bed_deck(tmp_path, "fast", MEMORY_STOCK), 1400)
    assert differ(stale, stock) > 1e-3  # contacts did part and meet again between two lists


@pytest.mark.parametrize("options", ["", MEMORY_STOCK])
def test_what_is_left_out_is_what_stock_leaves_out(tmp_path, options):
    for words in (
        "model hertz",
        "model hertz tangential history",
        "model hertz rolling_friction cdt",
        "model hertz tangential history rolling_friction cdt tangential_damping off",
    ):
        states = []
        for contacts in ("stock", "fast"):
            deck = bed_deck(tmp_path, "stock")
            terms, damping, off = words.partition(" tangential_damping")
            surface = f" surface fast {options}" if contacts == "fast" else ""
            line = f"pair_style gran {terms}{surface}{damping}{off}"
            # Short enough that no contact parts and meets again.
            states.append(run_bed(tmp_path, deck.replace(STOCK_CONTACTS, line), 300))
        # cdt has the direction of a spin, however small and close to rounding that is.
        assert_same(*states, 1e-8)


def test_bounded_damping_goes_over_into_damping_as_the_step_shrinks(tmp_path):
    # What bounds it is of the order of the step, and so is what it changes in an oblique impact.
    differences = []
    for shorter in (1, 2, 4):
        spins = []
        for damping in ("on", "bounded"):
            deck = _two_balls(0.5, 4e-6 / shorter, f"tangential_damping {damping}")
            deck += "set atom 1 vz 0.2\n"
            spins.append(run_bed(tmp_path, deck, 1250 * shorter)["omegax omegay omegaz"])
        differences.append(np.abs(spins[1] - spins[0]).max() / np.abs(spins[0]).max())
    assert differences[0] > 1e-5
    for coarse, fine in itertools.pairwise(differences):
        assert fine < 0.6 * coarse


@pytest.mark.parametrize("level", [2, 3, 4])
def test_a_kernel_of_choice_gives_the_same_motion_or_says_it_cannot_run(tmp_path, level):
    best = run_bed(tmp_path, bed_deck(tmp_path, "fast"), 300)
    deck = bed_deck(tmp_path, "fast", f"kernel {level}")
    result = run(tmp_path, deck + "run 0\n")
    if "this machine supports" in result.error:
        assert level > 2
    else:
        assert_same(run_bed(tmp_path, deck, 300), best, 1e-9)


def _two_balls(e, dt, options="", contacts="fast"):
    """Two balls that are about to meet along x at 2 m/s, and nothing else."""
    properties = material(0.02, dt, restitution=(e, e))
    return (
        HEAD.replace("f p f", "f f f")
        + "region box block -1 1 -1 1 -1 1 units box\ncreate_box 2 box\n"
        + with_contacts(properties, contacts, options)
        + "create_atoms 1 single -0.02002 0 0\ncreate_atoms 2 single 0.02002 0 0\n"
        + "set group all diameter 0.04 density 2678\n"
        + "set atom 1 vx 1.5\nset atom 2 vx -0.5\nfix move all nve/sphere\n"
    )


@pytest.mark.parametrize("e", [0.1, 0.2, 0.5, 0.9, 0.98])
def test_a_damped_collision_has_its_restitution_as_stock(tmp_path, e):
    after = []
    for contacts in ("stock", "fast"):
        after.append(run_bed(tmp_path, _two_balls(e, 1e-6, contacts=contacts), 5000))
    stock, fast = (state["vx vy vz"] for state in after)
    np.testing.assert_allclose(fast, stock, rtol=1e-10, atol=1e-13)
    # First order in the step, which is a two-thousandth of the impact.
    assert (fast[1, 0] - fast[0, 0]) / 2.0 == pytest.approx(e, abs=2e-3)
    assert fast[:, 0].sum() == pytest.approx(1.0, rel=1e-13)  # momentum, equal masses


MORE_BALLS = "".join(
    f"create_atoms 1 single {x!r} {y!r} {z!r} units box\n"
    for x, y, z in (BALLS[:20] + np.array([0.0, 0.0, 0.3])).tolist()
)
BETWEEN_RUNS = {
    "nothing": "",
    "balls added": MORE_BALLS + "set type 1 diameter 0.04 density 2678\n",
    "balls removed": "group g id 3 7 40 41\ndelete_atoms group g compress no\n",
    "another material": "set atom 1*33 type 2\n",
    "another skin": "neighbor 0.004 bin\n",
    "the pair style again": "{pair_style}\npair_coeff * *\n",
    "a restart file": "write_restart half.restart\nrun 300 pre no\n",
}


@pytest.mark.parametrize("edit", BETWEEN_RUNS.values(), ids=BETWEEN_RUNS)
def test_between_two_runs_a_deck_may_do_what_it_may_with_stock(tmp_path, edit):
    states = []
    for contacts, options in (("stock", ""), ("fast", MEMORY_STOCK)):
        deck = bed_deck(tmp_path, contacts, options)
        style = next(line for line in deck.splitlines() if line.startswith("pair_style"))
        deck += "run 300\n" + edit.format(pair_style=style)
        states.append(run_bed(tmp_path, deck, 300))
    assert_same(states[1], states[0], 1e-9)


def test_balls_created_in_another_order_move_the_same(tmp_path):
    order = np.random.default_rng(3).permutation(len(BALLS))
    straight = run_bed(tmp_path, bed_deck(tmp_path, "fast"), 300)
    shuffled = run_bed(tmp_path, bed_deck(tmp_path, "fast", balls=BALLS[order]), 300)
    # Sums in another order: rounding, grown by the contacts.
    assert_same(shuffled, {names: field[order] for names, field in straight.items()}, 1e-9)


def test_the_width_of_the_skin_changes_nothing(tmp_path):
    # A list that missed a contact would miss others with another skin.
    narrow, wide = (
        run_bed(tmp_path, bed_deck(tmp_path, "fast", skin=skin, edit=SIZES_AND_MATERIALS), 1000)
        for skin in (0.002, 0.02)
    )
    assert_same(narrow, wide, 1e-8)


def test_ranks_without_balls_do_nothing(tmp_path):
    balls = BALLS[BALLS[:, 1] < 0.15]
    one, four = (
        run_bed(tmp_path, bed_deck(tmp_path, "fast", balls=balls, length=2.0), 300, ranks)
        for ranks in (1, 4)
    )
    assert_same(four, one, 1e-9)


def _bed_that_is_checked(folder, steps, options="", ranks=1, **more):
    deck = bed_deck(folder, "fast", f"check 1 {options}", **more)
    return run(folder, deck + f"run {steps}\n", ranks)


def test_no_contact_is_missed(tmp_path):
    result = _bed_that_is_checked(tmp_path, 3000, edit=SIZES_AND_MATERIALS)
    assert result.code == 0, result.text[-600:]


@pytest.mark.validate
def test_no_contact_is_missed_in_a_million_steps(tmp_path):
    result = _bed_that_is_checked(tmp_path, 1_000_000, edit=SIZES_AND_MATERIALS)
    assert result.code == 0, result.text[-600:]


SELDOM = "neigh_modify delay 0 every 200 check no\n"  # the engine makes lists too seldom


def test_a_list_that_is_too_old_is_told(tmp_path):
    # Lists for stock memories are the engine's to ask for.
    result = _bed_that_is_checked(tmp_path, 3000, MEMORY_STOCK, skin=0.001, edit=SELDOM)
    assert result.code != 0
    assert "are no pair of the neighbour list" in result.error


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_list_is_asked_for_when_a_ball_has_left_its_margin(tmp_path, ranks):
    edit = SIZES_AND_MATERIALS + SELDOM
    result = _bed_that_is_checked(tmp_path, 3000, skin=0.001, edit=edit, ranks=ranks)
    assert result.code == 0, result.text[-600:]
    lists = re.search(r"Neighbor list builds = (\d+)", result.text)
    assert int(lists[1]) > 2 * 3000 / 200


@pytest.mark.parametrize("ranks", [1, 2])
def test_no_contact_across_a_border_is_missed(tmp_path, ranks):
    # Pairs of balls that fly at each other over the end of the box, as fast as each other, from
    # different distances: each side must know how far the other's ghost may go.
    length, speed = 0.6, 2.0
    apart = (0.05 + 0.0037 * np.arange(16)).tolist()
    places = itertools.product([0.05, 0.15, 0.25, 0.35], repeat=2)
    ends = [(x, y, z) for gap, (x, z) in zip(apart, places, strict=True) for y in (gap, -gap)]
    balls = "".join(
        f"create_atoms 1 single {x!r} {y / 2 % length!r} {z!r} units box\n" for x, y, z in ends
    )
    deck = (
        HEAD
        + f"region box block 0 0.4 0 {length!r} 0 0.4 units box\ncreate_box 2 box\n"
        + material(0.02, 2e-5)
        + balls
        + "set type 1 diameter 0.04 density 2678\n"
        + f'variable to_the_end atom "{speed!r} * (2 * (y > {length / 2!r}) - 1)"\n'
        + "velocity all set 0 v_to_the_end 0\nfix integrate all nve/sphere\n"
    )
    result = run(tmp_path, with_contacts(deck, "fast", "check 1") + "run 2000\n", ranks)
    assert result.code == 0, result.text[-600:]


WRONG_WORDS = [
    (
        "colour red",
        "unknown keyword 'colour'; accepted are tangential_damping, memory, precision, check,",
    ),
    ("limitForce on", "unknown keyword 'limitForce'"),
    ("tangential_damping some", "tangential_damping: got 'some', accepted are on, off, bounded"),
    ("memory short", "memory: got 'short', accepted are of_contact, stock"),
    ("memory", "memory: expected a value, the command ends here"),
    ("tangential_damping yes", "tangential_damping: got 'yes', accepted are on, off"),
    ("precision single", "precision: got 'single', accepted are mixed, double"),
    ("kernel 5", "kernel: got 5, this machine supports 2 (x86-64-v2)"),
    ("kernel v3", "kernel: expected a number, got 'v3'"),
]


@pytest.mark.parametrize(("options", "cause"), WRONG_WORDS, ids=[w for w, _ in WRONG_WORDS])
def test_a_wrong_option_gives_one_line_of_cause(tmp_path, options, cause):
    result = run(tmp_path, bed_deck(tmp_path, "fast", options) + "run 1\n")
    assert result.code != 0
    assert cause in result.error


OTHER_MODELS = [
    "model hooke tangential history",
    "model hertz tangential history rolling_friction epsd2",
    "model hertz tangential history cohesion sjkr",
]


@pytest.mark.parametrize("model", OTHER_MODELS)
def test_another_contact_model_is_refused(tmp_path, model):
    deck = bed_deck(tmp_path, "stock").replace(
        STOCK_CONTACTS, f"pair_style gran {model} surface fast"
    )
    result = run(tmp_path, deck + "run 1\n")
    assert result.code != 0
    assert "surface fast covers model hertz, tangential history or off" in result.error


def test_friction_without_memory_is_refused(tmp_path):
    model = "pair_style gran model hertz tangential no_history surface fast"
    deck = bed_deck(tmp_path, "stock").replace(STOCK_CONTACTS, model)
    result = run(tmp_path, deck + "run 1\n")
    assert result.code != 0
    assert "tangential no_history` with friction between balls" in result.error


def test_a_hybrid_pair_style_is_refused(tmp_path):
    deck = bed_deck(tmp_path, "fast").replace("pair_style      gran", "pair_style hybrid gran")
    result = run(tmp_path, deck.replace("pair_coeff      * *", "pair_coeff * * gran") + "run 1\n")
    assert result.code != 0
    assert "does not cover pair_style hybrid" in result.error


def test_a_restart_without_its_pair_style_is_refused(tmp_path):
    deck = bed_deck(tmp_path, "fast")
    run(tmp_path, deck + "run 1\nwrite_restart half.restart\n")
    again = again_deck("fast", "", deck)
    settings = again[again.index("pair_style") : again.index("timestep")]
    result = run(tmp_path, again.replace(settings, "") + "run 1\n")
    assert result.code != 0
    assert "repeat the pair_style command after read_restart" in result.error


NOT_COVERED = [
    ("fix cold all freeze", "frozen balls (fix freeze)"),
    ("compute pairs all pair/gran/local pos", "compute pair/gran/local"),
    ("compute p all pressure thermo_temp\nthermo_style custom step c_p", "no pressure, virial"),
    ("compute s all stress/atom\ndump s all custom 1 s.dump c_s[1]", "no pressure, virial"),
    ("neigh_modify exclude type 1 2", "neigh_modify exclude"),
    ("group g id 1\natom_modify first g\nneigh_modify include g", "neigh_modify include"),
]


@pytest.mark.parametrize(("line", "cause"), NOT_COVERED, ids=[w for w, _ in NOT_COVERED])
def test_what_is_not_covered_is_refused(tmp_path, line, cause):
    result = run(tmp_path, bed_deck(tmp_path, "fast") + f"{line}\nrun 1\n")
    assert result.code != 0
    assert cause in result.error, result.text[-600:]
