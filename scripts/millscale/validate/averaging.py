"""Rotation against seeds: `millscale validate averaging`.

How far a charge must turn until it is steady, how long its fluctuations last, and what a longer
rotation gives beside more seeds. Angles are of mill rotation.

After the start the centre of mass swings about its steady place like a damped pendulum,

    x(a) = m + A exp(-g a) cos(w a + phase).

If the same pendulum answers to uncorrelated kicks, its autocorrelation is
exp(-g a) (cos(w a) + (g / w) sin(w a)), with the correlation angle 4 g / (g^2 + w^2), twice the
integral. The variance of a mean over an angle W is the variance of the values times the correlation
angle over W. Derived here; docs/theory/charge.md.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure
from scipy.optimize import curve_fit

from millscale.analysis.charge.result import charge_scales
from millscale.analysis.charge.scaled_mills import ScaledMill, scaled_mills
from millscale.analysis.charge.steady import Window, lifter_pitch, standard_error
from millscale.analysis.finished import Charge
from millscale.analysis.several_campaigns import load_charges
from millscale.engine.record import provenance
from millscale.errors import PredictionError
from millscale.report.figures.style import STYLE
from millscale.runs.dumps import read_dump, required_dumps
from millscale.runs.writing import write_json

Row = dict[str, Any]
# The swing is fitted from where the first push of the lifters is over to where it is in the noise.
FIT_FROM, FIT_TO = 1.2, 9.0
# Mill angles of the windows whose means are compared [rad]: that of a run of 12 rad is 5.
WINDOWS = (3.0, 5.0, 8.0)
# A run shows its correlation angle if its steady part is as long as this many windows of 5 rad.
FEWEST_WINDOWS = 3
# The autocorrelation is summed to this many correlation angles (Sokal, in Functional Integration,
# Plenum 1997, p. 131, doi 10.1007/978-1-4899-0319-8_6).
SUMMED_ANGLES = 5.0
QUANTITIES: dict[str, Callable[[Charge], np.ndarray]] = {
    "centre_x": lambda x: x.series["centre_x_m"] / charge_scales(x.case, x.series).length,
    "kinetic": lambda x: x.series["kinetic_translation_J"] / charge_scales(x.case, x.series).energy,
    "flying_share": lambda x: x.series["balls_in_flight"] / x.series["balls"],
    "toe_angle_rad": lambda x: x.series["toe_angle_rad"],
}


@dataclass(frozen=True)
class Swing:
    """A damped pendulum, against mill angle.

    Attributes:
        mean: in the unit of the values.
        amplitude: at angle 0, over the mean.
        decay: angle in which it falls by e, 1 / g [rad].
        period: 2 pi / w [rad].
    """

    mean: float
    amplitude: float
    decay: float
    period: float

    @property
    def correlation_angle(self) -> float:
        """Return that of its fluctuations, 4 g / (g^2 + w^2) [rad]."""
        g, w = 1.0 / self.decay, 2.0 * math.pi / self.period
        return 4.0 * g / (g * g + w * w)

    def autocorrelation(self, angle: np.ndarray) -> np.ndarray:
        """Return that of its fluctuations at angles [rad]."""
        g, w = 1.0 / self.decay, 2.0 * math.pi / self.period
        return np.exp(-g * angle) * (np.cos(w * angle) + g / w * np.sin(w * angle))

    def angle_to(self, error: float, start: float | None = None) -> float:
        """Return the mill angle after which it is within a relative error of its mean [rad].

        Args:
            start: relative deviation at the start; by default its own.
        """
        begin = self.amplitude if start is None else start
        return self.decay * math.log(begin / error)


def fit_swing(angle: np.ndarray, values: np.ndarray) -> Swing:
    """Return the damped pendulum through values at mill angles [rad], by least squares."""

    def model(a, mean, cosine, sine, g, w):
        return mean + np.exp(-g * a) * (cosine * np.cos(w * a) + sine * np.sin(w * a))

    mean = float(values[len(values) // 2 :].mean())
    scale = float(np.abs(values - mean).max())
    found, _ = curve_fit(model, angle, values, p0=(mean, -scale, scale, 0.7, 1.7), maxfev=20_000)
    mean, cosine, sine, g, w = map(float, found)
    amplitude = math.hypot(cosine, sine) / abs(mean)
    return Swing(mean, amplitude, 1.0 / g, 2.0 * math.pi / abs(w))


def correlation_angle(values: np.ndarray, step: float) -> float:
    """Return the correlation angle of values at equal steps of mill angle [rad].

    step (1 + 2 sum of the autocorrelation), summed to `SUMMED_ANGLES` of itself.
    """
    left = values - values.mean()
    square, angle = float(left @ left), step
    for lag in range(1, len(left)):
        angle += 2.0 * step * float(left[:-lag] @ left[lag:]) / square
        if lag * step >= SUMMED_ANGLES * angle:
            break
    return max(angle, 0.0)


def pendulum_frequency(charge: Charge) -> float:
    """Return the frequency of the charge if it swung as a rigid body, over the mill's speed.

    sqrt(M g l / I) / omega: l the distance of the centre of mass from the axis, I the moment of
    inertia about the axis, of the last dump.
    """
    dump = read_dump(list(required_dumps(charge.folder).values())[-1])
    x, z = dump["x"], dump["z"]
    inertia = float(np.mean(x * x + z * z)) + 0.4 * charge.case.ball.radius_m**2
    arm, mill = math.hypot(float(x.mean()), float(z.mean())), charge.case.mill
    return math.sqrt(mill.gravity_m_s2 * arm / inertia) / mill.omega_rad_s


def pitch_means(charge: Charge, values: np.ndarray, begin: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the middles [rad] and means of the whole lifter pitches after a mill angle."""
    angle, pitch = charge.series["mill_angle_rad"], lifter_pitch(charge.case.mill.lifters)
    first = max(math.ceil(begin / pitch - 1e-9), 1)
    edges = pitch * np.arange(first, math.floor(angle[-1] / pitch + 1e-9) + 1)
    window = Window(float(edges[0]), float(edges[-1]), edges)
    return 0.5 * (edges[1:] + edges[:-1]), window.pitch_means(angle, values)


