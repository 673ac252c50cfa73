"""Balls and liner of a multi-ball case at the same times, for ParaView.

The files are CASE/paraview/charge.pvd and those it names. Open charge.pvd and show the balls as
Point Gaussian with `radius` for scale. OVITO reads the dumps themselves,
CASE/dump/charge.*.liggghts.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from millscale.analysis.shapes.snapshots import first_dump, mill_angle_at, starts_on_rising_side
from millscale.runs.case_folder import SERIES, RunFolderError, check_current, load_case
from millscale.runs.dumps import read_dump, required_dumps
from millscale.runs.provenance import PROVENANCE_FILE
from millscale.runs.series import read_series
from millscale.runs.writing import write_text, writing_folder

FOLDER, COLLECTION = "paraview", "charge.pvd"
LINER = "liner.vtp"


def write_paraview(folder: Path, every: int = 1) -> Path:
    """Write every so many dumps of a case, each with the liner turned to its mill angle.

    Returns:
        The collection to open, charge.pvd; its times are in s, those of series.csv.

    Raises:
        RunFolderError: no dumps, no series, no liner, one of them damaged, or of another case.json.
    """
    # Imported here: a case without dumps is refused without the drawing library.
    from millscale.report.pictures import save_balls, save_liner

    if (folder / PROVENANCE_FILE).exists():
        check_current(folder, load_case(folder), upto="rotate")
    files = required_dumps(folder)
    series = read_series(folder / SERIES, "multi-ball")
    steps = list(files)[::every]
    angles = mill_angle_at(np.array(steps, float), series)
    first = first_dump(folder)
    with writing_folder(folder / FOLDER) as to:
        for step, angle in zip(steps, angles, strict=True):
            dump = read_dump(files[step])
            try:
                rising = starts_on_rising_side(dump, first)
            except ValueError as error:
                raise RunFolderError(files[step], str(error), "run the case again") from None
            save_balls(dump, rising, to / f"balls.{step:09d}.vtp")
            save_liner(folder / LINER, float(angle), to / f"liner.{step:09d}.vtp")
        times = _time_at(np.array(steps, float), series)
        _write_collection(to / COLLECTION, steps, times)
    return folder / FOLDER / COLLECTION


def _time_at(steps: np.ndarray, series: dict[str, np.ndarray]) -> np.ndarray:
    """Return the simulated time [s] at steps, (n,) float."""
    step, time = series["step"], series["time_s"]
    slope = (time[-1] - time[0]) / (step[-1] - step[0])
    return time[0] + slope * (steps - step[0])


def _write_collection(path: Path, steps: Sequence[int], times: np.ndarray) -> None:
    entries = [
        f'  <DataSet timestep="{time:.9g}" part="{part}" name="{name}" '
        f'file="{name}.{step:09d}.vtp"/>'
        for step, time in zip(steps, times, strict=True)
        for part, name in enumerate(("balls", "liner"))
    ]
    text = '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n <Collection>\n'
    write_text(path, text + "\n".join(entries) + "\n </Collection>\n</VTKFile>\n")
