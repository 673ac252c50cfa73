"""Stock LIGGGHTS reads the meshes; panel ends, rank borders and the period change no motion."""

import os
import subprocess

import numpy as np
import pytest
from numpy.testing import assert_allclose

from millscale.engine.material_block import ball_and_wall, material_block
from millscale.mesh import build_liner_mesh, curvature_deg, default_chord_error, write_stl

pytestmark = pytest.mark.engine

DECK = """
units si
atom_style granular
atom_modify map array
boundary f p f
newton off
communicate single vel yes
processors 1 {ranks} 1
region box block -{half_box!r} {half_box!r} 0 {length!r} -{half_box!r} {half_box!r} units box
create_box 2 box
neighbor 0.01 bin
neigh_modify delay 0
{material}pair_style gran model hertz tangential history
pair_coeff * *
timestep 5e-5
fix gravity all gravity 9.81 vector 0 0 -1
fix liner all mesh/surface file liner.stl type 2 verbose yes curvature {curvature!r}
fix wall all wall/gran model hertz tangential history mesh n_meshes 1 meshes liner
{balls}
set group all diameter 0.04 density 2678
fix integrate all nve/sphere
{motion}
dump end all custom {steps} end.txt id x y z
dump_modify end sort id format "%d %.17g %.17g %.17g"
thermo_modify lost error
run {steps}
"""


MATERIAL = material_block(
    [5.98e7] * 2,
    [0.3] * 2,
    restitution=ball_and_wall(0.1, 0.2),
    friction=ball_and_wall(0.5, 0.5),
)


def run(folder, ranks, mesh, radius, length, balls, motion="", steps=400):
    """Run the deck; return the last positions (n, 3) by ball, and the engine's output."""
    write_stl(folder / "liner.stl", mesh)
    lines = [f"create_atoms 1 single {x!r} {y!r} {z!r} units box" for x, y, z in balls]
    deck = DECK.format(
        material=MATERIAL,
        ranks=ranks,
        half_box=1.05 * radius,
        length=length,
        curvature=curvature_deg(mesh),
        balls="\n".join(lines),
        motion=motion,
        steps=steps,
    )
    (folder / "in.deck").write_text(deck)
    allow_root = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    done = subprocess.run(
        ["mpirun", "-np", str(ranks), "--oversubscribe", "liggghts", "-in", "in.deck"],
        cwd=folder,
        env=os.environ | (allow_root if os.geteuid() == 0 else {}),
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    text = done.stdout + done.stderr
    assert done.returncode == 0, text[-2000:]
    last = (folder / "end.txt").read_text().split("ITEM: ATOMS id x y z")[-1]
    rows = np.array([line.split() for line in last.splitlines() if line.strip()], float)
    return rows[np.argsort(rows[:, 0]), 1:], text


def test_meshes_of_table_4_are_read_and_turned_without_a_warning(table4_mill, tmp_path):
    mill, S = table4_mill
    for number, chord_error in enumerate((default_chord_error(0.02, S), 1e-5)):
        folder = tmp_path / str(number)
        folder.mkdir()
        mesh = build_liner_mesh(mill, 1.0 / S, chord_error)
        _, text = run(
            folder,
            ranks=2,
            mesh=mesh,
            radius=mill.radius,
            length=1.0 / S,
            balls=[(0.0, 0.3 / S, -mill.radius + 0.02)],
            motion="fix turn all move/mesh mesh liner rotate origin 0 0 0 axis 0 1 0 period 6.28",
        )
        assert f"{len(mesh.triangles)} triangle(s) successful" in text
        assert "WARNING" not in text


# On the periodic boundary, on borders of ranks and panels, and between them.
ALONG_THE_AXIS = (0.0, 0.1, 0.2, 1.0 / 3.0, 0.42, 0.5, 0.58, 2.0 / 3.0, 0.8, 0.93)


def assert_alike(end):
    for column, expected in ((0, end[0, 0]), (1, ALONG_THE_AXIS), (2, end[0, 2])):
        assert_allclose(end[:, column], expected, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("ranks", [1, 2, 3])
@pytest.mark.parametrize("divisions", [1, 3])
def test_balls_along_the_axis_roll_alike(physical, tmp_path, ranks, divisions):
    mesh = build_liner_mesh(physical, 1.0, 5e-4, divisions)
    balls = [(0.06, y, -3.8795) for y in ALONG_THE_AXIS]
    end, _ = run(tmp_path, ranks, mesh, 3.9, 1.0, balls, steps=6000)
    assert 0.0 < end[0, 0] < 0.06
    assert_alike(end)


@pytest.mark.parametrize("divisions", [1, 3])
def test_balls_along_the_axis_cross_panel_edges_alike_on_one_rank(physical, tmp_path, divisions):
    # At x = 0 two chords join and a ball is in contact with both. Which one the engine uses depends
    # on the order of the triangles on the rank, so this holds on one rank only.
    mesh = build_liner_mesh(physical, 1.0, 5e-4, divisions)
    balls = [(0.003, y, -3.8799) for y in ALONG_THE_AXIS]
    end, _ = run(tmp_path, 1, mesh, 3.9, 1.0, balls, steps=6000)
    assert end[0, 0] < -1e-3
    assert_alike(end)
