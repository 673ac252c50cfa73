"""fix mill/impacts: closed forms of contacts, the energy budget, precisions, ranks, restarts."""

import csv

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from bed import again_deck
from scene import (
    HEAD,
    SLICE,
    analytic_wall,
    loose_bed,
    material,
    mill_deck,
    read_dump,
    run,
    with_contacts,
)

S = 2.6
RADIUS, BALL, DENSITY = 3.9 / S, 0.02, 2678.0
MASS = 4.0 / 3.0 * np.pi * BALL**3 * DENSITY
DT = 5e-5
SPEED = float(np.sqrt(S))
PAIRINGS = ("ball_ball", "ball_wall")
TERMS = ("contacts", "available", "ended", "open", "all")
FILE = "impact_spectra.csv"
IMPACTS = f"fix impacts all mill/impacts mill mill file {FILE} from 0 to 100\n"
LEDGER = "fix ledger all mill/ledger mill mill\n"
TELL = 'print "impacts ' + " ".join(f"$(f_impacts[{k + 1}])" for k in range(10)) + '"\n'
OF_LEDGER = (
    'print "ledger ' + " ".join(f"$(f_ledger[{k}])" for k in (*range(5, 21), 23, 25)) + '"\n'
)
PATHS = {
    "double, own loop": "precision double",
    "mixed, own loop": "precision mixed",
    "double, v3": "precision double kernel 3",
    "mixed, v3": "precision mixed kernel 3",
    "plain": "kernel 2",
    "without limit": "precision double tangential_damping on",
}
CLASSES = "".join(
    f"set atom {first}*{last} diameter {diameter} density {DENSITY}\n"
    for first, last, diameter in ((1, 40, 0.016), (41, 70, 0.024), (71, 100, 0.04))
)


def _told(result):
    assert result.code == 0, result.text[-2000:]
    numbers = result.printed("impacts ").reshape(2, 5)
    return {p: dict(zip(TERMS, row, strict=True)) for p, row in zip(PAIRINGS, numbers, strict=True)}


def _ledger(result):
    """Dissipated energy and number of impacts by pairing."""
    numbers = result.printed("ledger ")
    terms = numbers[:16].reshape(2, 8)
    return {
        p: (row[2:5].sum(), count)
        for p, row, count in zip(PAIRINGS, terms, numbers[16:], strict=True)
    }


def _deck(folder, options="precision double", edit=""):
    folder.mkdir(exist_ok=True)
    words = options if "tangential_damping" in options else "tangential_damping bounded " + options
    deck = mill_deck(
        folder, loose_bed(RADIUS, 100, SLICE, seed=5), S, "constant-gravity", dt=DT, wall="analytic"
    )
    return with_contacts(deck, "fast", words) + edit


def _two_balls(places, velocities, spins):
    """Balls in a resting drum of 1.5 m without lifters."""
    box = 1.02 * RADIUS
    lines = [
        HEAD,
        f"region box block -{box!r} {box!r} 0 {SLICE!r} -{box!r} {box!r} units box\n",
        "create_box 2 box\n",
        material(0.02, 1e-5, 5.98e7),
        *(f"create_atoms 1 single {x!r} {y!r} {z!r} units box\n" for x, y, z in places),
        "set type 1 diameter 0.04 density 2678\n",
        *(
            f"set atom {i + 1} vx {v[0]!r} vy {v[1]!r} vz {v[2]!r} "
            f"omegax {w[0]!r} omegay {w[1]!r} omegaz {w[2]!r}\n"
            for i, (v, w) in enumerate(zip(velocities, spins, strict=True))
        ),
        analytic_wall(S, 0),
        f"fix mill all mill/similarity radius {RADIUS!r} gravity 1e-9 omega 1e-6 "
        f"ball_radius {BALL!r} centrifuging allow start never\n",
        "fix integrate all nve/sphere\nfix forces all mill/forces\nthermo_modify lost error\n",
    ]
    return with_contacts("".join(lines), "fast", "precision double") + IMPACTS


ENERGY = "compute t all ke\ncompute r all erotate/sphere\n"
KINETIC = 'print "kinetic $(c_t+c_r)"\n'


@pytest.mark.parametrize("along", [0.0, 0.3, 3.0], ids=["head-on", "sticks", "slides"])
def test_an_impact_of_two_balls_dissipates_what_they_lose(tmp_path, along):
    places = [(0.0, 0.1, 0.0), (0.0401, 0.1, 0.0)]
    deck = _two_balls(
        places, [(1.0, along, 0.0), (0.0, 0.0, 0.0)], [(0.0, 5.0 * along, 0.0), (0.0, 0.0, 0.0)]
    )
    result = run(tmp_path, deck + ENERGY + "thermo_style custom step c_t c_r\nrun 0\n" + KINETIC)
    before = result.printed("kinetic ")[0]
    deck += ENERGY + "thermo_style custom step c_t c_r\nrun 1000\n"
    result = run(tmp_path, deck + KINETIC + TELL)
    told = _told(result)["ball_ball"]
    assert told["contacts"] == 1.0
    assert told["open"] == 0.0
    # The approach is along the line of centres where they touch, here within a step.
    apart, gap2 = 0.0401, 0.0401**2 - (2.0 * BALL) ** 2
    time = (apart - np.sqrt(apart**2 - (1.0 + along**2) * gap2)) / (1.0 + along**2)
    normal = np.array([apart - time, -along * time]) / (2.0 * BALL)
    speed = normal @ [1.0, along]
    assert told["available"] == pytest.approx(0.5 * (0.5 * MASS) * speed**2, rel=5e-3)
    # But for the error of the normal spring, which dissipates nothing.
    lost = before - result.printed("kinetic ")[0]
    assert told["ended"] == pytest.approx(lost, rel=0.01)


