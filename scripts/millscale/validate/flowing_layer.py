"""Rheology of the flowing layer: `millscale validate flowing-layer`.

Fields of the steady window give the layer that flows down the surface of the bed: its depth, speed,
shear rate, pressure and inertial number I = (shear rate) d sqrt(rho / p), and two measures of the
friction of the bed. Lengths are over R - a, times over 1 / omega. Derived here;
docs/theory/flowing-layer.md.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from scipy.ndimage import map_coordinates

from millscale.analysis.charge.scaled_mills import scaled_mills
from millscale.analysis.finished import Charge
from millscale.analysis.several_campaigns import load_charges
from millscale.analysis.shapes.curtain import IN_FLIGHT
from millscale.analysis.shapes.shape import (
    STATE,
    end_circle,
    snapshots_at,
    unit_length,
    wanted_angles,
)
from millscale.analysis.shapes.solid_fraction import Grid, solid_fraction
from millscale.analysis.shapes.throw_angle import FLIGHT_TIME
from millscale.engine.record import provenance
from millscale.errors import PredictionError
from millscale.prediction.contour import surface_line
from millscale.report.figures.style import STYLE
from millscale.runs.case_file import Case
from millscale.runs.dumps import Dump, read_dump
from millscale.runs.untrusted import RunFolderError
from millscale.runs.writing import write_json

Row = dict[str, Any]
# One kernel for all mills, so that it widens all profiles alike.
GRID = Grid(0.03)
# Part of the surface, over its length from the shoulder, that is nearly straight; normals on it.
PART, NORMALS = (0.35, 0.65), 31
# Depths below the surface; the profile begins above the bed, where balls fly.
DEPTHS = np.arange(-0.3, 0.45, 0.005)
# Balls slower than this relative to the mill, over omega R, move with it.
MOVES_WITH_MILL = 0.3
# Slopes are fitted over mills of three S or more.
FEWEST_RATIOS = 3


@dataclass(frozen=True)
class Layer:
    """The flowing layer in the middle of the surface.

    Attributes:
        depth: from the surface to where the balls begin to rise, over R - a.
        depth_diameters: the same in ball diameters.
        surface_speed: along the surface, relative to the turning mill, over omega (R - a).
        shear_rate: in the middle of the depth, over omega.
        inertial_number: there.
        solid_fraction: there.
        slope_friction: tangent of the angle of the surface against the horizontal.
        balance_friction: shear over normal stress there, by the momentum of what lies above.
        centre_friction: tangent of the angle of the centre of mass from the bottom.
    """

    depth: float
    depth_diameters: float
    surface_speed: float
    shear_rate: float
    inertial_number: float
    solid_fraction: float
    slope_friction: float
    balance_friction: float
    centre_friction: float


@dataclass(frozen=True)
class Fields:
    """Sums over the balls of the steady window on GRID, per dump.

    Attributes:
        fraction: solid fraction.
        momentum_x, momentum_z: solid fraction times mean velocity over omega (R - a).
        flux_xx, flux_xz, flux_zz: solid fraction times mean product of velocities.
    """

    fraction: np.ndarray
    momentum_x: np.ndarray
    momentum_z: np.ndarray
    flux_xx: np.ndarray
    flux_xz: np.ndarray
    flux_zz: np.ndarray


def dumps_of(charge: Charge) -> Iterator[Dump]:
    """Yield the dumps of the steady window of a charge."""
    angles = [
        angle
        for angle in wanted_angles(charge.result.rotation_angle_rad)
        if charge.steady_from <= angle <= charge.result.mean_to_rad
    ]
    for snapshot in snapshots_at(charge.folder, angles).values():
        yield read_dump(snapshot.path)


def fields_of(centres: np.ndarray, velocity: np.ndarray, areas: np.ndarray) -> Fields:
    """Return the mean fields of dumps.

    Args:
        centres, velocity: (n, 2) float [x, z], of the balls of all dumps.
        areas: (n,) float, as in `solid_fraction`, over the number of dumps.
    """
    x, z = velocity.T
    weights = (np.ones_like(x), x, z, x * x, x * z, z * z)
    return Fields(*(solid_fraction(centres, areas * weight, GRID) for weight in weights))


def layer_of(fields: Fields, surface: np.ndarray, gravity: float, diameter: float) -> Layer:
    """Return the flowing layer below the middle of a surface; without `centre_friction` (nan).

    Args:
        surface: (n, 2) float [x, z].
        gravity: over omega^2 (R - a).
        diameter: of a ball, over R - a.

    Raises:
        ValueError: no ball below the surface rises with the mill.
    """
    points, down, normal = _normals(surface)
    at = points[:, None] + DEPTHS[None, :, None] * normal
    fraction = _at(fields.fraction, at).mean(axis=0)
    speed = (_at(fields.momentum_x, at) * down[0] + _at(fields.momentum_z, at) * down[1]).mean(0)
    speed = speed / np.maximum(fraction, 1e-9)
    # The mill turns the bottom towards -x: velocity (z, -x) at rest in the mill.
    carried = (at[..., 1] * down[0] - at[..., 0] * down[1]).mean(axis=0)
    relative = speed - carried
    rising = np.flatnonzero((speed < 0.0) & (DEPTHS > 0.0))
    if not len(rising):
        raise ValueError("no ball below the surface rises with the mill")
    depth, top = float(DEPTHS[rising[0]]), int(np.argmin(np.abs(DEPTHS)))
    middle = int(np.argmin(np.abs(DEPTHS - 0.5 * depth)))
    step = float(DEPTHS[1] - DEPTHS[0])
    shear = float(-np.gradient(relative, step)[middle])
    tangential, pressure = _stresses(fields, at, gravity, down, normal)
    return Layer(
        depth=depth,
        depth_diameters=depth / diameter,
        surface_speed=float(relative[top]),
        shear_rate=shear,
        inertial_number=abs(shear) * diameter / math.sqrt(pressure[middle]),
        solid_fraction=float(fraction[middle]),
        slope_friction=float(-down[1] / down[0]),
        balance_friction=float(tangential[middle] / pressure[middle]),
        centre_friction=math.nan,
    )


def _stresses(
    fields: Fields, at: np.ndarray, gravity: float, down: np.ndarray, normal: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return shear and normal stress over the ball density, by depth: weight less the change of
    momentum of what lies above. Gradients of stress along the surface are left out."""

    def divergence(x: np.ndarray, z: np.ndarray) -> np.ndarray:
        return np.gradient(x, GRID.step, axis=1) + np.gradient(z, GRID.step, axis=0)

    force_x = -divergence(fields.flux_xx, fields.flux_xz)
    force_z = -gravity * fields.fraction - divergence(fields.flux_xz, fields.flux_zz)
    force = np.stack([_at(force_x, at).mean(axis=0), _at(force_z, at).mean(axis=0)])
    step = float(DEPTHS[1] - DEPTHS[0])
    return np.cumsum(down @ force) * step, np.cumsum(normal @ force) * step


