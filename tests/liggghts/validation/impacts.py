"""Single impacts, of two balls or of a ball and a plane, in the engine and by the law itself.

Every impact lies in one plane: `normal` from the other body to the ball, `along` the surface. The
spin is counted so that a ball that rolls along has slip v - R w = 0.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from contact_paths import CONTACT_PATHS
from millscale.engine.material_block import material_block
from millscale.mesh import build_liner_mesh, curvature_deg, write_stl
from scene import Ran, read_dump, run
from wall_bench import flats, over_flat

PLANES = ["mesh", "analytic"]
FLATS = 12
DRUM = 75.0  # radius of the drum of flat plates, in ball radii
LENGTH = 36.0  # of the drum, in ball radii: its triangles must not be thin
GAP = 0.5  # contact begins half a step after the start


@dataclass(frozen=True)
class Material:
    """Of a ball: Young's modulus [Pa], Poisson's ratio, density [kg/m^3]."""

    youngs_modulus: float
    poisson_ratio: float
    density: float


@dataclass(frozen=True)
class Impact:
    """A ball against another body, which rests unless it is the ball's mirror image.

    Attributes:
        ball, other: materials.
        radius: of the ball [m].
        other_radius: [m]; None: a plane.
        mirrored: the other ball is the image of the first, turned by half a turn about the contact.
        restitution, friction: of the contact.
        towards, along: speeds of the ball, (n,) [m/s].
        spin: (n,) [rad/s].
    """

    ball: Material
    other: Material
    radius: float
    other_radius: float | None
    mirrored: bool
    restitution: float
    friction: float
    towards: np.ndarray
    along: np.ndarray
    spin: np.ndarray

    @classmethod
    def of(cls, ball, radius, restitution, friction, towards, along=0.0, spin=0.0, **more):
        """Impact on a rigid plane, or as `more` says; speeds broadcast."""
        speeds = np.broadcast_arrays(
            *(np.atleast_1d(x).astype(float) for x in (towards, along, spin))
        )
        other = {"other": ball, "other_radius": None, "mirrored": False} | more
        return cls(
            ball,
            radius=radius,
            restitution=restitution,
            friction=friction,
            towards=speeds[0],
            along=speeds[1],
            spin=speeds[2],
            **other,
        )

    @property
    def mass(self):
        return 4.0 / 3.0 * np.pi * self.radius**3 * self.ball.density

    @property
    def effective(self):
        """Effective radius, mass, Young's and shear modulus of the contact."""
        radius, mass = self.radius, self.mass
        if self.other_radius is not None:
            other_mass = 4.0 / 3.0 * np.pi * self.other_radius**3 * self.other.density
            radius = self.radius * self.other_radius / (self.radius + self.other_radius)
            mass = self.mass * other_mass / (self.mass + other_mass)
        young = sum((1.0 - m.poisson_ratio**2) / m.youngs_modulus for m in (self.ball, self.other))
        shear = sum(
            2.0 * (2.0 - m.poisson_ratio) * (1.0 + m.poisson_ratio) / m.youngs_modulus
            for m in (self.ball, self.other)
        )
        return radius, mass, 1.0 / young, 1.0 / shear

    @property
    def closing(self):
        """(n,) relative speed along the normal [m/s]."""
        return self.towards * (2.0 if self.mirrored else 1.0)

    def hertz(self):
        """(n,) largest force [N], overlap [m] and duration [s] of the elastic impact."""
        radius, mass, young, _ = self.effective
        k = 4.0 / 3.0 * young * math.sqrt(radius)
        overlap = (1.25 * mass * self.closing**2 / k) ** 0.4
        return k * overlap**1.5, overlap, 2.9432750 * overlap / self.closing

    @property
    def duration(self):
        """Of the shortest elastic impact [s]."""
        return float(self.hertz()[2].min())


def rigid_plane(material: Material) -> Material:
    """Material that ball and wall must both have for the ball's own modulus on a rigid plane."""
    return replace(material, youngs_modulus=2.0 * material.youngs_modulus)


@dataclass(frozen=True)
class Rebound:
    """(n,) speeds [m/s] of the ball after the impact, away from the contact and along, in the
    directions these had at its beginning, and its spin [rad/s]; the same of the other ball in the
    same directions, None for a plane. Force and overlap in the engine only."""

    away: np.ndarray
    along: np.ndarray
    spin: np.ndarray
    other: Rebound | None = None
    force: np.ndarray | None = None  # along the normal [N]
    overlap: np.ndarray | None = None  # [m]


