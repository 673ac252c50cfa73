"""A hard case as a deck of the engine, and its run."""

from __future__ import annotations

import functools
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from millscale.campaign.contacts import ContactOptions
from millscale.engine.deck_run import engine_text, find_engine
from millscale.engine.material_block import ball_and_wall, material_block
from millscale.mesh import build_liner_mesh, curvature_deg, write_stl
from millscale.runs.writing import write_text
from millscale.validate.cases import MILL, Case, Mill
from millscale.validate.scenes import SETTLING, Balls


@dataclass(frozen=True)
class Contacts:
    """Contacts of balls and the wall that goes with them, "mesh" or "analytic"."""

    balls: ContactOptions
    wall: str

    @property
    def bounded(self) -> bool:
        """Whether the tangential damping of balls is limited."""
        return self.balls.damping == "bounded"


# stock: the engine's contacts and mesh wall; plain: pair style fast with the damping of the engine;
# default: as in campaigns; mixed: in mixed precision.
BACKENDS = {
    "stock": Contacts(ContactOptions("stock", "plain"), "mesh"),
    "plain": Contacts(ContactOptions(damping="plain"), "analytic"),
    "default": Contacts(ContactOptions(), "analytic"),
    "mixed": Contacts(ContactOptions(precision="mixed"), "analytic"),
}
SAMPLES = 400  # rows of series.csv
SPIN_STEPS = 12  # at the end, one after the other
GUARD_EVERY = 20  # steps; the guard of a hard case checks more often than that of a campaign
CHORD_SHARE = 0.025  # chord error of the mesh over the ball radius, as in campaigns
Box = tuple[tuple[float, float], ...]  # lower and upper end along x, y, z [m]
SERIES = ("step", "balls", "translation", "rotation", "potential", "overlap")


@dataclass(frozen=True)
class Ran:
    """The output of a run.

    Attributes:
        series: (m, 6) of SERIES.
        spins: (k, n, 3) of consecutive steps at the end [rad/s]; empty if it did not get there.
        stopped_by: the engine's error, or how it ended without one; None if it came to its end.
    """

    series: np.ndarray
    spins: np.ndarray
    stopped_by: str | None


def run_case(folder: Path, case: Case, mill: Mill, balls: Balls, backend: str, step: float) -> Ran:
    """Run a case at a time step [s] in a folder of its own."""
    folder.mkdir(parents=True)
    steps = case.steps or round(case.duration / step)
    across = 1.02 * mill.radius
    box = ((-across, across), (0.0, mill.length), (-across, across))
    write_balls(folder / "balls.data", mill, balls, box)
    write_text(folder / "case.in", _deck(folder, case, mill, balls, backend, step, steps))
    _, cause = engine_text([str(find_engine()), "-in", "case.in"], folder)
    return Ran(_read_series(folder / "series.csv"), _read_spins(folder), cause)


def write_balls(file: Path, mill: Mill, balls: Balls, box: Box) -> None:
    """Write a data file of the engine with the balls of a mill, without spin."""
    lines = ["balls", "", f"{len(balls.radius)} atoms", "2 atom types", ""]
    lines += [f"{low!r} {high!r} {d}lo {d}hi" for d, (low, high) in zip("xyz", box, strict=True)]
    lines += ["", "Atoms", ""]
    for i, (radius, place) in enumerate(zip(balls.radius, balls.position, strict=True)):
        words = " ".join(repr(float(x)) for x in (2.0 * radius, mill.density, *place))
        lines.append(f"{i + 1} 1 {words}")
    lines += ["", "Velocities", ""]
    for i, velocity in enumerate(balls.velocity):
        lines.append(f"{i + 1} " + " ".join(repr(float(x)) for x in velocity) + " 0 0 0")
    write_text(file, "\n".join(lines) + "\n")


