"""Style of every figure: matplotlib settings, logarithmic ticks, the colour of each S."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axis import Axis
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from millscale.analysis.finished import Finished

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


def shade_of_each_S(cases: Iterable[Finished]) -> dict[float, Any]:
    """Return a colour for each S of some cases; the physical mill's is black."""
    known = {case.S: case.is_physical for case in cases}
    scaled = sorted(S for S, is_physical in known.items() if not is_physical)
    shades = colormaps["viridis"](np.linspace(0.85, 0.15, len(scaled)))
    return dict.fromkeys(known, "black") | dict(zip(scaled, map(tuple, shades), strict=True))
