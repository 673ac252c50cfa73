"""Many balls, each alone with the wall, in one run of the engine: no weight, no contact between
balls, any materials."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from millscale import _core
from millscale.engine.material_block import material_block
from millscale.mesh import build_liner_mesh, curvature_deg, write_stl
from scene import read_dump, run

DENSITY = 2678.0
WALLS = ["mesh", "analytic"]


@dataclass(frozen=True)
class Balls:
    """(n, 3) positions, velocities, spins; (n,) radii [SI] and kinds (row of `Materials`)."""

    position: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray
    radius: np.ndarray
    kind: np.ndarray

    @classmethod
    def of(cls, position, velocity=0.0, spin=0.0, radius=0.02, kind=0):
        """Balls from arrays that broadcast."""
        position = np.atleast_2d(position)
        n = len(position)
        return cls(
            position,
            np.broadcast_to(velocity, (n, 3)),
            np.broadcast_to(spin, (n, 3)),
            np.broadcast_to(radius, n),
            np.broadcast_to(kind, n),
        )

    @property
    def mass(self):
        return 4.0 / 3.0 * np.pi * self.radius**3 * DENSITY


@dataclass(frozen=True)
class Materials:
    """Kinds of balls against the wall, one entry each; the wall's own modulus."""

    restitution: list[float] = field(default_factory=lambda: [0.2])
    friction: list[float] = field(default_factory=lambda: [0.5])
    rolling: float = 0.01
    youngs_modulus: list[float] = field(default_factory=lambda: [5.98e7])
    wall_youngs_modulus: float = 5.98e7

    def commands(self):
        """The engine's properties; the wall is the last type."""
        kinds = len(self.restitution)
        n = kinds + 1

        def matrix(values):
            full = np.full((n, n), 0.5)
            full[:kinds, -1] = full[-1, :kinds] = values
            return full.ravel()

        return material_block(
            [*(self.youngs_modulus * kinds)[:kinds], self.wall_youngs_modulus],
            [0.3] * n,
            restitution=matrix(self.restitution),
            friction=matrix(self.friction),
            rolling_friction=matrix(self.rolling),
        )


@dataclass(frozen=True)
class Mill:
    """Liner and how it is modelled: "mesh", "analytic" (the same polygon) or "arc"."""

    wall: str
    liner: _core.Profile
    chord_error: float
    length: float = 0.5
    axial_divisions: int = 1
    omega: float = 1e-6  # [rad/s]
    start: str = "never"
    gravity: float = 1e-9  # none, as good as [m/s^2]
    words: str = ""  # more of fix wall/mill
    boundary: str = "f p f"

    def commands(self, folder: Path, wall_type: int):
        drive = (
            f"fix mill all mill/similarity radius {self.liner.radius!r} gravity {self.gravity!r} "
            f"omega {self.omega!r} ball_radius 0.001 centrifuging allow start {self.start}"
        )
        if self.wall != "mesh":
            if isinstance(self.liner, _core.Lifters):
                return f"{self._analytic(wall_type, self._lifters())}\n{drive}\n"
            (folder / "liner.csv").write_text(self.liner.text)
            return f"{self._analytic(wall_type, '')}\n{drive} profile liner.csv\n"
        mesh = build_liner_mesh(self.liner, self.length, self.chord_error, self.axial_divisions)
        write_stl(folder / "liner.stl", mesh)
        return (
            f"fix liner all mesh/surface/stress file liner.stl type {wall_type} "
            f"curvature {curvature_deg(mesh)!r} reference_point 0 0 0\n"
            "fix wall all wall/gran model hertz tangential history rolling_friction cdt "
            f"mesh n_meshes 1 meshes liner\n{drive} mesh liner\n"
        )

    def _lifters(self):
        liner = self.liner
        shape = (
            f"lifters {liner.lifters} lifter_top_radius {liner.lifter_top_radius!r} "
            f"lifter_top_width {liner.lifter_top_width!r} groove_width {liner.groove_width!r} "
        )
        return f"phase {liner.phase!r} {shape if liner.lifters else ''}"

    def _analytic(self, wall_type, shape):
        groove = "arc" if self.wall == "arc" else f"polygon {self.chord_error!r}"
        return (
            f"fix liner all wall/mill mill mill type {wall_type} groove {groove} "
            f"{shape}{self.words}"
        )


STATE = [
    *("x", "y", "z", "vx", "vy", "vz", "omegax", "omegay", "omegaz"),
    *("fx", "fy", "fz", "tqx", "tqy", "tqz"),
]


