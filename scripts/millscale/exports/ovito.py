"""A charge for OVITO: charge.xyz with radii, and the turned liner as liner.*.stl."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from millscale.analysis.finished import Charge
from millscale.exports.columns import plain_name
from millscale.exports.snapshots import Moment, moments
from millscale.runs.case_file import Case
from millscale.runs.case_folder import LINER
from millscale.runs.writing import writing, writing_by_name

BALLS = "charge.xyz"
# Columns of the extended XYZ format, by those of a dump: name, kind, digits.
_POSITION = ("x", "y", "z")
_VELOCITY = ("vx", "vy", "vz")
_WHOLE = ("id", "type", "state", "flight_count", "flight_lifter", "from_outermost_layer",
          "last_lifter")  # fmt: skip


def write_ovito(charge: Charge, to: Path, every: int) -> Path:
    """Write every so many dumps of a charge into a folder; return the file to open.

    Raises:
        RunFolderError: no dumps, no series, no liner, or a damaged one.
    """
    from millscale.exports.geometry import turned_liner

    with writing(to / BALLS) as file:
        for number, moment in enumerate(moments(charge, every)):
            text, rows, formats = _frame(moment, charge.case)
            file.write(f"{len(moment.dump)}\n{text}\n".encode())
            np.savetxt(file, rows, fmt=formats)
            with writing_by_name(to / f"liner.{number:05d}.stl") as part:
                turned_liner(charge.folder / LINER, moment.mill_angle).save(part)
    return to / BALLS


def _frame(moment: Moment, case: Case) -> tuple[str, np.ndarray, list[str]]:
    """Return the second line of a frame, and its columns with their formats."""
    dump = moment.dump
    others = [name for name in dump.columns if name not in (*_POSITION, *_VELOCITY)]
    columns = [dump.positions, *(dump[name] for name in others), moment.rising]
    names = [_name(name) for name in others]
    kinds = ["I" if name in _WHOLE else "R" for name in names]
    of_each = (f"{name}:{kind}:1" for name, kind in zip(names, kinds, strict=True))
    properties = ["pos:R:3", *of_each, "rising:I:1"]
    whole = [False] * 3 + [kind == "I" for kind in kinds] + [True]
    if all(name in dump.columns for name in _VELOCITY):
        columns.append(np.column_stack([dump[name] for name in _VELOCITY]))
        properties.append("velo:R:3")
        whole += [False] * 3
    half, length = case.mill.radius_m, case.mill.simulated_length_m
    box = f"{2.0 * half:.9g} 0 0 0 {length:.9g} 0 0 0 {2.0 * half:.9g}"
    text = (
        f'Lattice="{box}" Origin="{-half:.9g} 0 {-half:.9g}" '
        f'pbc="F {"T" if case.mill.ends == "periodic" else "F"} F" '
        f"Properties={':'.join(properties)} Time={moment.time:.9g} Timestep={dump.step} "
        f"mill_angle_rad={moment.mill_angle:.9g}"
    )
    return text, np.column_stack(columns), ["%d" if x else "%.9g" for x in whole]


def _name(column: str) -> str:
    """Return the name of a column of a dump; OVITO knows a class of balls as a type."""
    name = plain_name(column)
    return "type" if name == "class" else name
