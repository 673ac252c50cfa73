"""Spectra of the energy that contacts dissipate, of one charge and of several values of S."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from millscale.analysis.charge.impacts import NAMES, summed_bins
from millscale.analysis.finished import Charge
from millscale.analysis.result_file import PAIRINGS, ContactClass, ImpactsResult
from millscale.report.figures.style import STYLE, colour_of_S

# Down to this share of the largest bin.
SHOWN = 1e-5
_LINES = dict(zip(("dissipated", "available"), ("-", ":"), strict=True))


def impacts_figure(result: ImpactsResult, tonnes: float) -> Figure:
    """Return the power of the contacts of a charge by their energy, of each pair of classes.

    Args:
        tonnes: mass of the balls [t].
    """
    with rc_context(STYLE):
        figure = Figure(figsize=(9.0, 3.8), layout="constrained")
        for axes, pairing in zip(figure.subplots(1, 2, sharex=True), PAIRINGS, strict=True):
            _spectra(axes, result, pairing, tonnes)
    return figure


def _spectra(axes: Axes, result: ImpactsResult, pairing: str, tonnes: float) -> None:
    classes = [one for one in result.classes if one.pairing == pairing]
    largest = 0.0
    for k, one in enumerate(classes):
        for quantity, line in _LINES.items():
            bins = getattr(one, quantity)
            if not bins.power_W:
                continue
            middle = np.sqrt(np.multiply(bins.energy_low_J, bins.energy_high_J))
            # Per decade: eight bins.
            width = np.log10(np.divide(bins.energy_high_J, bins.energy_low_J))
            power = np.array(bins.power_W) / width / tonnes
            largest = max(largest, float(power.max()))
            name = quantity if len(classes) == 1 else f"{_class_name(one)}, {quantity}"
            axes.plot(middle, power, line, drawstyle="steps-mid", color=f"C{k}", label=name)
    axes.set_title(NAMES[pairing])
    axes.set(xscale="log", yscale="log")
    axes.set_xlabel("energy of a contact [J]")
    axes.set_ylabel("power per decade and tonne of balls [W/t]")
    unit = result.energy_unit_J
    scaled = axes.secondary_xaxis(
        1.0, functions=(lambda x: np.divide(x, unit), lambda x: np.multiply(x, unit))
    )
    scaled.set_xlabel(r"over $m\,(\omega R)^2$")
    if largest > 0.0:
        axes.set_ylim(SHOWN * largest, 3.0 * largest)
        axes.legend()
    else:
        axes.text(0.5, 0.5, "no contacts", transform=axes.transAxes, ha="center")


def _class_name(one: ContactClass) -> str:
    if one.other_class is None:
        return f"class {one.ball_class}"
    return f"classes {one.ball_class} and {one.other_class}"


def collapse_figure(charges: Sequence[Charge]) -> Figure:
    """Return the dissipated energy of charges by the energy of a contact, over m (omega R)^2, per
    ball and revolution."""
    kept = [charge for charge in charges if charge.result.impacts is not None]
    shown: list[float] = []
    with rc_context(STYLE):
        figure = Figure(figsize=(9.0, 3.8), layout="constrained")
        for axes, pairing in zip(figure.subplots(1, 2, sharex=True), PAIRINGS, strict=True):
            largest, named, curves = 0.0, set(), []
            for charge in kept:
                result = charge.result.impacts
                assert result is not None
                bins = summed_bins(result, pairing)
                if not bins.power_W:
                    continue
                unit = result.energy_unit_J
                middle = np.sqrt(np.multiply(bins.energy_low_J, bins.energy_high_J)) / unit
                width = np.log10(np.divide(bins.energy_high_J, bins.energy_low_J))
                revolution = 2.0 * np.pi / charge.case.mill.omega_rad_s
                energy = np.array(bins.power_W) * revolution / (charge.balls * unit) / width
                largest = max(largest, float(energy.max()))
                curves.append((middle, energy))
                label = "" if charge.S in named else f"S = {charge.S:.4g}"
                named.add(charge.S)
                axes.plot(middle, energy, drawstyle="steps-mid",
                          color=colour_of_S(charge.S), label=label)  # fmt: skip
            axes.set_title(NAMES[pairing])
            axes.set(xscale="log", yscale="log")
            axes.set_xlabel(r"dissipated by a contact over $m\,(\omega R)^2$")
            axes.set_ylabel(r"sum over $m\,(\omega R)^2$, per decade, ball and revolution")
            if largest > 0.0:
                axes.set_ylim(SHOWN * largest, 3.0 * largest)
                axes.legend()
            for middle, energy in curves:
                shown += middle[energy > SHOWN * largest].tolist()
        if shown:
            axes.set_xlim(0.5 * min(shown), 2.0 * max(shown))
    return figure
