"""Errors that the command line prints as one line."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

from millscale.terminal import one_line


class CampaignError(ValueError):
    """A campaign that cannot be run: which file and key, the value, what is accepted.

    Attributes:
        file: the campaign file.
        key: path of the key, such as `mill.speed_rpm`; empty if the whole file is meant.
        cause: what is wrong and the value got.
        accepted: what would be accepted; may be empty.
    """

    def __init__(self, file: object, key: str, cause: str, accepted: str = "") -> None:
        self.file, self.key = str(file), key
        self.cause, self.accepted = cause, accepted
        where = f"{self.file}: {key}" if key else self.file
        text = f"{where}: {cause}" + (f"; accepted: {accepted}" if accepted else "")
        super().__init__(one_line(text))


class PredictionError(ValueError):
    """Runs that do not allow a prediction of the physical mill: why, and what would."""


class EngineError(RuntimeError):
    """The engine did not finish its deck."""


def nearest(word: str, known: Iterable[str]) -> str:
    """Return the known word most like `word`, or an empty string if none is near."""
    matches = difflib.get_close_matches(word, list(known), n=1, cutoff=0.5)
    return matches[0] if matches else ""
