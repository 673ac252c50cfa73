"""samples.json: the values that were run so far, so that the same command resumes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from scipy.stats import qmc

from millscale.calibration.file import CalibrationFile, rounded
from millscale.calibration.inference import Parameter
from millscale.errors import CampaignError
from millscale.runs.lock import LOCK_FILE
from millscale.runs.typed import read_typed
from millscale.runs.writing import write_json

SCHEMA = 1
NAME = "samples.json"
Values = tuple[float, ...]


@dataclass(frozen=True)
class Samples:
    """Content of samples.json.

    Attributes:
        file: name of the calibration file.
        digest: of its mills and of the keys of its parameters.
        rounds: of each round the values of each sample, in the order of the parameters.
    """

    schema: int
    file: str
    digest: str
    rounds: tuple[tuple[Values, ...], ...]


def read_samples(folder: Path, calibration: CalibrationFile) -> list[list[Values]]:
    """Return the rounds of a folder; none if it is new.

    Ranges and targets may change between two calls: the samples stay.

    Raises:
        CampaignError: the folder is of another calibration, or of something else.
        RunFolderError: samples.json is damaged.
    """
    path = folder / NAME
    if not path.exists():
        other = next((x.name for x in folder.glob("*") if x.name != LOCK_FILE), None)
        if other:
            cause = f"holds {other}, but no {NAME}"
            raise CampaignError(folder, "", cause, "a new folder, or one of millscale calibrate")
        return []
    content = read_typed(path, Samples, f"remove {folder}, or name another folder")
    if content.digest != calibration.digest:
        cause = f"was made for {content.file}, whose mill or parameters differ from those of "
        raise CampaignError(path, "", f"{cause}{calibration.file}", "another folder")
    return [[tuple(values) for values in one] for one in content.rounds]


def write_samples(
    folder: Path, calibration: CalibrationFile, rounds: Sequence[Sequence[Values]]
) -> None:
    """Write samples.json."""
    kept = tuple(tuple(one) for one in rounds)
    content = Samples(SCHEMA, calibration.file.name, calibration.digest, kept)
    write_json(folder / NAME, asdict(content))


def first_samples(calibration: CalibrationFile) -> list[Values]:
    """Return the samples of the first round: evenly over the ranges, by a Sobol sequence."""
    parameters = calibration.parameters
    sequence = qmc.Sobol(len(parameters), rng=np.random.default_rng(calibration.seed))
    # Its first points alone are even; drawn as a power of two, of which some are not used.
    power = int(np.ceil(np.log2(calibration.samples)))
    return values_at(parameters, sequence.random_base2(power)[: calibration.samples])


def values_at(parameters: Sequence[Parameter], places: np.ndarray) -> list[Values]:
    """Return the values at places of the cube, as campaign files state them."""
    columns = [one.value(places[:, j]) for j, one in enumerate(parameters)]
    return [tuple(rounded(float(value)) for value in row) for row in zip(*columns, strict=True)]


def places_of(parameters: Sequence[Parameter], values: Sequence[Values]) -> np.ndarray:
    """Return the places of values, (n, d) float."""
    return np.array(
        [[p.place(v) for p, v in zip(parameters, row, strict=True)] for row in values]
    )  # fmt: skip
