"""The dumps of a charge with mill angle, time and starting side of each ball, in turn."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from millscale.analysis.finished import Charge
from millscale.analysis.shapes.snapshots import first_dump, snapshots_of, starts_on_rising_side
from millscale.runs.dumps import Dump, read_dump
from millscale.runs.untrusted import RunFolderError


@dataclass(frozen=True, eq=False)
class Moment:
    """A dump of a charge.

    Attributes:
        time: simulated [s], as in series.csv.
        mill_angle: [rad].
        rising: (n,) bool, balls that started on the rising side.
    """

    dump: Dump
    time: float
    mill_angle: float
    rising: np.ndarray


def moments(charge: Charge, every: int = 1) -> Iterator[Moment]:
    """Yield every so many dumps of a charge, in order.

    Raises:
        RunFolderError: no dumps, no series, or a damaged one.
    """
    chosen = snapshots_of(charge.folder)[::every]
    first = first_dump(charge.folder)
    for snapshot in chosen:
        dump = read_dump(snapshot.path)
        try:
            rising = starts_on_rising_side(dump, first)
        except ValueError as error:
            raise RunFolderError(snapshot.path, str(error), "run the case again") from None
        yield Moment(dump, _time_at(dump.step, charge), snapshot.mill_angle, rising)


def _time_at(step: int, charge: Charge) -> float:
    """Return the simulated time [s] at a step: steps are of one length."""
    steps, times = charge.series["step"], charge.series["time_s"]
    slope = (times[-1] - times[0]) / (steps[-1] - steps[0])
    return float(times[0] + slope * (step - steps[0]))