def by_the_law(impact: Impact, steps: int = 5000) -> Rebound:
    """The impact by the law written out (Powder Technology 335 (2018) 91-102, Eqs. 16-21, with the
    tangential spring cut at Coulomb's limit), in `steps` steps per elastic duration: positions at
    whole, velocities at half steps; exact for vanishing steps. In the plane of the impact, axis 0
    along the surface and axis 1 away from it; the normal of two balls turns with them.
    """
    radius, mass, young, shear = impact.effective
    beta = -math.log(impact.restitution) / math.hypot(math.log(impact.restitution), math.pi)
    damping = 2.0 * math.sqrt(5.0 / 6.0) * beta
    dt, two = impact.duration / steps, impact.other_radius is not None
    balls = _balls_in_plane(impact)
    stretch = np.zeros_like(impact.towards)
    touching = np.ones_like(stretch, bool)
    for _ in range(40 * steps):
        for b in balls:
            b["place"] += dt * b["velocity"]
        apart = balls[0]["place"] - balls[1]["place"]
        distance = np.hypot(*apart) if two else apart[1]
        normal = apart / distance if two else np.array([np.zeros_like(distance), distance > 0.0])
        overlap = impact.radius + (impact.other_radius if two else 0.0) - distance
        touching &= overlap > 0.0
        if not touching.any():
            break
        along = np.array([normal[1], -normal[0]])
        lever = [b["radius"] - 0.5 * overlap if b["radius"] else 0.0 for b in balls]
        relative = balls[0]["velocity"] - balls[1]["velocity"]
        closing = -np.sum(relative * normal, axis=0)
        slip = np.sum(relative * along, axis=0)
        slip -= lever[0] * balls[0]["spin"] + lever[1] * balls[1]["spin"]
        size = np.sqrt(radius * np.maximum(overlap, 0.0))
        push = 4.0 / 3.0 * young * size * overlap
        push += damping * np.sqrt(2.0 * young * size * mass) * closing
        stretch += dt * slip
        stiffness = 8.0 * shear * size
        limit = impact.friction * np.abs(push)
        slides = stiffness * np.abs(stretch) > limit
        held = stiffness * stretch + damping * np.sqrt(stiffness * mass) * slip
        friction = np.where(slides, np.sign(stretch) * limit, held)
        cut = np.sign(stretch) * limit / np.maximum(stiffness, 1e-300)
        stretch = np.where(slides, cut, stretch)
        for b, sign, arm in zip(balls, (1.0, -1.0), lever, strict=True):
            b["velocity"] += sign * dt * touching * (push * normal - friction * along) / b["mass"]
            b["spin"] += dt * touching * friction * arm / b["inertia"]
    else:
        raise RuntimeError("the impact does not end")
    ball, other = (Rebound(b["velocity"][1], b["velocity"][0], b["spin"]) for b in balls)
    return replace(ball, other=other if two else None)


def _balls_in_plane(impact: Impact) -> list[dict]:
    """The ball just before it touches, and the other body: a ball or a plane without end."""
    zero, radius = np.zeros_like(impact.towards), impact.other_radius
    ball = {
        "radius": impact.radius,
        "mass": impact.mass,
        "place": np.array([zero, zero + impact.radius]),
        "velocity": np.array([impact.along, -impact.towards]),
        "spin": impact.spin.copy(),
    }
    other = {"radius": radius or 0.0, "mass": math.inf, "place": np.array([zero, zero])}
    sign = 1.0 if impact.mirrored else 0.0
    other |= {"velocity": -sign * ball["velocity"], "spin": sign * impact.spin}
    if radius is not None:
        other["mass"] = 4.0 / 3.0 * math.pi * radius**3 * impact.other.density
        other["place"] = np.array([zero, zero - radius])
    for b in (ball, other):
        b["inertia"] = 0.4 * b["mass"] * b["radius"] ** 2 if b["radius"] else math.inf
    return [ball, other]


@functools.cache
def _drum_of_radius_one():
    liner, chord_error = flats(FLATS, 1.0)
    return build_liner_mesh(liner, LENGTH / DRUM, chord_error)


def _properties(impact: Impact) -> str:
    """Return the properties of the ball (type 1) and of the other body (type 2)."""
    bodies = (impact.ball, impact.other)
    return material_block(
        [body.youngs_modulus for body in bodies],
        [body.poisson_ratio for body in bodies],
        restitution=[impact.restitution] * 4,
        friction=[impact.friction] * 4,
        rolling_friction=[0.0] * 4,
    )


