"""Targets of a run: what each must provide, and what a batch system adds to its base class."""

import pytest

from millscale.cases.cost import BUILT_IN
from millscale.engine.machine import Allocation, CoreWish
from millscale.errors import CampaignError
from millscale.workflow.failures import MEMORY, TIME_OUT, Traces, classify
from millscale.workflow.jobs import jobs_of
from millscale.workflow.targets import TARGETS, target_named
from millscale.workflow.targets.batch_system import MOST_JOBS, BatchSystem
from paper_campaign import MULTI_BALL, cases


class Queue(BatchSystem):
    """A batch system with nodes of eight cores, whose plugin and command are always there."""

    name, about, title = "queue", "jobs of a made-up queue", "Queue"
    plugin, install, commands = "json", "nothing", ("sh",)

    def node_cores(self):
        return 8

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


def test_a_batch_system_gives_a_case_the_ranks_of_one_node(tmp_path):
    some = cases(tmp_path, **MULTI_BALL)
    allocation = Queue().allocate(some, CoreWish(), CoreWish(), BUILT_IN)
    assert (allocation.jobs, allocation.cores) == (MOST_JOBS, 8)
    assert max(allocation.ranks.values()) <= 8
    asked = Queue().allocate(some, CoreWish(ranks=4, jobs=3), CoreWish(ranks=2), BUILT_IN)
    assert asked.jobs == 3
    assert {asked.ranks[x.id] for x in some if x.kind == "multi-ball"} == {4}
    assert {asked.ranks[x.id] for x in some if x.kind == "single-ball"} == {1}


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
    with pytest.raises(CampaignError, match="no_such_module is not installed; accepted: nothing"):
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
