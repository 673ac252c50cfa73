"""Mass in the monitoring box over total mass (Figs. 13, 14): two mills against each other."""

from __future__ import annotations

import numpy as np

FRAMES = {"fixed": "box_fixed_mass_fraction", "rotating": "box_rotating_mass_fraction"}


def compare_flow(
    angle: np.ndarray, share: np.ndarray, reference_angle: np.ndarray, reference: np.ndarray
) -> dict[str, float | None]:
    """Root mean square difference of two curves against mill angle, and their correlation.

    Over the mill angles both have, at those of the coarser curve; the other is interpolated.

    Args:
        angle, reference_angle: (n,), (m,) float, increasing [rad].
        share, reference: (n,), (m,) float: mass in the box over total mass.

    Returns:
        rms; rms_over_mean: over the mean of the reference, None if that is zero; correlation:
        Pearson's, None for a curve that does not vary.

    Raises:
        ValueError: fewer than three mill angles in common.
    """
    begin, end = max(angle[0], reference_angle[0]), min(angle[-1], reference_angle[-1])
    coarser = angle if angle.size <= reference_angle.size else reference_angle
    common = coarser[(coarser >= begin) & (coarser <= end)]
    if common.size < 3:
        raise ValueError(f"the curves share {common.size} mill angles, three are needed")
    ours = np.interp(common, angle, share)
    theirs = np.interp(common, reference_angle, reference)
    rms, mean = float(np.sqrt(np.mean((ours - theirs) ** 2))), float(theirs.mean())
    varies = min(np.ptp(ours), np.ptp(theirs)) > 0.0
    return {
        "rms": rms,
        "rms_over_mean": rms / mean if mean > 0.0 else None,
        "correlation": float(np.corrcoef(ours, theirs)[0, 1]) if varies else None,
    }