def _on_plane(impact: Impact, dt: float):
    """Balls above the flats of a drum, and what `_bodies` tells of them."""
    n = len(impact.towards)
    liner, chord_error = flats(FLATS, DRUM * impact.radius)
    middle, normal, along = over_flat(liner, chord_error, np.arange(n) % FLATS)
    middle[:, 1] = impact.radius * (1.5 + 2.5 * (np.arange(n) // FLATS))
    gap = GAP * dt * impact.towards
    position = middle + (impact.radius + gap)[:, None] * normal
    return _bodies(impact, position, normal, along) | {"gap": gap}


def _of_two_balls(impact: Impact, dt: float):
    """Pairs side by side, so that none flies into another: first all balls, then all others."""
    n = len(impact.towards)
    wide = 3.0 * max(impact.radius, impact.other_radius)
    normal = np.tile([0.0, 0.0, 1.0], (n, 1))
    along = np.tile([1.0, 0.0, 0.0], (n, 1))
    place = np.column_stack([np.zeros(n), wide * (np.arange(n) + 1.0), np.zeros(n)])
    gap = GAP * dt * impact.closing
    ball = place + (impact.radius + gap)[:, None] * normal
    other = place - impact.other_radius * normal
    first = _bodies(impact, ball, normal, along) | {"gap": gap}
    sign = 1.0 if impact.mirrored else 0.0
    second = dict(first) | {
        "position": other,
        "velocity": -sign * first["velocity"],
        "spin": sign * first["spin"],
        "type": np.full(n, 2),
        "radius": np.full(n, impact.other_radius),
        "density": np.full(n, impact.other.density),
        "side": -np.ones(n),
    }
    return {key: np.concatenate([first[key], second[key]]) for key in first}


def _bodies(impact: Impact, position, normal, along):
    n = len(position)
    side = np.cross(normal, along)
    return {
        "position": position,
        "velocity": impact.along[:, None] * along - impact.towards[:, None] * normal,
        "spin": impact.spin[:, None] * side,
        "type": np.ones(n, int),
        "radius": np.full(n, impact.radius),
        "density": np.full(n, impact.ball.density),
        "normal": normal,
        "along": along,
        "side": np.ones(n),  # 1: the ball, -1: the other one
    }


def _write_data(path: Path, bodies, box):
    lines = ["balls", "", f"{len(bodies['position'])} atoms", "2 atom types", ""]
    lines += [f"{low!r} {high!r} {d}lo {d}hi" for d, (low, high) in zip("xyz", box, strict=True)]
    lines += ["", "Atoms", ""]
    rows = zip(bodies["type"], bodies["radius"], bodies["density"], bodies["position"], strict=True)
    for i, (kind, radius, density, place) in enumerate(rows):
        words = " ".join(repr(float(x)) for x in (2 * radius, density, *place))
        lines.append(f"{i + 1} {kind} {words}")
    lines += ["", "Velocities", ""]
    for i, state in enumerate(np.hstack([bodies["velocity"], bodies["spin"]])):
        lines.append(f"{i + 1} " + " ".join(repr(float(x)) for x in state))
    path.write_text("\n".join(lines) + "\n")


def _plane(folder: Path, impact: Impact, wall: str) -> str:
    """The drum of flats, at rest."""
    radius = DRUM * impact.radius
    _, chord_error = flats(FLATS, radius)
    drive = (
        f"fix mill all mill/similarity radius {radius!r} gravity 1e-9 omega 1e-6 "
        f"ball_radius {impact.radius!r} centrifuging allow start never"
    )
    if wall == "analytic":
        return f"fix liner all wall/mill mill mill type 2 groove polygon {chord_error!r}\n{drive}\n"
    mesh = _drum_of_radius_one()
    mesh = replace(mesh, nodes=mesh.nodes * radius)
    write_stl(folder / "liner.stl", mesh)
    return (
        "fix liner all mesh/surface/stress file liner.stl type 2 "
        f"curvature {curvature_deg(mesh)!r} reference_point 0 0 0\n"
        "fix wall all wall/gran model hertz tangential history rolling_friction cdt "
        f"mesh n_meshes 1 meshes liner\n{drive} mesh liner\n"
    )


STATE = "x y z vx vy vz omegax omegay omegaz fx fy fz"


def in_engine(
    folder: Path, impact: Impact, path: str, wall: str, dt: float, every: int | None = None
) -> list[Rebound]:
    """Rebounds in the engine after three elastic durations and more for lossy impacts.

    Args:
        path: of contact_paths. wall: "mesh", "analytic", or "none" for two balls.
        every: steps between returned states; default only the last.
    """
    bodies = _of_two_balls(impact, dt) if wall == "none" else _on_plane(impact, dt)
    longest = float(impact.hertz()[2].max())
    steps = math.ceil((3.0 - 2.0 * math.log(max(impact.restitution, 0.05))) * longest / dt)
    states = _run(folder, _deck(folder, impact, bodies, path, wall, dt), steps, every or steps)
    return [_rebound(bodies, s) for s in (states if every else states[-1:])]


def force_at_rest(folder: Path, impact: Impact, path: str, overlap: float) -> np.ndarray:
    """(n,) forces [N] on balls that rest with an overlap [m] with their others."""
    bodies = _of_two_balls(replace(impact, towards=0.0 * impact.towards), 0.0)
    bodies["position"] = (
        bodies["position"] - 0.5 * overlap * bodies["side"][:, None] * bodies["normal"]
    )
    deck = _deck(folder, impact, bodies, path, "none", 1e-9)
    return _rebound(bodies, _run(folder, deck, 0, 1)[0]).force


def _run(folder: Path, deck: str, steps: int, every: int) -> list[dict[str, np.ndarray]]:
    deck += (
        f"dump state all custom {every} *.dump id {STATE}\n"
        f'dump_modify state format "%d{" %.17g" * len(STATE.split())}"\nrun {steps}\n'
    )
    result: Ran = run(folder, deck)
    assert result.code == 0, result.text[-1500:]
    files = sorted(folder.glob("*.dump"), key=lambda file: int(file.stem))
    return [read_dump(file) for file in files]


def _deck(folder: Path, impact: Impact, bodies, path: str, wall: str, dt: float) -> str:
    folder.mkdir(parents=True, exist_ok=True)
    reach = max(impact.radius, impact.other_radius or 0.0)
    if wall == "none":
        low, high = bodies["position"].min(axis=0), bodies["position"].max(axis=0)
        flight = 7.0 * float(impact.hertz()[2].max()) * float(np.abs(bodies["velocity"]).max())
        room = 3.0 * reach + flight
        box = [(float(a) - room, float(b) + room) for a, b in zip(low, high, strict=True)]
        boundary, walls = "f f f", ""
    else:
        across = 1.02 * DRUM * impact.radius
        box = [(-across, across), (0.0, LENGTH * impact.radius), (-across, across)]
        boundary, walls = "f p f", _plane(folder, impact, wall)
    _write_data(folder / "balls.data", bodies, box)
    return (
        "units si\natom_style granular\natom_modify map array sort 0 0.0\n"
        f"boundary {boundary}\nnewton off\ncommunicate single vel yes\nprocessors 1 * 1\n"
        "neigh_modify delay 0\nread_data balls.data\n"
        f"{_properties(impact)}neighbor {0.2 * reach!r} bin\n"
        "pair_style gran model hertz tangential history rolling_friction cdt "
        f"{CONTACT_PATHS[path].pair_style_words()}\npair_coeff * *\ntimestep {dt!r}\n"
        f"{walls}fix integrate all nve/sphere\nthermo_modify lost error\n"
    )


def _rebound(bodies, state) -> Rebound:
    x, v, w, f = (
        np.column_stack([state[name] for name in names.split()])
        for names in ("x y z", "vx vy vz", "omegax omegay omegaz", "fx fy fz")
    )
    normal, along = bodies["normal"], bodies["along"]
    side = np.cross(normal, along)
    away, flat, spin, force, moved = (
        np.sum(a * b, axis=1)
        for a, b in (
            (v, normal),
            (v, along),
            (w, side),
            (f, normal),
            (x - bodies["position"], normal),
        )
    )
    n = int((bodies["type"] == 1).sum())
    overlap = -(moved[:n] + bodies["gap"][:n])
    if len(away) == n:
        return Rebound(away, flat, spin, None, force, overlap)
    other = Rebound(away[n:], flat[n:], spin[n:])
    return Rebound(away[:n], flat[:n], spin[:n], other, force[:n], overlap + moved[n:])
