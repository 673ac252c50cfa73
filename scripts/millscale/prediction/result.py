"""A prediction: the physical mill, its observables with their intervals, and their checks."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from millscale.analysis.charge.physical_mill import PhysicalMill
from millscale.analysis.finished import Charge
from millscale.errors import nearest
from millscale.formats import NONE, number
from millscale.prediction.contour import PredictedContour
from millscale.prediction.extrapolation import (
    Extrapolation,
    Group,
    Noise,
    by_ratio,
    exact_exponent,
)
from millscale.prediction.field import PredictedField
from millscale.prediction.impacts import PredictedSpectrum
from millscale.prediction.mass_flow import PredictedCurve
from millscale.prediction.noise import PITCHES
from millscale.prediction.observables import Observable
from millscale.prediction.text import aligned, html_table

SCHEMA = 1


@dataclass(frozen=True)
class ScaledValue:
    """An observable as measured in the scaled mills of one S, in the physical mill's unit."""

    S: float
    mean: float
    runs: int


@dataclass(frozen=True)
class PredictedNumber:
    """An observable of the physical mill.

    Attributes:
        observable: what it is.
        scale: the physical mill's unit over the dimensionless number.
        found: dimensionless; None if it is not extrapolated.
        noise: of one run, dimensionless; None if it is not extrapolated.
        noise_from: "seeds", or "lifter pitches" of single runs.
        measured: in the scaled mills, by S.
        refused: why it is not extrapolated; empty if it is.
        check: what a physical mill that was left out has; None if none was.
        reverses: it rises and falls with S by more than its noise.
    """

    observable: Observable
    scale: float
    found: Extrapolation | None
    noise: Noise | None
    noise_from: str
    measured: tuple[ScaledValue, ...]
    refused: str
    check: float | None = None
    reverses: bool = False

    @property
    def value(self) -> float | None:
        return self.scale * self.found.value if self.found else None

    @property
    def interval(self) -> tuple[float, float] | None:
        """Return the lower and the upper end."""
        if self.found is None:
            return None
        ends = sorted((self.scale * self.found.lower, self.scale * self.found.upper))
        return ends[0], ends[1]

    @property
    def half_width(self) -> float | None:
        """Return half of the interval, in the unit."""
        return None if self.interval is None else 0.5 * (self.interval[1] - self.interval[0])

    @property
    def digits(self) -> int:
        """Return the decimals to show: two figures of the half width, or four of the values."""
        figures, sizes = 2, [self.half_width or 0.0]
        if not sizes[0] > 0.0:
            figures, sizes = 4, [abs(value.mean) for value in self.measured]
        largest = max(sizes, default=0.0)
        return max(0, figures - 1 - math.floor(math.log10(largest))) if largest > 0.0 else 0

    @property
    def cells(self) -> tuple[str, str, str, str]:
        """Return unit, value, interval and half width as text; dashes if it is not predicted."""
        unit, digits = self.observable.unit, self.digits
        if self.interval is None:
            return unit, NONE, NONE, NONE
        lower, upper = (number(end, digits) for end in self.interval)
        return (
            unit,
            number(self.value, digits),
            f"{lower} to {upper}",
            number(self.half_width, digits),
        )

    @property
    def exact_exponent(self) -> float | None:
        """Return the exponent that gives the mill that was left out; None if there is none."""
        if self.check is None or self.found is None:
            return None
        groups = [Group(x.S, (x.mean,) * x.runs) for x in self.measured]
        return exact_exponent(groups, self.check)

    @property
    def is_inside(self) -> bool | None:
        """Return whether the interval holds the measured value of the mill that was left out."""
        if self.check is None or self.interval is None:
            return None
        return self.interval[0] <= self.check <= self.interval[1]

    def document(self) -> dict[str, Any]:
        """Return it as JSON types."""
        interval = self.interval
        return {
            "name": self.observable.name,
            "unit": self.observable.unit,
            "value": self.value,
            "lower": interval[0] if interval else None,
            "upper": interval[1] if interval else None,
            "refused": self.refused,
            "kind": self.observable.kind.value,
            "prior_of_exponent": asdict(self.observable.kind.prior),
            "restates": self.observable.restates,
            "reverses": self.reverses,
            "noise_from": self.noise_from,
            "scale": self.scale,
            "dimensionless": asdict(self.found) if self.found else None,
            "measured": [asdict(value) for value in self.measured],
            "left_out_physical_mill": self.check,
            "is_inside": self.is_inside,
            "exact_exponent": self.exact_exponent,
        }


