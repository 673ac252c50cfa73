"""Figures of single-ball cases, after Figs. 6, 7 and 8 of the paper."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from millscale.analysis.finished import SingleBall
from millscale.analysis.measures import COMMON_ANGLES
from millscale.analysis.paper import numbers as paper
from millscale.analysis.shapes.cross_section import liner_outline
from millscale.analysis.single_ball.comparison import SingleBallRow, by_policy
from millscale.report.figures.style import STYLE, colour_of_S
from millscale.runs.series import Series

LEGEND_COLUMNS = 3
POLICY_MARKS = {
    "paper": ("o", "#1f6fb4"),
    "corrected": ("s", "#d1711b"),
    "offset-liner": ("^", "#2a8c4a"),
}
_REGION_COLOURS = {"I": "#f3e3e0", "II": "#e4eef6", "III": "#e8f3e4", "IV": "#f6f0dc"}
_REGION_BEGINS = (
    ("II", "settled_rad"),
    ("III", "thrown_rad"),
    ("IV", "impact_rad"),
    ("II", "settled_again_rad"),
)


def trajectories(balls: Sequence[SingleBall], over_radius: bool = False) -> Figure:
    """Return the path of the ball's centre in the cross-section over the first cycle (Fig. 6).

    Circles mark where free flight begins, crosses where the liner is left. The liner of each
    mill is drawn at the mill angle of the throw.

    Args:
        over_radius: divide by each mill's radius, so that similar paths coincide.
    """
    with rc_context(STYLE):
        figure = Figure(figsize=(4.8, 5.0))
        axes = figure.add_subplot()
        for ball in balls:
            unit = ball.case.mill.radius_m if over_radius else 1.0
            _trajectory(axes, ball, colour_of_S(ball.S), unit)
        axes.set_aspect("equal")
        unit_name = "/ R" if over_radius else "[m]"
        axes.set(xlabel=f"x {unit_name}", ylabel=f"z {unit_name}")
        figure.legend(loc="lower center", ncols=LEGEND_COLUMNS)
        _set_margins(figure, bottom=0.5 + _legend_height(balls))
    return figure


def energy_curves(balls: Sequence[SingleBall], over_prediction: bool = False) -> Figure:
    """Return kinetic and potential energy against mill angle over the first cycle (Fig. 7).

    The regions I to IV are those of the first mill: I bounce at the start, II carried up,
    III free flight, IV impact and rebound.

    Args:
        over_prediction: divide by the predicted energy ratio, so that similar curves coincide.
    """
    with rc_context(STYLE):
        figure = Figure(figsize=(5.2, 5.2))
        upper, lower = figure.subplots(2, 1, sharex=True)
        for ball in balls:
            colour = colour_of_S(ball.S)
            series, first = ball.series, first_cycle(ball)
            factor = ball.case.predicted_energy_ratio if over_prediction else 1.0
            angle = series["mill_angle_rad"][first]
            kinetic = series["kinetic_translation_J"][first] / factor
            upper.plot(angle, kinetic, color=colour, label=ball.label)
            lower.plot(angle, series["potential_J"][first] / factor, color=colour)
        _mark_regions((upper, lower), balls[0])
        unit = "/ predicted ratio [J]" if over_prediction else "energy [J]"
        upper.set_ylabel(f"kinetic {unit}")
        lower.set(xlabel="mill rotation angle [rad]", ylabel=f"potential {unit}")
        figure.legend(loc="upper center", ncols=LEGEND_COLUMNS)
        _set_margins(figure, top=0.1 + _legend_height(balls))
    return figure


def _legend_height(balls: Sequence[SingleBall]) -> float:
    """Return the height of a legend of balls [inch]."""
    return 0.15 + 0.19 * -(-len(balls) // LEGEND_COLUMNS)


def _set_margins(figure: Figure, top: float = 0.12, bottom: float = 0.5) -> None:
    """Set margins [inch]. They are known for these figures; to compute them takes longer than to
    draw the figure."""
    width, height = figure.get_size_inches()
    figure.subplots_adjust(
        left=0.75 / width, right=1.0 - 0.12 / width, top=1.0 - top / height, bottom=bottom / height
    )


def energy_ratios(scheme: str, rows: Sequence[SingleBallRow], of_paper: bool = True) -> Figure:
    """Return the energy ratio against its prediction, every policy and the paper (Fig. 8), and the
    deviation.

    Args:
        rows: of `comparison.single_ball_rows`, of one scheme.
        of_paper: whether the mill is the paper's.
    """
    mills = by_policy(list(rows))
    with rc_context(STYLE):
        figure = Figure(figsize=(4.8, 5.4), layout="constrained")
        upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        upper.plot([0, 1], [0, 1], color="#888", lw=1, zorder=1)
        lower.axhline(0.0, color="#888", lw=1, zorder=1)
        order = list(POLICY_MARKS)
        for variant, known in sorted(
            (
                (name, own)
                for (of, name), own in mills.items()
                if of == scheme and own[-1].policy in POLICY_MARKS
            ),
            key=lambda item: order.index(item[1][-1].policy),
        ):
            mark, colour = POLICY_MARKS[known[-1].policy]
            points = [(row.predicted_ratio, row.energies[COMMON_ANGLES].ratio) for row in known]
            first = known[-1].state == rows[0].state
            _ratio_points(
                (upper, lower),
                [point for point in points if point[1]],
                {
                    "marker": mark,
                    "color": colour,
                    "label": f"policy {variant}",
                    "zorder": 3,
                    "fillstyle": "full" if first else "none",
                },
            )
        if of_paper:
            _ratio_points(
                (upper, lower),
                [(row.predicted, row.ratio) for row in paper.reported_energies(scheme)],
                {"marker": "x", "color": "#444", "label": "the paper", "zorder": 2},
            )
        power = {"constant-gravity": " = 1/S", "constant-speed": " = 1/S²"}.get(scheme, "")
        lower.set(xlabel=f"predicted ratio{power}", ylabel="deviation [%]")
        upper.set_ylabel("ratio of energy change to S = 1")
        # Without the paper's points and a case at S = 1 the legend is empty.
        if upper.get_legend_handles_labels()[0]:
            upper.legend()
    return figure


def first_cycle(ball: SingleBall) -> slice:
    """Return the samples from the start of rotation to where the ball is lifted a second time."""
    angle = ball.series["mill_angle_rad"]
    begin = max(0, int(np.searchsorted(angle, 0.0, side="right")) - 1)
    throws = ball.result.throws
    end = angle.size
    if len(throws) > 1:
        settled = ball.result.regions.settled_again_rad
        last = throws[1].mill_angle_rad if settled is None else settled
        end = int(np.searchsorted(angle, last, side="right"))
    return slice(begin, end)


def _trajectory(axes: Axes, ball: SingleBall, colour, unit: float) -> None:
    series, first = ball.series, first_cycle(ball)
    x, z = series["x_m"][first] / unit, series["z_m"][first] / unit
    axes.plot(x, z, color=colour, label=ball.label, zorder=3)
    throws = ball.result.throws
    turned_by = throws[0].mill_angle_rad if throws else 0.0
    outline = liner_outline(ball.case, turned_by) / unit
    axes.plot(*outline.T, color=colour, lw=0.4, zorder=1)
    if throws:
        flight_x, _, flight_z = throws[0].position_m
        axes.plot(flight_x / unit, flight_z / unit, "o", color=colour, ms=4.5, zorder=4)
        row = _row_at(series, throws[0].liner_off_mill_angle_rad)
        if row is not None:
            axes.plot(
                series["x_m"][row] / unit, series["z_m"][row] / unit, "x", color=colour, zorder=4
            )


def _row_at(series: Series, mill_angle: float | None) -> int | None:
    if mill_angle is None:
        return None
    row = int(np.searchsorted(series["mill_angle_rad"], mill_angle))
    return min(row, series["step"].size - 1)


def _mark_regions(all_axes: Sequence[Axes], ball: SingleBall) -> None:
    regions = ball.result.regions
    if not regions:
        return
    end = float(ball.series["mill_angle_rad"][first_cycle(ball)][-1])
    begins = [("I", 0.0)] + [(name, getattr(regions, key)) for name, key in _REGION_BEGINS]
    known = [(name, begin) for name, begin in begins if begin is not None and begin < end]
    ends = [begin for _, begin in known[1:]] + [end]
    for axes in all_axes:
        for (name, begin), stop in zip(known, ends, strict=True):
            band = axes.axvspan(begin, stop, color=_REGION_COLOURS[name], lw=0, zorder=0)
            band.set_gid(name)
    for (name, begin), stop in zip(known, ends, strict=True):
        if stop - begin > 0.02 * end:
            where = (0.5 * (begin + stop), 0.98)
            transform = all_axes[1].get_xaxis_transform()
            all_axes[1].text(*where, name, transform=transform, ha="center", va="top")


def _ratio_points(all_axes: Sequence[Axes], points: list[tuple[float, float]], look: dict) -> None:
    if not points:
        return
    predicted, ratio = np.array(points).T
    upper, lower = all_axes
    upper.plot(predicted, ratio, ls="none", ms=5.5, **look)
    lower.plot(predicted, 100.0 * (ratio / predicted - 1.0), ms=5.5, lw=0.8, alpha=0.9, **look)
