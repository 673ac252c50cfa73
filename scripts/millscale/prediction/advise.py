"""Which scaled mills to run for a wanted error of the physical mill, and what they cost.

Designs are compared by the cost model of `cases.cost` and the errors of `error_model`: two scaled
mills extrapolated, the physical mill itself as a slice, and, for comparison, one scaled mill alone.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from scipy.special import stdtrit

from millscale.errors import PredictionError, nearest
from millscale.formats import duration
from millscale.prediction.error_model import (
    ErrorModel,
    ObservableError,
    expected_half_width,
    nearest_model,
    planned_noise,
)
from millscale.prediction.extrapolation import ExtrapolationError
from millscale.prediction.planned import (
    SLICE_DIAMETERS,
    SPIN_UP_RAD,
    PlannedMills,
    PlannedRun,
    RunSize,
)
from millscale.prediction.text import aligned, html_table

# Up to the largest S whose extrapolation was compared with S = 1.
RATIOS = tuple(round(1.1 + 0.1 * i, 1) for i in range(21))
# Values of S nearer together than this only add noise.
LEAST_SPREAD = 1.3
MOST_SEEDS = 4
# Lengths of slices and rotations that are compared, over the shortest.
LONGER = (1.0, 2.0, 4.0)
# Half width of an interval that is good for nothing, but is one.
_ANY = 1e9
# Observables that a plan is for if none is named.
USUAL = ("power", "toe_angle_rad", "solid_fraction")
# Endings of names that may be left out.
ENDINGS = ("_angle_rad",)


@dataclass(frozen=True)
class Design:
    """Runs to make, and what they give.

    Attributes:
        mills: (S, seeds) of each.
        cost_s: of all runs on one core [s].
        half_widths: expected relative half width of the interval, by observable; of one scaled
            mill its error as well.
    """

    mills: tuple[tuple[float, int], ...]
    size: RunSize
    cost_s: float
    half_widths: Mapping[str, float]

    @property
    def worst(self) -> float:
        return max(self.half_widths.values())

    @property
    def name(self) -> str:
        if self.mills[0][0] == 1.0:
            return "slice of the physical mill"
        return "two scaled mills, extrapolated" if self.has_interval else "one scaled mill"

    @property
    def has_interval(self) -> bool:
        """Return whether the runs themselves give an interval: the error of one scaled mill is
        only known from another physical mill."""
        return len(self.mills) > 1 or self.mills[0][0] == 1.0

    @property
    def runs(self) -> str:
        return ", ".join(
            f"S = {S:g}" + (f", {seeds} seeds" if seeds > 1 else "") for S, seeds in self.mills
        )


@dataclass(frozen=True, repr=False)
class Advice:
    """The chosen design, the others it was compared with, and its campaign file.

    A prompt shows it as text, a notebook as a table.

    Attributes:
        error: wanted, relative; angles as a share of a radian.
        met: whether the chosen design reaches it within the budget.
        cheapest: the cheapest design of each kind that reaches the error, or the most accurate.
        reasons: choices and why, (choice, reason) each.
        origin: of the expected errors.
    """

    chosen: Design
    cheapest: tuple[Design, ...]
    error: float
    budget_s: float | None
    met: bool
    text: str
    reasons: tuple[tuple[str, str], ...]
    origin: Mapping[str, Any]

    def __repr__(self) -> str:
        return "\n".join([self.title, *aligned([self.headings, *self.rows()]), *self.notes()])

    def _repr_html_(self) -> str:
        """Return the designs and the reasons as the HTML that notebooks show."""
        return html_table(self.title, self.headings, self.rows(), list(self.notes()))

    @property
    def title(self) -> str:
        return f"Runs for an error of {100.0 * self.error:g} %"

    @property
    def headings(self) -> tuple[str, ...]:
        return ("", "runs", "slice", "rotation", "time on one core", *self.chosen.half_widths)

    def rows(self) -> list[tuple[str, ...]]:
        """Return the chosen design, then the best of each kind, as text."""
        found = []
        for kind, design in [("chosen", self.chosen), *((x.name, x) for x in self.cheapest)]:
            size = f"{design.size.diameters:g} d", f"{design.size.rotation_rad:g} rad"
            widths = [f"{100.0 * design.half_widths[name]:.2f} %" for name in self.headings[5:]]
            found.append((kind, design.runs, *size, duration(design.cost_s), *widths))
        return found

    def notes(self) -> Iterator[str]:
        """Yield whether the error is reached, why each choice was made, where the expected errors
        come from."""
        if not self.met:
            reached = f"{100.0 * self.chosen.worst:.2g} %"
            within = f" in {duration(self.budget_s)}" if self.budget_s else ""
            able = [x for x in self.cheapest if x.worst <= self.error and x.has_interval]
            cheapest = min(able, key=lambda design: design.cost_s, default=None)
            needs = (
                f"it takes {duration(cheapest.cost_s)}: {cheapest.runs}"
                if cheapest
                else "no design that was compared reaches it"
            )
            yield f"not reached{within}: the chosen runs give {reached}; {needs}"
        yield (
            "columns: expected half width of the 95 % interval; of one scaled mill its error as "
            "well, so it is never chosen; d: ball diameters"
        )
        for choice, reason in self.reasons:
            yield f"  {choice}: {reason}"
        yield f"errors learnt from: {origin_text(self.origin)}"


def origin_text(origin: Mapping[str, Any]) -> str:
    """Return command and date of the runs that errors were learnt from."""
    return ", ".join(str(origin[key]) for key in ("command", "date") if key in origin)


def advise(
    path: Path,
    error: float,
    models: Sequence[ErrorModel],
    observables: Sequence[str] = (),
    budget_s: float | None = None,
    level: float = 0.95,
) -> Advice:
    """Return the cheapest runs that give observables of the physical mill within an error.

    Args:
        path: a campaign file with the physical mill and a [multi_ball] part.
        error: relative half width of the interval wanted.
        models: errors of the mills that are known.
        observables: as for `names_of`.
        budget_s: most time on one core [s].

    Raises:
        CampaignError: the campaign is not accepted.
        PredictionError: an observable is not known, or no scaled mill can be run.
    """
    mills = PlannedMills(path)
    own = nearest_model(models, mills.ball_over_mill, mills.case.scheme, mills.case.policy)
    return advise_mills(mills, own, names_of(observables, own), error, budget_s, level)


def advise_mills(
    mills: PlannedMills,
    model: ErrorModel,
    names: Sequence[str],
    error: float,
    budget_s: float | None = None,
    level: float = 0.95,
) -> Advice:
    """Return `advise` for the mills of a campaign file.

    Args:
        model: errors of this mill.
        names: of `names_of`.

    Raises:
        PredictionError: no scaled mill can be run.
    """
    known = {row.name: row for row in model.observables}
    search = _Search(mills, model, [known[name] for name in names], level)
    best = [found for kind in search.kinds if (found := search.best(kind, error))]
    if not best:
        raise PredictionError(
            f"{mills.path}: no scaled mill between S = 1 and {RATIOS[-1]:g} can be run"
        )
    affordable = [
        found
        for kind in search.kinds
        if (found := search.best(kind, error, budget_s)) and found.has_interval
    ]
    # Where the budget is too small for any interval: the cheapest runs that give one.
    anything = [found for kind in search.kinds if (found := search.best(kind, _ANY))]
    least = min(anything, key=lambda x: (not x.has_interval, x.cost_s))
    chosen, met = _choice(affordable or [least], error)
    met = met and bool(affordable)
    return Advice(
        chosen=chosen,
        cheapest=tuple(best),
        error=error,
        budget_s=budget_s,
        met=met,
        text=mills.campaign_text(
            [(S, range(1, seeds + 1)) for S, seeds in chosen.mills],
            chosen.size,
            "advised",
            "planned by millscale advise",
        ),
        reasons=tuple(reasons_of(mills, chosen, met)),
        origin=dict(model.origin),
    )


def names_of(texts: Iterable[str], model: ErrorModel) -> list[str]:
    """Return names of observables whose errors are known.

    Args:
        texts: names, separated by commas; `_angle_rad` may be left out; empty for `USUAL`.

    Raises:
        PredictionError: a name is not known.
    """
    known = [row.name for row in model.observables]
    short = {name.removesuffix(ending): name for name in known for ending in ENDINGS}
    wanted = [name.strip() for text in texts for name in text.split(",")]
    for name in wanted:
        if name not in short and name not in known:
            near = nearest(name, [*short, *known])
            hint = f', nearest is "{near}"' if near else ""
            raise PredictionError(
                f'--observable: got "{name}"{hint}; accepted, as their errors are known: '
                f"{', '.join(short)}"
            )
    found = [short.get(name, name) for name in wanted] or [x for x in USUAL if x in known]
    return list(dict.fromkeys(found))


def reasons_of(mills: PlannedMills, design: Design, met: bool) -> Iterator[tuple[str, str]]:
    """Yield the choices of a design and why each was made."""
    worst = max(design.half_widths, key=design.half_widths.__getitem__)
    size, time = design.size, mills.case.time
    if design.name == "slice of the physical mill":
        yield "S = 1", "a slice of the physical mill itself costs less than scaled mills as good"
    else:
        near, far = design.mills[0][0], design.mills[-1][0]
        which = "cheapest pair within the error" if met else "most accurate pair"
        yield (
            f"S = {near:g} and {far:g}",
            f"the {which}; {worst}, {100 * design.worst:.2g} %, decides; the nearer mill is for "
            "the value, the farther one for the slope",
        )
    seeds = max(count for _, count in design.mills)
    yield (
        f"{seeds} seed{'s' if seeds > 1 else ''}",
        "the noise of a run is small beside the unknown exponent"
        if seeds == 1
        else "fewer leave the noise of a run too large or unknown",
    )
    yield (
        f"slice of {size.diameters:g} ball diameters",
        "shorter ones are in error by their ends"
        + ("" if size.diameters == SLICE_DIAMETERS else "; with more balls the noise is smaller"),
    )
    yield (
        f"rotation of {size.rotation_rad:g} rad",
        f"the charge is steady from about {SPIN_UP_RAD:g} rad on; the rest is for the means",
    )
    step = f"time step of {mills.step_s:.3g} s"
    yield step, "given in the campaign" if mills.is_step_given else time.step_choice
    yield (
        f"precision {mills.case.deck.precision}",
        "single precision where no error adds up; faster"
        if mills.is_precision_chosen
        else "given in the campaign",
    )


def _choice(designs: Sequence[Design], error: float) -> tuple[Design, bool]:
    """Return the cheapest design within the error, or the most accurate one."""
    within = [design for design in designs if design.worst <= error]
    if within:
        return min(within, key=lambda design: design.cost_s), True
    return min(designs, key=lambda design: (design.worst, design.cost_s)), False


@dataclass(frozen=True)
class _Option:
    """Runs of a design whose half widths are not yet known."""

    mills: tuple[tuple[float, int], ...]
    size: RunSize
    runs: tuple[PlannedRun, ...]

    @property
    def cost_s(self) -> float:
        return math.fsum(run.cost_s for run in self.runs)


class _Search:
    """All designs of a campaign's mills, evaluated as far as a question needs."""

    def __init__(
        self,
        mills: PlannedMills,
        model: ErrorModel,
        wanted: Sequence[ObservableError],
        level: float,
    ) -> None:
        self._mills, self._model, self._level = mills, model, level
        self._order, self._wanted = tuple(wanted), list(wanted)
        self._known: dict[tuple[str, _Option], float] = {}
        shortest = mills.least_rotation_rad
        self._sizes = [
            RunSize(SLICE_DIAMETERS * longer, shortest + (more - 1.0) * RunSize().window_rad)
            for longer in LONGER
            for more in LONGER
        ]
        ratios = [S for S in (1.0, *RATIOS) if mills.run(S, RunSize()) is not None]
        counts = range(1, MOST_SEEDS + 1)
        pairs = [
            ((near, 1), (far, count))
            for near, far in itertools.combinations(ratios, 2)
            if far >= LEAST_SPREAD * near
            for count in counts
        ]
        alone = [((S, count),) for S in ratios for count in counts]
        # Of each kind of design the options, cheapest first.
        self.kinds = [
            self._options(x for x in pairs if x[0][0] > 1.0),
            # A scaled mill beside S = 1 shows the noise of a run.
            self._options(x for x in [*alone, *pairs] if x[0][0] == 1.0),
            self._options(x for x in alone if x[0][0] > 1.0),
        ]

    def _options(self, all_mills: Iterable[tuple[tuple[float, int], ...]]) -> list[_Option]:
        found = []
        for mills, size in itertools.product(all_mills, self._sizes):
            runs = [self._mills.run(S, size) for S, n in mills for _ in range(n)]
            known = tuple(run for run in runs if run is not None)
            if len(known) == len(runs):
                found.append(_Option(mills, size, known))
        return sorted(found, key=lambda option: option.cost_s)

    def best(
        self, options: Sequence[_Option], error: float, budget_s: float | None = None
    ) -> Design | None:
        """Return the cheapest design within an error and a budget; if there is none, the most
        accurate one within the budget; None if nothing is."""
        within = [x for x in options if budget_s is None or x.cost_s <= budget_s]
        # Half widths grow with the noise: if the dearest option of the same S is not within the
        # error, no cheaper one is.
        dearest = {tuple(S for S, _ in option.mills): option for option in within}
        hopeful = {ratios for ratios, option in dearest.items() if self._reaches(option, error)}
        for option in within:
            if tuple(S for S, _ in option.mills) in hopeful and self._reaches(option, error):
                return self._design(option)
        designs = map(self._design, dearest.values())
        known = [design for design in designs if math.isfinite(design.worst)]
        return min(known, key=lambda design: (design.worst, design.cost_s), default=None)

    def _reaches(self, option: _Option, error: float) -> bool:
        for wanted in self._wanted:
            if self._half_width(wanted, option) > error:
                # Likely to fail for the next option as well.
                self._wanted.remove(wanted)
                self._wanted.insert(0, wanted)
                return False
        return True

    def _design(self, option: _Option) -> Design:
        widths = {x.name: self._half_width(x, option) for x in self._order}
        return Design(option.mills, option.size, option.cost_s, widths)

    def _half_width(self, error: ObservableError, option: _Option) -> float:
        """Return the expected half width; infinity if the runs allow no interval."""
        key = error.name, option
        if key not in self._known:
            try:
                self._known[key] = self._expected(error, option)
            except ExtrapolationError:
                self._known[key] = math.inf
        return self._known[key]

    def _expected(self, error: ObservableError, option: _Option) -> float:
        if len(option.mills) > 1:
            return expected_half_width(error, self._model, option.runs, self._level)
        noise = planned_noise(error, self._model, option.runs)
        factor = float(stdtrit(noise.freedom, 0.5 * (1.0 + self._level)))
        bias = abs(error.bias(option.mills[0][0]))
        return bias + factor * noise.deviation / math.sqrt(len(option.runs))
