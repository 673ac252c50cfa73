"""The energy budget in a figure: dissipation by cause, impacts by energy."""

from __future__ import annotations

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from millscale.analysis.result_file import PAIRINGS, EnergyBudget
from millscale.report.figures.style import STYLE

SHOWN = 1e-6
COLOURS = dict(zip(PAIRINGS, ("#0072b2", "#d55e00"), strict=True))
_NAMES = dict(zip(PAIRINGS, ("ball on ball", "ball on wall"), strict=True))
# Key of a pairing, and what a reader calls it.
_CAUSES = {
    "dissipated_normal_J": "normal dashpot",
    "tangential_slip_J": "slip",
    "tangential_dashpot_J": "tangential dashpot",
    "tangential_spring_J": "tangential spring",
    "dissipated_rolling_J": "rolling friction",
}


def energy_budget_figure(budget: EnergyBudget) -> Figure:
    """Return dissipation by cause over the mill's work, and the energy of the impacts of a
    revolution by the energy of one impact."""
    with rc_context(STYLE):
        figure = Figure(figsize=(9.0, 3.6), layout="constrained")
        left, right = figure.subplots(1, 2)
        _causes(left, budget)
        _spectrum(right, budget)
    return figure


def _causes(axes: Axes, budget: EnergyBudget) -> None:
    """Draw stacked bars; the tangential spring may give energy, which is drawn below 0."""
    places = np.arange(len(_CAUSES))
    axes.set_axisbelow(True)
    ends = {sign: np.zeros(len(places)) for sign in (-1, 1)}
    for pairing in PAIRINGS:
        terms = budget.pairings[pairing]
        values = 100.0 / budget.mill_work_J * np.array([getattr(terms, key) for key in _CAUSES])
        begin = np.where(values < 0.0, ends[-1], ends[1])
        axes.barh(places, values, left=begin, color=COLOURS[pairing], label=_NAMES[pairing])
        ends[1] += np.maximum(values, 0.0)
        ends[-1] += np.minimum(values, 0.0)
    axes.set_yticks(places, list(_CAUSES.values()))
    axes.invert_yaxis()
    axes.axvline(0.0, color="#888", lw=0.8)
    axes.set_xlabel("dissipated over the work of the mill [%]")
    turned = budget.to_rad - budget.from_rad
    axes.set_title(f"{turned:.2f} rad, residual {100.0 * abs(budget.closure):.2g} %")
    axes.legend()


def _spectrum(axes: Axes, budget: EnergyBudget) -> None:
    """Draw the energy of the impacts in logarithmic bins, down to SHOWN of the largest."""
    shown = []
    for pairing in PAIRINGS:
        bins = budget.impacts[pairing]
        if not bins.energy_J:
            continue
        middle = np.sqrt(np.multiply(bins.energy_low_J, bins.energy_high_J))
        shown += list(zip(bins.energy_J, middle, strict=True))
        label = f"{_NAMES[pairing]}, {sum(bins.impacts):,.0f} impacts"
        axes.plot(middle, bins.energy_J, drawstyle="steps-mid", color=COLOURS[pairing],
                  label=label)  # fmt: skip
    axes.set(xscale="log", yscale="log")
    axes.set_xlabel("energy of an impact [J]")
    axes.set_ylabel("energy of the impacts of a bin\nin a revolution [J]")
    if not shown:
        axes.text(0.5, 0.5, "no impacts", transform=axes.transAxes, ha="center")
        return
    largest = max(shown)[0]
    axes.set_ylim(SHOWN * largest, 3.0 * largest)
    axes.set_xlim(left=0.5 * min(middle for energy, middle in shown if energy >= SHOWN * largest))
    axes.legend(loc="upper left")
