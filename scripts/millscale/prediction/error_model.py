"""How large errors of scaled mills are: slope and noise of each observable, from finished runs.

The constants decide which runs `millscale advise` plans. They come from the mill of the paper and
are replaced by the user's own runs. A prediction does not use them.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import msgspec

from millscale.errors import PredictionError
from millscale.prediction.extrapolation import (
    ExtrapolationError,
    Group,
    Noise,
    extrapolate,
    scale_function,
)
from millscale.prediction.noise import FEWEST_SEED_FREEDOM, WITH_PITCHES
from millscale.prediction.observables import kind_of
from millscale.prediction.result import Prediction

SCHEMA = 1
BUILT_IN = Path(__file__).with_name("error_model.json")
# The exponent at which slopes are stored: the middle of the prior of `extrapolation`.
EXPONENT = 0.5
# Lifter pitches of a planned run in the steady window, less one: 5 rad of 25 lifters.
PLANNED_PITCHES = 19.0
# Angles have no scale of their own: their errors are shares of a radian.
ANGLES = frozenset({"toe_angle_rad"})


@dataclass(frozen=True)
class ObservableError:
    """Error of one observable in the mill it was learnt from.

    Attributes:
        name: of `observables.OBSERVABLES`.
        slope: relative error over (S^p - 1) / p at p = `EXPONENT`.
        deviation: relative standard deviation of one run.
        freedom: degrees of freedom of the deviation.
    """

    name: str
    slope: float
    deviation: float
    freedom: float

    def bias(self, S: float) -> float:
        """Return the relative error of a scaled mill of the same a / R at S = 1."""
        return self.slope * float(scale_function(S, EXPONENT))


@dataclass(frozen=True)
class ErrorModel:
    """Errors of the observables, and the mill and runs that they were learnt from.

    Attributes:
        ball_over_mill: ball radius over mill radius at S = 1.
        window_rad: mill rotation over which means were taken, of the shortest run.
        origin: command, commit, machine and date.
    """

    ball_over_mill: float
    window_rad: float
    observables: tuple[ObservableError, ...]
    origin: dict[str, Any]

    def of_mill(self, ball_over_mill: float) -> ErrorModel:
        """Return the errors of a mill of another a / R: the error is a power of S a / R."""
        factor = (ball_over_mill / self.ball_over_mill) ** EXPONENT
        moved = tuple(
            ObservableError(x.name, factor * x.slope, x.deviation, x.freedom)
            for x in self.observables
        )
        return ErrorModel(ball_over_mill, self.window_rad, moved, self.origin)

    def document(self) -> dict[str, Any]:
        """Return it as JSON types."""
        return {"schema": SCHEMA, **asdict(self)}


def built_in() -> ErrorModel:
    """Return the errors learnt from the paper's mill."""
    content = json.loads(BUILT_IN.read_text(encoding="utf-8"))
    content.pop("schema")
    return msgspec.convert(content, ErrorModel)


def learn(prediction: Prediction, origin: dict[str, Any]) -> ErrorModel:
    """Return the errors of the mill of a prediction.

    Raises:
        PredictionError: no observable could be extrapolated.
    """
    rows = []
    for number in prediction.numbers:
        if number.found is None or number.noise is None:
            continue
        groups = [Group(x.S, (x.mean / number.scale,)) for x in number.measured]
        far, near = groups[-1], groups[0]
        reach = float(scale_function(far.S, EXPONENT) - scale_function(near.S, EXPONENT))
        unit = 1.0 if number.observable.name in ANGLES else abs(number.found.value)
        rows.append(
            ObservableError(
                number.observable.name,
                (far.mean - near.mean) / reach / unit,
                number.noise.deviation / unit,
                number.noise.freedom,
            )
        )
    if not rows:
        raise PredictionError("no observable was extrapolated: there is no error to learn")
    mill = prediction.mill
    window = min(x.result.mean_to_rad - x.result.mean_from_rad for x in prediction.runs)
    return ErrorModel(mill.ball_radius / mill.radius, window, tuple(rows), origin)


def expected_half_width(
    error: ObservableError, ratios: Sequence[tuple[float, int]], level: float
) -> float:
    """Return the relative half width that a prediction from planned runs will have.

    Evaluates the prediction itself on the values that the slope gives.

    Args:
        ratios: (S, seeds) of the planned mills.

    Raises:
        ExtrapolationError: the values of S do not allow an extrapolation.
    """
    groups = [Group(S, (1.0 + error.bias(S),) * seeds) for S, seeds in ratios]
    prior = kind_of(error.name).prior
    return extrapolate(groups, planned_noise(error, ratios), level, prior).half_width


def planned_noise(error: ObservableError, ratios: Sequence[tuple[float, int]]) -> Noise:
    """Return the noise that a prediction from planned runs will find (`noise.noise_of`).

    Raises:
        ExtrapolationError: the runs have too few seeds to find it.
    """
    freedom = sum(seeds - 1 for _, seeds in ratios)
    if freedom >= FEWEST_SEED_FREEDOM:
        return Noise(error.deviation, float(freedom))
    if error.name in WITH_PITCHES:
        return Noise(error.deviation, PLANNED_PITCHES * len(ratios))
    raise ExtrapolationError(f"{error.name}: its noise is found from three seeds at least")