def swing_of(charge: Charge) -> Swing:
    """Return the swing of a charge's centre of mass after the start."""
    angle, values = pitch_means(charge, QUANTITIES["centre_x"](charge), FIT_FROM)
    inside = angle < FIT_TO
    return fit_swing(angle[inside], values[inside])


def row_of(charge: Charge) -> Row:
    """Return what a charge shows of its start and of its fluctuations."""
    swing = swing_of(charge)
    row = {
        "id": charge.id,
        "S": charge.S,
        "policy": charge.policy,
        "seed": charge.seed,
        "rotation_rad": charge.result.rotation_angle_rad,
        "steady_from_rad": charge.steady_from,
        "swing": {**asdict(swing), "correlation_angle": swing.correlation_angle},
        "swing_frequency": math.hypot(2.0 * math.pi / swing.period, 1.0 / swing.decay),
        "pendulum_frequency": pendulum_frequency(charge),
        "angle_to_within_1_percent": swing.angle_to(0.01),
        "angle_to_within_0.3_percent": swing.angle_to(0.003),
        # From the state of another S, whose centre of mass differs by this much at most.
        "angle_from_5_percent_to_0.3": swing.angle_to(0.003, 0.05),
        "fluctuations": {},
    }
    if charge.result.rotation_angle_rad - charge.steady_from >= 5.0 * FEWEST_WINDOWS:
        row["fluctuations"] = {
            name: fluctuations(charge, values(charge)) for name, values in QUANTITIES.items()
        }
    return row


def fluctuations(charge: Charge, values: np.ndarray) -> Row:
    """Return correlation angle and relative scatter of a quantity, and of its means over windows.

    `by_pitches` is the root mean square over the windows of the error that the scatter of their
    pitches gives (`steady.standard_error`), `of_means` the scatter of the means themselves.
    """
    pitch = lifter_pitch(charge.case.mill.lifters)
    _, means = pitch_means(charge, values, charge.steady_from)
    mean = abs(float(means.mean()))
    windows = []
    for width in WINDOWS:
        count = round(width / pitch)
        parts = [means[i : i + count] for i in range(0, len(means) - count + 1, count)]
        if len(parts) >= FEWEST_WINDOWS:
            errors = [standard_error(part) for part in parts]
            windows.append(
                {
                    "window_rad": count * pitch,
                    "windows": len(parts),
                    "of_means": float(np.std([part.mean() for part in parts], ddof=1)) / mean,
                    "by_pitches": float(np.sqrt(np.mean(np.square(errors)))) / mean,
                }
            )
    angle = correlation_angle(means, pitch)
    return {
        "correlation_angle": angle,
        "deviation_of_pitches": float(means.std(ddof=1)) / mean,
        "error_of_5_rad": float(means.std(ddof=1)) / mean * math.sqrt(angle / 5.0),
        "windows": windows,
    }


