"""Loads of the balls on the liner, from lifter_loads.csv and liner_loads.csv."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from millscale.runs.case_file import Case
from millscale.runs.layout import LOADS_FILES
from millscale.runs.untrusted import MOST_SERIES, RunFolderError, read_text

LIFTERS, MAP = LOADS_FILES
LOADS = (
    *("normal_impulse_Ns", "tangential_impulse_Ns", "torque_impulse_Nms"),
    *("slip_work_J", "normal_dissipation_J"),
    *("impacts", "impact_energy_J", "finnie_energy_J"),
)
ENDS = ("lower_end", "upper_end")
FACES = ("groove", "leading", "top", "trailing")
_GEOMETRY = (
    *("arc_low_m", "arc_high_m", "radial_m", "tangential_m"),
    *("tangent_radial", "tangent_tangential"),
)
_WINDOW = ("mill_angle_from_rad", "mill_angle_to_rad", "steps")
_LIFTER_COLUMNS = (*_WINDOW, "ball_class", "sector", "bin", "face", "lifter", *_GEOMETRY, *LOADS)
_PLACE = ("sector_angle_low_rad", "sector_angle_high_rad", "sectors_time_s")
_MAP_COLUMNS = ("ball_class", "bin", *_PLACE, *LOADS)
_REMEDY = "run the case again: millscale run FILE --runs DIR --only ID"


@dataclass(frozen=True)
class Bins:
    """Parts of the profile of one pitch, in the direction of rotation.

    Attributes:
        edges: (bins + 1,) float, arc length from the first node of the sector [m].
        faces: (bins,) text, one of FACES.
        lifters: (bins,) int, lifter or groove, counted from the first of the sector.
        middles: (bins, 2) float, radial and tangential in the frame of the sector's centre line
            [m].
        tangents: (bins, 2) float, unit vectors in the direction of rotation.
    """

    edges: np.ndarray
    faces: np.ndarray
    lifters: np.ndarray
    middles: np.ndarray
    tangents: np.ndarray

    @property
    def widths(self) -> np.ndarray:
        """Return the width of each bin, (bins,) float [m]."""
        return np.diff(self.edges)

    @property
    def normals(self) -> np.ndarray:
        """Return the unit vectors into the cavity, (bins, 2) float."""
        return np.column_stack([-self.tangents[:, 1], self.tangents[:, 0]])


@dataclass(frozen=True)
class LinerLoads:
    """Loads on the liner between two mill angles. Loads are sums, in the order of `LOADS`.

    Attributes:
        from_rad, to_rad: mill angles of the first and the last step.
        duration: of these steps [s].
        bins: of a pitch.
        by_sector: (classes, sectors, bins, loads) float.
        by_place: (classes, places, bins, loads) float.
        places: (places,) float, middles of equal intervals of the angle of a sector's centre line
            from the bottom in the direction of rotation [rad].
        times: (places,) float, time of all sectors in a place [s].
        ends: (classes, 2, loads) float, of the end walls.
    """

    from_rad: float
    to_rad: float
    duration: float
    bins: Bins
    by_sector: np.ndarray
    by_place: np.ndarray
    places: np.ndarray
    times: np.ndarray
    ends: np.ndarray

    def total(self, load: str) -> float:
        """Return a load of the liner and its ends."""
        k = LOADS.index(load)
        return float(self.by_sector[..., k].sum() + self.ends[..., k].sum())

    def of_bins(self, load: str) -> np.ndarray:
        """Return a load of each bin over all sectors and classes, (bins,) float."""
        return self.by_sector[..., LOADS.index(load)].sum(axis=(0, 1))

    def of_sectors(self, load: str) -> np.ndarray:
        """Return a load of each sector and bin over all classes, (sectors, bins) float."""
        return self.by_sector[..., LOADS.index(load)].sum(axis=0)

    def rates(self, load: str) -> np.ndarray:
        """Return the mean load per time of one sector in each place and bin, (places, bins) float;
        0 where no sector was."""
        sums = self.by_place[..., LOADS.index(load)].sum(axis=0)
        time = self.times[:, None]
        return np.divide(sums, time, out=np.zeros_like(sums), where=time > 0.0)


def read_liner_loads(folder: Path, case: Case) -> LinerLoads:
    """Return the loads on the liner of a case folder.

    Raises:
        RunFolderError: a file is missing or not whole.
    """
    lifters = _table(folder / LIFTERS, _LIFTER_COLUMNS)
    places = _table(folder / MAP, _MAP_COLUMNS)
    try:
        return _loads(lifters, places, case)
    except (ValueError, IndexError, KeyError) as error:
        cause = f"its rows are not whole: {error}"
        raise RunFolderError(folder / LIFTERS, cause, _REMEDY) from None


def _table(path: Path, columns: tuple[str, ...]) -> pd.DataFrame:
    """Return the rows of a file; every column but the face is of finite numbers."""
    text = read_text(path, MOST_SERIES, _REMEDY)
    try:
        table = pd.read_csv(io.StringIO(text))
        if missing := [name for name in columns if name not in table]:
            raise ValueError(f"no column {', '.join(missing)}")
        numbers = table[[name for name in columns if name != "face"]].to_numpy(float)
        if len(numbers) == 0 or not np.isfinite(numbers).all():
            raise ValueError("no rows, or a number is not finite")
    except (ValueError, TypeError) as error:
        raise RunFolderError(path, str(error), _REMEDY) from None
    return table


def _loads(lifters: pd.DataFrame, places: pd.DataFrame, case: Case) -> LinerLoads:
    of_liner, of_ends = lifters[~lifters.face.isin(ENDS)], lifters[lifters.face.isin(ENDS)]
    last = of_liner[["ball_class", "sector", "bin"]].max()
    classes, sectors, bins = int(last.ball_class), int(last.sector) + 1, int(last.bin) + 1
    if len(of_liner) != classes * sectors * bins:
        raise ValueError(f"{len(of_liner)} rows of {classes} x {sectors} x {bins}")
    of_liner = of_liner.sort_values(["ball_class", "sector", "bin"])
    first = of_liner.iloc[:bins]
    if not first.face.isin(FACES).all():
        raise ValueError("an unknown face")
    ends = np.zeros((classes, len(ENDS), len(LOADS)))
    for k, name in enumerate(ENDS):
        own = of_ends[of_ends.face == name]
        ends[own.ball_class.to_numpy(int) - 1, k] = own[list(LOADS)].to_numpy(float)
    count, middles, times, by_place = _by_place(places, classes, bins, case.mill.phase_rad)
    head = lifters.iloc[0]
    return LinerLoads(
        from_rad=float(head.mill_angle_from_rad),
        to_rad=float(head.mill_angle_to_rad),
        duration=float(head.steps) * case.time.step_s,
        bins=Bins(
            edges=np.append(first.arc_low_m, first.arc_high_m.iloc[-1]),
            faces=first.face.to_numpy(str),
            lifters=first.lifter.to_numpy(int),
            middles=first[["radial_m", "tangential_m"]].to_numpy(float),
            tangents=first[["tangent_radial", "tangent_tangential"]].to_numpy(float),
        ),
        by_sector=of_liner[list(LOADS)].to_numpy(float).reshape(classes, sectors, bins, -1),
        by_place=by_place.reshape(classes, count, bins, -1),
        places=middles,
        times=times,
        ends=ends,
    )


def _by_place(
    table: pd.DataFrame, classes: int, bins: int, phase: float
) -> tuple[int, np.ndarray, np.ndarray, np.ndarray]:
    """Return number, middles and times of the places, and the loads of all classes and bins."""
    low, high, time = (table[name].to_numpy(float) for name in _PLACE)
    width = float(np.mean(high - low))
    count = round(2.0 * np.pi / width)
    place = np.round((low - phase) / (2.0 * np.pi / count)).astype(int)
    loads = np.zeros((classes, count, bins, len(LOADS)))
    rows = table.ball_class.to_numpy(int) - 1, place, table.bin.to_numpy(int)
    if any((row < 0).any() for row in rows):
        raise ValueError("a class, place or bin below the first")
    loads[rows] = table[list(LOADS)].to_numpy(float)
    times = np.zeros(count)
    times[place] = time
    middles = phase + 2.0 * np.pi / count * (np.arange(count) + 0.5)
    return count, middles, times, loads
