"""Units of length of drawings and tables."""

from __future__ import annotations

from types import MappingProxyType

# Metres of each unit.
LENGTHS = MappingProxyType({"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254, "ft": 0.3048})
ACCEPTED = ", ".join(LENGTHS)


def unit_that_fits(size: float, wanted: float, tolerance: float) -> str | None:
    """Return the unit in which a size of a file is the wanted one; None if there is none.

    Args:
        size: in the unit of the file.
        wanted: [m].
        tolerance: relative.
    """
    for unit, metres in LENGTHS.items():
        if abs(size * metres - wanted) <= tolerance * wanted:
            return unit
    return None
