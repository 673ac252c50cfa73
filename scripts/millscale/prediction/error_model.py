"""How large errors of scaled mills are: slope and noise of each observable, from finished runs.

The constants decide which runs `millscale advise` plans and `millscale solve` begins with. Those of
some mills are built in; the user's own runs replace them. A prediction does not use them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from millscale.analysis.finished import Charge
from millscale.errors import PredictionError
from millscale.prediction.contour import BLOCKS
from millscale.prediction.extrapolation import (
    ExtrapolationError,
    Group,
    Noise,
    Prior,
    extrapolate,
    scale_function,
)
from millscale.prediction.kinds import Kind
from millscale.prediction.noise import FEWEST_SEED_FREEDOM, WITH_PITCHES, pitch_noise
from millscale.prediction.observables import OBSERVABLES, kind_of
from millscale.prediction.planned import PlannedRun
from millscale.prediction.result import PredictedNumber, Prediction
from millscale.runs.typed import as_typed, read_typed
from millscale.runs.writing import write_json

SCHEMA = 2
BUILT_IN = Path(__file__).with_name("error_model.json")
# The exponent at which slopes are stored: the middle of the prior of `extrapolation`.
EXPONENT = 0.5
# The mean distance along the normals of the surface contour, over R - a.
CONTOUR = "contour"


@dataclass(frozen=True)
class ObservableError:
    """Error of one observable in the mill it was learnt from.

    Attributes:
        name: of `observables.OBSERVABLES`, or `CONTOUR`.
        slope: relative error over (S^p - 1) / p at p = `EXPONENT`.
        deviation: relative standard deviation of one run.
        freedom: degrees of freedom of the deviation.
        pitch_deviation: the same from the scatter of lifter pitches, which a prediction from
            single seeds finds; None if it has none.
    """

    name: str
    slope: float
    deviation: float
    freedom: float
    pitch_deviation: float | None = None

    def bias(self, S: float) -> float:
        """Return the relative error of a scaled mill of the same a / R at S = 1."""
        return self.slope * float(scale_function(S, EXPONENT))


@dataclass(frozen=True)
class ErrorModel:
    """Errors of the observables, and the mill and runs that they were learnt from.

    Attributes:
        ball_over_mill: ball radius over mill radius at S = 1.
        balls: in a run, the harmonic mean over the runs.
        window_rad: mill rotation over which means were taken, in the mean.
        origin: command, commit, machine and date.
    """

    ball_over_mill: float
    scheme: str
    policy: str
    balls: float
    window_rad: float
    observables: tuple[ObservableError, ...]
    origin: dict[str, Any]

    def of_mill(self, ball_over_mill: float) -> ErrorModel:
        """Return the errors of a mill of another a / R: the error is a power of S a / R."""
        factor = (ball_over_mill / self.ball_over_mill) ** EXPONENT
        moved = tuple(replace(x, slope=factor * x.slope) for x in self.observables)
        return replace(self, ball_over_mill=ball_over_mill, observables=moved)

    def of_run(self, run: PlannedRun) -> float:
        """Return the variance of a run over that of the runs that were learnt from: it is inverse
        to the number of balls and to the rotation of the means."""
        return self.balls * self.window_rad / (run.balls * run.window_rad)


def built_in() -> tuple[ErrorModel, ...]:
    """Return the errors of the mills that come with millscale."""
    return read_models(BUILT_IN)


def read_models(path: Path) -> tuple[ErrorModel, ...]:
    """Return the errors of a file of `write_model`."""
    content = read_typed(path, dict, "write it again: millscale predict DIR --errors FILE")
    return as_typed(tuple[ErrorModel, ...], content.get("mills"))


def write_model(path: Path, model: ErrorModel) -> None:
    """Add the errors of a mill to a file, in place of those of the same mill and policy."""
    others = read_models(path) if path.exists() else ()
    kept = [other for other in others if _kind(other) != _kind(model)]
    mills = sorted([*kept, model], key=lambda x: (x.ball_over_mill, x.scheme, x.policy))
    write_json(path, {"schema": SCHEMA, "mills": [asdict(x) for x in mills]})


def _kind(model: ErrorModel) -> tuple[float, str, str]:
    return round(model.ball_over_mill, 6), model.scheme, model.policy


def nearest_model(
    models: Sequence[ErrorModel], ball_over_mill: float, scheme: str, policy: str
) -> ErrorModel:
    """Return the errors for a mill, learnt from the most similar one: of the same policy and scheme
    if there is one, then of the nearest a / R."""

    def distance(model: ErrorModel) -> tuple[bool, bool, float]:
        ratio = math.log(model.ball_over_mill / ball_over_mill)
        return model.policy != policy, model.scheme != scheme, abs(ratio)

    return min(models, key=distance).of_mill(ball_over_mill)


def unit_of(number: PredictedNumber) -> float:
    """Return what errors of an observable are relative to, dimensionless: its value, or 1 rad of
    angles, which have no scale of their own."""
    if number.observable.unit == "deg":
        return 1.0
    return abs(number.found.value) if number.found else math.nan


def learn(prediction: Prediction, origin: dict[str, Any]) -> ErrorModel:
    """Return the errors of the mill of a prediction.

    Raises:
        PredictionError: no observable could be extrapolated.
    """
    rows = [x for number in prediction.numbers if (x := _learnt(number, prediction.runs))]
    if prediction.contour:
        contour = prediction.contour
        reach = contour.shifts[-1].S, contour.shifts[0].S
        rows.append(
            ObservableError(
                CONTOUR,
                (contour.shifts[-1].mean - contour.shifts[0].mean) / _reach(*reach),
                contour.noise.deviation,
                contour.noise.freedom,
            )
        )
    if not rows:
        raise PredictionError("no observable was extrapolated: there is no error to learn")
    mill, runs = prediction.mill, prediction.runs
    window = math.fsum(x.result.mean_to_rad - x.result.mean_from_rad for x in runs) / len(runs)
    balls = len(runs) / math.fsum(1.0 / charge.balls for charge in runs)
    return ErrorModel(
        mill.ball_radius / mill.radius,
        prediction.scheme,
        prediction.policy,
        balls,
        window,
        tuple(rows),
        origin,
    )


def _learnt(number: PredictedNumber, runs: Sequence[Charge]) -> ObservableError | None:
    if number.found is None or number.noise is None:
        return None
    of_pitches = pitch_noise(number.observable.measured_as, runs)
    near, far = number.measured[0], number.measured[-1]
    unit = unit_of(number)
    return ObservableError(
        number.observable.name,
        (far.mean - near.mean) / number.scale / _reach(far.S, near.S) / unit,
        number.noise.deviation / unit,
        number.noise.freedom,
        of_pitches.deviation / unit if of_pitches else None,
    )


def _reach(far: float, near: float) -> float:
    return float(scale_function(far, EXPONENT) - scale_function(near, EXPONENT))


def expected_half_width(
    error: ObservableError, model: ErrorModel, runs: Sequence[PlannedRun], level: float
) -> float:
    """Return the relative half width that a prediction from planned runs will have.

    Evaluates the prediction itself on the values that the slope gives.

    Args:
        runs: one entry for each; several of one S differ in the seed.

    Raises:
        ExtrapolationError: the values of S do not allow an extrapolation.
    """
    counts: dict[float, int] = {}
    for run in runs:
        counts[run.S] = counts.get(run.S, 0) + 1
    groups = [Group(S, (1.0 + error.bias(S),) * count) for S, count in counts.items()]
    noise = planned_noise(error, model, runs)
    return extrapolate(groups, noise, level, prior_of(error.name)).half_width


def planned_noise(error: ObservableError, model: ErrorModel, runs: Sequence[PlannedRun]) -> Noise:
    """Return the noise that a prediction from planned runs will find (`noise.noise_of`).

    Raises:
        ExtrapolationError: the runs have too few seeds to find it.
    """
    variance = math.fsum(map(model.of_run, runs)) / len(runs)
    freedom = planned_freedom(error.name, [(run.S, run.pitches) for run in runs])
    deviation = learnt_deviation(error, [run.S for run in runs])
    return Noise(deviation * math.sqrt(variance), freedom)


def learnt_deviation(error: ObservableError, ratios: Sequence[float]) -> float:
    """Return the noise that a prediction finds from runs of these S, one entry for each run: of the
    seeds if there are enough, else of the lifter pitches."""
    if error.pitch_deviation is None or _has_seeds(ratios):
        return error.deviation
    return error.pitch_deviation


def planned_freedom(name: str, runs: Iterable[tuple[float, float]]) -> float:
    """Return the degrees of freedom of the noise that a prediction from runs will find.

    Args:
        runs: S and lifter pitches of the means of each run.

    Raises:
        ExtrapolationError: the runs have too few seeds to find it.
    """
    runs = list(runs)
    ratios = [S for S, _ in runs]
    if _has_seeds(ratios):
        return float(len(ratios) - len(set(ratios)))
    if name == CONTOUR:
        return float(len(runs) * (BLOCKS - 1))
    if measured_as(name) in WITH_PITCHES:
        return math.fsum(max(pitches - 1.0, 1.0) for _, pitches in runs)
    raise ExtrapolationError(f"{name}: its noise is found from three seeds at least")


def _has_seeds(ratios: Sequence[float]) -> bool:
    """Return whether runs of these S have enough seeds for the noise."""
    return len(ratios) - len(set(ratios)) >= FEWEST_SEED_FREEDOM


def prior_of(name: str) -> Prior:
    """Return the prior of an observable's exponent."""
    return (Kind.SHAPE if name == CONTOUR else kind_of(name)).prior


def measured_as(name: str) -> str:
    """Return the name of the observable that has the same number without units."""
    return next((row.measured_as for row in OBSERVABLES if row.name == name), name)


def label_of(name: str) -> str:
    """Return an observable's name in text."""
    labels = {row.name: row.label for row in OBSERVABLES}
    return "surface contour" if name == CONTOUR else labels[name]
