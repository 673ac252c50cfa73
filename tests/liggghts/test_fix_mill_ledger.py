"""fix mill/ledger: single contacts against closed forms, a tumbling charge, ranks, restarts."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from contact_bounds import restitution_bound
from scene import (
    HEAD,
    SLICE,
    analytic_wall,
    loose_bed,
    material,
    mill_deck,
    read_dump,
    run,
    wall_and_drive,
    with_contacts,
)

S = 2.6
RADIUS, BALL, DENSITY, YOUNG = 3.9 / S, 0.02, 2678.0, 5.98e7
MASS = 4.0 / 3.0 * np.pi * BALL**3 * DENSITY
# Of `scene.material`; balls, wall.
RESTITUTION, FRICTION, ROLLING = (0.1, 0.2), (0.545, 0.5), 0.01
DT = 1e-4
_PAIRING = (
    *("elastic_normal", "elastic_tangential"),
    *("dissipated_normal", "dissipated_tangential", "dissipated_rolling"),
    *("dashpot", "slip", "spring_error"),
)
NAMES = (
    *("work", "translation", "rotation", "potential"),
    *(f"{pairing}_{term}" for pairing in ("balls", "wall") for term in _PAIRING),
    *("residual", "balls_impacts", "balls_impact_energy", "wall_impacts", "wall_impact_energy"),
)
LEDGER = "fix ledger all mill/ledger mill mill\n"
TELL = 'print "ledger ' + " ".join(f"$(f_ledger[{k + 1}])" for k in range(len(NAMES))) + '"\n'
PATHS = {"bounded": "tangential_damping bounded", "stock": "tangential_damping on memory stock"}


def _told(result):
    assert result.code == 0, result.text[-2000:]
    return dict(zip(NAMES, result.printed("ledger "), strict=True))


def _dissipated(told, pairing):
    return sum(told[f"{pairing}_dissipated_{kind}"] for kind in ("normal", "tangential", "rolling"))


def _unaccounted(told):
    """What neither terms nor the springs' error account for [J]: rounding."""
    return told["residual"] - told["balls_spring_error"] - told["wall_spring_error"]


def _two_bodies(places, velocities, spins, options="", gravity=1e-9, dt=1e-5):
    """Balls in a resting drum of 1.5 m without lifters."""
    box = 1.02 * RADIUS
    create = (
        "".join(
            f"create_atoms 1 single {x!r} {y!r} {z!r} units box\n"
            for x, y, z in np.array(places) + 0.0
        )
        .replace("np.float64(", "")
        .replace(")", "")
    )
    motion = "".join(
        f"set atom {i + 1} vx {v[0]!r} vy {v[1]!r} vz {v[2]!r} "
        f"omegax {w[0]!r} omegay {w[1]!r} omegaz {w[2]!r}\n"
        for i, (v, w) in enumerate(zip(velocities, spins, strict=True))
    )
    deck = (
        HEAD
        + f"region box block -{box!r} {box!r} 0 {SLICE!r} -{box!r} {box!r} units box\n"
        + "create_box 2 box\n"
        + material(0.02, dt, YOUNG)
        + create
        + "set type 1 diameter 0.04 density 2678\n"
        + motion
        + analytic_wall(S, 0)
        + f"fix mill all mill/similarity radius {RADIUS!r} gravity {gravity!r} omega 1e-6 "
        + f"ball_radius {BALL!r} centrifuging allow start never\n"
        + "fix integrate all nve/sphere\nfix forces all mill/forces\nthermo_modify lost error\n"
    )
    return with_contacts(deck, "fast", options) + LEDGER


def _impact(restitution, mass, radius, speed, dt):
    """(share of the impact energy by which its dissipation may be off), of a normal impact."""
    effective = YOUNG / (2.0 * (1.0 - 0.3**2))
    stiffness = 4.0 / 3.0 * effective * np.sqrt(radius)
    overlap = (1.25 * mass * speed**2 / stiffness) ** 0.4
    first, share = speed * dt / overlap, dt * speed / (2.94 * overlap)
    bound = restitution_bound(restitution, share, first)[0]
    # e^2 of the energy comes back; what the springs' trapezium rule loses goes to its own row, at
    # most the first step's square.
    return 2.0 * restitution * bound + first**2


STILL = (0.0, 0.0, 0.0)