def test_an_impact_on_the_wall_dissipates_what_the_ball_loses(tmp_path):
    place, speed = (0.0, 0.1, -RADIUS + BALL + 1e-4), 1.0
    deck = _two_balls([place], [(0.0, 0.3, -speed)], [(0.0, 0.0, 0.0)])
    deck += ENERGY + "thermo_style custom step c_t c_r\nrun 1000\n" + KINETIC + TELL
    result = run(tmp_path, deck)
    told = _told(result)["ball_wall"]
    assert told["contacts"] == 1.0
    assert told["available"] == pytest.approx(0.5 * MASS * speed**2, rel=1e-9)
    lost = 0.5 * MASS * (speed**2 + 0.3**2) - result.printed("kinetic ")[0]
    assert told["ended"] == pytest.approx(lost, rel=0.01)


@pytest.mark.parametrize("edit", ["", CLASSES], ids=["equal balls", "three sizes"])
@pytest.mark.parametrize("runs", [1, 4])
def test_the_contacts_dissipate_what_the_energy_budget_has(tmp_path, edit, runs):
    deck = _deck(tmp_path, "", edit) + LEDGER + IMPACTS + f"run {4000 // runs}\n" * runs
    result = run(tmp_path, deck + TELL + OF_LEDGER)
    told, ledger = _told(result), _ledger(result)
    for pairing in PAIRINGS:
        of = told[pairing]
        assert of["all"] > 0.1
        assert of["open"] != 0.0
        assert of["contacts"] > 50.0
        assert of["ended"] + of["open"] == pytest.approx(of["all"], rel=1e-9)
        assert of["all"] == pytest.approx(ledger[pairing][0], rel=1e-9)


@pytest.mark.parametrize("options", PATHS.values(), ids=PATHS)
def test_the_contacts_dissipate_the_same_on_every_path(tmp_path, options):
    steps = 400
    reference = run(
        tmp_path,
        _deck(tmp_path, "tangential_damping on" if "damping on" in options else "")
        + LEDGER
        + IMPACTS
        + f"run {steps}\n"
        + TELL
        + OF_LEDGER,
    )
    ledger = _ledger(reference)
    result = run(tmp_path, _deck(tmp_path, options) + IMPACTS + f"run {steps}\n" + TELL)
    assert ("Time loop: millscale's" in result.text) == ("kernel 2" not in options)
    told = _told(result)
    # Rounding of a bed that falls; of mixed precision, of single numbers.
    off = 3e-4 if "mixed" in options else 1e-9
    for pairing in PAIRINGS:
        of = told[pairing]
        assert of["contacts"] > 10.0
        assert of["ended"] + of["open"] == pytest.approx(of["all"], rel=1e-9)
        assert of["all"] == pytest.approx(ledger[pairing][0], rel=off)


def test_the_own_loop_and_that_of_the_engine_record_the_same(tmp_path):
    tellings = []
    for edit in ("", "run_style verlet\n"):
        deck = _deck(tmp_path, "precision mixed") + edit + IMPACTS + "run 600\n" + TELL
        result = run(tmp_path, deck)
        tellings.append((_told(result), (tmp_path / FILE).read_text()))
    assert tellings[0] == tellings[1]


def test_the_spectra_are_the_same_on_two_ranks(tmp_path):
    found = []
    for ranks in (1, 2):
        result = run(tmp_path, _deck(tmp_path) + IMPACTS + "run 400\n" + TELL, ranks)
        found.append([list(of.values()) for of in _told(result).values()])
    assert_allclose(found[1], found[0], rtol=1e-7, atol=1e-12)


