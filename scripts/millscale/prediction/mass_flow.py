"""Mass in the monitoring box of the physical mill over a lifter pitch.

The box is a groove at the bottom, at rest (docs/reference/styles/compute-mill-charge.md). The
lifters pass it, so the mass in it is periodic in the lifter pitch. Its mean over the steady window
at each phase of the pitch is extrapolated phase by phase.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from millscale.analysis.charge.groove_flow import PHASES, box_angle, pitch_masses
from millscale.analysis.charge.steady import lifter_pitch, standard_error
from millscale.analysis.finished import Charge
from millscale.prediction.extrapolation import ExtrapolationError, Noise, by_ratio
from millscale.prediction.kinds import Kind
from millscale.prediction.points import extrapolate_points, noise_of_points

# The bed thins towards its toe over about this many ball diameters.
THIN_DIAMETERS = 2.0
# Shallower grooves [ball diameters] hold one layer of balls: fewer than their volume lets expect.
LEAST_DEPTH = 2.0


@dataclass(frozen=True)
class PredictedCurve:
    """Mass in the monitoring box of the physical mill, against the mill angle within a pitch.

    Attributes:
        angles: (n,) float, middles of the phases of the pitch [rad].
        values, half_widths: (n,) float, share of the charge, and of the interval.
        check: RMS difference from a physical mill that was left out, over its mean.
        nearest: the same of the smallest scaled S, for comparison.
        inside: share of the phases whose interval holds the mill that was left out.
    """

    angles: np.ndarray
    values: np.ndarray
    half_widths: np.ndarray
    noise_from: str
    check: float | None = None
    nearest: float | None = None
    inside: float | None = None

    def document(self, mass: float) -> dict[str, Any]:
        """Return it as JSON types, masses in kg.

        Args:
            mass: of the whole charge of the physical mill [kg].
        """
        return {
            "mill_angles_rad": self.angles.round(6).tolist(),
            "masses_kg": (mass * self.values).round(6).tolist(),
            "half_widths_kg": (mass * self.half_widths).round(6).tolist(),
            "noise_from": self.noise_from,
            "rms_over_mean_from_left_out": self.check,
            "rms_over_mean_of_smallest_S_from_left_out": self.nearest,
            "share_inside": self.inside,
        }


def box_refused(charges: Sequence[Charge]) -> str:
    """Return why the mass in the box does not follow a power of S; empty if it does.

    The box must lie deep in the bed of every mill: as S grows the toe moves towards the bottom, and
    once it has reached the box, the mass in the box falls with another law. It is a groove as deep
    as the lifters are high, so it must be deep against the balls as well.
    """
    for charge in charges:
        depth = charge.case.groups.lifter_height_over_ball_diameter
        if depth < LEAST_DEPTH * (1.0 - 1e-3):
            return (
                f"the grooves of S = {charge.S:.4g} are {depth:.2g} ball diameters deep, at least "
                f"{LEAST_DEPTH:g} are needed for its mass of balls to follow a power of S"
            )
        toe, angle = charge.steady_mean("toe_angle_rad"), box_angle(charge.case)
        if toe is None or angle is None:
            continue
        mill = charge.case.mill
        end = math.pi - mill.phase_rad + 0.5 * angle
        thin = THIN_DIAMETERS * 2.0 * charge.case.ball.radius_m / mill.lifter_top_radius_m
        if toe < end + thin:
            return (
                f"the toe of S = {charge.S:.4g}, at {math.degrees(toe):.1f} deg, has reached the "
                f"monitoring box, which ends at {math.degrees(end):.1f} deg"
            )
    return ""


def predict_mass_flow(
    charges: Sequence[Charge], left_out: Sequence[Charge] = (), level: float = 0.95
) -> PredictedCurve:
    """Extrapolate the mass in the box at each phase of a lifter pitch to S = 1.

    Args:
        charges: of two or more values of S.
        left_out: charges of S = 1 to compare with.

    Raises:
        ExtrapolationError: no box, a toe that has reached it, too few charges.
    """
    by_charge = {charge: pitch_masses(charge) for charge in charges}
    known = {charge: masses for charge, masses in by_charge.items() if masses is not None}
    if len(known) < len(charges):
        raise ExtrapolationError("a plain drum has no box, or a run has too few lifter pitches")
    if reason := box_refused(charges):
        raise ExtrapolationError(reason)
    groups = by_ratio((charge.S, masses.mean(axis=0)) for charge, masses in known.items())
    noise, noise_from = noise_of_points(groups, _noise_of_pitches(list(known.values())))
    values, half_widths = extrapolate_points(groups, noise, level, Kind.DILATION.prior)
    width = lifter_pitch(charges[0].case.mill.lifters)
    angles = width * (np.arange(PHASES) + 0.5) / PHASES
    curve = PredictedCurve(angles, values, half_widths, noise_from)
    truth = [x.mean(axis=0) for charge in left_out if (x := pitch_masses(charge)) is not None]
    if not truth:
        return curve
    theirs = np.mean(truth, axis=0)
    return replace(
        curve,
        check=_rms_over_mean(values, theirs),
        nearest=_rms_over_mean(np.mean(groups[0][1], axis=0), theirs),
        inside=float(np.mean(np.abs(values - theirs) <= half_widths)),
    )


def _noise_of_pitches(runs: Sequence[np.ndarray]) -> Noise:
    """Return the noise of one run at one phase, from the scatter of its lifter pitches."""
    squares = [standard_error(masses[:, i]) ** 2 for masses in runs for i in range(PHASES)]
    freedom = sum(len(masses) - 1 for masses in runs)
    return Noise(math.sqrt(math.fsum(squares) / len(squares)), float(freedom))


def _rms_over_mean(ours: np.ndarray, theirs: np.ndarray) -> float:
    return float(np.sqrt(np.mean((ours - theirs) ** 2)) / theirs.mean())
