"""Small scenes in the engine: a deck, its liner mesh, and what it printed."""

from __future__ import annotations

import os
import subprocess
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy.optimize

from millscale import _core
from millscale.engine.deck_run import find_engine
from millscale.engine.material_block import ball_and_wall, material_block
from millscale.mesh import build_liner_mesh, curvature_deg, write_stl

HEAD = """
units           si
atom_style      granular
atom_modify     map array
boundary        f p f
newton          off
communicate     single vel yes
processors      1 * 1
neigh_modify    delay 0
"""
STOCK_CONTACTS = "pair_style      gran model hertz tangential history rolling_friction cdt"


def material(
    skin: float,
    dt: float,
    modulus: float = 5.98e7,
    restitution: tuple[float, float] = (0.1, 0.2),
) -> str:
    """Return the properties of balls (type 1) and wall (type 2), and stock contacts of balls.

    Args:
        skin: of the neighbour list [m].
        dt: time step [s].
        modulus: Young's modulus [Pa].
        restitution: of two balls, and of ball and wall.
    """
    properties = material_block(
        [modulus] * 2,
        [0.3] * 2,
        restitution=ball_and_wall(*restitution),
        friction=ball_and_wall(0.545, 0.5),
        rolling_friction=ball_and_wall(0.01, 0.01),
    )
    return (
        f"{properties}neighbor {skin!r} bin\n{STOCK_CONTACTS}\n"
        f"pair_coeff      * *\ntimestep        {dt!r}\n"
    )


SLICE = 0.2  # length of the periodic slice [m]


@dataclass(frozen=True)
class Ran:
    """What a deck printed, and whether it came to its end."""

    code: int
    text: str

    @property
    def error(self) -> str:
        """The engine's error line; empty if there is none."""
        lines = [line for line in self.text.splitlines() if "ERROR" in line]
        return lines[0] if lines else ""

    def printed(self, mark: str) -> np.ndarray:
        """Numbers of the last line that begins with `mark`."""
        lines = [line for line in self.text.splitlines() if line.startswith(mark)]
        assert lines, self.text[-2000:]
        return np.array([float(word) for word in lines[-1][len(mark) :].split()])


def run(folder: Path, deck: str, ranks: int = 1) -> Ran:
    """Run a deck in a folder."""
    (folder / "deck.in").write_text(deck)
    return run_file(folder, "deck.in", ranks)