def seeds_of(mill: ScaledMill) -> Row:
    """Return the relative scatter between the means of the seeds of a mill, over their windows."""
    windows = [x.result.mean_to_rad - x.steady_from for x in mill.seeds]
    row: Row = {
        "S": mill.name.S,
        "policy": mill.name.policy,
        "seeds": len(mill.seeds),
        "window_rad": float(np.mean(windows)),
        "deviation": {},
    }
    for name, values in QUANTITIES.items():
        means = [float(pitch_means(x, values(x), x.steady_from)[1].mean()) for x in mill.seeds]
        row["deviation"][name] = float(np.std(means, ddof=1) / abs(np.mean(means)))
    return row


def cost_of(spin_up: float, angle: float, deviation: float, seed_angle: float) -> Row:
    """Return the error of a mean for a given total rotation, by one run and by several seeds.

    Args:
        spin_up: rotation until steady [rad].
        angle: correlation angle [rad].
        deviation: relative scatter of the values.
        seed_angle: rotation of each of several seeds [rad].
    """
    totals = [seeds * seed_angle for seeds in (1, 2, 3, 6)]
    return {
        "spin_up_rad": spin_up,
        "rows": [
            {
                "total_rad": total,
                "one_run": deviation * math.sqrt(angle / (total - spin_up)),
                "seeds": round(total / seed_angle),
                "by_seeds": deviation
                * math.sqrt(angle / (total / seed_angle * (seed_angle - spin_up))),
            }
            for total in totals
        ],
    }


def write_averaging(folders: Sequence[Path], docs: Path) -> None:
    """Write results/averaging.json and .png.

    Args:
        folders: runs folders; at least one charge must turn for long.
    """
    charges = sorted(load_charges(folders)[0], key=lambda x: (x.policy, x.S, x.id))
    rows = [row_of(charge) for charge in charges]
    long = [row for row in rows if row["fluctuations"]]
    if not long:
        raise PredictionError(
            f"no charge is steady for {5.0 * FEWEST_WINDOWS:g} rad: correlation angles need one"
        )
    spin_up = float(np.median([row["angle_to_within_0.3_percent"] for row in rows]))
    centre = [row["fluctuations"]["centre_x"] for row in long]
    document = {
        "schema": 1,
        **provenance(),
        "charges": rows,
        "seeds": [seeds_of(mill) for mill in scaled_mills(charges) if len(mill.seeds) > 1],
        "cost": cost_of(
            spin_up,
            float(np.mean([x["correlation_angle"] for x in centre])),
            float(np.mean([x["deviation_of_pitches"] for x in centre])),
            12.0,
        ),
    }
    file = docs / "results/averaging.json"
    write_json(file, document)
    draw(charges, file.with_suffix(".png"))


def draw(charges: Sequence[Charge], file: Path) -> None:
    """Draw the swing of one charge of each S, and the autocorrelation of the longest run."""
    longest = max(charges, key=lambda charge: charge.result.rotation_angle_rad)
    with rc_context(STYLE):
        figure = Figure(figsize=(9.0, 3.4), layout="constrained")
        left, right = figure.subplots(1, 2)
        shown = {(charge.policy, charge.S): charge for charge in reversed(charges)}
        for charge in sorted(shown.values(), key=lambda charge: (charge.policy, charge.S)):
            swing = swing_of(charge)
            angle, values = pitch_means(charge, QUANTITIES["centre_x"](charge), 0.0)
            early = angle < 12.0
            label = f"S = {charge.S:g}, {charge.policy}"
            relative = 100.0 * (values[early] / swing.mean - 1.0)
            left.plot(angle[early], relative, marker=".", lw=0.8, label=label)
        left.set(xlabel="mill angle [rad]", ylabel="centre of mass x,\ndeviation from its mean [%]")
        left.set_ylim(-25.0, 50.0)
        left.legend(fontsize="x-small")
        pitch = lifter_pitch(longest.case.mill.lifters)
        _, means = pitch_means(longest, QUANTITIES["centre_x"](longest), longest.steady_from)
        off = means - means.mean()
        lags = np.arange(min(24, len(off) - 1))
        found = [float(off[: len(off) - k] @ off[k:] / (off @ off)) for k in lags]
        right.plot(pitch * lags, found, "o", ms=3.5, label=f"fluctuations, S = {longest.S:g}")
        fine = np.linspace(0.0, pitch * lags[-1], 200)
        right.plot(fine, swing_of(longest).autocorrelation(fine), label="from the swing")
        right.set(xlabel="mill angle [rad]", ylabel="autocorrelation of the centre of mass x")
        right.legend(fontsize="x-small")
        figure.savefig(file, dpi=110)