@pytest.mark.parametrize("options", PATHS.values(), ids=PATHS)
def test_two_balls_dissipate_one_minus_the_square_of_restitution(tmp_path, options):
    speed, dt = 1.0, 1e-5
    places = [(0.0, 0.1, 0.0), (0.041, 0.1, 0.0)]
    deck = _two_bodies(places, [(speed, 0.0, 0.0), STILL], [STILL, STILL], options)
    told = _told(run(tmp_path, deck + "run 1000\n" + TELL))
    energy = 0.5 * (0.5 * MASS) * speed**2
    off = _impact(RESTITUTION[0], 0.5 * MASS, 0.5 * BALL, speed, dt)
    assert off < 0.01
    lost = (1.0 - RESTITUTION[0] ** 2) * energy
    assert told["balls_dissipated_normal"] == pytest.approx(lost, abs=off * energy)
    assert told["balls_impacts"] == 1.0
    # It has flown freely until then, but for a gravity of 1e-9 m/s^2.
    assert told["balls_impact_energy"] == pytest.approx(energy, rel=1e-9)
    assert told["balls_elastic_normal"] == 0.0
    assert _unaccounted(told) == pytest.approx(0.0, abs=1e-12 * energy)


@pytest.mark.parametrize("options", PATHS.values(), ids=PATHS)
@pytest.mark.parametrize("along", [0.3, 3.0], ids=["sticks", "slides"])
def test_an_oblique_impact_loses_what_the_account_says(tmp_path, options, along):
    places = [(0.0, 0.1, 0.0), (0.0401, 0.1, 0.0)]
    spins = [(0.0, 5.0, -10.0), (3.0, 0.0, 20.0)]
    deck = _two_bodies(places, [(1.0, along, 0.2), STILL], spins, options)
    told = _told(run(tmp_path, deck + "run 1000\n" + TELL))
    lost = -told["translation"] - told["rotation"]
    assert lost > 0.0
    assert _dissipated(told, "balls") + told["balls_spring_error"] == pytest.approx(lost, rel=1e-9)
    assert told["balls_dissipated_tangential"] > 0.0
    share = told["balls_slip"] / told["balls_dissipated_tangential"]
    assert share > 0.1 if along > 1.0 else 0.0 < share < 0.01


def test_a_ball_on_the_wall_dissipates_one_minus_the_square_of_restitution(tmp_path):
    speed, dt = 1.0, 1e-5
    place = (0.0, 0.1, -RADIUS + BALL + 1e-4)
    deck = _two_bodies([place], [(0.0, 0.0, -speed)], [STILL])
    told = _told(run(tmp_path, deck + "run 1000\n" + TELL))
    energy = 0.5 * MASS * speed**2
    off = _impact(RESTITUTION[1], MASS, BALL, speed, dt)
    assert off < 0.01
    lost = (1.0 - RESTITUTION[1] ** 2) * energy
    assert told["wall_dissipated_normal"] == pytest.approx(lost, abs=off * energy)
    assert told["wall_impacts"] == 1.0
    assert told["wall_impact_energy"] == pytest.approx(energy, rel=1e-9)
    assert told["balls_impacts"] == 0.0
    assert told["work"] == 0.0


def test_a_rolling_ball_loses_the_work_of_rolling_friction(tmp_path):
    gravity, speed, steps, dt = 9.81, 0.2, 5000, 2e-5
    effective = YOUNG / (2.0 * (1.0 - 0.3**2))
    overlap = (MASS * gravity / (4.0 / 3.0 * effective * np.sqrt(BALL))) ** (2.0 / 3.0)
    spin = speed / BALL
    place = (0.0, 0.1, -RADIUS + BALL - overlap)
    # Along the axis it stays at the bottom; the periodic box is its way.
    deck = _two_bodies([place], [(0.0, speed, 0.0)], [(-spin, 0.0, 0.0)], gravity=gravity, dt=dt)
    told = _told(run(tmp_path, deck + f"run {steps}\n" + TELL))
    slows = ROLLING * gravity / (1.4 * BALL)
    turned = spin * steps * dt - 0.5 * slows * (steps * dt) ** 2
    # The lever is half an overlap shorter than the radius, 0.1 %.
    assert told["wall_dissipated_rolling"] == pytest.approx(
        ROLLING * MASS * gravity * BALL * turned, rel=0.005
    )
    assert told["wall_slip"] == 0.0
    assert told["wall_impacts"] == 0.0 or told["wall_impact_energy"] < 1e-12


# Diameters 1 : 1.5 : 2.5 of a hundred balls, the largest those of the equal ones.
CLASSES = "".join(
    f"set atom {first}*{last} diameter {diameter} density {DENSITY}\n"
    for first, last, diameter in ((1, 40, 0.016), (41, 70, 0.024), (71, 100, 0.04))
)


