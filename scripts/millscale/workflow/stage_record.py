"""stage.json of a case folder: the last stage that began, and how it ended."""

from __future__ import annotations

import json
import os
import socket
import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from millscale.engine.process_start import process_start
from millscale.runs.typed import read_typed
from millscale.runs.writing import write_over, write_text
from millscale.terminal import one_line

RECORD_FILE = "stage.json"
STATES = ("running", "done", "failed", "interrupted")
LARGEST_BYTES = 1 << 16
# Process numbers of Linux are below; 0 and negative numbers name groups of processes.
MOST_PROCESS = 1 << 22


@dataclass(frozen=True)
class StageRecord:
    """The last stage that began in a case folder.

    Attributes:
        state: running, done, failed or interrupted.
        started, ended: times [s since 1970]; `ended` is 0 while the stage runs.
        process, process_started: number and start [clock ticks] of its process; a later process
            may have the same number.
        cause: why it failed, one line.
        log: file in the case folder that explains the failure.
        kind, advice: kind of the failure and what to do; empty unless it failed.
        host: machine of the process.
        case: digest of the case.
    """

    stage: str
    state: str
    started: float
    ended: float
    process: int
    process_started: float
    cause: str = ""
    log: str = ""
    kind: str = ""
    advice: str = ""
    host: str = ""
    case: str = ""

    def alive(self) -> bool:
        """Return whether the process of the stage exists; true for one on another machine."""
        if self.host and self.host != socket.gethostname():
            return True
        return process_start(self.process) == self.process_started


def begin(folder: Path, stage: str, case: str = "") -> StageRecord:
    """Record that this process begins a stage of the case with this digest."""
    record = StageRecord(
        stage,
        "running",
        started=time.time(),
        ended=0.0,
        process=os.getpid(),
        process_started=float(process_start(os.getpid()) or 0),
        host=socket.gethostname(),
        case=case,
    )
    _write(folder, record)
    return record


def end(folder: Path, record: StageRecord, state: str, cause: str = "", log: str = "") -> None:
    """Record how the stage ended."""
    ended = replace(record, state=state, ended=time.time(), cause=one_line(cause), log=log)
    _write(folder, ended)


def read_record(folder: Path) -> StageRecord | None:
    """Return the record of a case folder; None if there is none that can be read."""
    try:
        record = read_typed(folder / RECORD_FILE, StageRecord, "", LARGEST_BYTES)
    except ValueError:
        return None
    if record.state not in STATES or not 0 < record.process <= MOST_PROCESS:
        return None
    return replace(
        record,
        stage=one_line(record.stage),
        cause=one_line(record.cause),
        log=one_line(record.log),
        advice=one_line(record.advice),
    )


def _write(folder: Path, record: StageRecord) -> None:
    text = json.dumps(asdict(record), indent=1) + "\n"
    try:
        write_text(folder / RECORD_FILE, text)
    except OSError:
        # On a full disk, the text still fits into the block that the record already has.
        write_over(folder / RECORD_FILE, text)
