"""Style of every figure: matplotlib settings, logarithmic ticks, the colour of each S."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axis import Axis
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

from millscale.runs.case_folder import is_physical

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
    """Ticks of a logarithmic axis at 1, 2 and 5 of each decade, as plain numbers: the default's
    labels run into each other over a few decades."""
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(StrMethodFormatter("{x:,g}"))
    axis.set_minor_formatter(NullFormatter())


def shades_of_models(models: Iterable[float]) -> dict[float, Any]:
    """A colour for each S; the physical mill's is black."""
    known = set(models)
    scaled = sorted(S for S in known if not is_physical(S))
    shades = colormaps["viridis"](np.linspace(0.85, 0.15, len(scaled)))
    return dict.fromkeys(known, "black") | dict(zip(scaled, map(tuple, shades), strict=True))
