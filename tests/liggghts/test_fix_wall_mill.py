"""fix wall/mill: the same wall as the mesh where that is exact, and the limit of finer meshes."""

import numpy as np
import pytest

from scene import SLICE, about_to_be_thrown, loose_bed, mill_deck, read_dump, run

S = 2.6
RADIUS = 3.9 / S
DT = 1e-4
SHOW = 'print "ball $(x[1]) $(z[1]) $(vx[1]) $(vz[1]) $(omegay[1])"\n'


def _ride(folder, wall, steps):
    """A ball riding a lifter's face: state, then force and torque on the wall."""
    folder.mkdir()
    position, velocity = about_to_be_thrown(S)
    deck = mill_deck(folder, position, S, "constant-gravity", dt=DT, wall=wall)
    deck += velocity + f"thermo_style custom step f_liner[1]\nthermo {steps}\nrun {steps}\n" + SHOW
    deck += 'print "wall ' + " ".join(f"$(f_liner[{k}])" for k in range(1, 7)) + '"\n'
    result = run(folder, deck)
    assert result.code == 0, result.text[-2000:]
    return result.printed("ball"), result.printed("wall")


def test_a_ball_on_a_flat_face_moves_as_on_the_mesh(tmp_path):
    # Face planes of mesh and wall are the same: only rounding tells them apart.
    ball, on_wall = _ride(tmp_path / "analytic", "analytic", 1500)
    mesh_ball, on_mesh = _ride(tmp_path / "mesh", "mesh", 1500)
    np.testing.assert_allclose(ball, mesh_ball, rtol=1e-9, atol=1e-10)
    assert np.linalg.norm(on_wall[:3]) > 0.01
    np.testing.assert_allclose(on_wall[:3], on_mesh[:3], rtol=1e-6, atol=1e-7)
    # The engine's torque leaves out the reaction of rolling friction, mu_r a F_n.
    rolling = 0.01 * 0.02 * np.linalg.norm(on_mesh[:3])
    assert np.linalg.norm(on_wall[3:] - on_mesh[3:]) < rolling


def test_a_finer_mesh_comes_closer_to_the_exact_arc(tmp_path):
    # The ball rolls over panel edges, where the stock wall starts a new contact: that error stays.
    rest = np.array([[0.03, SLICE / 2, -np.sqrt((RADIUS - 0.02) ** 2 - 0.03**2)]])

    def final(name, **wall):
        folder = tmp_path / name
        folder.mkdir()
        deck = mill_deck(folder, rest, S, "constant-gravity", dt=DT, start="never", **wall)
        result = run(folder, deck + "run 2000\n" + SHOW)
        return result.printed("ball")[:2]

    exact = final("exact", wall="analytic")
    errors = [
        np.linalg.norm(final(f"mesh{i}", chord_error=chord) - exact)
        for i, chord in enumerate((4e-3, 1e-3, 1e-4))
    ]
    assert errors[0] > errors[1] > errors[2]


def test_a_charge_comes_to_rest_on_the_wall_and_presses_with_its_weight(tmp_path):
    balls = loose_bed(RADIUS, 60, SLICE, seed=2)
    deck = mill_deck(tmp_path, balls, S, "constant-gravity", dt=DT, start="never", wall="analytic")
    deck += "fix damp all viscous 1.0\n"
    deck += (
        'thermo_style custom step ke f_liner[3]\nthermo 30000\nrun 30000\nprint "w $(f_liner[3])"\n'
    )
    deck += "dump end all custom 1 end.dump id x y z\nrun 0\n"
    result = run(tmp_path, deck)
    weight = 60 * 4 / 3 * np.pi * 0.02**3 * 2678 * 9.81
    assert result.printed("w")[0] == pytest.approx(-weight, rel=1e-3)  # balls rattle until 25000
    dump = read_dump(tmp_path / "end.dump")
    assert np.hypot(dump["x"], dump["z"]).max() < RADIUS - 0.0199
