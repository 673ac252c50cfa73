"""Damaged and malicious files of a runs folder give a one-line error at once and do no harm."""

import json
import os
import re
import shutil
import signal
import socket
import time
from contextlib import chdir

import pytest

from millscale.workflow import stage_record
from small_campaign import CHARGE, SINGLE_BALLS
from small_command import small

BALL, OTHER = SINGLE_BALLS
# Of the processor: other work beside the tests does not count. A command that waits is ended after
# 20 s by the clock.
WITHIN_S = 2.0


def pipe(path):
    os.mkfifo(path)


def socket_at(path):
    # Its name may have 107 bytes only.
    with chdir(path.parent), socket.socket(socket.AF_UNIX) as end:
        end.bind(path.name)


def holes(path):
    with path.open("wb") as file:
        file.truncate(1 << 40)


def text(content):
    return lambda path: path.write_bytes(content.encode("latin-1"))


HOSTILE = {
    "pipe": pipe,
    "socket": socket_at,
    "folder": lambda path: path.mkdir(),
    "device": lambda path: path.symlink_to("/dev/zero"),
    "terabyte": holes,
    "brackets": text("[" * 200_000),
    "large": text('{"schema": 1' + "0" * 400 + "}"),
    "infinite": text('{"schema": 1e400}'),
    "nan": text('{"schema": NaN}'),
    "array": text("[1, 2]"),
    "word": text('{"schema": "x"}'),
    "terminal": text('{"schema": "\x1b[2J\x07"}'),
    "latin": text("gr\xfc\xdfe"),
    "zeros": text("\0" * 5000),
    "empty": text(""),
}
FILES = (
    *("campaign.json", "campaign.toml", "predicted.json", "log.workflow", ".millscale.lock"),
    *(
        f"cases/{BALL}/{name}"
        for name in (
            *("case.json", "stage.json", "provenance.json", "timing.json", "result.json"),
            *("mesh.json", "series.csv", "parameters.in", "single_ball.in", "liner.stl"),
            *("out.rotate", "log.rotate", ".digests"),
        )
    ),
    *(f"cases/{CHARGE}/{name}" for name in ("settled.json", "settled.restart", "charge.data")),
    *(
        f"cases/{OTHER}/rotate.part/{name}"
        for name in ("attempts.json", "series.csv", "log.rotate", "mill.1.restart")
    ),
)
QUICK = ("pipe", "brackets")
COMMANDS = (("status",), ("verify",), ("report",), ("run", "--dry-run"))


@pytest.fixture(scope="session")
def begun_once(finished_once, tmp_path_factory):
    """A finished run, a rotation of which was ended early."""
    folder = tmp_path_factory.mktemp("begun")
    shutil.copytree(finished_once.runs, folder / "runs", symlinks=True)
    command = small(folder)
    case = command.case(OTHER)
    (case / "rotate.part").mkdir()
    for name in ("series.csv", "log.rotate"):
        shutil.copy(case / name, case / "rotate.part" / name)
    (case / "series.csv").unlink()
    record = {"stage": "rotate", "state": "interrupted", "started": 1, "ended": 2, "process": 1}
    (case / "stage.json").write_text(json.dumps(record | {"process_started": 0.5}))
    attempts = '{"schema": 1, "inputs": {"a": "b"}, "starts": [{"step": 0, "began": 1, "ranks": 1'
    attempts += ', "before": {}}]}'
    (case / "rotate.part" / "attempts.json").write_text(attempts)
    return command


@pytest.fixture(autouse=True)
def no_hang():
    """A command that waits for a pipe fails its test."""

    def too_long(number, frame):
        raise TimeoutError("a command does not come back")

    before = signal.signal(signal.SIGALRM, too_long)
    signal.setitimer(signal.ITIMER_REAL, 20.0)
    yield
    signal.setitimer(signal.ITIMER_REAL, 0.0)
    signal.signal(signal.SIGALRM, before)


def put(make, path):
    if path.is_dir():
        shutil.rmtree(path)
    path.unlink(missing_ok=True)
    make(path)


def check(done, took, most_lines=1):
    printed = done.stdout + done.stderr
    assert done.returncode in (0, 1, 2)
    assert took < WITHIN_S
    assert "Traceback" not in printed
    assert not re.search("[\x00-\x08\x0b-\x1f\x7f]", printed)
    if done.returncode == 2:
        lines = done.stderr.splitlines()
        assert 1 <= len(lines) <= most_lines and all(x.startswith("error: ") for x in lines)


@pytest.mark.parametrize("file", FILES)
@pytest.mark.parametrize(
    "kind",
    [x if x in QUICK else pytest.param(x, marks=pytest.mark.validate) for x in HOSTILE],
)
def test_reading_commands_report_damage_in_one_line(begun_once, tmp_path, monkeypatch, kind, file):
    monkeypatch.setattr(
        "millscale.report.build.build_report", lambda runs, predict: results_of(runs)
    )
    shutil.copytree(begun_once.runs, tmp_path / "runs", symlinks=True)
    command = small(tmp_path)
    put(HOSTILE[kind], command.runs / file)
    before = sorted(tmp_path.rglob("*"))
    for words in COMMANDS:
        begin = time.process_time()
        done = command(*words)
        check(done, time.process_time() - begin)
    after = [x for x in tmp_path.rglob("*") if x.name != ".digests"]
    assert sorted(after) == [x for x in before if x.name != ".digests"]