def _drum(folder, options, dt=DT, balls=100):
    deck = mill_deck(
        folder,
        loose_bed(RADIUS, balls, SLICE, seed=5),
        S,
        "constant-gravity",
        dt=dt,
        wall="analytic",
    )
    return with_contacts(deck, "fast", options)


@pytest.mark.parametrize("options", PATHS.values(), ids=PATHS)
def test_the_account_of_a_tumbling_charge_closes(tmp_path, options):
    # Half a second: the heap collapses, is lifted, and rolls.
    deck = _drum(tmp_path, options) + LEDGER
    deck += 'fix torque all print 1 "$(-f_liner[5]*f_mill[2])" screen no file power.txt\n'
    told = _told(run(tmp_path, deck + "run 5000\n" + TELL))
    work = told["work"]
    assert work > 20.0
    # The issue's tolerance; the springs' error, of the order of the step squared, is all of it.
    assert abs(told["residual"]) < 0.01 * work
    # But for gravity's end terms, dt^2 / 8 times weight times acceleration: 1e-9 x 90 N x 50 m/s^2.
    assert abs(_unaccounted(told)) < 1e-5
    power = np.loadtxt(tmp_path / "power.txt", comments="#")
    assert work == pytest.approx(np.trapezoid(power, dx=DT), rel=1e-4)
    for pairing in ("balls", "wall"):
        for kind in ("normal", "tangential", "rolling"):
            assert told[f"{pairing}_dissipated_{kind}"] > 0.0


@pytest.mark.parametrize("options", PATHS.values(), ids=PATHS)
def test_the_account_of_three_classes_closes(tmp_path, options):
    # The smallest ball's contact has as many steps as the equal balls' have.
    dt = 0.4 * DT
    deck = _drum(tmp_path, options, dt) + CLASSES + LEDGER
    told = _told(run(tmp_path, deck + "run 12500\n" + TELL))
    assert told["work"] > 5.0
    # The tolerances of the equal balls.
    assert abs(told["residual"]) < 0.01 * told["work"]
    assert abs(_unaccounted(told)) < 1e-5
    for pairing in ("balls", "wall"):
        for kind in ("normal", "tangential", "rolling"):
            assert told[f"{pairing}_dissipated_{kind}"] > 0.0


def test_the_springs_error_falls_with_the_square_of_the_step(tmp_path):
    errors = []
    for k, dt in enumerate((2e-4, 5e-5)):
        (tmp_path / str(k)).mkdir()
        deck = _drum(tmp_path / str(k), PATHS["bounded"], dt) + LEDGER
        told = _told(run(tmp_path / str(k), deck + f"run {round(0.4 / dt)}\n" + TELL))
        errors.append((told["balls_spring_error"] + told["wall_spring_error"]) / told["work"])
    # 16; the two charges move apart, and so do their impacts.
    assert 8.0 < errors[0] / errors[1] < 32.0


def test_the_account_is_the_same_on_two_ranks(tmp_path):
    tellings = []
    for ranks in (1, 2):
        folder = tmp_path / str(ranks)
        folder.mkdir()
        deck = _drum(folder, PATHS["bounded"]) + LEDGER
        tellings.append(_told(run(folder, deck + "run 300\n" + TELL, ranks)))
    one, two = (np.array(list(told.values())) for told in tellings)
    # Forces are summed in another order: 1e-16 a step, which the contacts amplify.
    assert_allclose(two, one, rtol=1e-7, atol=1e-9)
    assert tellings[0]["balls_impacts"] > 20.0


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_restart_goes_on_with_the_account(tmp_path, ranks):
    whole, halves = tmp_path / "whole", tmp_path / "halves"
    for folder in (whole, halves):
        folder.mkdir()
    window = LEDGER.replace("mill mill\n", "mill mill impacts impacts.csv from 0.01 to 0.06\n")
    deck = _drum(whole, PATHS["bounded"]) + window
    expected = _told(run(whole, deck + "run 400\n" + TELL, ranks))
    first = run(halves, deck + "run 200\nwrite_restart half.restart\n", ranks)
    assert first.code == 0, first.text[-2000:]
    (halves / "impacts.csv").unlink()
    again = (
        HEAD
        + "read_restart half.restart\n"
        + with_contacts(material(0.02, DT, YOUNG), "fast", PATHS["bounded"])
        + wall_and_drive(
            S,
            "constant-gravity",
            analytic_wall(S),
            "now",
            f"lifters 25 lifter_top_radius {3.61 / S!r}",
        )
        + window
    )
    got = _told(run(halves, again + "run 200\n" + TELL, ranks))
    assert_allclose(list(got.values()), list(expected.values()), rtol=1e-6, atol=1e-8)
    assert (halves / "impacts.csv").read_text() == (whole / "impacts.csv").read_text()


