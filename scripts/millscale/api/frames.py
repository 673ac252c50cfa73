"""Tables as pandas frames; `frame.attrs["units"]` holds the unit of each column by its name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import pandas as pd

from millscale.analysis.charge.rows import ChargeRow
from millscale.analysis.measures import ERRORS, ErrorColumn
from millscale.campaign.units import split_unit

# Units that end the names of columns, besides those of a campaign file.
_ENDINGS = {"_Nms": "N m s", "_Nm": "N m", "_kW": "kW", "_J": "J", "_W": "W"}
_SHOWN = {"_kg_m3": "kg/m3", "_m_s2": "m/s2", "_rad_s": "rad/s", "_m_s": "m/s", "_pa": "Pa",
          "_rpm": "1/min", "_percent": "%"}  # fmt: skip


def unit_of(column: str) -> str:
    """Return the unit that ends the name of a column: `centre_x_m` is in m; "-" without one."""
    if column == "percent_of_critical":
        return "%"
    for ending, unit in _ENDINGS.items():
        if column.endswith(ending):
            return unit
    _, suffix = split_unit(column)
    return _SHOWN.get(suffix, suffix.removeprefix("_")) or "-"


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
