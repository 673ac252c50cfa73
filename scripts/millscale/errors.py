"""Errors that the command line prints as one line for each mistake."""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager

from millscale.terminal import one_line


class CampaignError(ValueError):
    """A campaign that cannot be run: which file and key, the value, what is accepted.

    Attributes:
        file: the campaign file.
        key: path of the key, such as `mill.speed_rpm`; empty if the whole file is meant.
        cause: what is wrong and the value got.
        accepted: what would be accepted; may be empty.
        line: line of the file, from 1; None if it is not known.
        mistakes: all mistakes of the file, this one first; each is one line of the text.
    """

    def __init__(
        self, file: object, key: str, cause: str, accepted: str = "", line: int | None = None
    ) -> None:
        self.file, self.key = str(file), key
        self.cause, self.accepted, self.line = cause, accepted, line
        self.mistakes: tuple[CampaignError, ...] = (self,)
        place = f"{self.file}:{line}" if line else self.file
        where = f"{place}: {key}" if key else place
        text = f"{where}: {cause}" + (f"; accepted: {accepted}" if accepted else "")
        super().__init__(one_line(text))

    def each(self, change: Callable[[CampaignError], CampaignError]) -> CampaignError:
        """Return the error with each of its mistakes changed."""
        return one_error([change(mistake) for mistake in self.mistakes])


def one_error(mistakes: Iterable[CampaignError]) -> CampaignError:
    """Return the error of some mistakes in one file, in the order of their lines; those without
    line last."""
    found = sorted(mistakes, key=lambda mistake: mistake.line or math.inf)
    first = found[0]
    error = CampaignError(first.file, first.key, first.cause, first.accepted, first.line)
    error.mistakes = tuple(found)
    error.args = ("\n".join(str(mistake) for mistake in found),)
    return error


class Mistakes:
    """Mistakes that are collected to be raised together."""

    def __init__(self) -> None:
        self.found: list[CampaignError] = []

    @contextmanager
    def collected(self) -> Iterator[None]:
        """Keep the mistakes of a `CampaignError` raised in this block, and go on after it."""
        try:
            yield
        except CampaignError as error:
            self.found += error.mistakes

    def raise_all(self) -> None:
        """Raise the mistakes found, if any.

        Raises:
            CampaignError: holds every mistake.
        """
        if self.found:
            raise one_error(self.found) from None


class PredictionError(ValueError):
    """Runs that do not allow a prediction of the physical mill: why, and what would."""


class EngineError(RuntimeError):
    """The engine did not finish its deck."""


def nearest(word: str, known: Iterable[str]) -> str:
    """Return the known word most like `word`, or an empty string if none is near."""
    matches = difflib.get_close_matches(word, list(known), n=1, cutoff=0.5)
    return matches[0] if matches else ""
