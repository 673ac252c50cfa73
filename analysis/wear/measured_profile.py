"""The constant of a law of wear that fits a measured worn profile best, and how well it fits.

Compared are heights above the plate over a pitch, so the wear of the plate itself does not count.
Derived here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import minimize_scalar

from millscale import _core
from millscale.analysis.finished import Charge
from millscale.analysis.wear.rate import LAWS, WearRate
from millscale.analysis.wear.worn_liner import (
    HOUR,
    charges_with_loads,
    check_numbers,
    rate_of,
    worn_by,
)
from millscale.errors import CampaignError
from millscale.liner.csv_table import read_csv
from millscale.liner.sector import COUNTER, Placing, profile_of, reach
from millscale.liner.worn import Worn
from millscale.runs.liner import liner_of

# Angles of a pitch, and halvings of an interval of radii.
ANGLES, HALVINGS = 400, 40
# Deepest wear over the height of the lifters: of the first tries, and how many.
TRIES = np.geomspace(0.1, 3.0, 12)
# Of the constant, relative.
PRECISION = 1e-3


@dataclass(frozen=True)
class Fitted:
    """A law of wear with the constant that fits best.

    Attributes:
        law: of `rate.LAWS`.
        constant: worn volume over energy [m^3/J].
        rms: of the heights above the plate against the measured ones, over a pitch [m].
        worn: the liner with this constant.
    """

    law: str
    constant: float
    rms: float
    worn: Worn


@dataclass(frozen=True)
class Fit:
    """All laws beside a measured profile.

    Attributes:
        charges: whose loads are the mean.
        laws: those by which the liner wears at all.
        height: of the measured lifter [m].
        unworn_rms: of the liner without wear [m].
    """

    charges: tuple[Charge, ...]
    height: float
    unworn_rms: float
    laws: tuple[Fitted, ...]


def fit_laws(
    runs: Path, measured: Path, hours: float, ratio: float | None, smoothing: float | None
) -> Fit:
    """Return each law of wear with the constant that fits a measured profile of the physical mill.

    Args:
        measured: table of a worn pitch, as `[liner] profile` takes it; turned counter-clockwise.
        hours: until it was measured.
        ratio: S of the scaled mill that is read; None: the smallest.
        smoothing: as in Wear; None: the ball radius of the physical mill [m].

    Raises:
        RunFolderError: no finished case has loads on the liner.
        CampaignError: the table is not accepted, or its lifters are not those of the mill.
    """
    check_numbers({"--hours": hours}, {"--smoothing": smoothing})
    charges = charges_with_loads(runs, ratio)
    case = charges[0].case
    liner = liner_of(case.mill).scaled(1.0 / case.S)
    worn = _profile(measured, liner)
    wanted = heights(worn, liner.sectors)
    rates = [rate_of(charges, law) for law in LAWS]
    width = case.physical.ball_radius_m if smoothing is None else smoothing
    return Fit(
        charges,
        worn.radius - worn.clear_radius,
        _rms(heights(liner, liner.sectors) - wanted),
        tuple(_fitted(rate, liner, wanted, hours, width) for rate in rates if rate.mean > 0.0),
    )


def _profile(path: Path, liner: _core.Profile) -> _core.Profile:
    outline = read_csv(path)
    made, _ = profile_of(outline, Placing(reach(outline)[1], turns=COUNTER))
    if made.sectors != liner.sectors:
        cause = f"has {made.sectors} lifter pitches, the mill of the campaign {liner.sectors}"
        raise CampaignError(path, "", cause, "a profile of the same mill")
    return made


def heights(liner: _core.Profile, sectors: int) -> np.ndarray:
    """Return heights above the largest distance from the axis, at even angles of the pitch around
    a lifter whose centre is in the middle, (ANGLES,) float [m]."""
    pitch = 2.0 * math.pi / sectors
    groove = float(liner.lifter_angles[0]) - 0.5 * pitch
    angle = groove + pitch * (np.arange(ANGLES) + 0.5) / ANGLES
    rays = np.column_stack([np.cos(angle), np.sin(angle)])
    low = np.full(ANGLES, 0.5 * liner.clear_radius)
    high = np.full(ANGLES, 1.01 * liner.radius)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        inside = liner.nearest(middle[:, None] * rays).distance > 0.0
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return liner.radius - low


def _rms(difference: np.ndarray) -> float:
    return float(np.sqrt(np.mean(difference**2)))


def _fitted(
    rate: WearRate,
    liner: _core.Profile,
    wanted: np.ndarray,
    hours: float,
    smoothing: float,
) -> Fitted:
    height = liner.radius - liner.clear_radius

    def worn(factor: float) -> Worn:
        return worn_by(liner, rate, factor, (smoothing, None))

    def missed(logarithm: float) -> float:
        try:
            found = worn(math.exp(logarithm)).profile
        except CampaignError:
            # Worn away.
            return math.inf
        return _rms(heights(found, liner.sectors) - wanted)

    tries = np.log(TRIES * height / float(rate.flux.max()))
    errors = [missed(one) for one in tries.tolist()]
    best = int(np.argmin(errors))
    ends = tries[max(best - 1, 0)], tries[min(best + 1, len(tries) - 1)]
    found = minimize_scalar(missed, bounds=ends, method="bounded", options={"xatol": PRECISION})
    factor = math.exp(float(found.x))
    return Fitted(rate.law, factor / (hours * HOUR), float(found.fun), worn(factor))
