"""solve.json: what was asked for and the rounds so far, so that the same command resumes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from millscale.errors import CampaignError
from millscale.prediction.solve import Ask, Round
from millscale.runs.lock import LOCK_FILE
from millscale.runs.typed import read_typed
from millscale.runs.writing import write_json

SCHEMA = 1
NAME = "solve.json"


@dataclass(frozen=True)
class Record:
    """Content of solve.json.

    Attributes:
        file: name of the campaign file.
        digest: of its content.
        ask: of the last call; an earlier call may have asked for something else.
    """

    schema: int
    file: str
    digest: str
    ask: Ask
    rounds: tuple[Round, ...]


def read_rounds(folder: Path, file: Path, digest: str) -> tuple[Round, ...]:
    """Return the rounds of a folder; none if it is new.

    Another error, budget or list of observables uses the same runs, and may add some.

    Raises:
        CampaignError: the folder is of another campaign file, or of something else.
        RunFolderError: solve.json is damaged.
    """
    path = folder / NAME
    if not path.exists():
        other = next((x.name for x in folder.glob("*") if x.name != LOCK_FILE), None)
        if other:
            cause = f"holds {other}, but no {NAME}"
            raise CampaignError(folder, "", cause, "a new folder, or one of millscale solve")
        return ()
    record = read_typed(path, Record, f"remove {folder}, or name another folder")
    if record.digest != digest:
        cause = f"was made for {record.file}, which differs from {file}"
        raise CampaignError(path, "", cause, "another folder, or the same campaign file")
    return record.rounds


def write_rounds(folder: Path, file: Path, digest: str, ask: Ask, rounds: Sequence[Round]) -> None:
    """Write solve.json."""
    write_json(folder / NAME, asdict(Record(SCHEMA, file.name, digest, ask, tuple(rounds))))