def write_balls(path: Path, balls: Balls, mill: Mill, types: int):
    """The balls as a data file, in a box around the mill."""
    box = 1.02 * mill.liner.radius
    lines = ["balls", "", f"{len(balls.position)} atoms", f"{types} atom types", ""]
    lines += [
        f"{-box!r} {box!r} xlo xhi",
        f"0 {mill.length!r} ylo yhi",
        f"{-box!r} {box!r} zlo zhi",
    ]
    lines += ["", "Atoms", ""]
    for i, (p, a, kind) in enumerate(zip(balls.position, balls.radius, balls.kind, strict=True)):
        place = " ".join(repr(float(x)) for x in p)
        lines.append(f"{i + 1} {kind + 1} {2 * float(a)!r} {DENSITY} {place}")
    lines += ["", "Velocities", ""]
    for i, (v, w) in enumerate(zip(balls.velocity, balls.spin, strict=True)):
        lines.append(f"{i + 1} " + " ".join(repr(float(x)) for x in (*v, *w)))
    path.write_text("\n".join(lines) + "\n")


def deck(
    folder: Path,
    mill: Mill,
    balls: Balls,
    materials: Materials,
    dt: float,
    begin: str = "read_data balls.data",
) -> str:
    """A deck up to its first run."""
    types = len(materials.restitution) + 1
    write_balls(folder / "balls.data", balls, mill, types)
    return (
        "units si\natom_style granular\natom_modify map array\n"
        f"boundary {mill.boundary}\nnewton off\ncommunicate single vel yes\nprocessors 1 * 1\n"
        f"neigh_modify delay 0\n{begin}\n"
        + materials.commands()
        + "neighbor 0.01 bin\nneigh_modify exclude group all all\n"
        "pair_style gran model hertz tangential history rolling_friction cdt\npair_coeff * *\n"
        f"timestep {dt!r}\n" + mill.commands(folder, types) + "thermo_modify lost error\n"
    )


INTEGRATE = "fix integrate all nve/sphere\n"


def dump_every(steps: int) -> str:
    """Full state of all balls, in one file for each dumped step."""
    columns = " ".join(["id", *STATE])
    fields = "%d" + " %.17g" * len(STATE)
    return f'dump state all custom {steps} *.dump {columns}\ndump_modify state format "{fields}"\n'


def fly(
    folder: Path,
    mill: Mill,
    balls: Balls,
    materials: Materials,
    dt: float,
    steps: int,
    *,
    move: str = INTEGRATE,
    every: int | None = None,
    ranks: int = 1,
) -> list[dict[str, np.ndarray]]:
    """States (columns STATE, balls in order) after `every` steps each, by default only the last."""
    folder.mkdir(parents=True, exist_ok=True)
    text = deck(folder, mill, balls, materials, dt) + move + dump_every(every or max(steps, 1))
    result = run(folder, text + f"run {steps}\n", ranks)
    assert result.code == 0, result.text[-2000:]
    files = sorted(folder.glob("*.dump"), key=lambda path: int(path.stem))
    return [read_dump(path) for path in (files if every else files[-1:])]


def fly_in_halves(
    folder: Path, mill: Mill, balls: Balls, materials: Materials, dt: float, steps: int
) -> dict[str, np.ndarray]:
    """Last state of `fly`, with a restart half way."""
    folder.mkdir(parents=True, exist_ok=True)
    end = f"{INTEGRATE}fix forces all mill/forces\n"
    first = deck(folder, mill, balls, materials, dt) + end
    again = deck(folder, mill, balls, materials, dt, "read_restart half.restart") + end
    for text in (
        f"{first}run {steps // 2}\nwrite_restart half.restart\n",
        f"{again}{dump_every(steps)}run {steps - steps // 2}\n",
    ):
        result = run(folder, text)
        assert result.code == 0, result.text[-2000:]
    return read_dump(folder / f"{steps}.dump")


def columns(state, names):
    """(n, len(names)) of a state."""
    return np.column_stack([state[name] for name in names.split()])


def kinetic_energy(balls: Balls, velocity, spin):
    """(n,) kinetic energies with rotation [J]."""
    inertia = 0.4 * balls.mass * balls.radius**2
    return 0.5 * balls.mass * np.sum(velocity**2, axis=1) + 0.5 * inertia * np.sum(spin**2, axis=1)


def flats(count: int, radius: float = 1.5) -> tuple[_core.Profile, float]:
    """A drum of `count` flat plates, and the chord error that makes it."""
    return _core.Lifters(radius, 0.0, 0.0, 0.0, 0), radius * (1.0 - math.cos(math.pi / count))


def over_flat(liner, chord_error, index):
    """Middle of flats (n, 3), unit vector into the drum (n, 3) and along the flat (n, 3)."""
    nodes, _ = liner.polygon(chord_error)
    a, b = nodes[index], np.roll(nodes, -1, axis=0)[index]
    along = (b - a) / np.linalg.norm(b - a, axis=1)[:, None]
    middle = 0.5 * (a + b)
    inward = -middle / np.linalg.norm(middle, axis=1)[:, None]
    return (np.insert(v, 1, 0.0, axis=1) for v in (middle, inward, along))
