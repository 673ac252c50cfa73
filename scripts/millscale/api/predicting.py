"""Prediction of the physical mill, and plans of the runs that it needs."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path

from millscale.prediction import error_model
from millscale.prediction.advise import Advice
from millscale.prediction.advise import advise as _advise
from millscale.prediction.predict import predict as _predict
from millscale.prediction.result import Prediction

Folder = str | PathLike[str]


def predict(
    folders: Folder | Sequence[Folder],
    *,
    scheme: str | None = None,
    policy: str | None = None,
    level: float = 0.95,
    check: bool = False,
) -> Prediction:
    """Predict the physical mill from the finished scaled mills in one or more runs folders.

    Args:
        scheme, policy: of the scaled mills to use, where the folders hold several.
        level: probability of the intervals.
        check: leave the runs of S = 1 out, and compare with them.

    Raises:
        PredictionError: the runs allow no prediction; the message says what would.
        RunFolderError: a folder holds no campaign, or a damaged one.
    """
    return _predict(_paths(folders), scheme, policy, level, check)


def advise(
    file: Folder,
    error: float,
    *,
    observables: Sequence[str] = (),
    budget_s: float | None = None,
    learn_from: Folder | Sequence[Folder] = (),
) -> Advice:
    """Plan the cheapest runs that give the physical mill of a campaign file within an error.

    Args:
        error: half width of the interval wanted, over the value: 0.02 is 2 %.
        observables: names such as "power"; power, toe and solid fraction by default.
        budget_s: most time on one core [s].
        learn_from: runs folders whose errors are expected; the paper's mill by default.

    Raises:
        CampaignError: the campaign is not accepted.
        PredictionError: an observable is not known, or no scaled mill can be run.
    """
    learnt = _paths(learn_from)
    errors = (error_model.learn(_predict(learnt), {}),) if learnt else error_model.built_in()
    return _advise(Path(file), error, errors, observables, budget_s)


def _paths(folders: Folder | Sequence[Folder]) -> list[Path]:
    if isinstance(folders, str | PathLike):
        return [Path(folders)]
    return [Path(folder) for folder in folders]
