"""What the finished cases of a sample give of each target."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from millscale.analysis.finished import Charge, damage
from millscale.calibration.file import CalibrationFile
from millscale.calibration.inference import CalibrationError, Evidence
from millscale.calibration.targets import Target
from millscale.runs.case_folder import finished_or_reason
from millscale.runs.untrusted import RunFolderError
from millscale.study.file import Setting

# A profile of which a sample lacks more of the points is none.
LEAST_POINTS = 0.5


@dataclass(frozen=True, eq=False)
class Observation:
    """A target of a sample, the mean over the seeds.

    Attributes:
        values: (p,) float, nan at points of a profile that the sample lacks.
        noise: standard error; None if it is not known.
    """

    values: np.ndarray
    noise: float | None


@dataclass(frozen=True)
class Observed:
    """What a sample gives.

    Attributes:
        targets: observations by target; empty if the sample is not used.
        excluded: why it is not used.
        unsteady: why a charge of it is not steady.
    """

    targets: Mapping[str, Observation] = field(default_factory=dict)
    excluded: str = ""
    unsteady: str = ""


@dataclass
class Observer:
    """Reads cases, each once."""

    targets: Sequence[Target]
    _of_cases: dict[Path, Observed] = field(default_factory=dict)

    def observe(
        self, settings: Mapping[str, Setting], folders: Mapping[str, Mapping[str, Path]]
    ) -> Observed:
        """Return what a sample gives.

        Args:
            settings: of the sample, by experiment.
            folders: of its finished cases, by experiment and id.
        """
        found: dict[str, Observation] = {}
        unsteady = ""
        for experiment, setting in settings.items():
            seeds = []
            for case in setting.cases:
                folder = folders[experiment].get(case.id)
                seen = (
                    self._case(folder, experiment) if folder else Observed(excluded="not finished")
                )
                if seen.excluded:
                    return Observed(excluded=f"{case.id}: {seen.excluded}")
                unsteady = unsteady or seen.unsteady
                seeds.append(seen.targets)
            for name in seeds[0]:
                found[name] = _mean([seed[name] for seed in seeds])
        return Observed(found, unsteady=unsteady)

    def _case(self, folder: Path, experiment: str) -> Observed:
        if folder not in self._of_cases:
            self._of_cases[folder] = self._read(folder, experiment)
        return self._of_cases[folder]

    def _read(self, folder: Path, experiment: str) -> Observed:
        finished = finished_or_reason(folder)
        if isinstance(finished, str):
            return Observed(excluded=finished)
        charge = Charge(finished, folder.name)
        if why := damage(charge):
            return Observed(excluded=why)
        found = {}
        for target in self.targets:
            if target.experiment != experiment:
                continue
            try:
                seen = Observation(target.simulated(charge), target.noise(charge))
            except RunFolderError as error:
                return Observed(excluded=f"{error.cause}; {error.remedy}")
            if np.isfinite(seen.values).mean() < LEAST_POINTS:
                return Observed(excluded=f"it has no {target.name}")
            found[target.name] = seen
        return Observed(found, unsteady="; ".join(charge.result.steady.reasons))


def _mean(seeds: Sequence[Observation]) -> Observation:
    noises = [seed.noise for seed in seeds if seed.noise is not None]
    noise = None
    if len(noises) == len(seeds):
        noise = math.sqrt(math.fsum(one**2 for one in noises)) / len(seeds)
    return Observation(np.mean([seed.values for seed in seeds], axis=0), noise)


def evidence_of(calibration: CalibrationFile, samples: Sequence[Observed]) -> list[Evidence]:
    """Return the evidence of some samples that are used, over the uncertainties of the targets.

    Points of a profile that one of them lacks are left out of all.

    Raises:
        CalibrationError: no point of a profile is in all of them.
    """
    found = []
    for target in calibration.targets:
        seen = [sample.targets[target.name] for sample in samples]
        differences = np.array([target.differences(one.values) for one in seen])
        differences = differences.reshape(len(seen), len(target.measured))
        known = np.isfinite(differences).all(axis=0)
        if not known.any():
            raise CalibrationError(f"{target.name}: no point that all samples have")
        noise = tuple(None if one.noise is None else one.noise / target.uncertainty for one in seen)
        found.append(Evidence(target.name, differences[:, known], noise))
    return found
