"""The balls of a rotating mill as a data file that every engine reads."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from millscale.runs.case_file import Case
from millscale.runs.dumps import read_dump
from millscale.runs.writing import writing

STATE_FILE = "state.data"


@dataclass(frozen=True)
class State:
    """A rotating mill: its case, and the files of its balls and liner.

    Attributes:
        data: data file of the engine (`read_data`, atom style granular).
        liner: STL of the liner at mill angle 0.
        mill_angle: angle of the mill in this state [rad].
        balls: number of balls.
    """

    case: Case
    data: Path
    liner: Path
    mill_angle: float
    balls: int


def write_data(dump: Path, box: tuple[float, float], data: Path, types: int = 2) -> int:
    """Write the balls of a dump as a data file; return their number.

    Columns of the dump: id type x y z vx vy vz omegax omegay omegaz radius density.

    Args:
        box: half the box in x and z, length along y [m].
        types: classes of balls, and walls.
    """
    balls = read_dump(dump)
    half, length = box
    order = np.argsort(balls["id"])
    rows = {name: values[order] for name, values in balls.columns.items()}
    rows["diameter"] = 2.0 * rows["radius"]
    with writing(data) as binary:
        file = io.TextIOWrapper(binary, encoding="ascii", write_through=True)
        file.write(
            f"Balls of a mill in motion\n\n{order.size} atoms\n{types} atom types\n\n"
            f"{-half!r} {half!r} xlo xhi\n0.0 {length!r} ylo yhi\n{-half!r} {half!r} zlo zhi\n\n"
        )
        _section(file, "Atoms", rows, ["id", "type", "diameter", "density", "x", "y", "z"])
        _section(file, "Velocities", rows, ["id", "vx", "vy", "vz", "omegax", "omegay", "omegaz"])
        file.detach()
    return int(order.size)


def read_data(data: Path) -> dict[str, np.ndarray]:
    """Return the balls of a data file by number: place [m], velocity [m/s] and spin [rad/s],
    (n, 3); radius [m], (n,)."""
    text = data.read_text(encoding="ascii")
    atoms, _, velocities = text.partition("Atoms\n\n")[2].partition("Velocities\n\n")
    of_atoms, of_velocities = (
        np.array([line.split() for line in part.split("\n") if line.strip()], dtype=float)
        for part in (atoms, velocities)
    )
    return {
        "place": of_atoms[:, 4:7],
        "radius": 0.5 * of_atoms[:, 2],
        "velocity": of_velocities[:, 1:4],
        "spin": of_velocities[:, 4:7],
    }


def _section(file, name: str, rows: dict[str, np.ndarray], columns: list[str]) -> None:
    file.write(f"{name}\n\n")
    formats = ["%d" if column in ("id", "type") else "%.17g" for column in columns]
    np.savetxt(file, np.column_stack([rows[c] for c in columns]), fmt=formats)
    file.write("\n")