def _deck(
    folder, case: Case, mill: Mill, balls: Balls, backend: str, step: float, steps: int
) -> str:
    contacts = BACKENDS[backend]
    wall = contacts.wall
    shape = (
        f"lifters {mill.lifters} lifter_top_radius {mill.lifter_top_radius!r} "
        f"lifter_top_width {mill.lifter_top_width!r} groove_width {mill.groove_width!r}"
    )
    start = "now" if case.kind == MILL else "never"
    liner = f"fix liner all wall/mill mill mill type 2 {shape}\n" if wall == "analytic" else ""
    turned = ""
    if wall == "mesh":
        liner, turned = _mesh_wall(folder, mill), "mesh liner"
    return (
        "units si\natom_style granular\natom_modify map array\nboundary f p f\nnewton off\n"
        "communicate single vel yes\nprocessors 1 * 1\nread_data balls.data\n"
        f"{material(mill)}neighbor {0.75 * mill.radii[-1]!r} bin\n"
        "neigh_modify delay 0 every 1 check yes\n"
        f"pair_style gran model hertz tangential history rolling_friction cdt "
        f"{contacts.balls.pair_style_words()}\n"
        f"pair_coeff * *\ntimestep {step!r}\n{liner}"
        f"fix mill all mill/similarity radius {mill.radius!r} gravity {mill.gravity!r} "
        f"omega {mill.omega!r} ball_radius {mill.radii[0]!r} centrifuging allow "
        f"start {start} {turned}\n"
        "fix integrate all nve/sphere\nfix forces all mill/forces\n"
        f"fix guard all mill/guard mill mill every {GUARD_EVERY} {shape}\n"
        f"compute charge all mill/charge mill mill {shape}\n"
        f"fix series all print {max(1, steps // SAMPLES)} "
        '"$(step) $(c_charge[1]) $(c_charge[3]) $(c_charge[4]) $(c_charge[5]) $(c_charge[12])" '
        "file series.csv screen no\n"
        f"thermo {steps}\nthermo_modify lost error\n{_runs(mill, balls, step, steps)}"
    )


def material(mill: Mill) -> str:
    """Return the properties of balls (type 1) and wall (type 2) for the engine."""
    return material_block(
        [mill.youngs_modulus] * 2,
        [mill.poisson_ratio] * 2,
        restitution=ball_and_wall(*mill.restitution),
        friction=ball_and_wall(*mill.friction),
        rolling_friction=ball_and_wall(*mill.rolling),
    )


def _mesh_wall(folder: Path, mill: Mill) -> str:
    mesh = _mesh(mill)
    write_stl(folder / "liner.stl", mesh)
    return (
        "fix liner all mesh/surface/stress file liner.stl type 2 "
        f"curvature {curvature_deg(mesh)!r} reference_point 0 0 0\n"
        "fix wall all wall/gran model hertz tangential history rolling_friction cdt "
        "mesh n_meshes 1 meshes liner\n"
    )


@functools.lru_cache(maxsize=8)
def _mesh(mill: Mill):
    error = CHORD_SHARE * mill.radii[-1]
    return build_liner_mesh(mill.liner, mill.length, error)


def _runs(mill: Mill, balls: Balls, step: float, steps: int) -> str:
    """Return the commands of the run: the late ball, then spins of a few consecutive steps."""
    before, late = "", balls.late
    if late is not None:
        settling = round(SETTLING / step)
        steps -= settling
        place = " ".join(repr(float(x)) for x in late.position[0])
        speed = " ".join(f"v{d} {float(v)!r}" for d, v in zip("xyz", late.velocity[0], strict=True))
        number = len(balls.radius) + 1
        before = (
            f"run {settling}\ncreate_atoms 1 single {place} units box\n"
            f"set atom {number} diameter {2.0 * float(late.radius[0])!r} density {mill.density!r}\n"
            f"set atom {number} {speed}\n"
        )
    return (
        f"{before}run {steps}\n"
        "dump spins all custom 1 spins.dump id omegax omegay omegaz\n"
        f'dump_modify spins format "%d %.17g %.17g %.17g"\nrun {SPIN_STEPS}\n'
    )


def _read_series(file: Path) -> np.ndarray:
    if not file.exists():
        return np.empty((0, len(SERIES)))
    rows = [
        line.split() for line in file.read_text(encoding="utf-8").splitlines() if line[:1].isdigit()
    ]
    whole = [row for row in rows if len(row) == len(SERIES)]
    return np.array(whole, float).reshape(-1, len(SERIES))


def _read_spins(folder: Path) -> np.ndarray:
    """Return spins of shape (steps, balls, 3); empty if there are none."""
    file = folder / "spins.dump"
    return read_frames(file)[..., 1:] if file.exists() else np.empty((0, 0, 3))


def read_frames(file: Path) -> np.ndarray:
    """Return a dump as (frames, balls, columns), balls in the order of their ids.

    The shape is (0, 0, 1) if the run was stopped before the first frame.
    """
    frames, lines = [], file.read_text(encoding="utf-8").splitlines()
    starts = [i for i, line in enumerate(lines) if line.startswith("ITEM: ATOMS")]
    if not starts:
        return np.empty((0, 0, 1))
    for start, end in zip(starts, [*starts[1:], len(lines) + 8], strict=True):
        rows = [line.split() for line in lines[start + 1 : end - 8]]
        frame = np.array(rows, float)
        frames.append(frame[np.argsort(frame[:, 0])])
    return np.array(frames)