def test_runs_one_after_the_other_stay_closed(tmp_path):
    # The engine evaluates the forces anew between them, with other velocities.
    deck = _drum(tmp_path, PATHS["bounded"]) + LEDGER
    told = _told(run(tmp_path, deck + "run 700\n" * 5 + TELL))
    assert abs(_unaccounted(told)) < 1e-5


def test_the_account_changes_nothing(tmp_path):
    states = []
    for ledger in ("", LEDGER):
        deck = _drum(tmp_path, PATHS["bounded"] + " kernel 2") + ledger
        deck += (
            "dump end all custom 300 end.dump id x y z vx vy vz\n"
            'dump_modify end format "%d %.17g %.17g %.17g %.17g %.17g %.17g"\nrun 300\n'
        )
        assert run(tmp_path, deck).code == 0
        dump = read_dump(tmp_path / "end.dump")
        states.append(np.column_stack([dump[n] for n in ("x", "y", "z", "vx", "vy", "vz")]))
    assert_array_equal(states[1], states[0])


def test_impacts_of_the_window_are_in_the_file(tmp_path):
    speed = float(np.sqrt(S))
    window = LEDGER.replace(
        "mill mill\n", f"mill mill impacts impacts.csv from 0 to {300.5 * DT * speed!r}\n"
    )
    deck = _drum(tmp_path, PATHS["bounded"]) + window
    told = _told(run(tmp_path, deck + "run 300\n" + TELL + "run 100\n"))
    lines = (tmp_path / "impacts.csv").read_text().splitlines()
    assert lines[0] == (
        "mill_angle_from_rad,mill_angle_to_rad,pairing,energy_low_J,energy_high_J,impacts,energy_J"
    )
    rows = [line.split(",") for line in lines[1:]]
    assert float(rows[0][1]) == pytest.approx(300 * DT * speed, rel=1e-9)
    for pairing, name in (("ball_ball", "balls"), ("ball_wall", "wall")):
        own = np.array([row[3:] for row in rows if row[2] == pairing], float)
        low, high, count, energy = own.T
        assert count.sum() == told[f"{name}_impacts"]
        assert energy.sum() == pytest.approx(told[f"{name}_impact_energy"], rel=1e-8)
        some = count > 0.0
        mean = energy[some] / count[some]
        assert (
            (mean >= low[some] * (1 - 1e-9)) & (mean <= high[some] * (1 + 1e-9))
            | (low[some] < 2e-11)
        ).all()


WRONG = [
    ("mill nobody", "'nobody' is not the id of a fix mill/similarity"),
    ("mill mill impacts a", "mill angles 0 <= from < to are needed [rad], got from 0 to -1"),
    ("mill mill impacts a from 2 to 1", "got from 2 to 1"),
    ("mill mill colour 3", "unknown keyword 'colour'; accepted are mill, impacts, from, to"),
]


@pytest.mark.parametrize(("words", "cause"), WRONG, ids=[words for words, _ in WRONG])
def test_wrong_arguments_give_one_line_of_cause(tmp_path, words, cause):
    result = run(tmp_path, _drum(tmp_path, "") + f"fix ledger all mill/ledger {words}\n")
    assert result.code != 0
    assert cause in result.error


def test_a_second_ledger_is_refused(tmp_path):
    result = run(tmp_path, _drum(tmp_path, "") + LEDGER + LEDGER.replace("ledger all", "two all"))
    assert "a deck takes one fix mill/ledger" in result.error


def test_contacts_without_an_energy_budget_are_refused(tmp_path):
    stock = mill_deck(
        tmp_path, loose_bed(RADIUS, 2, SLICE, seed=5), S, "constant-gravity", wall="analytic"
    )
    assert "pair_style gran ... surface fast" in run(tmp_path, stock + LEDGER + "run 1\n").error
    mesh = mill_deck(tmp_path, loose_bed(RADIUS, 2, SLICE, seed=5), S, "constant-gravity")
    result = run(tmp_path, with_contacts(mesh) + LEDGER + "run 1\n")
    assert "walls must be fix wall/mill, got fix wall/gran" in result.error


def test_a_file_that_cannot_be_written_stops_the_run(tmp_path):
    words = "impacts nowhere/impacts.csv from 0 to 0.001\n"
    result = run(
        tmp_path,
        _drum(tmp_path, "") + LEDGER.replace("mill mill\n", f"mill mill {words}") + "run 100\n",
    )
    assert result.code != 0
    assert "cannot write 'nowhere/impacts.csv'" in result.error
