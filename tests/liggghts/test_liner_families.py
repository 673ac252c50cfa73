"""Liners from profile files in the engine: forces, energy, records, refused files."""

import numpy as np
import pytest

from liner_families import FAMILIES, RADIUS, all_around, hi_lo, ship_lap, turned, worn
from millscale import _core
from scene import SLICE, loose_bed, mill_deck, read_dump, run
from wall_bench import Balls, Materials, Mill, columns, fly, kinetic_energy

BALL = 0.02
ELASTIC = Materials([1.0], [0.0], 0.0)


def _in_space(liner, point, sector, y=0.25):
    """A point of a sector's frame in space."""
    angle = liner.phase + sector * liner.pitch
    c, s = np.cos(angle), np.sin(angle)
    radial, tangential = point
    return [-radial * s - tangential * c, y, -radial * c + tangential * s]


def _touches_of_lines(liner, count, random):
    """(count, 3) centres of balls that overlap lines of the profile, away from their ends."""
    nodes = liner.nodes
    lines = []
    for i, (radial, tangential, arc, *_) in enumerate(nodes):
        begin = np.array([radial, tangential])
        end = (
            np.array(nodes[i + 1][:2]) if i + 1 < len(nodes) else turned(nodes[0][:2], liner.pitch)
        )
        if arc == 0.0 and np.linalg.norm(end - begin) > 2.5 * BALL:
            lines.append((begin, end))
    centres = []
    for k in range(count):
        begin, end = lines[k % len(lines)]
        along = (end - begin) / np.linalg.norm(end - begin)
        normal = np.array([-along[1], along[0]])
        margin = 0.5 * BALL / np.linalg.norm(end - begin)
        on = begin + random.uniform(margin, 1.0 - margin) * (end - begin)
        centre = on + random.uniform(0.9, 0.99) * BALL * normal
        place = _in_space(liner, centre, int(random.integers(liner.sectors)))
        if liner.nearest(place[0], place[2]).distance > 0.88 * BALL:
            centres.append(place)
    return np.array(centres)


OF_LINES = {"hi-lo": lambda: hi_lo(0.0), "worn": lambda: worn(0.0), "ship-lap": ship_lap}


@pytest.mark.parametrize("family", OF_LINES)
def test_forces_on_lines_are_those_of_the_mesh(tmp_path, family):
    liner = OF_LINES[family]()
    centres = _touches_of_lines(liner, 10_000, np.random.default_rng(3))
    assert len(centres) > 5_000
    # One contact: near a corner the mesh has the other side's panels too, near an edge it counts
    # the edge as well.
    alone = np.bincount(liner.contacts(centres[:, [0, 2]], BALL).ball, minlength=len(centres)) == 1
    balls = Balls.of(centres[alone])
    force = {}
    for wall in ("mesh", "arc"):
        mill = Mill(wall, liner, 1e-4)
        state = fly(tmp_path / wall, mill, balls, Materials(), 1e-6, 0)[-1]
        force[wall] = columns(state, "fx fy fz")
    size = np.linalg.norm(force["mesh"], axis=1)
    assert (size > 0.0).all() and len(size) > 4_000
    # Overlaps of 2e-4 m and more are known to 3e-16 of 1.5 m.
    assert (np.linalg.norm(force["arc"] - force["mesh"], axis=1) / size).max() < 1e-10


@pytest.mark.parametrize("family", FAMILIES)
def test_elastic_balls_keep_their_energy_wherever_they_hit(tmp_path, family):
    liner, random = FAMILIES[family](), np.random.default_rng(4)
    starts, velocities = [], []
    for radial, tangential, *_ in liner.nodes:
        for sector in (0, liner.sectors - 1):
            joint = np.array(_in_space(liner, (radial, tangential), sector))
            for _ in range(60):
                aim = random.uniform(-np.pi, np.pi)
                to = np.array([np.cos(aim), 0.0, np.sin(aim)])
                target = joint + random.uniform(-0.3, 0.3, 3) * BALL * [1.0, 0.0, 1.0]
                start = target - 1.3 * BALL * to
                if liner.nearest(start[0], start[2]).distance > 1.01 * BALL:
                    starts.append(start)
                    velocities.append(to)
    balls = Balls.of(starts, velocities)
    dt = 2e-5
    steps = round(3.0 * BALL / dt)
    state = fly(tmp_path, Mill("arc", liner, 1e-4), balls, ELASTIC, dt, steps)[-1]
    velocity, spin = columns(state, "vx vy vz"), columns(state, "omegax omegay omegaz")
    free = np.abs(columns(state, "fx fy fz")).max(axis=1) < 1e-6
    hit = np.linalg.norm(velocity - balls.velocity, axis=1) > 0.1
    assert (free & hit).sum() > 20
    ratio = kinetic_energy(balls, velocity, spin) / kinetic_energy(
        balls, balls.velocity, 0.0 * spin
    )
    # An impact at 1 m/s has 100 steps or more: Verlet's error is 2 / 100^2 of the energy.
    np.testing.assert_allclose(ratio[free], 1.0, rtol=0.0, atol=2e-4)


