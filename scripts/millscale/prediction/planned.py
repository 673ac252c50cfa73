"""Slices of the scaled mills of a campaign file, at any S: what a run costs, and the campaign file
of several."""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from millscale.analysis.charge.range_of_law import outside_range
from millscale.analysis.charge.steady import lifter_pitch
from millscale.campaign.build import campaign_of
from millscale.campaign.keys import FRICTION_MATCHED
from millscale.campaign.reader import campaign_tree
from millscale.campaign.writer import Tree, toml_text
from millscale.cases.case import cases_of
from millscale.cases.cost import BUILT_IN, Rates, run_time
from millscale.errors import CampaignError
from millscale.runs.case_file import Case
from millscale.runs.digests import json_digest

# Shorter slices are in error by their ends (docs/results/slice-length.json).
SLICE_DIAMETERS = 4.0
# Steady from about 7 rad on in the mills that were tried; the rest is for the means [rad].
SPIN_UP_RAD, ROTATION_RAD = 7.0, 12.0
# Mills to run: S, and the seeds of each.
Mills: TypeAlias = Sequence[tuple[float, Sequence[int]]]


@dataclass(frozen=True)
class RunSize:
    """What decides the noise of a run besides the mill.

    Attributes:
        diameters: length of the slice in ball diameters.
        rotation_rad: mill rotation [rad].
    """

    diameters: float = SLICE_DIAMETERS
    rotation_rad: float = ROTATION_RAD

    @property
    def window_rad(self) -> float:
        """Return the part of the rotation that is for the means."""
        return max(self.rotation_rad - SPIN_UP_RAD, 1.0)


@dataclass(frozen=True)
class PlannedRun:
    """A run that could be made.

    Attributes:
        balls: in the slice.
        window_rad: mill rotation over which its means are taken.
        pitches: lifter pitches in it.
        cost_s: on one core, settling included [s].
    """

    S: float
    balls: int
    window_rad: float
    pitches: float
    cost_s: float


