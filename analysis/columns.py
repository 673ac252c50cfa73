"""Names of columns: which unit ends them, and how people read them."""

from __future__ import annotations

from millscale.campaign.units import split_unit

# Units that end the names of columns, besides those of a campaign file.
_ENDINGS = {"_Nms": "N m s", "_Nm": "N m", "_kW": "kW", "_J": "J", "_W": "W"}
_SHOWN = {"_kg_m3": "kg/m3", "_m_s2": "m/s2", "_rad_s": "rad/s", "_m_s": "m/s", "_pa": "Pa",
          "_rpm": "1/min", "_percent": "%"}  # fmt: skip
NO_UNIT = "-"


def unit_of(column: str) -> str:
    """Return the unit that ends the name of a column: `centre_x_m` is in m; "-" without one."""
    return _parts(column)[1]


def heading_of(column: str) -> str:
    """Return the name of a column in words: `drive_power_W` is "drive power [W]"."""
    name, unit = _parts(column)
    words = name.replace("_", " ")
    return words if unit == NO_UNIT else f"{words} [{unit}]"


def _parts(column: str) -> tuple[str, str]:
    if column == "percent_of_critical":
        return column, "%"
    for ending, unit in _ENDINGS.items():
        if column.endswith(ending):
            return column.removesuffix(ending), unit
    name, suffix = split_unit(column)
    unit = _SHOWN.get(suffix, suffix.removeprefix("_"))
    return (name, unit) if unit else (column, NO_UNIT)
