"""Run scaled mills until the physical mill is known within a wanted error: which run comes next.

Sequential design. The first round has the fewest runs of the cheapest plan (`advise`) that give an
interval. Each further round is one run: another seed of an S that is there, another S, nearer or
farther, or a slice of S = 1. A candidate is judged by the extrapolation itself, evaluated on the
values found so far and the value that the fitted law gives for the candidate.

- If one or two further runs are expected to reach the error, the cheapest such set is begun.
- Otherwise the run that narrows the widest interval most per second is made.
- Charges that are not steady are repeated with a longer rotation.

The loop ends when every interval is narrow enough, when no helpful run fits the budget, or when no
run helps.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Protocol

from millscale.formats import duration
from millscale.prediction.advise import LEAST_SPREAD, RATIOS, Design
from millscale.prediction.error_model import (
    EXPONENT,
    ErrorModel,
    learnt_deviation,
    planned_freedom,
    prior_of,
)
from millscale.prediction.extrapolation import (
    SAME_S,
    ExtrapolationError,
    Group,
    Noise,
    extrapolate,
    scale_function,
)
from millscale.prediction.planned import PlannedRun, RunSize

# A run is expected to be the last one if it brings the half width below this share of the error.
AIM = 0.95
# Runs that narrow the widest interval by less than this share do not help.
LEAST_GAIN = 0.01
# An observable that is refused after so many rounds in a row is given up.
MOST_REFUSED = 4
# Rotation of a repeated charge over that of the one that was not steady, and the longest rotation
# over the first.
LONGER_ROTATION, LONGEST_ROTATION = 1.5, 2.3

MET, BUDGET, NOTHING_HELPS, UNSTEADY = "met", "budget spent", "nothing helps", "not steady"


@dataclass(frozen=True)
class Ask:
    """What is wanted.

    Attributes:
        names: of observables.
        error: half width of each interval, relative; of angles in rad, of the contour over R - a.
        budget_s: of all runs on one core [s].
        level: probability of the intervals.
    """

    names: tuple[str, ...]
    error: float
    budget_s: float | None = None
    level: float = 0.95


@dataclass(frozen=True)
class Round:
    """Runs that are made together, and what was known after them.

    Attributes:
        mills: S, and the seeds of each.
        cost_s: predicted, on one core [s].
        why: the reason for these runs, for people.
        expected: widest half width that was expected of it, relative; None if unknown.
        done: whether its runs are finished.
        spent_s: of all runs up to this round, measured, on one core [s].
        half_widths: relative, after this round, by observable; None without an interval.
    """

    number: int
    mills: tuple[tuple[float, tuple[int, ...]], ...]
    size: RunSize
    cost_s: float
    why: str
    expected: float | None = None
    done: bool = False
    spent_s: float | None = None
    half_widths: dict[str, float | None] = field(default_factory=dict)

    @property
    def runs(self) -> list[tuple[float, int]]:
        """Return (S, seed) of each run."""
        return [(S, seed) for S, seeds in self.mills for seed in seeds]

    @property
    def text(self) -> str:
        """Return its runs in words."""
        return ", ".join(
            f"S = {S:g} seed{'s' if len(seeds) > 1 else ''} {', '.join(map(str, seeds))}"
            for S, seeds in self.mills
        )


@dataclass(frozen=True)
class Track:
    """One observable as far as it is known, relative to what its error is relative to.

    Attributes:
        groups: values by S.
        noise: of one run; None if unknown.
        half_width: of the interval; None without one.
        exponent: of the error.
        refused: why there is no interval.
        is_broken: whether that is because its values do not follow the law of the error.
    """

    name: str
    groups: tuple[Group, ...]
    noise: Noise | None = None
    half_width: float | None = None
    exponent: float = EXPONENT
    refused: str = ""
    is_broken: bool = False


@dataclass(frozen=True)
class Look:
    """What the finished runs give.

    Attributes:
        tracks: by observable.
        used: (S, seed) of the steady runs.
        unsteady: why the others are not used, by (S, seed).
        spent_s: of all runs on one core [s].
    """

    tracks: Mapping[str, Track]
    used: frozenset[tuple[float, int]]
    unsteady: Mapping[tuple[float, int], str]
    spent_s: float

    def half_width(self, name: str) -> float:
        """Return the relative half width of an observable; infinity without an interval."""
        track = self.tracks.get(name)
        return math.inf if track is None or track.half_width is None else track.half_width

    def widest(self, names: Sequence[str]) -> float:
        """Return the widest half width."""
        return max(self.half_width(name) for name in names)


NOTHING = Look({}, frozenset(), {}, 0.0)


class Runner(Protocol):
    """Makes runs and looks at what they gave."""

    def planned(self, S: float, size: RunSize) -> PlannedRun | None:
        """Return a run that could be made; None if it cannot."""

    def run(self, asked: Round) -> None:
        """Make the runs of a round.

        Raises:
            EngineError: a run failed.
        """

    def look(self, finished: Sequence[Round]) -> Look:
        """Return what the finished runs give."""


@dataclass(frozen=True)
class Outcome:
    """Why no further run is made.

    Attributes:
        kind: met, budget spent, nothing helps, not steady.
        text: one line for people.
    """

    kind: str
    text: str


@dataclass(frozen=True)
class Solver:
    """The loop and its decisions.

    Attributes:
        model: errors of this mill, for what its own runs do not yet show.
        design: returns the plan to begin with, and whether it fits the budget; called once.
        save: keeps the rounds, so that the same call resumes.
        tell: reports a round that is about to run, and what is known.
    """

    ask: Ask
    runner: Runner
    model: ErrorModel
    design: Callable[[], Design]
    save: Callable[[Sequence[Round]], None]
    tell: Callable[[Round, Look], None]

    def solve(self, rounds: Sequence[Round] = ()) -> tuple[list[Round], Look, Outcome]:
        """Make runs until a stop rule holds; return all rounds, what they give, and why it ended.

        Args:
            rounds: of an earlier call, whose decisions are kept.
        """
        rounds = list(rounds)
        while True:
            rounds, look, following = self.following(rounds)
            if isinstance(following, Outcome):
                return rounds, look, following
            if following.number > len(rounds):
                rounds.append(following)
                self.save(rounds)
            self.tell(following, look)
            self.runner.run(following)
            rounds[-1] = replace(following, done=True)
            self.save(rounds)

    def following(self, rounds: Sequence[Round]) -> tuple[list[Round], Look, Round | Outcome]:
        """Return the rounds with what is known after the last one that is done, and what follows:
        a round, which may have been begun, or the end."""
        rounds = list(rounds)
        finished = [x for x in rounds if x.done]
        look = self.runner.look(finished) if finished else NOTHING
        if finished and finished[-1].spent_s is None:
            widths = {name: track.half_width for name, track in look.tracks.items()}
            last = finished[-1].number - 1
            rounds[last] = replace(finished[-1], spent_s=look.spent_s, half_widths=widths)
            self.save(rounds)
        if look.widest(self.ask.names) <= self.ask.error:
            return (
                rounds,
                look,
                Outcome(MET, f"every interval is within {_percent(self.ask.error)}"),
            )
        begun = next((x for x in rounds if not x.done), None)
        return rounds, look, begun or self._next(rounds, look)

    def _next(self, rounds: Sequence[Round], look: Look) -> Round | Outcome:
        if not rounds:
            return self._first()
        for name in self.ask.names:
            if why := self._is_lost(name, rounds, look):
                return Outcome(NOTHING_HELPS, f"{name}: {why}")
        size = rounds[-1].size
        repeated = [run for run in look.unsteady if run not in look.used]
        at_this_size = [run for x in rounds if x.size == size for run in x.runs]
        unknown = math.isinf(look.widest(self.ask.names))
        if any(run in repeated for run in at_this_size):
            rotation = LONGER_ROTATION * size.rotation_rad
            if rotation <= LONGEST_ROTATION * rounds[0].size.rotation_rad:
                size = replace(size, rotation_rad=rotation)
            elif unknown:
                S, seed = next(run for run in at_this_size if run in repeated)
                return Outcome(
                    UNSTEADY,
                    f"S = {S:g}, seed {seed}, is not steady after {size.rotation_rad:g} rad: "
                    f"{look.unsteady[S, seed]}",
                )
        if repeated and unknown:
            return self._repeat(rounds, repeated, look, size)
        return _Candidates(self, look, size, len(rounds) + 1).best()

    def _is_lost(self, name: str, rounds: Sequence[Round], look: Look) -> str:
        """Return why no run will give an interval of an observable; empty if one may."""
        track = look.tracks.get(name)
        if track is None or track.half_width is not None:
            return ""
        last = rounds[-MOST_REFUSED:]
        refused = len(last) == MOST_REFUSED and all(x.half_widths.get(name) is None for x in last)
        return track.refused if track.is_broken or refused else ""

    def _first(self) -> Round | Outcome:
        """Return the fewest runs of the plan that give every interval."""
        design = self.design()
        if self.ask.budget_s is not None and design.cost_s > self.ask.budget_s:
            return Outcome(
                BUDGET, f"the cheapest plan, {design.runs}, takes {duration(design.cost_s)}"
            )
        for mills in _smaller(design.mills):
            runs = [
                run
                for S, count in mills
                for run in [self.runner.planned(S, design.size)] * count
                if run is not None
            ]
            try:
                for name in self.ask.names:
                    planned_freedom(name, [(run.S, run.pitches) for run in runs])
            except ExtrapolationError:
                continue
            break
        cost = math.fsum(run.cost_s for run in runs)
        numbered = tuple((S, tuple(range(1, count + 1))) for S, count in mills)
        whole = f"begin of the plan {design.runs}" if mills != design.mills else "the plan"
        expected = design.worst if mills == design.mills else None
        why = f"{whole}, expected {_percent(design.worst)}"
        return Round(1, numbered, design.size, cost, why, expected)

    def _repeat(
        self,
        rounds: Sequence[Round],
        repeated: Sequence[tuple[float, int]],
        look: Look,
        size: RunSize,
    ) -> Round | Outcome:
        """Return the runs of one S that were not steady, with a longer rotation."""
        S = max(run[0] for run in repeated)
        seeds = tuple(sorted(seed for other, seed in repeated if other == S))
        run = self.runner.planned(S, size)
        if run is None:
            return Outcome(UNSTEADY, f"S = {S:g} is not steady and cannot turn further")
        cost = len(seeds) * run.cost_s
        why = f"not steady before ({look.unsteady[S, seeds[0]]}): {size.rotation_rad:g} rad"
        if not self.fits(cost, look):
            return self.too_dear(f"S = {S:g}, turned further", cost, look)
        return Round(len(rounds) + 1, ((S, seeds),), size, cost, why)

    def fits(self, cost_s: float, look: Look) -> bool:
        """Return whether a cost fits what is left of the budget."""
        return self.ask.budget_s is None or look.spent_s + cost_s <= self.ask.budget_s

    def too_dear(self, what: str, cost_s: float, look: Look) -> Outcome:
        """Return the end for want of budget."""
        left = max((self.ask.budget_s or 0.0) - look.spent_s, 0.0)
        return Outcome(
            BUDGET, f"the next run, {what}, takes {duration(cost_s)}; {duration(left)} are left"
        )


def _smaller(mills: tuple[tuple[float, int], ...]) -> Iterator[tuple[tuple[float, int], ...]]:
    """Yield the mills of a plan with one seed each, then with more of the last, up to the plan."""
    *others, (S, seeds) = mills
    for count in range(1, seeds + 1):
        yield (*((other, 1) for other, _ in others), (S, count))


@dataclass(frozen=True)
class _Step:
    """One or two further runs."""

    ratios: tuple[float, ...]
    cost_s: float
    widest: float


class _Candidates:
    """Runs that could be the next."""

    def __init__(self, solver: Solver, look: Look, size: RunSize, number: int) -> None:
        self._solver, self._look, self._size, self._number = solver, look, size, number
        self._ask = solver.ask
        self._runs = {
            S: run for S in self._ratios() if (run := solver.runner.planned(S, size)) is not None
        }
        self._now = {name: self._raw(name, ()) for name in self._ask.names}

    def best(self) -> Round | Outcome:
        """Return the next round, or why there is none."""
        singles = [self._step((S,)) for S in self._runs]
        affordable = [x for x in singles if self._solver.fits(x.cost_s, self._look)]
        ending = self._cheapest_end(affordable, self._solver.fits)
        if ending:
            parts = [x for x in affordable if x.ratios[0] in ending.ratios]
            return self._round(max(parts, key=self._rate), ending)
        helpful = [x for x in affordable if self._gain(x) >= LEAST_GAIN]
        if helpful:
            return self._round(max(helpful, key=self._rate), None)
        dear = [x for x in singles if x not in affordable and self._gain(x) >= LEAST_GAIN]
        if dear:
            end = self._cheapest_end(singles, lambda cost, look: True)
            step = end or max(dear, key=self._rate)
            text = " and ".join(f"S = {S:g}" for S in step.ratios)
            return self._solver.too_dear(text, step.cost_s, self._look)
        return Outcome(NOTHING_HELPS, self._why_not())

    def _ratios(self) -> list[float]:
        """Return the values of S that may be run: those that are there, others, and 1."""
        there = sorted({S for S, _ in self._look.used})
        if not there:
            return [1.0, *RATIOS]
        # Two values of S too close together would only add noise.
        gap = LEAST_SPREAD if len(there) == 1 else 1.0 + SAME_S
        new = [S for S in RATIOS if all(max(S, x) > gap * min(S, x) for x in there)]
        return sorted({1.0, *there, *new})

    def _step(self, ratios: tuple[float, ...]) -> _Step:
        cost = math.fsum(self._runs[S].cost_s for S in ratios)
        return _Step(ratios, cost, max(self._width(name, ratios) for name in self._ask.names))

    def _cheapest_end(
        self, singles: Sequence[_Step], fits: Callable[[float, Look], bool]
    ) -> _Step | None:
        """Return the cheapest one or two runs that are expected to reach the error."""
        wanted = AIM * self._ask.error
        best = min((x for x in singles if x.widest <= wanted), key=_cost, default=None)
        pairs = itertools.combinations_with_replacement([x.ratios[0] for x in singles], 2)
        by_cost = sorted(pairs, key=lambda pair: math.fsum(self._runs[S].cost_s for S in pair))
        for pair in by_cost:
            cost = math.fsum(self._runs[S].cost_s for S in pair)
            if (best and cost >= best.cost_s) or not fits(cost, self._look):
                break
            if all(self._width(name, pair) <= wanted for name in self._by_width()):
                return self._step(pair)
        return best

    def _by_width(self) -> list[str]:
        """Return the names of the observables, the widest interval first."""
        return sorted(self._ask.names, key=lambda name: -self._look.half_width(name))

    def _gain(self, step: _Step) -> float:
        now = self._look.widest(self._ask.names)
        if math.isinf(now):
            return 0.0 if math.isinf(step.widest) else 1.0
        return 1.0 - step.widest / now

    def _rate(self, step: _Step) -> float:
        """Return by how much a run narrows the widest interval per second, as a logarithm."""
        now = self._look.widest(self._ask.names)
        if math.isinf(now):
            return (0.0 if math.isinf(step.widest) else 1.0) / step.cost_s
        return math.log(now / step.widest) / step.cost_s

    def _round(self, step: _Step, ending: _Step | None) -> Round:
        (S,) = step.ratios
        tried = self._look.used | self._look.unsteady.keys()
        seed = next(n for n in itertools.count(1) if (S, n) not in tried)
        name = self._by_width()[0]
        now = self._look.half_width(name)
        narrows = f"{name} from {_percent(now)}" if math.isfinite(now) else f"an interval of {name}"
        why = f"narrows {narrows} to {_percent(step.widest)} most per second"
        if ending:
            text = " and ".join(f"S = {x:g}" for x in ending.ratios)
            why = f"cheapest way to {_percent(ending.widest)}: {text}"
        size, cost = self._size, step.cost_s
        return Round(self._number, ((S, (seed,)),), size, cost, why, step.widest)

    def _why_not(self) -> str:
        name = self._by_width()[0]
        track = self._look.tracks.get(name)
        if track is not None and track.refused:
            return f"{name}: {track.refused}"
        return f"no run narrows {name}, {_percent(self._look.half_width(name))}, any further"

    def _width(self, name: str, ratios: tuple[float, ...]) -> float:
        """Return the half width that an observable is expected to have with further runs."""
        raw, now, found = self._raw(name, ratios), self._now[name], self._look.half_width(name)
        # What the evaluation leaves out, such as that a contour has many points, is the same now.
        return raw * found / now if math.isfinite(now) and math.isfinite(found) else raw

    def _raw(self, name: str, ratios: tuple[float, ...]) -> float:
        look, error = self._look, {x.name: x for x in self._solver.model.observables}[name]
        track = look.tracks.get(name, Track(name, ()))
        law = _law(track) or (lambda S: 1.0 + error.bias(S))
        values = {group.S: group.values for group in track.groups}
        for S in ratios:
            there = next((known for known in values if abs(known - S) < SAME_S), S)
            group = values.get(there, ())
            added = math.fsum(group) / len(group) if group else law(S)
            values[there] = (*group, added)
        runs = [(S, self._pitches(S)) for S, group in values.items() for _ in group]
        learnt = learnt_deviation(error, [S for S, _ in runs])
        deviation = track.noise.deviation if track.noise else self._deviation(learnt)
        try:
            noise = Noise(deviation, planned_freedom(name, runs))
            groups = [Group(S, group) for S, group in values.items()]
            return extrapolate(groups, noise, self._ask.level, prior_of(name)).half_width
        except ExtrapolationError:
            return math.inf

    def _pitches(self, S: float) -> float:
        run = self._solver.runner.planned(S, self._size)
        return run.pitches if run else 1.0

    def _deviation(self, learnt: float) -> float:
        """Return the noise of a run from that of other mills."""
        runs = [self._runs[S] for S, _ in self._look.used if S in self._runs]
        runs = runs or list(self._runs.values())
        variance = math.fsum(map(self._solver.model.of_run, runs)) / len(runs)
        return learnt * math.sqrt(variance)


def _law(track: Track) -> Callable[[float], float] | None:
    """Return the law that an observable follows by its values; None from fewer than two S."""
    if len(track.groups) < 2:
        return None
    x = [float(scale_function(group.S, track.exponent)) for group in track.groups]
    y = [group.mean for group in track.groups]
    weights = [float(len(group.values)) for group in track.groups]
    total = math.fsum(weights)
    x0 = math.fsum(w * a for w, a in zip(weights, x, strict=True)) / total
    y0 = math.fsum(w * b for w, b in zip(weights, y, strict=True)) / total
    square = math.fsum(w * (a - x0) ** 2 for w, a in zip(weights, x, strict=True))
    slope = (
        math.fsum(w * (a - x0) * (b - y0) for w, a, b in zip(weights, x, y, strict=True)) / square
    )
    return lambda S: y0 + slope * (float(scale_function(S, track.exponent)) - x0)


def _cost(step: _Step) -> float:
    return step.cost_s


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %"