class PlannedMills:
    """The charge of a campaign file at other values of S: slices that are filled alike.

    Scheme and policy are the first of the campaign. Policy friction-matched is refused: its errors
    follow no law, so intervals of its mills do not hold.

    Attributes:
        ball_over_mill: a / R of the physical mill.
        case: the first case of the campaign.
        is_precision_chosen: whether the precision is not the campaign's.
        least_rotation_rad: the campaign's rotation, or `ROTATION_RAD` if that is longer.
        digest: of the content of the file.
    """

    def __init__(self, path: Path, rates: Rates = BUILT_IN) -> None:
        base = campaign_tree(path)
        if "multi_ball" not in base:
            raise CampaignError(path, "multi_ball", "missing", "a charge, [multi_ball]")
        self.path, self.rates = path, rates
        self._base = deepcopy({name: base[name] for name in base if name != "single_ball"})
        self.is_precision_chosen = _choose_precision(self._base)
        self.case = case = _charges(path, self._base)[0]
        if case.mill.ends != "periodic":
            cause = f'got "{case.mill.ends}": the planned mills are slices, which do not keep L / R'
            raise CampaignError(path, "mill.ends", cause, "no such key")
        if case.policy == FRICTION_MATCHED:
            raise CampaignError(
                path,
                "scaling.policies",
                f"{FRICTION_MATCHED} comes first, whose errors change sign with S, so that no "
                "interval holds (docs/results/coverage.md)",
                "another policy first, such as paper",
            )
        self.ball_over_mill = case.physical.ball_radius_m / case.physical.radius_m
        self.least_rotation_rad = max(ROTATION_RAD, case.time.rotation_angle_rad)
        self.digest = json_digest(base)
        # N S^3 in the whole length of each mill is the same where all are filled alike.
        whole = case.ball.count * case.mill.length_m / case.mill.simulated_length_m
        self._balls_at_1 = whole * case.S**3
        self._cases: dict[tuple[float, float], Case | None] = {}
        self._set_step()

    def run(self, S: float, size: RunSize) -> PlannedRun | None:
        """Return a run of a scaled mill; None if there is no such mill or slice of it, or if it is
        beyond the range of the law."""
        case = self._case(S, size.diameters)
        if case is None:
            return None
        settle, time = case.time.settle_steps, case.time
        steps = round(time.steps * size.rotation_rad / time.rotation_angle_rad)
        cost = run_time(case, steps, 1, self.rates)
        cost += run_time(case, settle, 1, self.rates) if settle else 0.0
        window = size.window_rad
        pitches = window / lifter_pitch(case.mill.lifters)
        return PlannedRun(S, case.ball.count, window, pitches, cost)

    def longest_slice(self, S: float) -> float:
        """Return the length of a scaled mill in ball diameters."""
        return self.case.physical.length_m / S / (2.0 * self.case.physical.ball_radius_m)

    def campaign_text(self, mills: Mills, size: RunSize, name: str, about: str) -> str:
        """Return the campaign file of some runs: of all mills the same seeds, or of all but the
        largest S its first seed alone."""
        tree = self._tree([S for S, _ in mills], size)
        tree = {"campaign": {"name": name, "about": about}, **tree}
        seeds, part = list(mills[-1][1]), tree["multi_ball"]
        part["seeds"] = seeds
        fewer = [S for S, some in mills if list(some) != seeds]
        if fewer:
            part["seeds_from_S"] = min(S for S, some in mills if list(some) == seeds)
        planned = {(S, tuple(some)) for S, some in mills}
        made = {
            (S, tuple(seeds if not fewer or part["seeds_from_S"] <= S else seeds[:1]))
            for S, _ in mills
        }
        if planned != made:
            raise ValueError(f"no campaign holds these seeds: {mills}")
        return toml_text(tree)

    @property
    def is_step_given(self) -> bool:
        return self.case.time.step_choice == "given"

    @property
    def step_s(self) -> float:
        """Return the time step in the physical mill [s]."""
        step = self._base["multi_ball"].get("step_s")
        return step if isinstance(step, float) else self.case.time.step_s

    def _set_step(self) -> None:
        """Give all runs the step of the physical mill, whose impacts are the fastest: predictions
        then compare mills of one step."""
        if self.is_step_given:
            return
        try:
            (physical,) = _charges(self.path, self._tree([1.0], RunSize()))
        except CampaignError:
            return
        self._base["multi_ball"]["step_s"] = physical.time.step_s

    def _case(self, S: float, diameters: float) -> Case | None:
        key = S, diameters
        if key not in self._cases:
            tree = self._tree([S], RunSize(diameters, self.least_rotation_rad))
            try:
                (case,) = _charges(self.path, tree)
            except CampaignError:
                self._cases[key] = None
            else:
                self._cases[key] = None if outside_range(case) else case
        return self._cases[key]

    def _tree(self, ratios: Sequence[float], size: RunSize) -> Tree:
        tree = deepcopy(self._base)
        tree.pop("campaign", None)
        part, scaling = tree["multi_ball"], tree.setdefault("scaling", {})
        dropped = ("S", "scaled_radius_m", "slice_length_m", "schemes", "policies")
        for section in (part, scaling):
            for key in dropped:
                section.pop(key, None)
        scaling["S"] = list(ratios)
        scaling["schemes"] = [self.case.scheme]
        scaling["policies"] = [self.case.policy]
        scaling.pop("friction_exponent", None)
        if "filling" not in part:
            part["count"] = [max(1, round(self._balls_at_1 / S**3)) for S in ratios]
        part["slice_diameters"] = size.diameters
        for key in ("revolutions", "rotation_s", "seeds_from_S"):
            part.pop(key, None)
        part["rotation_angle_rad"] = size.rotation_rad
        part["seeds"] = [1]
        return tree


def _choose_precision(tree: Tree) -> bool:
    """Choose mixed precision where the campaign states none; return whether it was chosen."""
    model = tree.setdefault("model", {})
    if "precision" in model or model.get("contacts") == "stock":
        return False
    model["precision"] = "mixed"
    return True


def _charges(path: Path, tree: Tree) -> list[Case]:
    return [case for case in cases_of(campaign_of(path, tree)) if case.kind == "multi-ball"]