def test_the_record_changes_nothing(tmp_path):
    for options in ("precision double", "precision mixed", "kernel 2"):
        states = []
        for impacts in ("", IMPACTS):
            deck = _deck(tmp_path, options) + impacts
            deck += (
                "dump end all custom 300 end.dump id x y z vx vy vz\n"
                'dump_modify end format "%d %.17g %.17g %.17g %.17g %.17g %.17g"\nrun 300\n'
            )
            assert run(tmp_path, deck).code == 0
            dump = read_dump(tmp_path / "end.dump")
            states.append(np.column_stack([dump[n] for n in ("x", "y", "z", "vx", "vy", "vz")]))
        assert_array_equal(states[1], states[0])


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("precision", ["double", "mixed"])
def test_a_restart_goes_on_with_every_contact(tmp_path, ranks, precision):
    whole, halves = tmp_path / "whole", tmp_path / "halves"
    options = f"tangential_damping bounded precision {precision}"
    # The window begins before the restart.
    impacts = IMPACTS.replace("from 0 to 100", "from 0.005 to 100")
    deck = _deck(whole, options) + impacts
    # Both runs build a list at the step of the file.
    files = "restart 300 one.restart other.restart\n"
    deck += files
    expected = _told(run(whole, deck + "run 600\n" + TELL, ranks))
    _deck(halves, options)
    first = run(halves, deck + "run 300\nwrite_restart half.restart\n", ranks)
    assert first.code == 0, first.text[-2000:]
    (halves / FILE).unlink()
    again = again_deck("fast", options, deck).replace("timestep        5e-05", f"timestep {DT!r}")
    got = _told(run(halves, again + impacts + files + "run 300\n" + TELL, ranks))
    assert got == expected
    assert (halves / FILE).read_text() == (whole / FILE).read_text()


def _rows(path):
    with path.open() as file:
        return list(csv.DictReader(file))


def test_the_file_holds_the_contacts_of_the_window(tmp_path):
    window = f"from {100.5 * DT * SPEED!r} to {3500.5 * DT * SPEED!r}"
    impacts = IMPACTS.replace("from 0 to 100", window)
    deck = _deck(tmp_path, "precision mixed", CLASSES + "set atom 1*40 type 2\n") + impacts
    assert run(tmp_path, deck + "run 4000\n").code == 0
    rows = _rows(tmp_path / FILE)
    assert float(rows[0]["mill_angle_from_rad"]) == pytest.approx(101 * DT * SPEED, rel=1e-9)
    assert float(rows[0]["mill_angle_to_rad"]) == pytest.approx(3501 * DT * SPEED, rel=1e-9)
    assert float(rows[0]["duration_s"]) == pytest.approx(3400 * DT, rel=1e-9)

    def energy(pairing, quantity):
        return sum(
            float(r["energy_J"])
            for r in rows
            if r["pairing"] == pairing and r["quantity"] == quantity
        )

    classes = {(r["type_1"], r["type_2"]) for r in rows if r["pairing"] == "ball_ball"}
    assert {("1", "1"), ("1", "2"), ("2", "2")} <= classes
    for pairing in PAIRINGS:
        ended = energy(pairing, "dissipated")
        change = energy(pairing, "open_at_end") - energy(pairing, "open_at_begin")
        assert ended > 0.0
        assert ended + change == pytest.approx(energy(pairing, "all_contacts"), rel=1e-9)
    for row in rows:
        low, high = float(row["energy_low_J"]), float(row["energy_high_J"])
        if row["quantity"] in ("dissipated", "available") and low > 2e-11:
            mean = float(row["energy_J"]) / float(row["contacts"])
            assert low * (1 - 1e-9) <= mean <= high * (1 + 1e-9)


WRONG = [
    ("mill nobody file a from 0 to 1", "'nobody' is not the id of a fix mill/similarity"),
    ("mill mill from 0 to 1", "file: the name of the file to write is needed"),
    ("mill mill file a", "mill angles 0 <= from < to are needed [rad], got 0 and -1"),
    ("mill mill file a from 2 to 1", "got 2 and 1"),
    ("mill mill colour 3", "unknown keyword 'colour'; accepted are mill, file, from, to"),
]


@pytest.mark.parametrize(("words", "cause"), WRONG, ids=[words for words, _ in WRONG])
def test_wrong_arguments_give_one_line_of_cause(tmp_path, words, cause):
    result = run(tmp_path, _deck(tmp_path) + f"fix impacts all mill/impacts {words}\n")
    assert result.code != 0
    assert cause in result.error


def test_a_second_fix_is_refused(tmp_path):
    result = run(tmp_path, _deck(tmp_path) + IMPACTS + IMPACTS.replace("impacts all", "two all"))
    assert "a deck takes one fix mill/impacts" in result.error


def test_contacts_that_nothing_records_are_refused(tmp_path):
    stock = mill_deck(
        tmp_path, loose_bed(RADIUS, 2, SLICE, seed=5), S, "constant-gravity", wall="analytic"
    )
    assert "pair_style gran ... surface fast" in run(tmp_path, stock + IMPACTS + "run 1\n").error
    mesh = mill_deck(tmp_path, loose_bed(RADIUS, 2, SLICE, seed=5), S, "constant-gravity")
    result = run(tmp_path, with_contacts(mesh) + IMPACTS + "run 1\n")
    assert "walls must be fix wall/mill, got fix wall/gran" in result.error
    stays = _deck(tmp_path, "memory stock") + IMPACTS + "run 1\n"
    assert "needs `memory of_contact`" in run(tmp_path, stays).error


def test_a_file_that_cannot_be_written_stops_the_run(tmp_path):
    words = IMPACTS.replace(FILE, "nowhere/a.csv").replace("to 100", "to 0.001")
    result = run(tmp_path, _deck(tmp_path) + words + "run 100\n")
    assert result.code != 0
    assert "cannot write 'nowhere/a.csv'" in result.error
