"""The loop of a solve, by made-up runs whose observables follow a known law with known noise."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from millscale.errors import EngineError
from millscale.prediction.advise import Design
from millscale.prediction.error_model import ErrorModel, ObservableError, prior_of
from millscale.prediction.extrapolation import (
    ExtrapolationError,
    Group,
    Noise,
    by_ratio,
    extrapolate,
    scale_function,
)
from millscale.prediction.noise import FEWEST_SEED_FREEDOM
from millscale.prediction.planned import PlannedRun, RunSize
from millscale.prediction.solve import Ask, Look, Outcome, Solver, Track

PITCHES = 20.0
DEVIATION, SLOPE, EXPONENT = 2e-3, 0.05, 0.3
RATIOS = (1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.7, 2.0, 2.3, 2.6, 3.1)
MODEL = ErrorModel(
    0.005,
    "constant-gravity",
    "paper",
    1000.0,
    5.0,
    (
        ObservableError("power", SLOPE, DEVIATION, 20.0),
        ObservableError("solid_fraction", SLOPE, DEVIATION, 4.0),
    ),
    {"command": "a test"},
)
PLAN = Design(((1.7, 1), (2.6, 3)), RunSize(), 400.0, {"power": 0.02})


def cost(S):
    return 1000.0 / S**3


class MadeUpRuns:
    """Runs that take no time.

    Args:
        unsteady: (S, seed, rotation) that are not steady.
        fails: (S, seed) that fail.
    """

    def __init__(self, deviation=DEVIATION, slope=SLOPE, ratios=RATIOS, unsteady=(), fails=()):
        self.deviation, self.slope, self._ratios = deviation, slope, ratios
        self.unsteady, self.fails, self.made = set(unsteady), set(fails), []

    def planned(self, S, size):
        if S not in self._ratios:
            return None
        at = size.rotation_rad / RunSize().rotation_rad
        return PlannedRun(S, 1000, size.window_rad, PITCHES, at * cost(S))

    def run(self, asked):
        for run in asked.runs:
            if run in self.fails:
                raise EngineError(f"S = {run[0]:g} failed")
        self.made.append(asked)

    def value(self, S, seed):
        chance = np.random.default_rng([round(1000 * S), seed]).normal()
        return 1.0 + self.slope * float(scale_function(S, EXPONENT)) + self.deviation * chance

    def look(self, finished):
        used, unsteady, spent = {}, {}, 0.0
        for asked in finished:
            for S, seed in asked.runs:
                spent += self.planned(S, asked.size).cost_s
                if (S, seed, asked.size.rotation_rad) in self.unsteady:
                    unsteady[S, seed] = "it drifts"
                else:
                    used[S, seed] = self.value(S, seed)
        groups = [Group(S, tuple(v)) for S, v in by_ratio((S, v) for (S, _), v in used.items())]
        tracks = {name: self.track(name, groups) for name in ("power", "solid_fraction")}
        return Look(tracks, frozenset(used), unsteady, spent)

    def track(self, name, groups):
        seeds = sum(len(group.values) - 1 for group in groups)
        if name == "solid_fraction" and seeds < FEWEST_SEED_FREEDOM:
            return Track(name, tuple(groups), refused="its noise is not known")
        freedom = (
            seeds
            if seeds >= FEWEST_SEED_FREEDOM
            else PITCHES * sum(len(group.values) for group in groups)
        )
        noise = Noise(self.deviation, float(freedom))
        try:
            found = extrapolate(groups, noise, prior=prior_of(name))
        except ExtrapolationError as error:
            return Track(name, tuple(groups), noise, refused=str(error))
        return Track(name, tuple(groups), noise, found.half_width, found.exponent)


def solver(runs, error, budget=None, names=("power",), plan=PLAN, saved=None):
    keep = (lambda rounds: None) if saved is None else (lambda rounds: saved.append(list(rounds)))
    return Solver(
        Ask(tuple(names), error, budget), runs, MODEL, lambda: plan, keep, lambda asked, look: None
    )


def solved(runs, error, budget=None, names=("power",), rounds=(), **changes):
    return solver(runs, error, budget, names, **changes).solve(rounds)


def test_the_interval_is_met_and_holds_the_truth():
    rounds, look, outcome = solved(MadeUpRuns(), 0.01)
    assert outcome.kind == "met"
    assert look.half_width("power") <= 0.01
    power = look.tracks["power"]
    found = extrapolate(power.groups, power.noise, prior=prior_of("power"))
    assert found.lower <= 1.0 <= found.upper
    assert len(rounds) > 1  # the plan alone does not give it


def test_no_run_is_made_once_the_interval_is_met():
    """The widths before the last round were too wide; those of the first round of a lax ask are
    not, though the plan has more seeds."""
    rounds, _, _ = solved(MadeUpRuns(), 0.01)
    assert all(x.half_widths["power"] > 0.01 for x in rounds[:-1])
    rounds, _, outcome = solved(MadeUpRuns(), 0.2)
    assert outcome.kind == "met"
    assert [x.runs for x in rounds] == [[(1.7, 1), (2.6, 1)]]


def test_the_first_round_has_the_seeds_that_every_interval_needs():
    rounds, look, _ = solved(MadeUpRuns(), 0.2, names=("power", "solid_fraction"))
    assert rounds[0].mills == ((1.7, (1,)), (2.6, (1, 2, 3)))
    assert math.isfinite(look.half_width("solid_fraction"))


@pytest.mark.parametrize("error", [0.02, 0.01, 0.005])
def test_each_run_is_worth_its_cost(error):
    """The whole costs less than twice the cheapest set of two groups that reaches the error."""
    runs = MadeUpRuns()
    _, look, outcome = solved(runs, error)
    assert outcome.kind == "met"
    assert look.spent_s < 2.0 * cheapest_pair(runs, error)


def cheapest_pair(runs, error):
    """By trying all of them."""
    known = []
    for near, far in itertools.combinations(RATIOS, 2):
        for n, m in itertools.product((1, 2, 3, 4), repeat=2):
            groups = [
                Group(S, tuple(runs.value(S, seed) for seed in range(1, count + 1)))
                for S, count in ((near, n), (far, m))
            ]
            track = runs.track("power", groups)
            if track.half_width is not None and track.half_width <= error:
                known.append(n * cost(near) + m * cost(far))
    return min(known)


def test_a_budget_is_not_exceeded_and_the_cost_of_more_is_reported():
    first = cost(1.7) + cost(2.6)
    runs = MadeUpRuns()
    _, look, outcome = solved(runs, 0.001, budget=450.0)
    assert outcome.kind == "budget spent"
    assert first <= look.spent_s <= 450.0
    assert look.half_width("power") > 0.001
    assert "takes" in outcome.text and "left" in outcome.text


def test_a_plan_beyond_the_budget_is_not_begun():
    runs = MadeUpRuns()
    rounds, _, outcome = solved(runs, 0.01, budget=10.0)
    assert (rounds, outcome.kind, runs.made) == ([], "budget spent", [])
    assert "6 min 40 s" in outcome.text


def test_a_larger_budget_goes_on_from_the_same_runs():
    runs = MadeUpRuns()
    rounds, _, _ = solved(runs, 0.004, budget=600.0)
    before = len(runs.made)
    more, _, outcome = solved(runs, 0.004, rounds=rounds)
    assert outcome.kind == "met"
    assert [x.runs for x in more[:before]] == [x.runs for x in rounds]
    assert len(runs.made) == len(more) > before


def test_what_no_run_narrows_is_reported():
    """Far mills alone can be run, and the noise is nothing."""
    runs = MadeUpRuns(deviation=1e-9, ratios=(2.0, 2.6))
    plan = replace(PLAN, mills=((2.0, 1), (2.6, 1)))
    _, look, outcome = solved(runs, 0.001, plan=plan)
    assert outcome.kind == "nothing helps"
    assert "power" in outcome.text
    assert look.half_width("power") > 0.001


def test_another_S_is_run_where_the_exponent_is_what_is_unknown():
    rounds, _, _ = solved(MadeUpRuns(deviation=1e-5), 0.004)
    assert all(S not in (1.7, 2.6) for S, _ in rounds[1].runs)


def test_seeds_are_run_where_the_noise_is_what_is_unknown():
    """Other values of S cannot be run, and the error hardly depends on S."""
    runs = MadeUpRuns(deviation=0.01, slope=1e-3, ratios=(1.7, 2.6))
    rounds, _, outcome = solved(runs, 0.04, names=("solid_fraction",))
    assert outcome.kind == "met"
    assert len(rounds) > 2


def test_values_that_do_not_follow_the_law_end_it_at_once():
    class Bent(MadeUpRuns):
        def track(self, name, groups):
            return Track(name, tuple(groups), refused="they do not", is_broken=True)

    runs = Bent()
    _, _, outcome = solved(runs, 0.01)
    assert (outcome.kind, outcome.text) == ("nothing helps", "power: they do not")
    assert len(runs.made) == 1


def test_an_observable_that_stays_refused_is_given_up():
    class Hidden(MadeUpRuns):
        def track(self, name, groups):
            return Track(name, tuple(groups), refused="too few dumps")

    runs = Hidden()
    _, _, outcome = solved(runs, 0.01)
    assert (outcome.kind, outcome.text) == ("nothing helps", "power: too few dumps")
    assert len(runs.made) == 4


def test_a_charge_that_is_not_steady_turns_further():
    runs = MadeUpRuns(unsteady={(2.6, 1, 12.0)})
    rounds, _, outcome = solved(runs, 0.05)
    assert rounds[1].runs == [(2.6, 1)]
    assert rounds[1].size.rotation_rad == 18.0
    assert "it drifts" in rounds[1].why
    assert outcome.kind == "met"


def test_a_charge_that_never_is_steady_ends_it():
    unsteady = {(2.6, 1, rotation) for rotation in (12.0, 18.0, 27.0)}
    rounds, _, outcome = solved(MadeUpRuns(unsteady=unsteady), 0.05)
    assert [x.size.rotation_rad for x in rounds] == [12.0, 18.0, 27.0]
    assert outcome.kind == "not steady"
    assert "S = 2.6, seed 1" in outcome.text and "it drifts" in outcome.text


def test_the_slice_of_the_physical_mill_answers_alone():
    plan = Design(((1.0, 1),), RunSize(), 1000.0, {"power": 0.004})
    rounds, _, outcome = solved(MadeUpRuns(), 0.01, plan=plan)
    assert [x.runs for x in rounds] == [[(1.0, 1)]]
    assert outcome.kind == "met"


def test_a_failed_run_ends_it_and_the_round_is_kept():
    saved, runs = [], MadeUpRuns(fails={(2.6, 1)})
    with pytest.raises(EngineError, match=r"S = 2.6 failed"):
        solved(runs, 0.01, saved=saved)
    assert len(saved[-1]) == 1 and not saved[-1][0].done


class Killed(Exception):
    pass


@pytest.mark.parametrize("error", [0.01, 0.004])
def test_a_kill_at_any_point_changes_no_decision(error):
    """Ended at each write of the rounds and in each run, and called again: the same rounds."""
    whole, _, ended = solved(MadeUpRuns(), error)
    for last in itertools.count():
        rounds, again, calls = interrupted(error, last)
        assert [x.runs for x in rounds] == [x.runs for x in whole]
        assert again == ended
        if calls <= last:
            break
    assert last > 3 * len(whole) - 2


def interrupted(error, last):
    """Solve, killed once at call number `last` of save or run; then solve from what was saved."""
    runs, kept, calls = MadeUpRuns(), [()], itertools.count()
    count = 0

    def point():
        nonlocal count
        count = next(calls) + 1
        if count - 1 == last:
            raise Killed

    def save(rounds):
        point()
        kept.append(tuple(rounds))

    def run(asked, run=runs.run):
        point()
        run(asked)

    runs.run = run
    made = replace(solver(runs, error), save=save)
    try:
        rounds, _, outcome = made.solve()
    except Killed:
        rounds, _, outcome = made.solve(kept[-1])
    return rounds, outcome, count


def test_the_decisions_of_earlier_rounds_are_read_not_made():
    """A round that was begun is run as it is, even if another would be chosen now."""
    runs = MadeUpRuns()
    rounds, _, _ = solved(runs, 0.01)
    odd = replace(rounds[1], mills=((2.3, (7,)),), done=False, spent_s=None)
    again = MadeUpRuns()
    solved(again, 0.01, rounds=[rounds[0], odd])
    assert again.made[0].runs == [(2.3, 7)]


def test_a_laxer_error_does_not_run_what_was_begun():
    runs = MadeUpRuns()
    rounds, _, _ = solved(runs, 0.01)
    begun = [rounds[0], replace(rounds[1], done=False, spent_s=None)]
    runs = MadeUpRuns()
    _, _, outcome = solved(runs, 0.2, rounds=begun)
    assert outcome.kind == "met"
    assert runs.made == []


def test_following_shows_the_next_round_without_making_it():
    runs = MadeUpRuns()
    _, _, following = solver(runs, 0.01).following([])
    assert following.runs == [(1.7, 1), (2.6, 1)]
    rounds, _, _ = solved(runs, 0.2)
    made = len(runs.made)
    _, _, following = solver(runs, 0.01).following(rounds)
    assert not isinstance(following, Outcome) and following.number == 2
    assert len(runs.made) == made
