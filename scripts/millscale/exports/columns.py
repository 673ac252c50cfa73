"""Columns of a dump under names that people read."""

from __future__ import annotations

# Of compute mill/detach: docs/reference/files.md, dump/charge.STEP.liggghts.
_PLAIN = {
    "type": "class",
    "c_detach[1]": "state",
    "c_detach[12]": "flight_count",
    "c_detach[14]": "flight_mill_angle_rad",
    "c_detach[15]": "flight_lifter",
    "c_detach[22]": "time_in_flight_s",
    "c_detach[23]": "from_outermost_layer",
    "c_detach[24]": "last_lifter",
}
# Units of columns whose name does not end with one.
_UNITS = {
    **dict.fromkeys(("x", "y", "z", "radius"), "m"),
    **dict.fromkeys(("vx", "vy", "vz"), "m_s"),
}


def plain_name(column: str) -> str:
    """Return the name of a column of a dump: `c_detach[24]` is `last_lifter`."""
    return _PLAIN.get(column, column)


def name_with_unit(column: str) -> str:
    """Return the same with its unit at the end: `vx` is `vx_m_s`."""
    unit = _UNITS.get(column)
    return f"{column}_{unit}" if unit else plain_name(column)
