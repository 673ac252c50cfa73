"""Finished cases with another content of case.json or result.json."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, TypeVar

from msgspec import structs

from millscale.analysis.finished import Finished, SingleBall

F = TypeVar("F", bound=Finished)


def with_case(one: F, **changes: Any) -> F:
    """Return a finished case whose case.json has other values of these keys."""
    case = structs.replace(one.finished.case, **changes)
    return replace(one, finished=replace(one.finished, case=case))


def with_result(one: F, **changes: Any) -> F:
    """Return a finished case whose result.json has other values of these keys."""
    result = one.finished.result | changes
    return replace(one, finished=replace(one.finished, result=result))


def with_throw(ball: SingleBall, **changes: Any) -> SingleBall:
    """Return a ball whose first throw has other values of these keys."""
    throws = ball.finished.result["throws"]
    return with_result(ball, throws=[throws[0] | changes, *throws[1:]])
