"""Number of ranks of each case."""

import itertools
import random

import pytest

from millscale.cases.cost import wall_time
from millscale.engine.machine import CoreWish
from millscale.errors import CampaignError
from millscale.workflow import placement
from millscale.workflow.placement import campaign_time, makespan, place, ranks_on_nodes
from paper_campaign import cases


def on(monkeypatch, cores):
    monkeypatch.setattr(placement, "available_cores", lambda: cores)


@pytest.fixture(autouse=True)
def two_cores(monkeypatch):
    on(monkeypatch, 2)


def charges(tmp_path, ratios, counts, **more):
    study = {"S": ratios, "count": counts, "rotation_angle_rad": 8.0, "step_s": 1e-4}
    schemes = ["constant-gravity"]
    return cases(tmp_path, single_ball=None, multi_ball=study | more, scaling={"schemes": schemes})


def test_as_many_equal_cases_as_cores_run_side_by_side_on_one_rank_each(tmp_path):
    mills = charges(tmp_path, [2.6], [13370], seeds=[1, 2])
    assert set(place(mills, CoreWish()).ranks.values()) == {1}


def test_a_case_alone_takes_the_machine(tmp_path):
    mills = charges(tmp_path, [2.6], [13370])
    chosen = place(mills, CoreWish())
    assert set(chosen.ranks.values()) == {2} and chosen.cores == 2


def test_the_largest_case_of_a_campaign_gets_ranks_if_it_holds_up_the_others(tmp_path, monkeypatch):
    on(monkeypatch, 8)
    mills = charges(tmp_path, [1.0, 2.6], [231461, 1000], seeds=[1, 2, 3], seeds_from_S=2.0)
    large, *small = place(mills, CoreWish()).ranks.values()
    assert large > 1 and set(small) == {1}
    assert campaign_time(mills, place(mills, CoreWish())) < wall_time(mills[0], 1)


def test_no_other_choice_of_ranks_ends_much_earlier(tmp_path, monkeypatch):
    on(monkeypatch, 4)
    mills = charges(tmp_path, [1.0, 1.3, 1.696, 2.6], [231461, 178047, 100786, 13370])
    chosen = campaign_time(mills, place(mills, CoreWish()))
    best = min(
        makespan([(wall_time(x, r), r) for x, r in zip(mills, ranks, strict=True)], 4, 4)
        for ranks in itertools.product(range(1, 5), repeat=len(mills))
    )
    # The rule tries only some of the choices; its result has to be close to the best.
    assert best <= chosen <= 1.2 * best


def test_slabs_stay_two_ball_diameters_thick(tmp_path, monkeypatch):
    on(monkeypatch, 64)
    mills = charges(tmp_path, [2.6], [13370])
    assert max(place(mills, CoreWish()).ranks.values()) <= 4


@pytest.mark.parametrize(
    ("asked", "ranks", "jobs", "cores"),
    [
        (CoreWish(ranks=2), 2, 8, 8),
        (CoreWish(jobs=2), 4, 2, 8),
        (CoreWish(ranks=2, jobs=4), 2, 4, 8),
        (CoreWish(4, 4, oversubscribe=True), 4, 4, 16),
    ],
)
def test_requested_ranks_and_jobs_are_used(tmp_path, monkeypatch, asked, ranks, jobs, cores):
    on(monkeypatch, 8)
    mills = charges(tmp_path, [1.0], [231461], seeds=[1, 2])
    chosen = place(mills, asked)
    assert set(chosen.ranks.values()) == {ranks}
    assert (chosen.jobs, chosen.cores) == (jobs, cores)


def test_defaults_yield_to_the_machine_and_to_requests(tmp_path):
    mills = charges(tmp_path, [1.0], [231461])
    assert set(place(mills, CoreWish(), CoreWish(64, 64)).ranks.values()) == {1}
    assert set(place(mills, CoreWish(ranks=2), CoreWish(1, 1)).ranks.values()) == {2}


@pytest.mark.parametrize("asked", [CoreWish(ranks=3), CoreWish(jobs=3), CoreWish(2, 2)])
def test_more_cores_than_there_are_need_permission(tmp_path, asked):
    mills = charges(tmp_path, [2.6], [13370])
    with pytest.raises(CampaignError, match=r"this machine offers 2; accepted: at most 2 in all"):
        place(mills, asked)


def test_single_balls_run_on_one_rank_whatever_is_requested(tmp_path):
    balls = cases(tmp_path)
    assert set(place(balls, CoreWish(ranks=64, jobs=2)).ranks.values()) == {1}


def test_on_a_cluster_a_case_takes_the_ranks_that_are_worth_it(tmp_path):
    mills = charges(tmp_path, [1.0, 2.6], [231461, 13370])
    ranks = ranks_on_nodes(mills, None, 64)
    large, small = (ranks[x.id] for x in mills)
    assert large > small > 1
    for case in mills:
        gain = wall_time(case, 1) / wall_time(case, ranks[case.id])
        assert gain >= 0.6 * ranks[case.id]
    assert max(ranks_on_nodes(mills, None, 2).values()) == 2
    assert set(ranks_on_nodes(mills, 3, 64).values()) == {3}


def test_a_makespan_is_between_its_bounds_and_never_uses_more_cores_than_there_are():
    chance = random.Random(1)
    for _ in range(50):
        loads = [(chance.uniform(1, 9), chance.randint(1, 4)) for _ in range(20)]
        whole = makespan(loads, 4, 4)
        work = sum(time * width for time, width in loads) / 4.0
        assert max(work, max(time for time, _ in loads)) <= whole <= sum(x for x, _ in loads)


def test_makespans_that_can_be_counted_by_hand():
    assert makespan([], 2, 2) == 0.0
    assert makespan([(3, 1), (2, 1), (2, 1)], 2, 2) == 4.0
    assert makespan([(3, 1), (2, 1), (2, 1)], 2, 1) == 7.0
    assert makespan([(3, 2), (2, 1), (2, 1)], 2, 2) == 5.0
    assert makespan([(1, 8)], 2, 2) == 1.0
