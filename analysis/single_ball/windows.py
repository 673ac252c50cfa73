"""Between which mill angles the energies of the models of a scheme are compared."""

from __future__ import annotations

from dataclasses import dataclass

from millscale.analysis.paper import numbers as paper
from millscale.runs.case_folder import FinishedCase


@dataclass(frozen=True)
class Window:
    """Mill angles at which every model of a scheme is in the flight of its first throw, and a
    length of rotation that every one of these flights has.

    Attributes:
        begin, end: the same for all models [rad]; equal if their flights have no angle in common.
        from_throw: rotation counted from each model's own throw [rad].
        limited_by: id of the model that makes [begin, end] shorter than the paper's window, or
            None.
    """

    begin: float
    end: float
    from_throw: float
    limited_by: str | None


def common_windows(cases: list[FinishedCase]) -> dict[str, Window]:
    """The window of each scheme: from the last throw on, as long as the paper's, or to the first
    impact if that comes before."""
    thrown = [case for case in cases if case.result["throws"]]
    schemes = dict.fromkeys(case.case["scheme"] for case in thrown)
    return {s: _window([case for case in thrown if case.case["scheme"] == s]) for s in schemes}


def _window(cases: list[FinishedCase]) -> Window:
    longest = paper.longest_window()
    begin = max(_throw(case)["mill_angle_rad"] for case in cases)
    first = min(cases, key=_end)
    short = _end(first) < begin + longest
    return Window(
        begin=begin,
        end=max(begin, _end(first)) if short else begin + longest,
        from_throw=min(longest, *(_throw(case)["flight_length_rad"] for case in cases)),
        limited_by=first.id if short else None,
    )


def _throw(case: FinishedCase) -> dict:
    return case.result["throws"][0]


def _end(case: FinishedCase) -> float:
    return _throw(case)["mill_angle_rad"] + _throw(case)["flight_length_rad"]
