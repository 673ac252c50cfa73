"""`millscale run --slurm` on a real Slurm of one node, started and stopped here.

The node is configured with four cores on any machine: these tests measure no time.
"""

import importlib.util
import json
import re
import shutil
import signal
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import pytest
import slurm_node

from millscale.workflow.targets import Slurm
from small_campaign import CHARGE, SINGLE_BALLS
from small_command import Millscale, small

MISSING = [
    *slurm_node.missing(),
    *([] if importlib.util.find_spec(Slurm.plugin) else [Slurm.plugin]),
]
pytestmark = pytest.mark.skipif(
    bool(MISSING), reason=f"no {', '.join(MISSING)}: apt-get install slurmctld slurmd munge"
)
CORES = 4


@pytest.fixture(scope="module")
def node():
    # Sockets have short paths.
    folder = Path(tempfile.mkdtemp(prefix="slurm", dir="/tmp"))
    with slurm_node.node(folder / "n", CORES) as running:
        yield running
    shutil.rmtree(folder)


@dataclass(frozen=True)
class OnSlurm:
    command: Millscale
    node: slurm_node.Node

    def start(self, *arguments, **more):
        return self.command.start("run", "--slurm", *arguments, **(self.node.environment | more))

    def end(self, process, seconds=240):
        output, errors = process.communicate(timeout=seconds)
        return process.returncode, output + errors

    def done(self, case_id):
        return (self.command.case(case_id) / "result.json").exists()

    def attempts(self):
        """Numbers of the jobs of this run, in order."""
        ours = [
            line.split()[0]
            for line in self.node(
                "squeue", "--noheader", "--states", "all", "--format", "%i %Z"
            ).splitlines()
            if line.endswith(str(self.command.runs))
        ]
        return sorted(ours, key=int)

    def shown(self, number):
        """Return what Slurm reports of a job, by key."""
        return dict(re.findall(r"(\S+?)=(\S*)", self.node("scontrol", "show", "job", number)))


@pytest.fixture
def on_slurm(node, tmp_path):
    return OnSlurm(small(tmp_path), node)


def test_a_campaign_runs_on_slurm_with_ranks_memory_and_time_of_each_case(on_slurm):
    process = on_slurm.start("--ranks", "2")
    code, output = on_slurm.end(process)
    assert code == 0, output
    assert all(on_slurm.done(x) for x in (*SINGLE_BALLS, CHARGE))
    jobs = [on_slurm.shown(x) for x in on_slurm.attempts()]
    # The charge by itself, the single balls together.
    assert sorted(job["NumCPUs"] for job in jobs) == ["1", "2"]
    for job in jobs:
        assert job["JobState"] == "COMPLETED"
        assert job["TimeLimit"] == "00:10:00"
        assert 500 < int(job["MinMemoryNode"].removesuffix("M")) < 1000
    assert f"Slurm: {CHARGE}: 10 min requested" in output and "2 cores" in output
    timing = json.loads((on_slurm.command.case(CHARGE) / "timing.json").read_text())
    assert timing["hardware"]["cores"] >= 1
    # Nothing is left to do.
    assert on_slurm.end(on_slurm.start())[0] == 0
    assert len(on_slurm.attempts()) == 2


@pytest.mark.validate
def test_a_killed_job_is_queued_again_and_finished_cases_are_kept(on_slurm, wait_for):
    process = on_slurm.start("--only", "sb-*", STAND_IN_SECONDS="4")
    first, second = (on_slurm.command.case(x) for x in SINGLE_BALLS)
    wait_for((second / "rotate.part" / "series.csv").exists)
    kept = (first / "timing.json").stat().st_mtime_ns
    (number,) = on_slurm.attempts()
    on_slurm.node("scancel", "--full", "--signal=KILL", number)
    code, output = on_slurm.end(process)
    assert code == 0, output
    assert all(on_slurm.done(x) for x in SINGLE_BALLS)
    assert (first / "timing.json").stat().st_mtime_ns == kept
    # The state of a killed job in Slurm depends on which of its processes ended first.
    assert on_slurm.shown(number)["JobState"] in ("CANCELLED", "FAILED")
    again = on_slurm.shown(on_slurm.attempts()[-1])
    assert again["JobState"] == "COMPLETED"
    # The second attempt requested more time.
    assert again["TimeLimit"] == "00:20:00"


@pytest.mark.validate
def test_an_interrupted_run_takes_its_jobs_out_of_the_queue(on_slurm, wait_for):
    process = on_slurm.start("--only", "sb-*", STAND_IN_SECONDS="60")
    series = on_slurm.command.case(SINGLE_BALLS[0]) / "rotate.part" / "series.csv"
    wait_for(series.exists)
    process.send_signal(signal.SIGTERM)
    code, output = on_slurm.end(process)
    assert code == 130 and "repeat the command to resume" in output
    (number,) = on_slurm.attempts()
    wait_for(lambda: on_slurm.shown(number)["JobState"] == "CANCELLED")
    length = series.stat().st_size if series.exists() else 0
    time.sleep(2.0)
    assert (series.stat().st_size if series.exists() else 0) == length, "the engine still writes"


@pytest.mark.validate
def test_a_job_ended_by_its_time_is_sent_again_with_more(on_slurm, tmp_path):
    """Settling and rotation take 45 s each; the site gives a minute, then three.

    Slurm looks at times every half minute, so 90 s do not fit into the first.
    """
    site = tmp_path / "site"
    site.mkdir()
    rule = f"job_{CHARGE}".replace("-", "_").replace(".", "_")
    runtime = '"2 * attempt - 1"'
    (site / "config.yaml").write_text(f"set-resources:\n  {rule}:\n    runtime: {runtime}\n")
    process = on_slurm.start("--only", CHARGE, "--profile", str(site), STAND_IN_SECONDS="45")
    code, output = on_slurm.end(process, 580)
    assert code == 0, output
    assert on_slurm.done(CHARGE)
    jobs = [on_slurm.shown(x) for x in on_slurm.attempts()]
    assert [job["JobState"] for job in jobs] == ["TIMEOUT", "COMPLETED"]
    assert [job["TimeLimit"] for job in jobs] == ["00:01:00", "00:03:00"]


@pytest.mark.validate
def test_a_job_that_slurm_requeues_goes_on(on_slurm, wait_for):
    """Slurm waits two minutes before it starts a requeued job again."""
    process = on_slurm.start("--only", "sb-*", STAND_IN_SECONDS="4")
    first, second = (on_slurm.command.case(x) for x in SINGLE_BALLS)
    wait_for((second / "rotate.part" / "series.csv").exists)
    kept = (first / "timing.json").stat().st_mtime_ns
    (number,) = on_slurm.attempts()
    on_slurm.node("scontrol", "requeue", number)
    code, output = on_slurm.end(process, 580)
    assert code == 0, output
    assert on_slurm.shown(number)["Restarts"] == "1"
    assert all(on_slurm.done(x) for x in SINGLE_BALLS)
    assert (first / "timing.json").stat().st_mtime_ns == kept


@pytest.mark.validate
@pytest.mark.engine
def test_the_engine_runs_on_two_ranks_in_a_job(on_slurm):
    from millscale.engine.deck_run import find_engine

    engine = {"MILLSCALE_ENGINE": str(find_engine())}
    process = on_slurm.start("--ranks", "2", "--only", CHARGE, **engine)
    code, output = on_slurm.end(process, 580)
    assert code == 0, output
    timing = json.loads((on_slurm.command.case(CHARGE) / "timing.json").read_text())
    assert timing["ranks"] == 2 and timing["balls"] == 50
