"""Targets of a run: what each must provide, and what a batch system adds to its base class."""

import os

import pytest

from millscale.cases.cost import BUILT_IN
from millscale.engine.deck_run import engine_environment, mpirun_line
from millscale.engine.machine import Allocation, CoreWish, Spread, ranks_per_node
from millscale.engine.temporary_folder import own_folder
from millscale.errors import CampaignError, EngineError
from millscale.workflow import targets
from millscale.workflow.failures import MEMORY, TIME_OUT, Traces, classify
from millscale.workflow.jobs import jobs_of
from millscale.workflow.targets import TARGETS, Slurm, slurm, spread_of, target_named
from millscale.workflow.targets.batch_system import MOST_JOBS, BatchSystem, Nodes
from paper_campaign import MULTI_BALL, cases


class Queue(BatchSystem):
    """A batch system of four nodes of eight cores, whose plugin and command are always there."""

    name, about, title = "queue", "jobs of a made-up queue", "Queue"
    plugin, extra, commands = "json", "slurm", ("sh",)
    job_variable = "QUEUE_JOB"

    def nodes(self):
        return Nodes(cores=8, count=4)

    def spread(self, ranks, nodes):
        return Spread(ranks_per_node(ranks, nodes), {"QUEUE_JOB": os.environ["QUEUE_JOB"]})

    def executor_options(self):
        return ["--executor", "made-up"]


def value_of(options, name):
    return options[options.index(name) + 1]


def test_every_target_is_found_by_its_name():
    assert {"local", "slurm"} <= set(TARGETS)
    for name, target in TARGETS.items():
        assert target.name == name and target.about
        assert isinstance(target_named(name), target)


def test_this_machine_takes_no_profile(tmp_path):
    with pytest.raises(CampaignError, match="--profile: got one without a batch system"):
        target_named("local", tmp_path)


def test_a_batch_system_gives_a_case_ranks_of_one_node(tmp_path):
    some = cases(tmp_path, **MULTI_BALL)
    allocation = Queue().allocate(some, CoreWish(), CoreWish(), BUILT_IN)
    assert (allocation.jobs, allocation.cores) == (MOST_JOBS, 32)
    assert max(allocation.ranks.values()) <= 8
    assert {allocation.nodes_of(x.id) for x in some} == {1}
    asked = Queue().allocate(some, CoreWish(ranks=4, jobs=3), CoreWish(ranks=2), BUILT_IN)
    assert asked.jobs == 3
    assert {asked.ranks[x.id] for x in some if x.kind == "multi-ball"} == {4}
    assert {asked.ranks[x.id] for x in some if x.kind == "single-ball"} == {1}


@pytest.mark.parametrize(
    ("ranks", "asked", "nodes"),
    [(8, None, 1), (9, None, 2), (32, None, 4), (8, 4, 4), (2, 4, 2), (5, 4, 3), (9, 1, 2)],
)
def test_a_case_has_the_nodes_its_ranks_need_or_those_asked_for(ranks, asked, nodes):
    allocation = Allocation({"a": ranks}, 1, 32, node_cores=8, nodes=asked or 1)
    found = allocation.nodes_of("a")
    assert found == nodes
    # Every node has a rank, none more than its cores.
    assert (found - 1) * ranks_per_node(ranks, found) < ranks
    assert ranks_per_node(ranks, found) <= 8


def test_a_case_on_several_nodes_may_use_the_cores_of_all(tmp_path):
    some = cases(tmp_path, **MULTI_BALL, mill__length_m=10.0, multi_ball__count=[10**6, 10**4])
    one = Queue().allocate(some, CoreWish(), CoreWish(), BUILT_IN)
    three = Queue().allocate(some, CoreWish(nodes=3), CoreWish(), BUILT_IN)
    assert max(one.ranks.values()) == 8 < max(three.ranks.values()) <= 24
    job, lone = (
        max(jobs_of(some, x, BUILT_IN, Queue().shared_job_s), key=lambda job: job.ranks)
        for x in (three, one)
    )
    assert (job.nodes, lone.nodes) == (3, 1)
    # Of each node.
    assert job.memory_mb < lone.memory_mb
    assert f"{job.ranks} cores on 3 nodes, " in Queue().request_lines([job])[0]


@pytest.mark.parametrize(
    ("wish", "message"),
    [
        (CoreWish(ranks=33), "--ranks 33: needs 5 nodes, a job can have 4; accepted: at most 32"),
        (CoreWish(nodes=5), "--nodes 5: needs 5 nodes, a job can have 4"),
        (CoreWish(ranks=9, nodes=1), "needs 2 nodes of 8 cores; accepted: --nodes 2, or at most 8"),
        (CoreWish(ranks=3, nodes=2), "nodes with unequal ranks; accepted: a multiple of 2 ranks"),
        (CoreWish(nodes=0), "--nodes: got 0; accepted: a whole number >= 1"),
        (CoreWish(ranks=-1), "--ranks: got -1; accepted: a whole number >= 1"),
    ],
)
def test_ranks_and_nodes_that_no_job_can_have_are_refused(tmp_path, wish, message):
    with pytest.raises(CampaignError, match=message):
        Queue().allocate(cases(tmp_path, **MULTI_BALL), wish, CoreWish(), BUILT_IN)


