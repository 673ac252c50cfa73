"""Mass in the monitoring box over total mass (Figs. 13, 14): two mills against each other."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from millscale.runs.series import Series

# Column of series.csv by the frame in which the box is at rest.
FRAMES = {"fixed": "box_fixed_mass_fraction", "rotating": "box_rotating_mass_fraction"}


@dataclass(frozen=True)
class MassFlow:
    """Mass in the box against mill angle.

    Attributes:
        mill_angle: (n,) float, increasing [rad].
        share: (n,) float: mass in the box over total mass.
    """

    mill_angle: np.ndarray
    share: np.ndarray


def flow_of(series: Series, column: str) -> MassFlow:
    """Return one of FRAMES of a series."""
    return MassFlow(series["mill_angle_rad"], series[column])


def compare_flow(flow: MassFlow, reference: MassFlow) -> tuple[float, float | None, float | None]:
    """Return root mean square difference and correlation of two curves against mill angle.

    Over the mill angles that both have, at those of the coarser curve; the other is interpolated.

    Returns:
        Root mean square difference; the same over the mean of the reference, None if that is zero;
        Pearson's correlation, None for a curve that does not vary.

    Raises:
        ValueError: fewer than three mill angles in common.
    """
    both = (flow, reference)
    begin = max(curve.mill_angle[0] for curve in both)
    end = min(curve.mill_angle[-1] for curve in both)
    coarser = min(both, key=lambda curve: curve.mill_angle.size).mill_angle
    common = coarser[(coarser >= begin) & (coarser <= end)]
    if common.size < 3:
        raise ValueError(f"the curves share {common.size} mill angles, three are needed")
    ours, theirs = (np.interp(common, curve.mill_angle, curve.share) for curve in both)
    rms, mean = float(np.sqrt(np.mean((ours - theirs) ** 2))), float(theirs.mean())
    varies = min(np.ptp(ours), np.ptp(theirs)) > 0.0
    correlation = float(np.corrcoef(ours, theirs)[0, 1]) if varies else None
    return rms, rms / mean if mean > 0.0 else None, correlation
