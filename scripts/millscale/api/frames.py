"""Tables as pandas frames; `frame.attrs["units"]` holds the unit of each column by its name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import pandas as pd

from millscale.analysis.charge.rows import ChargeRow
from millscale.analysis.columns import unit_of
from millscale.analysis.measures import ERRORS, ErrorColumn


def frame(
    columns: Mapping[str, Any] | Iterable[Mapping[str, Any]],
    index: str | None = None,
    units: Mapping[str, str] | None = None,
    **about: Any,
) -> pd.DataFrame:
    """Return a table with the units of its columns.

    Args:
        columns: by name, or rows of values by name.
        index: column that names the rows.
        units: of columns whose name does not end with one.
        about: further entries of `attrs`.
    """
    made = pd.DataFrame(columns if isinstance(columns, Mapping) else list(columns))
    if index is not None and index in made:
        made = made.set_index(index)
    named = {str(column): unit_of(str(column)) for column in made.columns}
    made.attrs = {"units": named | dict(units or {}), **about}
    return made


# Errors of one number each.
SCALAR_ERRORS = tuple(error for error in ERRORS if not error.by_curtain)


def error_unit(error: ErrorColumn) -> str:
    """Return the unit of an error as it is stored."""
    if error.unit == "deg":
        return "rad"
    return error.unit.removeprefix("%").removeprefix(" of ").strip() or "-"


def error_frame(rows: Iterable[ChargeRow]) -> pd.DataFrame:
    """Return a row for each multi-ball case: its errors against its reference, in the mean over the
    steady part of the rotation, and the speed-up."""
    content = [
        {
            **{key: getattr(row.charge, key) for key in ("campaign", "id", "scheme", "policy")},
            **{"S": row.charge.S, "seed": row.charge.seed, "reference": row.reference.id},
            "speed_up": row.speed_up,
            **{error.name: row.errors.steady(error.name) for error in SCALAR_ERRORS},
        }
        for row in rows
    ]
    units = {error.name: error_unit(error) for error in SCALAR_ERRORS}
    labels = {error.name: error.label for error in SCALAR_ERRORS}
    return frame(content, "id", units, labels=labels)
