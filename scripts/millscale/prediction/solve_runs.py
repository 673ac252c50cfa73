"""Rounds of a solve as campaigns: DIR/round-N is a runs folder, DIR/round-N.toml its campaign."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from rich.console import Console

from millscale.analysis.charge.measured import measure
from millscale.analysis.finished import Charge
from millscale.analysis.finished_campaign import load_campaign
from millscale.cases.cost import learned
from millscale.engine.machine import CoreWish, hardware
from millscale.errors import EngineError
from millscale.prediction.error_model import CONTOUR, unit_of
from millscale.prediction.extrapolation import Group, Noise
from millscale.prediction.planned import PlannedMills, PlannedRun, RunSize
from millscale.prediction.predict import predict_charges
from millscale.prediction.result import PredictedNumber, Prediction
from millscale.prediction.selection import check_one_mill
from millscale.prediction.solve import Look, Round, Track
from millscale.runs.layout import CASES_FOLDER
from millscale.runs.untrusted import RunFolderError
from millscale.runs.writing import write_text
from millscale.workflow.placement import OPEN
from millscale.workflow.run_command import check_free_disk, request, run_campaign
from millscale.workflow.status import campaign_status

# One core a run: runs side by side use the machine better than ranks.
RANKS = 1


def round_folder(folder: Path, number: int) -> Path:
    """Return the runs folder of a round."""
    return folder / f"round-{number}"


@dataclass
class SolveRuns:
    """Makes the runs of rounds with the engine, and predicts from those that are finished.

    Attributes:
        folder: of the solve.
        mills: of the campaign file.
        cores: ranks of a run and runs at a time.
        prediction: from the finished runs; None if they allow none.
        refused: why there is none.
    """

    folder: Path
    mills: PlannedMills
    console: Console
    cores: CoreWish = OPEN
    level: float = 0.95
    ignore_disk: bool = False
    prediction: Prediction | None = None
    refused: str = ""
    _charges: dict[int, list[Charge]] = field(default_factory=dict)
    _numbers: dict[Charge, dict[str, float | None]] = field(default_factory=dict)

    def planned(self, S: float, size: RunSize) -> PlannedRun | None:
        """Return a run that could be made, at the rates of the finished runs."""
        return self.mills.run(S, size)

    def run(self, asked: Round) -> None:
        """Make the runs of a round, or finish them.

        Raises:
            EngineError: names the first case that failed.
        """
        folder = round_folder(self.folder, asked.number)
        file = folder.with_suffix(".toml")
        about = f"round {asked.number} of millscale solve: {asked.text}"
        text = self.mills.campaign_text(asked.mills, asked.size, folder.name, about)
        if not file.exists():
            write_text(file, text)
        wish = replace(self.cores, ranks=self.cores.ranks or RANKS)
        wanted = request(file, folder, [], wish)
        if not self.ignore_disk:
            check_free_disk(wanted)
        if not run_campaign(wanted, self.console):
            raise EngineError(_failure(folder, asked.number))

    def look(self, finished: Sequence[Round]) -> Look:
        """Return what the finished runs give. Each round's files are read once."""
        for done in finished:
            if done.number not in self._charges:
                folder = round_folder(self.folder, done.number)
                campaign = load_campaign(folder)
                if campaign.missing:
                    name, why = next(iter(campaign.missing.items()))
                    raise RunFolderError(folder / CASES_FOLDER / name, why, "run it again")
                self._charges[done.number] = campaign.charges
                self._numbers |= measure(_steady(campaign.charges), []).numbers
        charges = [x for done in finished for x in self._charges[done.number]]
        folders = [charge.folder for charge in charges]
        self.mills.rates = learned(folders, str(hardware()["cpu"]))
        used = sorted(_steady(charges), key=lambda charge: (charge.S, charge.seed))
        unsteady = {
            (charge.S, charge.seed): "; ".join(charge.result.steady.reasons)
            for charge in charges
            if not charge.result.steady.is_steady
        }
        self._predict(used, unsteady)
        keys = frozenset((charge.S, charge.seed) for charge in used)
        tracks = {track.name: track for track in _tracks(self.prediction)}
        return Look(tracks, keys, unsteady, math.fsum(map(cost_of, charges)))

    def _predict(self, used: Sequence[Charge], unsteady: Mapping[tuple[float, int], str]) -> None:
        self.prediction, self.refused = None, ""
        ratios = {charge.S for charge in used}
        if len(ratios) < 2 and ratios != {1.0}:
            there = ", ".join(f"S = {S:g}" for S in ratios) or "no run"
            self.refused = f"{there} finished and steady: two values of S are needed"
            return
        check_one_mill(used)
        excluded = {f"S = {S:g}, seed {seed}": why for (S, seed), why in unsteady.items()}
        self.prediction = predict_charges(used, [], self._numbers, self.level, excluded)


def cost_of(charge: Charge) -> float:
    """Return the core time of a run, settling included [s].

    A run that resumed timed only part of its steps; its time is scaled up.
    """
    timing = charge.timing
    rotation = timing.wall_time_s * charge.case.time.steps / max(timing.steps, 1)
    return timing.ranks * (rotation + (charge.settled.wall_time_s or 0.0))


def _steady(charges: Sequence[Charge]) -> list[Charge]:
    return [charge for charge in charges if charge.result.steady.is_steady]


def _tracks(prediction: Prediction | None) -> Iterator[Track]:
    if prediction is None:
        return
    yield from map(_track, prediction.numbers)
    contour = prediction.contour
    if contour is None:
        yield Track(CONTOUR, (), refused=prediction.contour_refused)
    else:
        half_width = float(contour.half_widths.mean())
        yield Track(CONTOUR, contour.shifts, contour.noise, half_width)


def _track(number: PredictedNumber) -> Track:
    name, found = number.observable.name, number.found
    unit = unit_of(number) if found else 1.0
    groups = tuple(Group(x.S, (x.mean / number.scale / unit,) * x.runs) for x in number.measured)
    if found is None or number.noise is None:
        # The noise is known where the residuals alone refuse the law.
        broken = number.noise is not None
        return Track(name, groups, refused=number.refused, is_broken=broken)
    noise = Noise(number.noise.deviation / unit, number.noise.freedom)
    return Track(name, groups, noise, found.half_width / unit, found.exponent)


def _failure(folder: Path, number: int) -> str:
    """Return which case of a round failed, and why."""
    for status in campaign_status(folder):
        if status.state != "done":
            log = folder / CASES_FOLDER / status.id / status.log
            problem = status.problem or "its workflow ended early"
            state = f"{status.stage} {status.state}".strip()
            return f"round {number}: {status.id}: {state}: {problem}; see {log}"
    return f"round {number} did not end: see {folder}"
