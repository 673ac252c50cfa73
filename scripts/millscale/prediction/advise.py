"""Which scaled mills to run for a wanted error of the physical mill, and what they cost.

Designs are compared by the cost model of `cases.cost` and the errors of `error_model`: one scaled
mill alone, two scaled mills extrapolated, and the physical mill itself as a slice.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scipy.special import stdtrit

from millscale.campaign.build import campaign_of
from millscale.campaign.keys import FRICTION_MATCHED
from millscale.campaign.reader import parse_toml
from millscale.campaign.writer import Tree, toml_text
from millscale.cases.case import cases_of
from millscale.cases.cost import wall_time
from millscale.errors import CampaignError, PredictionError, nearest
from millscale.prediction.error_model import (
    ErrorModel,
    ObservableError,
    expected_half_width,
    planned_noise,
)
from millscale.prediction.extrapolation import ExtrapolationError
from millscale.prediction.observables import OBSERVABLES
from millscale.runs.case_file import Case

# Shorter slices are in error by their ends, longer ones cost more (docs/results/slice-length.json).
SLICE_DIAMETERS = 4.0
# Steady from about 7 rad on in the mills that were tried; the rest is for the means [rad].
ROTATION_RAD = 12.0
# Up to the largest S whose extrapolation was compared with S = 1.
RATIOS = tuple(round(1.1 + 0.1 * i, 1) for i in range(21))
# Values of S nearer together than this only add noise.
LEAST_SPREAD = 1.3
SEEDS = (1, 2, 3)
# Observables that a plan is for if none is named.
USUAL = ("power", "toe_angle_rad", "solid_fraction")


@dataclass(frozen=True)
class Design:
    """Runs to make, and what they give.

    Attributes:
        mills: (S, seeds) of each.
        cost_s: of all runs on one core [s].
        half_widths: expected relative half width of the interval, or error, by observable.
    """

    mills: tuple[tuple[float, int], ...]
    cost_s: float
    half_widths: Mapping[str, float]

    @property
    def worst(self) -> float:
        return max(self.half_widths.values())

    @property
    def name(self) -> str:
        if self.mills[0][0] == 1.0:
            return "slice of the physical mill"
        return "one scaled mill" if len(self.mills) == 1 else "two scaled mills, extrapolated"

    @property
    def runs(self) -> str:
        return ", ".join(
            f"S = {S:g}" + (f", {seeds} seeds" if seeds > 1 else "") for S, seeds in self.mills
        )


@dataclass(frozen=True)
class Advice:
    """The chosen design, the others it was compared with, and its campaign file.

    Attributes:
        error: wanted, relative; angles as a share of a radian.
        met: whether the chosen design reaches it within the budget.
        cheapest: the cheapest design of each kind that reaches the error, or the most accurate.
    """

    chosen: Design
    cheapest: tuple[Design, ...]
    error: float
    budget_s: float | None
    met: bool
    text: str
    origin: Mapping[str, Any]


def advise(
    path: Path,
    error: float,
    errors: ErrorModel,
    observables: Sequence[str] = (),
    budget_s: float | None = None,
    level: float = 0.95,
) -> Advice:
    """Return the cheapest runs that give observables of the physical mill within an error.

    Args:
        path: a campaign file with the physical mill and a [multi_ball] part.
        error: relative half width of the interval wanted.
        observables: names of `observables.OBSERVABLES`; `USUAL` by default.
        budget_s: most time on one core [s].

    Raises:
        CampaignError: the campaign is not accepted.
        PredictionError: an observable is not known, or no scaled mill can be run.
    """
    base = parse_toml(path)
    scenes = _Scenes(path, base)
    own = errors.of_mill(scenes.ball_over_mill)
    wanted = _wanted(own, observables)
    designs = list(_designs(scenes, wanted, level))
    if not designs:
        raise PredictionError(f"{path}: no scaled mill between S = 1 and {RATIOS[-1]:g} can be run")
    affordable = [x for x in designs if budget_s is None or x.cost_s <= budget_s]
    chosen, met = _choice(affordable or [min(designs, key=lambda x: x.cost_s)], error)
    met = met and bool(affordable)
    kinds: dict[str, list[Design]] = {}
    for design in designs:
        kinds.setdefault(design.name, []).append(design)
    best = tuple(_choice(found, error)[0] for found in kinds.values())
    return Advice(
        chosen, best, error, budget_s, met, scenes.campaign_text(chosen), dict(errors.origin)
    )


def _choice(designs: Sequence[Design], error: float) -> tuple[Design, bool]:
    """Return the cheapest design within the error, or the most accurate one."""
    within = [design for design in designs if design.worst <= error]
    if within:
        return min(within, key=lambda design: design.cost_s), True
    return min(designs, key=lambda design: (design.worst, design.cost_s)), False


def _wanted(errors: ErrorModel, names: Sequence[str]) -> list[ObservableError]:
    known = {row.name: row for row in errors.observables}
    for name in names:
        if name not in known:
            near = nearest(name, known)
            hint = f", nearest is {near}" if near else ""
            raise PredictionError(
                f"observable {name}{hint}; accepted: {', '.join(known)} "
                f"(of {', '.join(row.name for row in OBSERVABLES)}, those whose errors are known)"
            )
    return [known[name] for name in names or [x for x in USUAL if x in known]]


def _designs(scenes: _Scenes, wanted: Sequence[ObservableError], level: float) -> Iterator[Design]:
    costs = {S: cost for S in (1.0, *RATIOS) if (cost := scenes.cost(S)) is not None}
    if 1.0 in costs:
        yield from _alone(1.0, costs[1.0], wanted, level)
    for S in RATIOS:
        if S in costs:
            yield from _alone(S, costs[S], wanted, level)
    for near, far in itertools.combinations(sorted(S for S in costs if S > 1.0), 2):
        if far < LEAST_SPREAD * near:
            continue
        # The campaign file gives the smaller S, which costs more, the first seed alone.
        for seeds in SEEDS:
            mills = ((near, 1), (far, seeds))
            try:
                widths = {x.name: expected_half_width(x, mills, level) for x in wanted}
            except ExtrapolationError:
                continue
            yield Design(mills, costs[near] + seeds * costs[far], widths)


def _alone(
    S: float, cost: float, wanted: Sequence[ObservableError], level: float
) -> Iterator[Design]:
    """Yield the designs of one mill; a scaled one counts with its whole error."""
    for seeds in SEEDS:
        mills = ((S, seeds),)
        widths = {}
        for error in wanted:
            try:
                noise = planned_noise(error, mills)
            except ExtrapolationError:
                break
            factor = float(stdtrit(noise.freedom, 0.5 * (1.0 + level)))
            widths[error.name] = abs(error.bias(S)) + factor * noise.deviation / math.sqrt(seeds)
        else:
            yield Design(mills, seeds * cost, widths)


class _Scenes:
    """The campaign of a file at other values of S: slices of equal filling."""

    def __init__(self, path: Path, base: Tree) -> None:
        self._path = path
        if "multi_ball" not in base:
            raise CampaignError(path, "multi_ball", "missing", "a charge, [multi_ball]")
        first = _charges(path, {name: c for name, c in base.items() if name != "single_ball"})[0]
        self._base, self._first = base, first
        self.ball_over_mill = first.physical.ball_radius_m / first.physical.radius_m
        # N S^3 in the whole length of each mill is the same where all are filled alike.
        whole = first.ball.count * first.mill.length_m / first.mill.simulated_length_m
        self._balls_at_1 = whole * first.S**3

    def cost(self, S: float) -> float | None:
        """Return the time of one run on one core [s]; None if such a mill cannot be run."""
        try:
            (case,) = _charges(self._path, self._tree(((S, 1),)))
        except CampaignError:
            return None
        return wall_time(case, 1)

    def campaign_text(self, design: Design) -> str:
        """Return the campaign file of a design."""
        return toml_text(self._tree(design.mills))

    def _tree(self, mills: Sequence[tuple[float, int]]) -> Tree:
        tree = {name: dict(content) for name, content in self._base.items()}
        tree.pop("single_ball", None)
        tree["campaign"] = {
            "name": "advised",
            "about": "planned by millscale advise",
        }
        part, scaling = tree["multi_ball"], tree.setdefault("scaling", {})
        dropped = ("S", "scaled_radius_m", "slice_length_m", "schemes", "policies")
        for section in (part, scaling):
            for key in dropped:
                section.pop(key, None)
        scaling["S"] = [S for S, _ in mills]
        scaling["schemes"] = [self._first.scheme]
        scaling["policies"] = [self._first.policy]
        if self._first.policy != FRICTION_MATCHED:
            scaling.pop("friction_exponent", None)
        if "filling" not in part:
            part["count"] = [max(1, round(self._balls_at_1 / S**3)) for S, _ in mills]
        part["slice_diameters"] = SLICE_DIAMETERS
        for key in ("revolutions", "rotation_s"):
            part.pop(key, None)
        part["rotation_angle_rad"] = max(ROTATION_RAD, self._first.time.rotation_angle_rad)
        part["seeds"] = list(range(1, max(seeds for _, seeds in mills) + 1))
        part.pop("seeds_from_S", None)
        if len(part["seeds"]) > 1:
            part["seeds_from_S"] = mills[-1][0]
        return tree


def _charges(path: Path, tree: Tree) -> list[Case]:
    return [case for case in cases_of(campaign_of(path, tree)) if case.kind == "multi-ball"]
