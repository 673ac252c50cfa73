"""`millscale run --slurm` on a real Slurm of two nodes, started and stopped here.

The nodes are configured with four cores each on any machine: these tests measure no time.
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
import slurm_cluster

from millscale.workflow.targets import Slurm
from small_campaign import CHARGE, SINGLE_BALLS
from small_command import Millscale, small

MISSING = [
    *slurm_cluster.missing(),
    *([] if importlib.util.find_spec(Slurm.plugin) else [Slurm.plugin]),
]
pytestmark = pytest.mark.skipif(
    bool(MISSING), reason=f"no {', '.join(MISSING)}: apt-get install slurmctld slurmd munge"
)
NODES, CORES = 2, 4


@pytest.fixture(scope="module")
def cluster():
    # Sockets have short paths.
    folder = Path(tempfile.mkdtemp(prefix="slurm", dir="/tmp"))
    with slurm_cluster.cluster(folder / "n", CORES, NODES) as running:
        yield running
    shutil.rmtree(folder)


@dataclass(frozen=True)
class OnSlurm:
    command: Millscale
    cluster: slurm_cluster.Cluster

    def start(self, *arguments, **more):
        return self.command.start("run", "--slurm", *arguments, **(self.cluster.environment | more))

    def end(self, process, seconds=240):
        output, errors = process.communicate(timeout=seconds)
        return process.returncode, output + errors

    def done(self, case_id):
        return (self.command.case(case_id) / "result.json").exists()

    def printed(self, stage):
        """Return what a stage of the charge printed."""
        return (self.command.case(CHARGE) / f"out.{stage}").read_text()

    def attempts(self):
        """Numbers of the jobs of this run, in order."""
        ours = [
            line.split()[0]
            for line in self.cluster(
                "squeue", "--noheader", "--states", "all", "--format", "%i %Z"
            ).splitlines()
            if line.endswith(str(self.command.runs))
        ]
        return sorted(ours, key=int)

    def shown(self, number):
        """Return what Slurm reports of a job, by key."""
        return dict(re.findall(r"(\S+?)=(\S*)", self.cluster("scontrol", "show", "job", number)))


@pytest.fixture
def on_slurm(cluster, tmp_path):
    return OnSlurm(small(tmp_path), cluster)


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
    on_slurm.cluster("scancel", "--full", "--signal=KILL", number)
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
    on_slurm.cluster("scontrol", "requeue", number)
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


def test_ranks_beyond_the_cores_of_a_node_get_a_second_one(on_slurm):
    """Six ranks on nodes of four cores; the stand-in for the engine writes on its first rank."""
    code, output = on_slurm.end(on_slurm.start("--ranks", "6", "--only", CHARGE))
    assert code == 0, output
    assert "6 cores on 2 nodes" in output
    (job,) = map(on_slurm.shown, on_slurm.attempts())
    assert (job["NumNodes"], job["NumCPUs"], job["CPUs/Task"]) == ("2", "6", "3")
    assert "-np 6 --bind-to none --map-by ppr:3:node " in on_slurm.printed("rotate")
    record = json.loads((on_slurm.command.case(CHARGE) / "provenance.json").read_text())
    assert record["stages"]["rotate"]["ranks"] == 6


def test_what_no_job_can_have_is_refused_before_anything_is_written(on_slurm):
    for options, cause in [
        (("--ranks", "9"), "--ranks 9: needs 3 nodes, a job can have 2; accepted: at most 8 ranks"),
        (("--ranks", "6", "--nodes", "1"), "needs 2 nodes of 4 cores; accepted: --nodes 2, or"),
    ]:
        code, output = on_slurm.end(on_slurm.start(*options))
        assert code == 2 and cause in output, output
    assert not on_slurm.command.runs.exists()


@pytest.mark.validate
@pytest.mark.engine
def test_two_ranks_on_two_nodes_give_the_bits_of_two_ranks_on_one(on_slurm, tmp_path):
    from millscale.engine.deck_run import find_engine

    command, engine = on_slurm.command, tmp_path / "engine"

    def engine_that_names_nodes(kind):
        used = tmp_path / f"nodes of {kind}"
        lines = ("#!/bin/sh", f"echo $SLURMD_NODENAME >>'{used}'", f'exec {find_engine()} "$@"', "")
        engine.write_text("\n".join(lines))
        engine.chmod(0o755)
        return used

    def made():
        """Return the results of the engine by name, and put the runs folder aside."""
        case = command.case(CHARGE)
        files = [case / "series.csv", *sorted((case / "dump").iterdir())]
        content = {file.name: file.read_bytes() for file in files}
        command.runs.rename(tmp_path / f"{len(list(tmp_path.iterdir()))}")
        return content

    results, nodes = {}, {}
    for count in (1, 2):
        used = engine_that_names_nodes(count)
        options = ("--ranks", "2", "--nodes", str(count), "--only", CHARGE)
        code, output = on_slurm.end(on_slurm.start(*options, MILLSCALE_ENGINE=str(engine)), 580)
        assert code == 0, output
        results[count], nodes[count] = made(), used.read_text().split()

    used = engine_that_names_nodes("by hand")
    command("generate")
    request = ("--nodes=2", "--ntasks-per-node=1", "--cpus-per-task=1")
    where = ("--chdir", str(command.case(CHARGE)), str(command.case(CHARGE) / "mpirun.sh"))
    names = f"RANKS=2,LIGGGHTS_MILL={engine}"
    on_slurm.cluster("sbatch", "--wait", f"--export=ALL,{names}", *request, *where)
    results["by hand"], nodes["by hand"] = made(), used.read_text().split()

    # Settling and rotation, two ranks each.
    assert nodes[1] == ["node1"] * 4
    for kind in (2, "by hand"):
        assert sorted(nodes[kind]) == ["node1", "node1", "node2", "node2"]
        assert len(results[1]) > 2 and results[kind] == results[1]
