"""Mill angles between which the energies of the scaled mills of a scheme are compared."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from millscale.analysis.finished import SingleBall
from millscale.analysis.paper import numbers as paper
from millscale.analysis.result_file import Thrown


@dataclass(frozen=True)
class Window:
    """Mill angles at which every scaled mill of a scheme is in the flight of its first throw, and a
    length of rotation that each of these flights has.

    Attributes:
        begin, end: the same for all mills [rad]; equal if their flights have no angle in common.
        from_throw: rotation counted from the throw of each mill [rad].
        limited_by: id of the case that makes [begin, end] shorter than the paper's window, or None.
    """

    begin: float
    end: float
    from_throw: float
    limited_by: str | None


def common_windows(balls: Sequence[SingleBall]) -> dict[str, Window]:
    """Return the window of each scheme: from the last throw on, as long as the paper's, or to the
    first impact if that comes before."""
    thrown = [ball for ball in balls if ball.result.throws]
    schemes = dict.fromkeys(ball.scheme for ball in thrown)
    return {s: _window([ball for ball in thrown if ball.scheme == s]) for s in schemes}


def _window(balls: Sequence[SingleBall]) -> Window:
    longest = paper.longest_window()
    begin = max(_throw(ball).mill_angle_rad for ball in balls)
    first = min(balls, key=lambda ball: _throw(ball).mill_angle_end_rad)
    impact = _throw(first).mill_angle_end_rad
    short = impact < begin + longest
    return Window(
        begin=begin,
        end=max(begin, impact) if short else begin + longest,
        from_throw=min(longest, *(_throw(ball).flight_length_rad for ball in balls)),
        limited_by=first.id if short else None,
    )


def _throw(ball: SingleBall) -> Thrown:
    return ball.result.throws[0]
