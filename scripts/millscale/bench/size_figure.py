"""Cost of a step against the number of balls."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

NAMES = {"fast": "millscale", "mixed": "millscale, mixed precision", "stock": "stock LIGGGHTS"}
COLOURS = {"fast": "C0", "mixed": "C2", "stock": "k"}


def draw_sizes(rows: Sequence[dict[str, Any]], file: Path) -> Figure:
    """Draw medians with their range over the rounds, a line for each engine and number of ranks.

    Args:
        rows: of `millscale bench --scene size`.
        file: picture to write.
    """
    figure = Figure(figsize=(6.5, 4.5), layout="constrained")
    axes = figure.subplots()
    for pair, name in NAMES.items():
        for ranks, style in ((1, "-"), (2, "--")):
            line = [row for row in rows if row["pair"] == pair and row["ranks"] == ranks]
            if not line:
                continue
            each = [row["ns_per_particle_step_core"] for row in line]
            down = [ns["median"] - ns["min"] for ns in each]
            up = [ns["max"] - ns["median"] for ns in each]
            axes.errorbar(
                [row["balls"] for row in line],
                [ns["median"] for ns in each],
                [down, up],
                color=COLOURS[pair],
                linestyle=style,
                marker="o",
                markersize=3,
                capsize=2,
                label=f"{name}, {ranks} rank{'s' if ranks > 1 else ''}",
            )
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("balls")
    axes.set_ylabel("time per ball, step and core [ns]")
    axes.grid(True, which="both", alpha=0.3)
    figure.legend(loc="outside upper center", ncols=3, fontsize=8)
    figure.savefig(file, dpi=150)
    return figure
