"""Files of loads on the liner that follow from a pressure on the lifters in a part of the turn."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pandas as pd

from millscale.analysis.wear.loads import FACES, LIFTERS, LOADS, MAP
from millscale.liner.outline import arc_points
from millscale.liner.worn import outline_of
from millscale.runs.case_file import Case
from millscale.runs.liner import liner_of

PRESSURE = 2000.0  # [Pa]
SLIP = 30.0  # slip work per area and time of the scaled mill [W/m^2]
BINS_OF_A_PIECE = 12
STEPS = 8000


def bins_of(case: Case) -> pd.DataFrame:
    """Return the bins of a pitch, the same number on each line and arc."""
    liner = liner_of(case.mill)
    outline, rows, before = outline_of(liner), [], 0.0
    shares = np.arange(2 * BINS_OF_A_PIECE + 1) / (2 * BINS_OF_A_PIECE)
    for k, node in enumerate(liner.nodes):
        begin, end, bulge = outline.points[k], outline.points[k + 1], float(outline.bulges[k])
        points = begin + shares[:, None] * (end - begin)
        length = math.dist(begin, end)
        if bulge:
            points = arc_points(begin, end, bulge, shares)
            length *= 2.0 * math.atan(bulge) / math.sin(2.0 * math.atan(bulge))
        for i in range(BINS_OF_A_PIECE):
            chord = points[2 * i + 2] - points[2 * i]
            rows.append(
                {
                    "face": FACES[node[3]],
                    "lifter": node[4],
                    "arc_low_m": before + length * i / BINS_OF_A_PIECE,
                    "arc_high_m": before + length * (i + 1) / BINS_OF_A_PIECE,
                    "radial_m": points[2 * i + 1, 0],
                    "tangential_m": points[2 * i + 1, 1],
                    "tangent_radial": chord[0] / np.linalg.norm(chord),
                    "tangent_tangential": chord[1] / np.linalg.norm(chord),
                }
            )
        before += length
    return pd.DataFrame(rows)


def write_loads(folder: Path, case: Case, first: int, count: int) -> None:
    """Write both files: the pressure acts on each lifter in `count` places from `first` on, and the
    slip everywhere.

    Places of a lifter are counted from that of lifter 0 at rest, half a pitch behind the bottom.
    """
    liner, bins = liner_of(case.mill), bins_of(case)
    steps = math.ceil(liner.pitch / 0.035)
    places = liner.sectors * steps
    duration = STEPS * case.time.step_s
    area = (bins.arc_high_m - bins.arc_low_m).to_numpy() * case.mill.simulated_length_m
    loaded = np.zeros(places)
    loaded[(first + np.arange(count)) % places] = 1.0
    on_lifter = (bins.face != "groove").to_numpy()
    lifter = bins.lifter.to_numpy()
    # Time of a sector in a place.
    time = duration / places
    by_place = np.zeros((places, len(bins), len(LOADS)))
    for place in range(places):
        of_bin = loaded[(place + lifter * steps) % places] * on_lifter
        by_place[place, :, LOADS.index("normal_impulse_Ns")] = PRESSURE * area * of_bin * time
        by_place[place, :, LOADS.index("slip_work_J")] = SLIP * area * time
    by_place *= liner.sectors
    _write_map(folder / MAP, by_place, liner.phase, liner.sectors * time)
    _write_lifters(folder / LIFTERS, bins, by_place.sum(axis=0) / liner.sectors, liner.sectors)


def _write_map(path: Path, loads: np.ndarray, phase: float, time: float) -> None:
    places, bins, _ = loads.shape
    width = 2.0 * np.pi / places
    rows = [
        {
            "ball_class": 1,
            "bin": k,
            "sector_angle_low_rad": phase + p * width,
            "sector_angle_high_rad": phase + (p + 1) * width,
            "sectors_time_s": time,
        }
        | dict(zip(LOADS, loads[p, k].tolist(), strict=True))
        for p in range(places)
        for k in range(bins)
    ]
    pd.DataFrame(rows).to_csv(path, index=False)


def _write_lifters(path: Path, bins: pd.DataFrame, loads: np.ndarray, sectors: int) -> None:
    window = {"mill_angle_from_rad": 0.5, "mill_angle_to_rad": 1.0, "steps": STEPS}
    tables = [
        pd.concat(
            [
                bins.assign(**window, ball_class=1, sector=sector, bin=range(len(bins))),
                pd.DataFrame(loads, columns=list(LOADS)),
            ],
            axis=1,
        )
        for sector in range(sectors)
    ]
    pd.concat(tables).to_csv(path, index=False)
