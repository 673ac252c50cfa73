"""`millscale calibrate` of a calibration file: run samples, infer, refine, confirm."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from rich.console import Console

from millscale.calibration.file import CalibrationFile, load_calibration
from millscale.calibration.inference import (
    CalibrationError,
    Inference,
    contributions,
    infer,
    next_places,
)
from millscale.calibration.observed import Observed, Observer, evidence_of
from millscale.calibration.page import write_result
from millscale.calibration.result import Result, Sample
from millscale.calibration.samples import (
    Values,
    first_samples,
    places_of,
    read_samples,
    values_at,
    write_samples,
)
from millscale.calibration.table import lines, parameter_table, target_table
from millscale.engine.machine import CoreWish
from millscale.engine.record import provenance
from millscale.errors import PredictionError
from millscale.formats import counted, duration
from millscale.runs.lock import hold
from millscale.study.file import Setting
from millscale.study.folders import Places, found_cases
from millscale.study.running import RunOptions, run_settings
from millscale.workflow.placement import OPEN
from millscale.workflow.plan import plan_rows

CALIBRATED = "calibrated"
# Samples that are not used, of which an error names as many.
MOST_NAMED = 3


@dataclass(frozen=True)
class CalibrateCall:
    """Arguments of the command.

    Attributes:
        runs: folder of the calibration.
        others: runs folders whose finished cases are reused.
        no_run: infer from the finished samples only.
    """

    file: Path
    runs: Path
    others: tuple[Path, ...] = ()
    cores: CoreWish = OPEN
    ignore_disk: bool = False
    no_run: bool = False


def plan_lines(file: Path) -> list[str]:
    """Return the runs of a calibration and their predicted time; writes no file."""
    calibration = load_calibration(file)
    middle = [float(one.value(np.array(0.5))) for one in calibration.parameters]
    settings = calibration.settings("sample", "", middle)
    rows = [row for setting in settings.values() for row in plan_rows(setting.campaign)]
    each = sum(row["predicted_wall_time_s"] for row in rows)
    later = (calibration.rounds - 1) * calibration.later
    most = calibration.samples + later + 1
    ids = ", ".join(row["id"] for row in rows)
    found = [
        f"parameters: {', '.join(one.name for one in calibration.parameters)}",
        f"targets: {', '.join(one.name for one in calibration.targets)}",
        f"a sample is {counted(len(rows), 'case')}, {ids}: about {duration(each)}",
        f"round 1: {calibration.samples} samples, about {duration(each * calibration.samples)}",
        f"at most {later} samples later, and the mill with the best values",
        f"in all at most {counted(most, 'sample')}, about {duration(each * most)}",
    ]
    warned = dict.fromkeys(text for row in rows for text in row["warnings"])
    return found + [f"warning: {text}" for text in warned]


def calibrate(call: CalibrateCall, console: Console) -> tuple[bool, Result]:
    """Run what is missing and write the result; return whether every sample has results, and it.

    Raises:
        CampaignError: wrong arguments, or a folder of something else.
        PredictionError: too few finished samples.
    """
    calibration = load_calibration(call.file)
    places = Places(call.runs, call.others)
    places.check("millscale calibrate")
    with hold(call.runs):
        work = _Work(call, calibration, places, console, Observer(calibration.targets))
        work.make_rounds()
        result = work.result()
        write_result(call.runs, result, provenance())
    console.print(parameter_table(result))
    console.print(target_table(result))
    for line in lines(result, call.runs):
        console.print(line, markup=False, highlight=False, soft_wrap=True)
    return work.done, result


@dataclass
class _Work:
    """A calibration that is under way.

    Attributes:
        rounds: values of the samples of each round.
        history: what was inferred after each round.
        done: whether every run has results.
    """

    call: CalibrateCall
    calibration: CalibrationFile
    places: Places
    console: Console
    observer: Observer
    rounds: list[list[Values]] = field(default_factory=list)
    history: list[Inference] = field(default_factory=list)
    done: bool = True

    def make_rounds(self) -> None:
        """Run and infer round after round."""
        calibration = self.calibration
        self.rounds = read_samples(self.call.runs, calibration) or [first_samples(calibration)]
        for number in range(1, max(calibration.rounds, len(self.rounds)) + 1):
            if number > len(self.rounds):
                if self.call.no_run or self.history[-1].is_converged:
                    return
                places = next_places(self.history[-1], calibration.later)
                self.rounds.append(values_at(calibration.parameters, places))
            write_samples(self.call.runs, calibration, self.rounds)
            samples = self._samples(number)
            self._run(samples[-len(self.rounds[number - 1]) :], samples)
            self.history.append(self._infer(number))

    def result(self) -> Result:
        """Run the mill with the best values, and return everything."""
        samples = self._samples()
        best = self.history[-1].best[None]
        values = values_at(self.calibration.parameters, best)[0]
        settings = self.calibration.settings(CALIBRATED, "the calibrated mill", values)
        self._run([settings], [*samples, settings])
        return Result(
            self.calibration,
            tuple(self.history),
            tuple(
                Sample(values, number, seen)
                for (number, values), seen in zip(
                    ((i, x) for i, one in enumerate(self.rounds, 1) for x in one),
                    self._observed(samples),
                    strict=True,
                )
            ),
            Sample(values, None, self._observed([settings])[0]),
            {name: setting.text() for name, setting in settings.items()},
            contributions(self.history[-1], self.calibration.seed),
        )

    def _samples(self, rounds: int | None = None) -> list[dict[str, Setting]]:
        """Return the settings of each sample of the first rounds, by experiment."""
        values = [x for one in self.rounds[:rounds] for x in one]
        return [
            self.calibration.settings(f"sample-{i:03d}", "", one) for i, one in enumerate(values, 1)
        ]

    def _run(
        self, chosen: Sequence[dict[str, Setting]], every: Sequence[dict[str, Setting]]
    ) -> None:
        if self.call.no_run:
            return
        how = RunOptions(self.call.cores, self.call.ignore_disk, self.console, "sample")
        self.done &= run_settings(_flat(every), _flat(chosen), self.places, how)

    def _observed(self, samples: Sequence[dict[str, Setting]]) -> list[Observed]:
        every = _flat(samples)
        return [
            self.observer.observe(
                sample,
                {name: found_cases(every, one, self.places) for name, one in sample.items()},
            )
            for sample in samples
        ]

    def _infer(self, number: int) -> Inference:
        """Return what the samples of the first rounds give."""
        calibration = self.calibration
        values = [x for one in self.rounds[:number] for x in one]
        seen = self._observed(self._samples(number))
        used = [i for i, one in enumerate(seen) if not one.excluded]
        try:
            if not used:
                raise CalibrationError("no finished sample")
            found = infer(
                calibration.parameters,
                places_of(calibration.parameters, [values[i] for i in used]),
                evidence_of(calibration, [seen[i] for i in used]),
                calibration.level,
                calibration.seed,
                self.history[-1] if self.history else None,
            )
        except CalibrationError as error:
            reasons = list(dict.fromkeys(one.excluded for one in seen if one.excluded))
            why = f" ({'; '.join(reasons[:MOST_NAMED])})" if reasons else ""
            raise PredictionError(f"{error}{why}") from None
        best = ", ".join(
            f"{one.name} {one.best:.3g} ({one.lower:.3g} to {one.upper:.3g})" for one in found.found
        )
        self.console.print(f"round {number}: {best}", markup=False, highlight=False)
        return found


def _flat(samples: Sequence[dict[str, Setting]]) -> list[Setting]:
    return [setting for sample in samples for setting in sample.values()]
