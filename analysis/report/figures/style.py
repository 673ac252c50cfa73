"""Style of every figure: matplotlib settings, logarithmic ticks, the colour of each S."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from matplotlib import colormaps
from matplotlib.axis import Axis
from matplotlib.colors import to_hex
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from millscale.analysis.finished import Finished

LARGEST_S = 6.5
LIGHTEST = 0.62  # of the scale: lighter colours are hard to see on white
STYLE = {
    "font.size": 9.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#888",
    "axes.labelcolor": "#222",
    "axes.grid": True,
    "grid.color": "#e6e6e6",
    "grid.linewidth": 0.7,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "lines.linewidth": 1.3,
    "xtick.color": "#555",
    "ytick.color": "#555",
}


def plain_log_ticks(axis: Axis) -> None:
    """Set the ticks of a logarithmic axis at 1, 2 and 5 of each decade, as plain numbers: the
    labels of the default overlap over a few decades."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(StrMethodFormatter("{x:,g}"))
    axis.set_minor_formatter(NullFormatter())


# Lines of the second and later states of the liner; those of the first are as without states.
_STATES = ((0, (6, 2)), (0, (6, 2, 1, 2)), (0, (3, 2)), (0, (3, 1, 1, 1, 1, 1)))


def dashes_of_states(cases: Iterable[Finished]) -> dict[str, Any]:
    """Return the line style of each state of the liner but the first of some cases."""
    states = list(dict.fromkeys(case.state for case in cases))[1:]
    return {state: _STATES[i % len(_STATES)] for i, state in enumerate(states)}


def colour_of_S(S: float) -> str:
    """Return the colour of scaled mills of an S in every figure: black for the physical mill, then
    from blue to orange. Each has a contrast of 3 or more on white."""
    if S <= 1.0:
        return "#000000"
    # 1 - 1/S is bounded and differs most at small S; nothing is simulated beyond LARGEST_S.
    place = min(1.0, (1.0 - 1.0 / S) / (1.0 - 1.0 / LARGEST_S))
    return to_hex(colormaps["plasma"](LIGHTEST * place))


def shade_of_each_S(cases: Iterable[Finished]) -> dict[float, Any]:
    """Return the colour of each S of some cases."""
    return {case.S: colour_of_S(1.0 if case.is_physical else case.S) for case in cases}
