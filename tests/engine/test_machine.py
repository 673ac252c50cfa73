"""The machine and its cores."""

from millscale.engine import machine
from millscale.engine.machine import available_cores, hardware


def test_the_quota_of_a_container_limits_the_cores(monkeypatch, tmp_path):
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