def test_this_machine_is_one_node(tmp_path):
    some = cases(tmp_path, **MULTI_BALL)
    with pytest.raises(CampaignError, match="--nodes 2: this machine is one node"):
        target_named("local").allocate(some, CoreWish(nodes=2), CoreWish(), BUILT_IN)
    chosen = target_named("local").allocate(some, CoreWish(nodes=1), CoreWish(), BUILT_IN)
    assert {chosen.nodes_of(x.id) for x in some} == {1}


def test_only_mpirun_on_several_nodes_sees_the_variables_of_the_job(monkeypatch):
    monkeypatch.setattr(targets, "_TARGETS", (Queue,))
    with pytest.raises(CampaignError, match="2 nodes outside a batch job"):
        spread_of(4, 2)
    monkeypatch.setenv("QUEUE_JOB", "7")
    monkeypatch.setenv("SLURM_NTASKS", "1")
    assert spread_of(4, 1) is None
    spread = spread_of(4, 2)
    assert mpirun_line("engine", "a.in", "log", 4, spread.per_node)[1:7] == [
        *("-np", "4", "--bind-to", "none", "--map-by", "ppr:2:node")
    ]
    with own_folder():
        here, there = engine_environment(), engine_environment(spread)
    assert "SLURM_NTASKS" not in here and "SLURM_NTASKS" not in there
    assert there["QUEUE_JOB"] == "7"
    # The temporary folders of a run exist on one node.
    left = {name for name in here if name not in there}
    assert left and all("backing_directory" in name for name in left)
    assert here["TMPDIR"].startswith(there["TMPDIR"] + "/millscale-")


def test_slurm_names_its_largest_nodes(monkeypatch):
    answers = {"two sizes, two partitions": "16 10\n64 2\n64 6\n", "nobody": ""}
    monkeypatch.setattr(slurm, "_run", lambda *line: answers["two sizes, two partitions"])
    assert Slurm().nodes() == Nodes(cores=64, count=6)
    monkeypatch.setattr(slurm, "_run", lambda *line: answers["nobody"])
    with pytest.raises(CampaignError, match="sinfo names no nodes"):
        Slurm().nodes()


def test_slurm_gives_mpirun_the_nodes_of_the_job(monkeypatch):
    monkeypatch.setenv("SLURM_JOB_ID", "42")
    monkeypatch.delenv("SLURM_CONF", raising=False)
    monkeypatch.setattr(slurm, "_run", lambda *line: "n[3-5]\n" if "42" in line else "")
    spread = Slurm().spread(12, 3)
    assert spread.per_node == 4
    assert spread.environment["SLURM_NODELIST"] == "n[3-5]"
    assert spread.environment["SLURM_TASKS_PER_NODE"] == "4(x3)"
    assert "SLURM_CONF" not in spread.environment
    # The executor removes the variable from the jobs.
    monkeypatch.setenv("SLURM_CONF", "/etc/elsewhere.conf")
    with Slurm().waiting():
        monkeypatch.delenv("SLURM_CONF")
        assert Slurm().spread(12, 3).environment["SLURM_CONF"] == "/etc/elsewhere.conf"
    assert "SLURM_CONF" not in Slurm().spread(12, 3).environment
    monkeypatch.setenv("SLURM_JOB_ID", "43")
    with pytest.raises(EngineError, match="squeue names no nodes of job 43"):
        Slurm().spread(12, 3)


def test_a_batch_system_passes_executor_retries_and_profile_to_snakemake(tmp_path):
    (tmp_path / "config.yaml").write_text("")
    options = Queue(tmp_path).snakemake_options(Allocation({}, 7, 8))
    assert value_of(options, "--executor") == "made-up"
    assert value_of(options, "--jobs") == "7"
    assert int(value_of(options, "--retries")) > 0
    assert value_of(options, "--profile") == str(tmp_path)
    assert value_of(Queue().snakemake_options(Allocation({}, 7, 8)), "--profile") == "none"


def test_a_batch_system_without_its_programs_is_refused(monkeypatch):
    monkeypatch.setattr(Queue, "commands", ("no-such-command",))
    with pytest.raises(CampaignError, match="--target queue: no no-such-command on the PATH"):
        Queue().check()
    monkeypatch.setattr(Queue, "plugin", "no_such_module")
    with pytest.raises(CampaignError, match=r"no_such_module is not .*install snakemake-executor"):
        Queue().check()


def test_the_request_is_one_line_for_each_of_the_longest_jobs(tmp_path):
    some = cases(tmp_path, **MULTI_BALL, scaling__S=[1.0, 2.0])
    target = Queue()
    allocation = target.allocate(some, CoreWish(ranks=2), CoreWish(), BUILT_IN)
    jobs = jobs_of(some, allocation, BUILT_IN, target.shared_job_s)
    lines = target.request_lines(jobs)
    assert len(lines) == len(jobs)
    assert lines[0].startswith(f"Queue: {jobs[0].name}: {jobs[0].minutes} min requested, ")
    assert target.request_lines(jobs * 30)[-1] == f"Queue: and {30 * len(jobs) - 20} shorter jobs"


@pytest.mark.parametrize(
    ("printed", "kind"),
    [
        ("slurmstepd: error: *** STEP 7.0 CANCELLED AT 09:00 DUE TO TIME LIMIT ***", TIME_OUT),
        ("slurmstepd: error: Detected 1 oom_kill event in StepId=7.0.", MEMORY),
    ],
)
def test_messages_of_a_batch_system_name_the_failure(printed, kind):
    error = "mpirun ended by signal 9"
    assert classify(Traces(error, printed=printed, runs_engine=True)).kind == kind
