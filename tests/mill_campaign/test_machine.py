"""Sharing of the cores."""

import pytest

from mill_campaign import machine
from mill_campaign.cost import most_ranks
from mill_campaign.errors import CampaignError
from mill_campaign.machine import Allocation, CoreWish, allocate, available_cores, hardware


@pytest.fixture(autouse=True)
def eight_cores(monkeypatch):
    monkeypatch.setattr(machine, "available_cores", lambda: 8)


@pytest.mark.parametrize(
    ("kinds", "asked", "expected"),
    [
        ({"single-ball"}, CoreWish(), Allocation(8, 8, 8)),
        ({"multi-ball"}, CoreWish(), Allocation(8, 8, 8)),
        ({"multi-ball"}, CoreWish(jobs=2), Allocation(4, 2, 8)),
        ({"multi-ball"}, CoreWish(ranks=2, jobs=4), Allocation(2, 4, 8)),
        ({"single-ball"}, CoreWish(ranks=4, jobs=8), Allocation(4, 8, 8)),
        ({"multi-ball"}, CoreWish(4, 4, oversubscribe=True), Allocation(4, 4, 16)),
    ],
)
def test_what_is_not_asked_for_fills_the_machine(kinds, asked, expected):
    assert allocate(kinds, asked) == expected


def test_usual_values_give_way_to_the_machine_and_to_what_is_asked():
    usual = CoreWish(ranks=64, jobs=64)
    assert allocate({"multi-ball", "single-ball"}, CoreWish(), usual) == Allocation(8, 8, 8)
    assert allocate({"multi-ball"}, CoreWish(ranks=3), CoreWish(2, 2)) == Allocation(3, 2, 8)


@pytest.mark.parametrize("asked", [CoreWish(ranks=9), CoreWish(jobs=9), CoreWish(4, 3)])
def test_more_cores_than_there_are_need_permission(asked):
    with pytest.raises(CampaignError, match=r"this machine offers 8; accepted: at most 8 in all"):
        allocate({"multi-ball"}, asked)


def test_no_charge_is_cut_thinner_than_two_ball_diameters():
    def case(kind, length):
        return {"kind": kind, "mill": {"simulated_length_m": length}, "ball": {"radius_m": 0.02}}

    charges = [case("multi-ball", length) for length in (1.0, 0.385)]
    assert most_ranks(charges) == 4
    assert most_ranks([case("multi-ball", 0.05)]) == 1
    assert most_ranks([*charges, case("single-ball", 0.05)]) == 4
    assert most_ranks([case("single-ball", 1.0)]) == 1


def test_a_container_s_quota_lowers_the_cores(monkeypatch, tmp_path):
    monkeypatch.setattr(machine.os, "sched_getaffinity", lambda _: set(range(16)))
    monkeypatch.setattr(machine, "_QUOTA", tmp_path / "cpu.max")
    assert available_cores() == 16
    (tmp_path / "cpu.max").write_text("250000 100000\n")
    assert available_cores() == 3
    (tmp_path / "cpu.max").write_text("max 100000\n")
    assert available_cores() == 16


def test_hardware_is_named():
    found = hardware()
    assert found["cpu"] and found["cores"] >= 1 and found["available_cores"] >= 1