def _normals(surface: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points on the middle of a surface, its direction downhill, and its normal into the
    bed."""
    line = surface if surface[0, 0] < surface[-1, 0] else surface[::-1]
    travelled = np.append(0.0, np.cumsum(np.hypot(*np.diff(line, axis=0).T)))
    places = np.linspace(*PART, NORMALS) * travelled[-1]
    points = np.column_stack([np.interp(places, travelled, c) for c in line.T])
    down = np.linalg.svd(points - points.mean(axis=0))[2][0]
    down = down * math.copysign(1.0, down[0])
    return points, down, np.array([down[1], -down[0]])


def _at(field: np.ndarray, points: np.ndarray) -> np.ndarray:
    place = (points - GRID.nodes[0]) / GRID.step
    return map_coordinates(field, [place[..., 1], place[..., 0]], order=1)


def row_of(charge: Charge) -> Row:
    """Return the flowing layer of a charge and what its balls contribute to the kinetic energy.

    Raises:
        RunFolderError: no dumps in the steady window, or no surface.
    """
    case, unit = charge.case, unit_length(charge.case)
    mill, omega = case.mill, case.mill.omega_rad_s
    dumps = list(dumps_of(charge))
    if not dumps:
        raise RunFolderError(charge.folder, "no dumps in the steady window", "dump more often")
    centres = np.vstack([dump.positions[:, [0, 2]] for dump in dumps]) / unit
    velocity = np.column_stack([_joined(dumps, name) for name in ("vx", "vz")]) / (omega * unit)
    length = mill.simulated_length_m / unit
    areas = 4.0 / 3.0 * np.pi * (_joined(dumps, "radius") / unit) ** 3 / length / len(dumps)
    flying = (_joined(dumps, STATE) == IN_FLIGHT) & (_joined(dumps, FLIGHT_TIME) > 0.0)
    surface = surface_line(case, centres, areas)
    if surface is None:
        raise RunFolderError(charge.folder, "its bed has no surface", "look at it in OVITO")
    gravity = mill.gravity_m_s2 / (omega**2 * unit)
    fields = fields_of(centres, velocity, areas)
    layer = asdict(layer_of(fields, surface, gravity, 2.0 * case.ball.radius_m / unit))
    centre = charge.result.dimensionless
    layer["centre_friction"] = centre["centre_x"] / centre["centre_z"]
    return {
        "id": charge.id,
        "policy": charge.policy,
        "S": charge.S,
        "seed": charge.seed,
        "friction": case.material.static_friction_pp,
        "layer": layer,
        "populations": _populations(centres, velocity, flying, unit / mill.radius_m),
        "speed_at_wall": _speed_at_wall(case, centres, velocity),
    }


def _joined(dumps: Sequence[Dump], column: str) -> np.ndarray:
    return np.concatenate([dump[column] for dump in dumps])


def _populations(
    centres: np.ndarray, velocity: np.ndarray, flying: np.ndarray, unit: float
) -> dict[str, dict[str, float]]:
    """Return the balls in confirmed flight, those that flow, and those that move with the mill: of
    each their share and their kinetic energy over M (omega R)^2 of all balls.

    Args:
        unit: R - a over R.
    """
    x, z = centres.T
    relative = velocity - np.column_stack([z, -x])
    carried = ~flying & (np.hypot(*relative.T) * unit < MOVES_WITH_MILL)
    kinetic = 0.5 * unit**2 * (velocity**2).sum(axis=1)

    def of(which: np.ndarray) -> dict[str, float]:
        return {"share": float(np.mean(which)), "kinetic": float(kinetic[which].sum() / len(which))}

    return {
        "in flight": of(flying),
        "flowing": of(~flying & ~carried),
        "moving with the mill": of(carried),
    }


def _speed_at_wall(case: Case, centres: np.ndarray, velocity: np.ndarray) -> float:
    """Return the mean tangential speed of balls outside the circle of toe and shoulder, within 45
    degrees of the bottom, over that of the mill: 1 without slip."""
    x, z = centres.T
    radius = np.hypot(x, z)
    near = (radius > end_circle(case)) & (z < -np.abs(x))
    along = (velocity[:, 0] * z - velocity[:, 1] * x)[near] / radius[near]
    return float(np.mean(along / radius[near]))


def slopes_of(rows: Sequence[Row]) -> Row:
    """Return how inertial number and friction change with ln S, by policy, and the exponent q of
    friction / S^q that keeps the friction of the bed.

    With a change m of the friction of the bed per ln S at the physical friction, and n at the
    friction divided by S, q = m / (m - n).
    """
    found: Row = {}
    for policy in sorted({row["policy"] for row in rows}):
        own = [row for row in rows if row["policy"] == policy or row["S"] == 1.0]
        if len({row["S"] for row in own}) < FEWEST_RATIOS:
            continue
        logarithm = np.log([row["S"] for row in own])
        found[policy] = {
            name: float(np.polyfit(logarithm, [row["layer"][name] for row in own], 1)[0])
            for name in ("slope_friction", "balance_friction", "centre_friction")
        }
        numbers = np.log([row["layer"]["inertial_number"] for row in own])
        found[policy]["exponent_of_inertial_number"] = float(np.polyfit(logarithm, numbers, 1)[0])
    if {"paper", "friction-matched"} <= found.keys():
        found["exponent_of_friction"] = {
            name: found["paper"][name] / (found["paper"][name] - found["friction-matched"][name])
            for name in ("slope_friction", "balance_friction", "centre_friction")
        }
    return found


def write_flowing_layer(folders: Sequence[Path], docs: Path) -> None:
    """Write results/flowing-layer.json and .png.

    Args:
        folders: runs folders of one physical mill at constant gravity or at constant speed.
    """
    charges = sorted(load_charges(folders)[0], key=lambda x: (x.policy, x.S, x.id))
    if len({charge.scheme for charge in charges if not charge.case.is_physical}) > 1:
        raise PredictionError("charges of two schemes: give the folders of one")
    rows = [row_of(charge) for charge in charges]
    mills = []
    for mill in scaled_mills(charges):
        own = [row for row in rows if row["id"] in {seed.id for seed in mill.seeds}]
        mills.append(_mean_row(own))
    document = {
        "schema": 1,
        **provenance(),
        "charges": rows,
        "mills": mills,
        "slopes": slopes_of(rows),
    }
    file = docs / "results/flowing-layer.json"
    write_json(file, document)
    draw(mills, file.with_suffix(".png"))


def _mean_row(rows: Sequence[Row]) -> Row:
    """Return the means over the seeds of a mill, and the standard deviation of its layer."""
    first = rows[0]
    return {
        **{key: first[key] for key in ("policy", "S", "friction")},
        "seeds": len(rows),
        "layer": {
            name: float(np.mean([row["layer"][name] for row in rows])) for name in first["layer"]
        },
        "deviation": {
            name: float(np.std([row["layer"][name] for row in rows], ddof=1))
            for name in first["layer"]
        }
        if len(rows) > 1
        else None,
        "populations": {
            name: {
                key: float(np.mean([row["populations"][name][key] for row in rows]))
                for key in values
            }
            for name, values in first["populations"].items()
        },
        "speed_at_wall": float(np.mean([row["speed_at_wall"] for row in rows])),
    }


def draw(mills: Sequence[Row], file: Path) -> None:
    """Draw friction and solid fraction of the layer against its inertial number, by policy."""
    with rc_context(STYLE):
        figure = Figure(figsize=(9.0, 3.2), layout="constrained")
        panels = (
            ("centre_friction", "tangent of the centre's angle"),
            ("slope_friction", "tangent of the surface's angle"),
            ("solid_fraction", "solid fraction of the layer"),
        )
        for axes, (name, label) in zip(figure.subplots(1, 3), panels, strict=True):
            for policy in sorted({mill["policy"] for mill in mills}):
                own = [mill for mill in mills if mill["policy"] == policy or mill["S"] == 1.0]
                own.sort(key=lambda mill: mill["S"])
                axes.errorbar(
                    [mill["layer"]["inertial_number"] for mill in own],
                    [mill["layer"][name] for mill in own],
                    [mill["deviation"][name] if mill["deviation"] else 0.0 for mill in own],
                    marker="o", ms=3.5, capsize=2, label=policy,
                )  # fmt: skip
            axes.set(xlabel="inertial number I", ylabel=label)
        axes.legend(fontsize="x-small")
        figure.savefig(file, dpi=110)