S = 2.6
LIFTERS = _core.Lifters(3.9 / S, 3.61 / S, 0.25 / S, 0.635 / S, 25)
RECORDS = (
    "compute charge all mill/charge mill mill\nfix guard all mill/guard mill mill every 1\n"
    "thermo_style custom step c_charge[1] c_detach[1] f_liner[5]\n"
    "dump state all custom STEPS end.dump id x z vx vz c_detach[1] c_detach[5] c_detach[15] "
    'c_detach[24]\ndump_modify state format "%d' + 8 * " %.15g" + '"\n'
    'run STEPS\nprint "values $(c_charge[8]) $(c_charge[9]) $(c_charge[12]) $(c_detach[10])"\n'
)


def _bed(folder, liner, steps=600):
    """Values of the charge and state of the balls in a mill with this liner."""
    folder.mkdir()
    (folder / "liner.csv").write_text(liner.text)
    deck = mill_deck(
        folder, loose_bed(RADIUS, 60, SLICE, 1), S, "constant-gravity", wall="analytic"
    )
    for old, new in (
        ("type 2 lifters", "type 2\n#"),
        (
            f"mill/detach mill mill lifters 25 lifter_top_radius {3.61 / S!r}",
            "mill/detach mill mill",
        ),
        (f"scale {S!r}", f"scale {S!r} profile liner.csv"),
    ):
        assert old in deck
        deck = deck.replace(old, new)
    result = run(folder, deck + RECORDS.replace("STEPS", str(steps)))
    assert result.error == "", result.text[-500:]
    return result.printed("values"), read_dump(folder / "end.dump")


def test_an_outline_all_around_is_the_same_mill(tmp_path):
    values, state = _bed(tmp_path / "sectors", LIFTERS)
    around_values, around = _bed(tmp_path / "around", all_around(LIFTERS))
    assert values[0] > 0.0 and len(set(state["c_detach[24]"])) > 1
    for lifter in ("c_detach[5]", "c_detach[15]", "c_detach[24]", "c_detach[1]"):
        np.testing.assert_array_equal(around[lifter], state[lifter])
    # Nodes turned by up to 2 pi are off by 1e-16; impacts amplify this by a factor of ten or so.
    for column in ("x", "z", "vx", "vz"):
        np.testing.assert_allclose(around[column], state[column], rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(around_values, values, rtol=1e-7)


def test_records_name_the_lifters_of_a_sector_with_two(tmp_path):
    steps = 4000
    values, state = _bed(tmp_path / "sectors", hi_lo(), steps)
    around_values, around = _bed(tmp_path / "around", all_around(hi_lo()), steps)
    last = state["c_detach[24]"]
    assert len(set(last)) > 1
    # Balls on the wall are before their lifter, as of the last look, one each 0.013 rad, but for
    # those that have just come to the wall.
    angles = hi_lo().lifter_angles
    assert len(angles) == 20
    turned_by = np.sqrt(S) * steps * 5e-5
    place = np.arctan2(-state["x"], -state["z"]) - turned_by
    before = np.mod(place - angles[last.astype(int)] + 0.013, 2.0 * np.pi)
    to_next = np.mod(np.roll(angles, -1) - angles, 2.0 * np.pi)[last.astype(int)]
    assert (before < to_next + 2.0 * 0.013)[state["c_detach[1]"] == 1].mean() > 0.8
    np.testing.assert_array_equal(around["c_detach[24]"], last)
    np.testing.assert_allclose(around_values, values, rtol=1e-7)
    assert values[2] > 0.0
