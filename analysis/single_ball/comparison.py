"""Single-ball cases of a campaign against each other and against the law's prediction."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Protocol, TypeVar

import numpy as np

from millscale.analysis.finished import SingleBall
from millscale.analysis.measures import (
    COMMON_ANGLES,
    ENERGY_WINDOWS,
    FROM_THROW,
    PAPER_ANGLES,
    SINGLE_BALL_ANGLES,
    EnergyWindow,
)
from millscale.analysis.paper import numbers as paper
from millscale.analysis.single_ball import energy
from millscale.analysis.single_ball.result import ball_of, flight_of
from millscale.analysis.single_ball.windows import Window, common_windows

STATISTICS = ("_deg", "_mean_deg", "_std_deg")


class OfMill(Protocol):
    """What belongs to one scaled mill."""

    @property
    def scheme(self) -> str: ...
    @property
    def state(self) -> str: ...
    @property
    def variant(self) -> str: ...
    @property
    def S(self) -> float: ...
    @property
    def is_physical(self) -> bool: ...


M = TypeVar("M", bound=OfMill)


@dataclass(frozen=True)
class FirstThrow:
    """The first throw of a case and its energy change.

    Attributes:
        throw_rad: mill angle at which it begins.
        energy_begin_rad, energy_end_rad: mill angles common to all mills of the scheme.
        from_throw_window_rad: rotation counted from the throw.
        off_parabola: largest distance of the samples from the parabola, over the energy change.
        energy_imbalance: kinetic energy gained less potential energy lost in the samples, over the
            energy change.
    """

    throw_rad: float | None = None
    energy_begin_rad: float | None = None
    energy_end_rad: float | None = None
    from_throw_window_rad: float | None = None
    off_parabola: float | None = None
    energy_imbalance: float | None = None


@dataclass(frozen=True)
class EnergyRatio:
    """Energy change of a case in one window [J], over that of the reference, and the deviation of
    the ratio from its prediction."""

    change_J: float | None
    ratio: float | None
    relative_error: float | None


@dataclass(frozen=True)
class SingleBallRow:
    """A single-ball case against the physical mill and against the prediction.

    Attributes:
        reference: id of the case at S = 1; None without one.
        energies: by `measures.EnergyWindow`.
        reported: what the paper printed; None of another mill than the paper's.
    """

    ball: SingleBall
    reference: str | None
    throw: FirstThrow
    energies: dict[EnergyWindow, EnergyRatio]
    reported: paper.ReportedEnergy | None

    @property
    def id(self) -> str:
        return self.ball.id

    @property
    def scheme(self) -> str:
        return self.ball.scheme

    @property
    def policy(self) -> str:
        return self.ball.policy

    @property
    def state(self) -> str:
        return self.ball.state

    @property
    def variant(self) -> str:
        return self.ball.variant

    @property
    def S(self) -> float:
        return self.ball.S

    @property
    def is_physical(self) -> bool:
        return self.ball.is_physical

    @property
    def predicted_ratio(self) -> float:
        """Return the energy ratio that Eq. 15 predicts."""
        return self.ball.case.predicted_energy_ratio

    @property
    def in_flight_at_paper_angles(self) -> bool | None:
        angles = self.ball.result.paper_angles
        return angles and angles.in_flight

    def angle(self, name: str, statistic: str = "_deg") -> float | None:
        """Return one of `measures.SINGLE_BALL_ANGLES` [deg].

        Args:
            statistic: of STATISTICS: of the first throw, mean or standard deviation over all.
        """
        return getattr(self.ball.result, name + statistic)

    def document(self) -> dict[str, Any]:
        """Return the row of results.json; keys and units: docs/reference/files.md."""
        case, result = self.ball.case, self.ball.result
        common = self.energies[COMMON_ANGLES].ratio
        names = (column.name for column in SINGLE_BALL_ANGLES)
        row = {
            **{key: getattr(case, key) for key in ("id", "scheme", "policy", "S")},
            **{
                key: getattr(case.mill, key)
                for key in ("radius_m", "gravity_m_s2", "omega_rad_s", "froude")
            },
            **{f"{name}{x}": self.angle(name, x) for name in names for x in STATISTICS},
            "point_mass_detach_angle_deg": case.mill.detach_angle_deg,
            "cycles": result.cycles,
            "problem": result.problem,
            **asdict(self.throw),
            "paper_angles_in_flight": self.in_flight_at_paper_angles,
            "predicted_ratio": self.predicted_ratio,
            "centre_path_ratio": case.centre_path_energy_ratio,
            "relative_error_to_centre_path": _relative(common, case.centre_path_energy_ratio),
            "wall_time_s": self.ball.timing.wall_time_s,
            "paper_energy_change_J": self.reported and self.reported.change,
            "paper_energy_ratio": self.reported and self.reported.ratio,
            "reference": self.reference,
        }
        for window, found in self.energies.items():
            row[f"{window.prefix}energy_change_J"] = found.change_J
            row[window.ratio_key] = found.ratio
            row[f"{window.prefix}relative_error"] = found.relative_error
        return row


@dataclass(frozen=True)
class Line:
    """A least-squares line and Pearson's correlation; None below three points, where any line
    fits."""

    slope: float | None = None
    intercept: float | None = None
    correlation: float | None = None


@dataclass(frozen=True)
class Fit:
    """Energy ratio against its prediction in one window.

    Attributes:
        worst_relative_error, worst_case: largest deviation from the prediction over S > 1.
    """

    line: Line
    worst_relative_error: float | None
    worst_case: str | None

    @property
    def worst_size(self) -> float | None:
        """Return the magnitude of the worst deviation."""
        return None if self.worst_relative_error is None else abs(self.worst_relative_error)


@dataclass(frozen=True)
class Regression:
    """Ratio against prediction of one scheme and policy; with several states of the liner, of one.

    Attributes:
        mills: number of scaled mills.
        fits: by `measures.EnergyWindow`.
        spread_deg: largest less smallest of each of `measures.SINGLE_BALL_ANGLES`, by name.
        in_flight_at_paper_angles: number of mills whose ball flies at both of the paper's angles.
    """

    scheme: str
    policy: str
    mills: int
    fits: dict[EnergyWindow, Fit]
    spread_deg: dict[str, float | None]
    in_flight_at_paper_angles: int

    def document(self) -> dict[str, Any]:
        """Return the row of results.json."""
        row = {"scheme": self.scheme, "policy": self.policy, "models": self.mills}
        for window, fit in self.fits.items():
            values = asdict(fit.line) | {
                "worst_relative_error": fit.worst_relative_error,
                "worst_case": fit.worst_case,
            }
            row |= {f"{window.prefix}{key}": value for key, value in values.items()}
        row |= {f"{name}_spread_deg": value for name, value in self.spread_deg.items()}
        return row | {"paper_angles_models_in_flight": self.in_flight_at_paper_angles}


def single_ball_rows(balls: Iterable[SingleBall]) -> list[SingleBallRow]:
    """Return a row for each case, by scheme, policy and S.

    Energies are changes on the parabola of the first throw. Ratios are to S = 1 of the same scheme,
    state of the liner and policy, or of another policy: all policies are the same mill there.
    """
    ordered = sorted(balls, key=lambda ball: ball.place)
    windows = common_windows(ordered)
    throws = {ball: _first_throw(ball, windows.get(ball.scheme)) for ball in ordered}
    changes = {ball: _changes(ball, windows.get(ball.scheme)) for ball in ordered}
    physical = [ball for ball in ordered if ball.is_physical]
    return [_row(ball, throws[ball], changes, _reference(ball, physical)) for ball in ordered]


def by_policy(entries: Sequence[M]) -> dict[tuple[str, str], list[M]]:
    """Return the scaled mills of each scheme and variant, a policy with one state of the liner. At
    S = 1 all policies are the same mill: a policy without that mill takes another's.

    Args:
        entries: by scheme, policy and S.
    """
    groups: dict[tuple[str, str], list[M]] = {}
    for entry in entries:
        groups.setdefault((entry.scheme, entry.variant), []).append(entry)
    for (scheme, _), group in groups.items():
        if not any(entry.is_physical for entry in group):
            physical = [x for x in entries if x.scheme == scheme and x.is_physical]
            group[:0] = [x for x in physical if x.state == group[0].state][:1]
    return groups


def regressions(rows: Sequence[SingleBallRow]) -> list[Regression]:
    """Return ratio against prediction for each scheme and policy."""
    return [_regression(*of, group) for of, group in by_policy(rows).items()]


def regression_line(predicted: Sequence[float], ratio: Sequence[float]) -> Line:
    """Return the line through ratios against their predictions."""
    if len(set(predicted)) < 3:
        return Line()
    (xx, xy), (_, yy) = np.cov(predicted, ratio, bias=True)
    slope = xy / xx
    intercept = np.mean(ratio) - slope * np.mean(predicted)
    correlation = float(np.clip(xy / np.sqrt(xx * yy), -1.0, 1.0)) if yy > 0.0 else None
    return Line(float(slope), float(intercept), correlation)


def _row(
    ball: SingleBall,
    throw: FirstThrow,
    changes: dict[SingleBall, dict[EnergyWindow, float | None]],
    reference: SingleBall | None,
) -> SingleBallRow:
    of_paper = paper.is_papers_mill(ball.case)
    energies = {
        window: _ratio(change, reference and changes[reference][window], ball)
        for window, change in changes[ball].items()
    }
    reported = paper.reported_energy(ball.scheme, ball.S) if of_paper else None
    return SingleBallRow(ball, reference and reference.id, throw, energies, reported)


def _reference(ball: SingleBall, physical: Sequence[SingleBall]) -> SingleBall | None:
    """Return which of the balls at S = 1 a ball is compared with."""
    alike = [x for x in physical if (x.scheme, x.state) == (ball.scheme, ball.state)]
    same_policy = [other for other in alike if other.policy == ball.policy]
    return next(iter(same_policy + alike), None)


def _ratio(change: float | None, reference: float | None, ball: SingleBall) -> EnergyRatio:
    ratio = change / reference if change is not None and reference else None
    return EnergyRatio(change, ratio, _relative(ratio, ball.case.predicted_energy_ratio))


def _relative(ratio: float | None, predicted: float) -> float | None:
    return None if ratio is None else ratio / predicted - 1.0


def _changes(ball: SingleBall, window: Window | None) -> dict[EnergyWindow, float | None]:
    """Return the magnitude of the energy change in each window [J]."""
    fixed = ball.result.paper_angles
    changes = dict.fromkeys(ENERGY_WINDOWS) | {PAPER_ANGLES: fixed and abs(fixed.kinetic_J)}
    if not ball.result.throws:
        return changes
    begin = ball.result.throws[0].mill_angle_rad
    if window.end > window.begin:
        changes[COMMON_ANGLES] = _change(ball, window.begin, window.end)
    return changes | {FROM_THROW: _change(ball, begin, begin + window.from_throw)}


def _change(ball: SingleBall, begin: float, end: float) -> float:
    flight = flight_of(ball.result.throws[0])
    return abs(energy.change_on_parabola(flight, ball_of(ball.case), begin, end))


def _first_throw(ball: SingleBall, window: Window | None) -> FirstThrow:
    if not ball.result.throws:
        return FirstThrow()
    begin, sampled = ball.result.throws[0].mill_angle_rad, ball.result.throw_energy
    own = _change(ball, begin, begin + window.from_throw)
    off = max(sampled.off_parabola_kinetic_J, sampled.off_parabola_potential_J)
    imbalance = abs(sampled.kinetic_sampled_J + sampled.potential_sampled_J)
    return FirstThrow(
        begin,
        window.begin,
        window.end,
        window.from_throw,
        off / own if own else None,
        imbalance / own if own else None,
    )


def _regression(scheme: str, policy: str, rows: Sequence[SingleBallRow]) -> Regression:
    return Regression(
        scheme=scheme,
        policy=policy,
        mills=len(rows),
        fits={window: _fit(window, rows) for window in ENERGY_WINDOWS},
        spread_deg={column.name: _spread(rows, column.name) for column in SINGLE_BALL_ANGLES},
        in_flight_at_paper_angles=sum(bool(row.in_flight_at_paper_angles) for row in rows),
    )


def _fit(window: EnergyWindow, rows: Sequence[SingleBallRow]) -> Fit:
    compared = [row for row in rows if row.energies[window].ratio is not None]
    scaled = [row for row in compared if not row.is_physical]
    worst = max(scaled, key=lambda row: abs(row.energies[window].relative_error), default=None)
    line = regression_line(
        [row.predicted_ratio for row in compared], [row.energies[window].ratio for row in compared]
    )
    return Fit(line, worst and worst.energies[window].relative_error, worst and worst.id)


def _spread(rows: Sequence[SingleBallRow], name: str) -> float | None:
    values = [row.angle(name) for row in rows if row.angle(name) is not None]
    return max(values) - min(values) if len(values) > 1 else None
