"""Finished cases, typed: case.json, result.json, timing.json, series.csv; read on first use."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TypeVar

import numpy as np

from millscale.analysis.result_file import ChargeResult, SingleBallResult
from millscale.campaign.keys import POLICIES
from millscale.runs.case_file import Case
from millscale.runs.case_folder import RESULT, SERIES, TIMING, FinishedCase, read_json, run_line
from millscale.runs.series import Series, read_series
from millscale.runs.typed import as_typed
from millscale.runs.untrusted import RunFolderError
from millscale.terminal import one_line

SETTLED = "settled.json"
T = TypeVar("T")


@dataclass(frozen=True)
class Hardware:
    """The machine that a stage ran on."""

    cpu: str
    available_cores: int | None

    def __str__(self) -> str:
        return f"{self.cpu}, {self.available_cores} cores"


@dataclass(frozen=True)
class Timing:
    """What the rotation took, by timing.json."""

    hardware: Hardware
    ranks: int
    balls: int
    steps: int
    wall_time_s: float
    particle_steps_per_s_core: float
    processor_time_s: float | None = None


@dataclass(frozen=True)
class Settled:
    """The bed at rest and the cost of settling, by settled.json; None where it lacks a number."""

    largest_overlap_over_radius: float | None = None
    bulk_fraction: float | None = None
    wall_time_s: float | None = None
    processor_time_s: float | None = None


@dataclass(frozen=True, eq=False)
class Finished:
    """A case whose analysis is done."""

    finished: FinishedCase

    @property
    def folder(self) -> Path:
        return self.finished.folder

    @property
    def case(self) -> Case:
        return self.finished.case

    @property
    def id(self) -> str:
        return self.case.id

    @property
    def S(self) -> float:
        return self.case.S

    @property
    def scheme(self) -> str:
        return self.case.scheme

    @property
    def policy(self) -> str:
        return self.case.policy

    @property
    def state(self) -> str:
        """Return the state of the liner, such as worn; empty in a campaign of one."""
        return self.case.liner_state.name if self.case.liner_state else ""

    @property
    def variant(self) -> str:
        """Return the policy, with the state of the liner if there are several: `paper-worn`."""
        return f"{self.policy}-{self.state}" if self.state else self.policy

    @property
    def is_physical(self) -> bool:
        return self.case.is_physical

    @property
    def place(self) -> tuple:
        """Return its place in tables: by scheme, policy, state of the liner and S."""
        known = POLICIES.index(self.policy) if self.policy in POLICIES else len(POLICIES)
        return self.scheme, known, self.variant, self.S, self.id

    @cached_property
    def timing(self) -> Timing:
        return self._typed(TIMING, Timing, self.finished.timing)

    @cached_property
    def series(self) -> Series:
        return read_series(self.folder / SERIES, self.case.kind)

    def _typed(self, file: str, kind: type[T], content: object) -> T:
        try:
            return as_typed(kind, content)
        except ValueError as error:
            remedy = f"make it again: {run_line(self.folder)}"
            raise RunFolderError(self.folder / file, str(error), remedy) from None


@dataclass(frozen=True, eq=False)
class SingleBall(Finished):
    """A finished single-ball case."""

    @cached_property
    def result(self) -> SingleBallResult:
        return self._typed(RESULT, SingleBallResult, self.finished.result)

    @property
    def label(self) -> str:
        """Return its name in a legend of scaled mills of one scheme and policy."""
        return f"S = {self.S:.4g}"


@dataclass(frozen=True, eq=False)
class Charge(Finished):
    """A finished multi-ball case: one packing of balls in one scaled mill.

    Attributes:
        campaign: name of its campaign, or of its setting in a parameter study.
    """

    campaign: str

    @cached_property
    def result(self) -> ChargeResult:
        return self._typed(RESULT, ChargeResult, self.finished.result)

    @cached_property
    def settled(self) -> Settled:
        try:
            content = read_json(self.folder / SETTLED, run_line(self.folder))
            return as_typed(Settled, content)
        except ValueError:
            return Settled()

    @property
    def key(self) -> tuple[str, str]:
        """Return campaign and id."""
        return self.campaign, self.id

    @property
    def seed(self) -> int:
        return self.case.seed

    @property
    def stiffness(self) -> str:
        """Return fixed or overlap-matched."""
        return self.case.material.stiffness

    @property
    def balls(self) -> int:
        return self.case.ball.count

    @property
    def mass(self) -> float:
        """Return the mass of the balls [kg]."""
        return self.case.ball.mass_kg * self.balls

    @property
    def balls_per_length_scaled(self) -> float:
        """Return N S^2 / L [1/m]: the same in all scaled mills that are filled alike."""
        return self.balls * self.S**2 / self.case.mill.simulated_length_m

    @property
    def steady_from(self) -> float:
        """Return the mill angle at which the window of the means begins [rad]."""
        return self.result.mean_from_rad

    @property
    def label(self) -> str:
        """Return its name in a legend of scaled mills of one scheme."""
        words = [f"S = {self.S:.4g}"]
        if self.stiffness != "fixed":
            words.append("E matched")
        if self.policy != "paper":
            k = self.case.friction_exponent
            words.append(self.policy + (f", k = {k:g}" if k else ""))
        if self.state:
            words.append(self.state)
        return ", ".join(words)

    def has(self, column: str) -> bool:
        """Return whether the series has a column, and has numbers in it: a plain drum has no box
        and writes nan."""
        return column in self.series and bool(np.isfinite(self.series[column]).all())

    def steady_mean(self, column: str) -> float | None:
        """Return the mean of the rows of a column in the window of the means; None without it."""
        if not self.has(column):
            return None
        angle = self.series["mill_angle_rad"]
        inside = (angle >= self.steady_from) & (angle <= self.result.mean_to_rad)
        return float(np.mean(self.series[column][inside]))


def damage(case: SingleBall | Charge) -> str:
    """Return why a JSON file of a case cannot be used; empty if all can."""
    try:
        _ = case.result, case.timing
    except RunFolderError as error:
        return one_line(f"{error.path.name}: {error.cause}; {error.remedy}")
    return ""