def run_file(folder: Path, deck: str, ranks: int = 1) -> Ran:
    """Run a deck that is a file of the folder."""
    line = ["mpirun", "-np", str(ranks), "--bind-to", "none", "--oversubscribe"] * (ranks > 1)
    # On a busy machine ranks that wait give way to those that work.
    environment = dict(os.environ) | {"OMPI_MCA_mpi_yield_when_idle": "1"}
    if ranks == 1:  # without mpirun: no daemon of its own
        environment |= {"OMPI_MCA_ess_singleton_isolated": "1"}
    if os.geteuid() == 0:
        environment |= {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
    done = subprocess.run(
        [*line, str(find_engine()), "-in", deck],
        cwd=folder,
        env=environment,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        errors="replace",  # the engine appends an uninitialised text to some errors
        timeout=300,
    )
    return Ran(done.returncode, done.stdout + done.stderr)


def with_contacts(deck: str, contacts: str = "fast", options: str = "") -> str:
    """The deck with the stock contacts of balls, or with our fast ones and their options."""
    assert STOCK_CONTACTS in deck
    surface = {"stock": "", "fast": f" surface fast {options}"}[contacts]
    return deck.replace(STOCK_CONTACTS, STOCK_CONTACTS + surface)


def write_liner(folder: Path, liner: _core.Profile, length: float, chord_error: float) -> float:
    """Write liner.stl; returns the curvature [deg] the engine needs for it."""
    mesh = build_liner_mesh(liner, length, chord_error)
    write_stl(folder / "liner.stl", mesh)
    return curvature_deg(mesh)


def mill_deck(
    folder: Path,
    positions: np.ndarray,
    S: float,
    scheme: str,
    *,
    youngs_modulus: float = 5.98e7,
    dt: float = 5e-5,
    start: str = "now",
    lifters: int = 25,
    wall: str = "mesh",
    chord_error: float = 4e-3,
    length: float = SLICE,
) -> str:
    """A deck, up to its first run, of balls in the scaled paper mill with its meshed liner.

    Args:
        positions: (n, 3) of the balls [m].
        lifters: 25, or 0 for a plain drum.
        wall: "mesh" or "analytic".
        length: of the periodic slice [m].
    """
    physical = _core.OperatingPoint(3.9, 0.02, 9.81, 1.0)
    radius = _core.scale(physical, S, scheme).mill.radius
    top = 3.61 / S if lifters else 0.0
    shape = (top, 0.25 / S, 0.635 / S, lifters) if lifters else (0.0, 0.0, 0.0, 0)
    if wall == "mesh":
        curvature = write_liner(folder, _core.Lifters(radius, *shape), length, chord_error)
        liner = mesh_wall(curvature)
    else:
        liner = analytic_wall(S, lifters)
    create = "".join(
        f"create_atoms 1 single {x!r} {y!r} {z!r} units box\n" for x, y, z in positions.tolist()
    )
    detach = f"lifters {lifters} lifter_top_radius {top!r}" if lifters else ""
    box = 1.02 * radius
    return (
        HEAD
        + f"region box block -{box!r} {box!r} 0 {length!r} -{box!r} {box!r} units box\n"
        + "create_box 2 box\n"
        + material(0.02, dt, youngs_modulus)
        + create
        + "set type 1 diameter 0.04 density 2678\n"
        + wall_and_drive(S, scheme, liner, start, detach)
    )


def mesh_wall(curvature: float) -> str:
    """The liner as liner.stl."""
    return (
        f"fix liner all mesh/surface/stress file liner.stl type 2 curvature {curvature!r} "
        "reference_point 0 0 0\n"
        "fix wall all wall/gran model hertz tangential history rolling_friction cdt "
        "mesh n_meshes 1 meshes liner\n"
    )


def analytic_wall(S: float, lifters: int = 25) -> str:
    """The paper's liner, scaled by S, or a plain drum, as exact arcs and lines."""
    shape = (
        f"lifters 25 lifter_top_radius {3.61 / S!r} lifter_top_width {0.25 / S!r} "
        f"groove_width {0.635 / S!r}"
    )
    return f"fix liner all wall/mill mill mill type 2 {shape if lifters else ''}\n"


def wall_and_drive(S: float, scheme: str, liner: str, start: str, detach: str) -> str:
    """The part of a deck that is repeated after a restart.

    Args:
        liner: of mesh_wall or analytic_wall.
    """
    mesh = "mesh liner" if "mesh" in liner else ""
    return (
        f"{liner}fix mill all mill/similarity radius 3.9 gravity 9.81 omega 1.0 ball_radius 0.02 "
        f"scale {S!r} scheme {scheme} start {start} {mesh}\n"
        f"compute detach all mill/detach mill mill {detach}\n"
        "fix integrate all nve/sphere\nfix forces all mill/forces\nthermo_modify lost error\n"
    )


def loose_bed(radius: float, count: int, length: float, seed: int) -> np.ndarray:
    """(count, 3) positions [m] of 20 mm balls stacked in the bottom groove, almost touching."""
    spacing, random = 0.0404, np.random.default_rng(seed)
    columns, along = 5, int(length / spacing)
    index = np.arange(count)
    x = (index % columns - (columns - 1) / 2) * spacing
    y = (index // columns % along + 0.5) * (length / along)
    z = 0.005 - np.sqrt((radius - 0.02) ** 2 - (columns / 2 * spacing) ** 2)
    z = z + index // (columns * along) * spacing
    return np.column_stack([x, y, z]) + random.uniform(-1e-4, 1e-4, (count, 3))


def about_to_be_thrown(S: float) -> tuple[np.ndarray, str]:
    """A ball just off a lifter's face on the rising side, and its velocity with the mill: it rides
    the face and leaves its tip within half a radian."""
    liner = _core.Lifters(3.9 / S, 3.61 / S, 0.25 / S, 0.635 / S, 25)
    path, groove = 3.9 / S - 0.04, 9 * 2 * np.pi / 25

    def place(psi):
        return -path * np.sin(psi), -path * np.cos(psi)

    psi = scipy.optimize.brentq(
        lambda psi: liner.nearest(*place(psi)).distance - 1.001 * 0.02, groove - 0.16, groove
    )
    (x, z), speed = place(psi), np.sqrt(S) * path
    velocity = f"velocity all set {-speed * np.cos(psi):.6f} 0.4 {speed * np.sin(psi):.6f}\n"
    return np.array([[x, SLICE / 2, z]]), velocity


def read_dump(path: Path) -> dict[str, np.ndarray]:
    """Columns of a text dump's last frame, sorted by id."""
    lines = path.read_text().splitlines()
    start = max(i for i, line in enumerate(lines) if line.startswith("ITEM: ATOMS"))
    names = lines[start].split()[2:]
    rows = np.array([[float(word) for word in line.split()] for line in lines[start + 1 :]])
    rows = rows[np.argsort(rows[:, names.index("id")])]
    return {name: rows[:, column] for column, name in enumerate(names)}
