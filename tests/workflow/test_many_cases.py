"""Processor time of a campaign of many small cases outside its engines.

Other work on the machine does not change the processor time.
"""

import json
import os
import subprocess
import sys

import pytest

from paper_campaign import write_campaign
from small_campaign import TEXT
from small_command import Millscale, small

# Limit of the seconds per case outside the engine, for a campaign of two hundred.
MOST = 0.3


def spent(line, **where):
    """Processor time of a command and of all it started [s]."""
    begin = os.times()
    subprocess.run(line, check=True, capture_output=True, **where)
    end = os.times()
    return end.children_user + end.children_system - begin.children_user - begin.children_system


def in_engines(command):
    timings = [json.loads(x.read_text()) for x in command.runs.glob("cases/*/timing.json")]
    return sum(x["processor_time_s"] for x in timings), len(timings)


def test_a_further_case_of_a_job_costs_little_outside_its_engine(tmp_path):
    command = small(tmp_path)
    ratios = [1.0 + 0.1 * i for i in range(12)]
    command.file.write_text(TEXT.partition("[multi_ball]")[0].replace("[1.0, 2.0]", str(ratios)))
    assert command("generate").returncode == 0
    ids = sorted(x.name for x in command.runs.glob("cases/*"))
    outside = []
    for name, some in (("few", ids[:2]), ("many", ids[2:])):
        entry = {"name": name, "cases": some, "ranks": 1, "time_s": 1, "minutes": 1}
        (command.runs / "jobs.json").write_text(json.dumps([{**entry, "memory_mb": 1}]))
        line = [sys.executable, "-m", "millscale.workflow.run_job", "jobs.json", name]
        before, _ = in_engines(command)
        whole = spent(line, cwd=command.runs, env=command.environment())
        after, done = in_engines(command)
        outside.append(whole - (after - before))
    assert done == len(ids)
    # Ten cases against two: the start of Python, some two seconds, is in both.
    assert (outside[1] - outside[0]) / 8 < MOST


@pytest.mark.validate
@pytest.mark.engine
def test_two_hundred_single_balls_cost_little_outside_their_engines(tmp_path):
    ratios = [round(1.0 + 0.05 * i, 3) for i in range(100)]
    command = Millscale(write_campaign(tmp_path, scaling__S=ratios), tmp_path / "runs")
    whole = spent([sys.executable, "-m", "millscale", *command.line("run")])
    engines, done = in_engines(command)
    assert done == 200
    per_case = (whole - engines) / done
    print(f"{per_case:.3f} s of processor time per case outside the engine, {engines:.1f} s inside")
    assert per_case < MOST
