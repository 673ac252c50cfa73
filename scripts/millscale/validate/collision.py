"""Collision of two equal balls, head-on or at 45 degrees, at a time step."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from millscale import _core
from millscale.engine.deck_run import engine_text, find_engine
from millscale.runs.writing import write_text
from millscale.validate.cases import Mill
from millscale.validate.deck import BACKENDS, material, read_frames, write_balls
from millscale.validate.scenes import Balls

SPEED = 5.0  # along the normal [m/s]; at 45 degrees as much across it
# Contact may begin at any point of a step: the gaps of the pairs are spread evenly over a step.
PAIRS = 16
APART = 6.0  # distance of pairs over the ball radius
LOSSY = 6.0  # duration of the contact with damping over that without, at most
COLUMNS = "id x z vx vz omegay"


@dataclass(frozen=True)
class Collision:
    """Means over the pairs.

    Attributes:
        restitution: realised head-on; None at 45 degrees, where the normal turns.
        peak_overlap: over the ball radius, at the ends of steps.
        dissipated: share of the kinetic energy in the frame of the centre of mass.
    """

    restitution: float | None
    peak_overlap: float
    dissipated: float


def collide(folder: Path, mill: Mill, backend: str, step: float, oblique: bool) -> Collision:
    """Simulate collisions of pairs of balls in the engine.

    Args:
        backend: of BACKENDS.
        step: [s].
        oblique: 45 degrees instead of head-on.

    Raises:
        RuntimeError: the engine failed, or balls still touch at the end.
    """
    folder.mkdir(parents=True)
    across = SPEED if oblique else 0.0
    balls, reach = _begin(mill.radii[0], across, step), _reach(mill, across)
    box = ((-reach, reach), (0.0, APART * mill.radii[0] * PAIRS), (-reach, reach))
    write_balls(folder / "balls.data", mill, balls, box)
    steps = math.ceil(LOSSY * contact_time(mill) / step)
    write_text(folder / "collision.in", _deck(mill, backend, step, steps))
    _, cause = engine_text([str(find_engine()), "-in", "collision.in"], folder)
    if cause:
        raise RuntimeError(f"collision on backend {backend}, step {step:.3g} s: {cause}")
    return _measured(read_frames(folder / "balls.dump"), mill.radii[0], across)


def contact_time(mill: Mill) -> float:
    """Return the duration of the head-on collision without damping [s]."""
    balls = _core.Material(mill.youngs_modulus, mill.poisson_ratio, mill.density)
    return _core.hertz_collision_time(balls, mill.radii[0], SPEED)


def _begin(radius: float, across: float, step: float) -> Balls:
    """Return the upper balls, then the lower ones."""
    gap = SPEED * step * (np.arange(PAIRS) + 0.5) / PAIRS
    middle = np.zeros((PAIRS, 3))
    middle[:, 1] = APART * radius * (np.arange(PAIRS) + 0.5)
    half = np.column_stack([0.0 * gap, 0.0 * gap, radius + 0.5 * gap])
    # Balls that move across are so placed that they touch right above each other.
    half[:, 0] -= 0.5 * across * gap / SPEED
    speed = np.tile([0.5 * across, 0.0, -0.5 * SPEED], (PAIRS, 1))
    place = np.concatenate([middle + half, middle - half])
    return Balls(place, np.concatenate([speed, -speed]), np.full(2 * PAIRS, radius))


def _reach(mill: Mill, across: float) -> float:
    """Return the largest distance of a ball from the middle [m]."""
    return 3.0 * mill.radii[0] + LOSSY * contact_time(mill) * (SPEED + across)


def _deck(mill: Mill, backend: str, step: float, steps: int) -> str:
    return (
        "units si\natom_style granular\natom_modify map array\nboundary f f f\nnewton off\n"
        "communicate single vel yes\nread_data balls.data\n"
        f"{material(mill)}neighbor {0.75 * mill.radii[0]!r} bin\n"
        "neigh_modify delay 0 every 1 check yes\n"
        "pair_style gran model hertz tangential history rolling_friction cdt "
        f"{BACKENDS[backend].balls.pair_style_words()}\npair_coeff * *\ntimestep {step!r}\n"
        f"fix integrate all nve/sphere\ndump balls all custom 1 balls.dump {COLUMNS}\n"
        f'dump_modify balls format "%d{" %.17g" * 5}"\nthermo {steps}\n'
        f"thermo_modify lost error\nrun {steps}\n"
    )


def _measured(frames: np.ndarray, radius: float, across: float) -> Collision:
    """Return the means of frames of shape (steps, 2 PAIRS, columns of COLUMNS)."""
    upper, lower = frames[:, :PAIRS, 1:], frames[:, PAIRS:, 1:]
    separation = upper - lower
    overlap = 2.0 * radius - np.hypot(separation[..., 0], separation[..., 1])
    if (overlap[-1] > 0.0).any():
        raise RuntimeError(f"{(overlap[-1] > 0.0).sum()} of {PAIRS} pairs still touch at the end")
    speed, spin = separation[-1, :, 2:4], upper[-1, :, 4]
    # Relative speed u of two equal masses m: m u^2 / 4; their spins are the same: 2/5 m (a w)^2.
    before = 0.25 * (SPEED**2 + across**2)
    after = 0.25 * (speed**2).sum(axis=1) + 0.4 * (radius * spin) ** 2
    return Collision(
        restitution=None if across else float(np.mean(speed[:, 1]) / SPEED),
        peak_overlap=float(np.mean(overlap.max(axis=0)) / radius),
        dissipated=float(np.mean(1.0 - after / before)),
    )