@dataclass(frozen=True, repr=False)
class Prediction:
    """The physical mill and what is predicted of it.

    A prompt shows it as text, a notebook as a table. `prediction["power"]` is an observable.

    Attributes:
        contour: the free surface; None if it is not extrapolated, which `contour_refused` explains.
        mass_flow: mass in the monitoring box over a lifter pitch; None as the contour.
        field: mean solid fraction of the cross-section, without an interval; None as the contour.
        spectra: impacts by energy, of each pairing; empty if they are not extrapolated.
        runs: charges used, by S, then seed.
        excluded: charges that were not used, and why, by id.
        warnings: what may mislead.
    """

    mill: PhysicalMill
    scheme: str
    policy: str
    numbers: tuple[PredictedNumber, ...]
    contour: PredictedContour | None
    contour_refused: str
    runs: tuple[Charge, ...]
    excluded: Mapping[str, str]
    warnings: tuple[str, ...]
    level: float = 0.95
    mass_flow: PredictedCurve | None = None
    mass_flow_refused: str = ""
    field: PredictedField | None = None
    field_refused: str = ""
    spectra: tuple[PredictedSpectrum, ...] = ()
    spectra_refused: str = ""

    def __getitem__(self, name: str) -> PredictedNumber:
        """Return an observable by its name, such as "power".

        Raises:
            KeyError: states the names.
        """
        found = {row.observable.name: row for row in self.numbers}
        if name not in found:
            near = nearest(name, found)
            hint = f", nearest is {near}" if near else ""
            raise KeyError(f"{name}{hint}; accepted: {', '.join(found)}")
        return found[name]

    @property
    def title(self) -> str:
        """Return size and filling of the physical mill in one line."""
        mill = self.mill
        return (
            f"Physical mill: radius {mill.radius:g} m, length {mill.length:g} m, "
            f"{mill.balls:,.0f} balls, {1e-3 * mill.mass:.3g} t"
        )

    def __repr__(self) -> str:
        return self.summary()

    def summary(self) -> str:
        """Return values, intervals and notes as text."""
        heading = ("", "predicted", f"{100.0 * self.level:g} % interval", "")
        return "\n".join([self.title, *aligned([heading, *self._rows()]), *self.notes()])

    def _repr_html_(self) -> str:
        """Return values, intervals and notes as the HTML that notebooks show."""
        headings = ("observable", "predicted", f"{100.0 * self.level:g} % interval", "unit")
        return html_table(self.title, headings, self._rows(), list(self.notes()))

    def _rows(self) -> list[tuple[str, str, str, str]]:
        """Return label, value, interval and unit of each observable that is predicted."""
        found = []
        for row in self.numbers:
            unit, value, interval, _ = row.cells
            if row.value is not None:
                found.append((row.observable.label, value, interval, unit))
        return found

    def notes(self) -> Iterator[str]:
        """Yield what belongs to the numbers: curves, refusals, runs, warnings."""
        for row in self.numbers:
            if row.refused:
                yield f"not predicted: {row.observable.label}: {row.refused}"
        yield from self._contour_notes()
        yield from self._mass_flow_notes()
        yield from self._field_notes()
        if not self.spectra:
            yield f"not predicted: impacts: {self.spectra_refused}"
        counts = by_ratio((charge.S, charge) for charge in self.runs)
        used = ", ".join(f"S = {S:.4g}: {len(found)}" for S, found in counts)
        yield f"runs by {self.scheme}, {self.policy}: {used}; all steady"
        if any(row.noise_from == PITCHES for row in self.numbers):
            yield "noise from the scatter of lifter pitches: too few seeds to measure it"
        for name, why in self.excluded.items():
            yield f"not used: {name}: {why}"
        for warning in self.warnings:
            yield f"warning: {warning}"

    def _contour_notes(self) -> Iterator[str]:
        contour = self.contour
        if contour is None:
            yield f"not predicted: surface contour: {self.contour_refused}"
            return
        yield (
            f"surface contour: {len(contour.points)} points, half width of the interval "
            f"{100.0 * contour.half_widths.mean():.2f} % of R - a in the mean"
        )
        if contour.check and contour.nearest:
            ours, theirs = (100.0 * pair[0] for pair in (contour.check, contour.nearest))
            yield (
                f"  distance from the contour of S = 1, left out: {ours:.2f} % of R - a; that of "
                f"the smallest scaled S: {theirs:.2f} %"
            )

    def _mass_flow_notes(self) -> Iterator[str]:
        curve = self.mass_flow
        if curve is None:
            yield f"not predicted: mass in the monitoring box: {self.mass_flow_refused}"
            return
        masses, mean = self.mill.mass * curve.values, float(curve.values.mean())
        yield (
            f"mass in the monitoring box over a lifter pitch: {len(masses)} phases, "
            f"{masses.min():.4g} to {masses.max():.4g} kg, half width of the interval "
            f"{100.0 * curve.half_widths.mean() / mean:.1f} % of its mean"
        )
        if curve.check and curve.nearest and curve.inside is not None:
            yield (
                f"  RMS difference from S = 1, left out: {100.0 * curve.check:.1f} % of "
                f"its mean, {100.0 * curve.inside:.0f} % of the phases inside; that of the "
                f"smallest scaled S: {100.0 * curve.nearest:.1f} %"
            )

    def _field_notes(self) -> Iterator[str]:
        field = self.field
        if field is None:
            yield f"not predicted: map of the solid fraction: {self.field_refused}"
            return
        yield "map of the solid fraction, without an interval: --field FILE writes it"
        if field.check is not None and field.nearest is not None:
            yield (
                f"  balls that S = 1, left out, has elsewhere: {100.0 * field.check:.1f} %; than "
                f"the smallest scaled S: {100.0 * field.nearest:.1f} %"
            )

    def document(self) -> dict[str, Any]:
        """Return it as JSON types."""
        return {
            "schema": SCHEMA,
            "physical_mill": asdict(self.mill),
            "scheme": self.scheme,
            "policy": self.policy,
            "numbers": [number.document() for number in self.numbers],
            "contour": self.contour
            and self.contour.document(self.mill.radius - self.mill.ball_radius),
            "contour_refused": self.contour_refused,
            "mass_in_box": self.mass_flow and self.mass_flow.document(self.mill.mass),
            "mass_in_box_refused": self.mass_flow_refused,
            "solid_fraction_field": self.field and self.field.document(),
            "solid_fraction_field_refused": self.field_refused,
            "impacts": [spectrum.document() for spectrum in self.spectra],
            "impacts_refused": self.spectra_refused,
            "runs": [
                {"campaign": x.campaign, "id": x.id, "S": x.S, "seed": x.seed} for x in self.runs
            ],
            "excluded": dict(self.excluded),
            "warnings": list(self.warnings),
        }