@pytest.mark.parametrize("file", [*FILES, "settled"])
@pytest.mark.parametrize(
    "kind",
    [x if x == "pipe" else pytest.param(x, marks=pytest.mark.validate) for x in HOSTILE],
)
def test_a_run_refuses_damage_in_one_line_or_makes_the_file_anew(begun_once, tmp_path, kind, file):
    shutil.copytree(begun_once.runs, tmp_path / "runs", symlinks=True)
    command = small(tmp_path)
    put(HOSTILE[kind], command.runs / file)
    begin = time.process_time()
    done = command("run")
    refused = done.returncode == 2
    check(done, time.process_time() - begin if refused else 0.0)
    if kind in ("pipe", "socket", "device"):
        assert refused


@pytest.mark.parametrize("process", [-1, 0, (1 << 22) + 1, 1 << 31, 10**18, True, "1", 1.5, None])
def test_an_impossible_process_id_is_not_looked_up(begun_once, tmp_path, monkeypatch, process):
    shutil.copytree(begun_once.runs, tmp_path / "runs", symlinks=True)
    command = small(tmp_path)
    file = command.case(OTHER) / "stage.json"
    file.write_text(
        json.dumps(json.loads(file.read_text()) | {"process": process, "state": "running"})
    )
    looked_up = []
    monkeypatch.setattr(stage_record, "process_start", looked_up.append)
    done = command("status", "--json")
    check(done, 0.0)
    assert looked_up == []
    assert {x["state"] for x in json.loads(done.stdout)} >= {"done"}


def test_a_damaged_case_is_shown_beside_the_others(begun_once, tmp_path):
    shutil.copytree(begun_once.runs, tmp_path / "runs", symlinks=True)
    command = small(tmp_path)
    (command.case(BALL) / "case.json").write_text("[" * 200_000)
    rows = {x["id"]: x for x in json.loads(command("status", "--json").stdout)}
    assert (rows[BALL]["state"], rows[BALL]["failure"]) == ("damaged", "damaged file")
    assert "case.json: not valid JSON (nested too deep)" in rows[BALL]["problem"]
    assert (rows[OTHER]["state"], rows[CHARGE]["state"]) == ("interrupted", "done")
    text = command("status").stdout
    assert f"{BALL}: damaged: damaged file: case.json: not valid JSON" in " ".join(text.split())


def test_control_characters_are_not_printed(begun_once, tmp_path):
    shutil.copytree(begun_once.runs, tmp_path / "runs", symlinks=True)
    command = small(tmp_path)
    other = command.case(OTHER)
    record = json.loads((other / "stage.json").read_text())
    record |= {"state": "failed", "cause": "\x1b[2J\x9b1m", "advice": "\x07", "log": "\x1b]0;x\x07"}
    (other / "stage.json").write_text(json.dumps(record))
    (other / "a\x1b[31m.in").write_text("x")
    (command.runs / "log.workflow").write_text("\x1b[2J")
    for words in (("status",), ("verify",), ("run", "--dry-run")):
        check(command(*words), 0.0)


def results_of(runs):
    """What a report computes, without its page and pictures."""
    from millscale.analysis.finished_campaign import load_campaign

    load_campaign(runs).results()


@pytest.mark.parametrize(
    "content",
    ["a." * 500_000 + "a = 1", "[" + "a." * 500_000 + "a]", '"#" . ' * 170_000 + "a = 1",
     "a = " + "[" * 1_000_000, "a = " + "{a = " * 200_000, "a = 1,5" + "0" * 1_000_000,
     "a" * 1_000_000 + " = 1", "[" + "a" * 1_000_000 + "]", "a = " + "9" * 1_000_000],
    ids=["dotted key", "deep table", "quoted", "brackets", "braces", "comma", "key", "table",
         "number"],
)  # fmt: skip
def test_a_campaign_file_that_takes_long_to_parse_is_refused_at_once(tmp_path, content):
    command = small(tmp_path)
    command.file.write_text(content[: (1 << 20) - 1])
    begin = time.process_time()
    done = command("plan")
    # Of what is TOML, every mistake has a line: an unknown key, three missing sections, no part.
    check(done, time.process_time() - begin, most_lines=5)
    assert done.returncode == 2 and len(done.stderr) < 5000


def test_a_text_with_many_points_is_not_a_long_key(tmp_path):
    command = small(tmp_path)
    about = 'about = "www.a.b.c ... 1.0.0, see e.g. 3.2.1"'
    text = command.file.read_text().replace("[campaign]", f"# {'.' * 60}\n[campaign]\n{about}")
    ratios = [1.0 + 0.1 * i for i in range(30)]
    command.file.write_text(text.partition("[multi_ball]")[0].replace("[1.0, 2.0]", f"{ratios}"))
    assert command("plan").returncode == 0
