"""Radial segregation of the classes of balls of a charge."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from millscale.analysis.shapes.snapshots import class_of_each, mill_angle_at
from millscale.runs.case_file import Case
from millscale.runs.dumps import dump_files, read_dump
from millscale.runs.series import Series


def segregation_indices(
    places: np.ndarray, mass: np.ndarray, kinds: np.ndarray, classes: int
) -> np.ndarray:
    """Return the radial segregation index of each class, (classes,) float.

    1 less the mean square distance of a class from the centre of mass of the charge, in the
    cross-section, over that of all balls; means by mass. 0: mixed; positive: the class lies in the
    core of the charge; negative: around it. The radial form of the generalized mean mixing index of
    Asmar, Langston, Matchett, Granular Matter 4 (2002) 129, which compares a mean position of a
    class with that of all particles.

    Args:
        places: (n, 2) float, x and z [m].
        mass: (n,) float [kg].
        kinds: (n,) int, class of each ball from 0 on.
    """
    centre = mass @ places / mass.sum()
    square = ((places - centre) ** 2).sum(axis=1)
    of_all = float(mass @ square / mass.sum())
    totals = np.bincount(kinds, mass, classes)
    return 1.0 - np.bincount(kinds, mass * square, classes) / totals / of_all


def segregation_of(
    folder: Path, case: Case, series: Series, begin: float, end: float
) -> tuple[float, ...] | None:
    """Return the mean indices of the classes over the dumps between two mill angles [rad].

    None for a charge of one class, or without dumps there.
    """
    files = dump_files(folder)
    classes = case.ball.classes
    if not classes or not files:
        return None
    angles = mill_angle_at(np.array(list(files), float), series)
    chosen = [
        path
        for path, angle in zip(files.values(), angles, strict=True)
        if begin - 1e-6 <= angle <= end + 1e-6
    ]
    if not chosen:
        return None
    densities = np.array([one.density_kg_m3 for one in classes])
    found = []
    for dump in map(read_dump, chosen):
        kinds = class_of_each(dump, len(classes))
        mass = densities[kinds] * dump["radius"] ** 3
        found.append(segregation_indices(dump.positions[:, [0, 2]], mass, kinds, len(classes)))
    return tuple(float(x) for x in np.mean(found, axis=0))
