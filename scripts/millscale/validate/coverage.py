"""Predictions from scaled mills against S = 1, left out: `millscale validate prediction`.

Each mill is predicted from each pair of its scaled mills, from all of them, and, where the nearer
mill of a pair has several seeds, from each of these alone with all seeds of the farther one. How
many intervals hold the value of S = 1 is the coverage.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from statistics import median
from typing import Any

from scipy.special import betaincinv

from millscale.analysis.finished import Charge
from millscale.engine.record import provenance
from millscale.prediction.noise import pitch_error
from millscale.prediction.predict import Prediction, predict_charges
from millscale.runs.writing import write_json
from millscale.validate.coverage_figures import draw_coverage, draw_speed
from millscale.validate.coverage_tables import markdown, runs_text
from millscale.validate.differences import CHANCES, Comparison, comparisons, deviations
from millscale.validate.gain import Single, cost_at_equal_error
from millscale.validate.mills import COUNTED, Mill, load_mills, mean_time, processor_time

COMMAND = "millscale validate prediction DIR... --to FILE"
LEVEL = 0.95  # probability of the intervals
# Costs over that of the whole mill, by balls, up to which the coverage is counted by itself.
BUDGETS = (0.1, 0.05)
ALL, ONE_NEAR = "all seeds", "one seed of the nearest"
BySeeds = Mapping[float, tuple[Charge, ...]]


@dataclass(frozen=True)
class Interval:
    """A predicted interval and the value of S = 1 that was left out.

    Attributes:
        refused: why there is no interval; empty if there is one.
        value, lower, upper, truth: in `unit`.
        truth_error: standard error of `truth` from its lifter pitches; None if not known.
        single_cost_s: processor time of the cheapest single scaled mill of equal error [s].
    """

    observable: str
    label: str
    unit: str
    refused: str
    truth: float
    truth_error: float | None
    value: float | None = None
    lower: float | None = None
    upper: float | None = None
    single_cost_s: float | None = None

    @property
    def is_inside(self) -> bool | None:
        if self.lower is None or self.upper is None:
            return None
        return self.lower <= self.truth <= self.upper

    @property
    def error(self) -> float | None:
        """Return the value less that of S = 1."""
        return None if self.value is None else self.value - self.truth

    @property
    def half_width(self) -> float | None:
        if self.lower is None or self.upper is None:
            return None
        return 0.5 * (self.upper - self.lower)

    def document(self) -> dict[str, Any]:
        """Return it as JSON types."""
        derived = {key: getattr(self, key) for key in ("is_inside", "error", "half_width")}
        return asdict(self) | derived


@dataclass(frozen=True)
class Curve:
    """A predicted curve against that of S = 1.

    Attributes:
        error: of the contour the mean distance along the normals, in % of R - a; of the mass in the
            box the RMS difference, in % of its mean.
        half_width: of the interval, mean over the points, in the same unit.
        share_inside: of the points.
        single_cost_s: as in `Interval`.
    """

    error: float
    half_width: float
    share_inside: float | None
    single_cost_s: float


@dataclass(frozen=True)
class Trial:
    """One prediction of one mill.

    Attributes:
        runs: (S, seeds) of the scaled mills.
        seeds: ALL or ONE_NEAR.
        cost_s: processor time of all runs [s].
    """

    mill: str
    scheme: str
    policy: str
    runs: tuple[tuple[float, int], ...]
    seeds: str
    cost_s: float
    intervals: tuple[Interval, ...]
    contour: Curve | None
    mass_in_box: Curve | None

    def document(self) -> dict[str, Any]:
        """Return it as JSON types."""
        return asdict(self) | {"intervals": [row.document() for row in self.intervals]}


def try_predictions(folders: Sequence[Path], every: bool) -> dict[str, Any]:
    """Return the predictions of all mills of runs folders, as JSON types.

    Raises:
        PredictionError: no mill has both S = 1 and a scaled mill.
    """
    mills, excluded = load_mills(folders, every)
    trials = [trial for mill in mills for trial in trials_of(mill)]
    return {
        "schema": 1,
        **provenance(),
        "command": COMMAND + (" --all" if every else ""),
        "level": LEVEL,
        "mills": [_mill_document(mill) for mill in mills],
        "trials": [trial.document() for trial in trials],
        "coverage": [
            asdict(row)
            for row in coverage(
                trials,
                {x.name: mean_time(x.physical) for x in mills},
                {x.name: mean_time(x.physical) / x.length_share for x in mills},
            )
        ],
        "excluded": excluded,
    }


def _mill_document(mill: Mill) -> dict[str, Any]:
    """Return cost and errors of S = 1 and of the single scaled mills."""
    compared = [x for x in comparisons(mill) if x.name in ("power", "contour_mean")]
    singles = []
    for scaling, by_S in mill.scaled.items():
        noise = {x.name: deviations(x, mill, scaling.scheme) for x in compared}
        for S, seeds in by_S.items():
            errors = {
                x.name: {"error": abs(x.size(mean)), "deviation": noise[x.name].at(S)}
                for x in compared
                if (mean := x.mean(seeds)) is not None
            }
            singles.append(
                {**scaling._asdict(), "S": S, "seeds": len(seeds), "cost_s": mean_time(seeds)}
                | {"errors": errors}
            )
    return {
        "name": mill.name,
        "description": mill.description,
        "cost_s": mean_time(mill.physical),
        "settling_s": median(x.settled.processor_time_s or 0.0 for x in mill.physical),
        "steady_from_rad": median(x.result.mean_from_rad for x in mill.physical),
        "rotation_rad": median(x.result.rotation_angle_rad for x in mill.physical),
        "length_share": mill.length_share,
        "deviations": {
            x.name: deviations(x, mill, next(iter(mill.scaled)).scheme).at(1.0) for x in compared
        },
        "singles": singles,
    }


def trials_of(mill: Mill) -> Iterator[Trial]:
    """Yield the predictions of a mill."""
    compared = {x.name: x for x in comparisons(mill)}
    for scaling, by_S in mill.scaled.items():
        for ratios, seeds, used in _designs(by_S):
            prediction = predict_charges(used, mill.physical, mill.values, LEVEL)
            yield Trial(
                mill.name,
                *scaling,
                runs=tuple((S, sum(x in by_S[S] for x in used)) for S in ratios),
                seeds=seeds,
                cost_s=sum(map(processor_time, used)),
                intervals=tuple(_intervals(prediction, mill, compared)),
                contour=_contour(prediction, mill, compared),
                mass_in_box=_mass_in_box(prediction, mill, compared),
            )


def _designs(by_S: BySeeds) -> Iterator[tuple[tuple[float, ...], str, list[Charge]]]:
    """Yield the values of S, which seeds, and the charges of each prediction."""
    for near, far in itertools.combinations(by_S, 2):
        several = len(by_S[near]) > 1
        yield (near, far), ALL if several else ONE_NEAR, [*by_S[near], *by_S[far]]
        if several:
            for charge in by_S[near]:
                yield (near, far), ONE_NEAR, [charge, *by_S[far]]
    if len(by_S) > 2:
        yield tuple(by_S), ALL, [charge for seeds in by_S.values() for charge in seeds]


def _intervals(
    prediction: Prediction, mill: Mill, compared: Mapping[str, Comparison]
) -> Iterator[Interval]:
    names = {row.name for row in COUNTED}
    for found in prediction.numbers:
        row = found.observable
        if row.name not in names or found.check is None:
            continue
        errors = [pitch_error(charge, row.name) for charge in mill.physical]
        known = [error for error in errors if error is not None]
        interval = Interval(
            observable=row.name,
            label=row.label,
            unit=row.unit,
            refused=found.refused,
            truth=found.check,
            truth_error=abs(found.scale) * math.hypot(*known) / len(known) if known else None,
        )
        if found.value is not None and found.interval is not None:
            lower, upper = found.interval
            cost = _single_cost(compared[row.name], prediction, mill)
            interval = replace(
                interval, value=found.value, lower=lower, upper=upper, single_cost_s=cost
            )
        yield interval


def _contour(
    prediction: Prediction, mill: Mill, compared: Mapping[str, Comparison]
) -> Curve | None:
    found, one = prediction.contour, compared.get("contour_mean")
    if found is None or one is None:
        return None
    return _curve(one, prediction, mill, 100.0 * float(found.half_widths.mean()), found.inside)


def _mass_in_box(
    prediction: Prediction, mill: Mill, compared: Mapping[str, Comparison]
) -> Curve | None:
    found, one = prediction.mass_flow, compared.get("mass_in_box")
    if found is None or one is None:
        return None
    width = 100.0 * float(found.half_widths.mean() / found.values.mean())
    return _curve(one, prediction, mill, width, found.inside)


def _curve(
    one: Comparison, prediction: Prediction, mill: Mill, half_width: float, inside: float | None
) -> Curve | None:
    difference = one.of_prediction(prediction)
    if difference is None:
        return None
    return Curve(one.size(difference), half_width, inside, _single_cost(one, prediction, mill))


def _single_cost(one: Comparison, prediction: Prediction, mill: Mill) -> float:
    """Return the cost of the cheapest single mill, of any policy, as accurate as a prediction."""
    difference = one.of_prediction(prediction)
    assert difference is not None
    physical = Single(1.0, mean_time(mill.physical), 0.0)
    costs = []
    for scaling, by_S in mill.scaled.items():
        if scaling.scheme == prediction.scheme:
            singles = [
                Single(S, mean_time(seeds), abs(one.size(mean)))
                for S, seeds in by_S.items()
                if (mean := one.mean(seeds)) is not None
            ]
            costs.append(cost_at_equal_error([physical, *singles], abs(one.size(difference))))
    return min(costs)


@dataclass(frozen=True)
class Coverage:
    """How many intervals hold the value of S = 1, of trials that share something.

    Attributes:
        inside, intervals, refused: numbers of intervals.
        lower, upper: 95 % binomial interval of the share inside (Clopper and Pearson).
        within_chance: intervals that miss by less than two standard errors of S = 1.
        half_width_over_error: median.
        gain: median over intervals of the cost of the single mill over that of the prediction.
        cost_share: median cost of a prediction over that of a run of S = 1.
    """

    of: str
    inside: int
    intervals: int
    refused: int
    lower: float
    upper: float
    within_chance: int
    half_width_over_error: float | None
    gain: float | None
    cost_share: float


def coverage(
    trials: Sequence[Trial], costs: Mapping[str, float], whole_costs: Mapping[str, float]
) -> list[Coverage]:
    """Return the coverage by scaling, and there by cost, runs, mill and observable.

    Args:
        costs: of a run of S = 1, by mill [s].
        whole_costs: the same of the mill's whole length.
    """
    found = []
    for scaling in sorted({(x.scheme, x.policy) for x in trials}):
        some = [x for x in trials if (x.scheme, x.policy) == scaling]
        name = ", ".join(scaling)
        found.append(_coverage(name, _pairs(some), costs))
        # The torque of a steady charge is that of its weight: x of its centre gives the power.
        without_x = [(x, row) for x, row in _pairs(some) if row.observable != "centre_x"]
        found.append(_coverage(f"{name}: without centre of mass, x", without_x, costs))
        for share in BUDGETS:
            group = [x for x in some if x.cost_s <= share * whole_costs[x.mill]]
            of = f"{name}: at most 1/{1.0 / share:.0f} of the whole mill"
            found += [_coverage(of, _pairs(group), costs)] if group else []
        for kind in dict.fromkeys(x.seeds for x in some):
            group = [x for x in some if x.seeds == kind]
            found.append(_coverage(f"{name}: {kind}", _pairs(group), costs))
        if len(costs) > 1:
            for mill in dict.fromkeys(x.mill for x in some):
                group = [x for x in some if x.mill == mill]
                found.append(_coverage(f"{name}: {mill}", _pairs(group), costs))
        else:
            for runs in dict.fromkeys(runs_text(x.runs) for x in some):
                group = [x for x in some if runs_text(x.runs) == runs]
                found.append(_coverage(f"{name}: {runs}", _pairs(group), costs))
        for label in dict.fromkeys(row.label for x in some for row in x.intervals):
            of_label = [(x, row) for x, row in _pairs(some) if row.label == label]
            found.append(_coverage(f"{name}: {label}", of_label, costs))
    return found


def _pairs(trials: Sequence[Trial]) -> list[tuple[Trial, Interval]]:
    return [(trial, row) for trial in trials for row in trial.intervals]


def _coverage(
    of: str, rows: Sequence[tuple[Trial, Interval]], costs: Mapping[str, float]
) -> Coverage:
    known = [(trial, row) for trial, row in rows if row.is_inside is not None]
    inside, count = sum(bool(row.is_inside) for _, row in known), len(known)
    lower, upper = binomial_interval(inside, count)
    over = [row.half_width / abs(row.error) for _, row in known if row.error and row.half_width]
    gains = [row.single_cost_s / trial.cost_s for trial, row in known if row.single_cost_s]
    return Coverage(
        of=of,
        inside=inside,
        intervals=count,
        refused=len(rows) - count,
        lower=lower,
        upper=upper,
        within_chance=sum(_misses_by_chance(row) for _, row in known),
        half_width_over_error=median(over) if over else None,
        gain=median(gains) if gains else None,
        cost_share=median(trial.cost_s / costs[trial.mill] for trial, _ in rows),
    )


def _misses_by_chance(row: Interval) -> bool:
    if row.is_inside is not False or row.truth_error is None:
        return False
    assert row.lower is not None and row.upper is not None
    return max(row.lower - row.truth, row.truth - row.upper) <= CHANCES * row.truth_error


def binomial_interval(inside: int, count: int) -> tuple[float, float]:
    """Return the 95 % interval of a share by Clopper and Pearson, Biometrika 26 (1934) 404,
    doi 10.1093/biomet/26.4.404."""
    lower = betaincinv(inside, count - inside + 1, 0.025) if inside > 0 else 0.0
    upper = betaincinv(inside + 1, count - inside, 0.975) if inside < count else 1.0
    return float(lower), float(upper)


def write_coverage(folders: Sequence[Path], file: Path, every: bool = False) -> str:
    """Write the predictions to a file, and two figures beside it.

    Returns:
        Tables of the predictions and of their coverage as Markdown.
    """
    content = try_predictions(folders, every)
    write_json(file, content)
    draw_speed(content, file.with_suffix(".png"))
    draw_coverage(content, file.with_name(f"{file.stem}-intervals.png"))
    return markdown(content)
