"""An impact_spectra.csv of few bins."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from millscale.analysis.charge.impacts import COLUMNS, SPECTRA, energy_unit
from synthetic_case import typed

DURATION = 2.0


def write_spectra(
    folder: Path,
    case: dict[str, Any],
    contacts: float,
    strong: float = 1.0,
    classes: int = 1,
    all_contacts: float = 1.0,
    on_liner: float = 1.0,
) -> Path:
    """Write the spectra of one revolution, in proportion to its duration.

    Args:
        contacts: of each pair of classes, with 2e-4 and with 2e-3 of m (omega R)^2.
        strong: factor of the number of those with 2e-3.
        all_contacts: factor of the energy of all contacts.
        on_liner: factor of the number of those with the liner.
    """
    unit = energy_unit(typed(case))
    omega = case["mill"]["omega_rad_s"]
    scale = DURATION * omega / math.tau if "deck" in case and case["deck"].get("impacts") else 1.0
    pairs = [("ball_ball", a, b) for a in range(1, classes + 1) for b in range(a, classes + 1)]
    pairs += [("ball_wall", a, 0) for a in range(1, classes + 1)]
    rows, sums = [], {"ball_ball": 0.0, "ball_wall": 0.0}
    head = f"1,{1.0 + omega * DURATION!r},{DURATION!r}"
    for pairing, a, b in pairs:
        for quantity in ("dissipated", "available"):
            for energy, factor in ((2e-4, 1.0), (2e-3, strong)):
                count = contacts * scale * factor * (1.0 if b else on_liner)
                low, high = (10.0 ** (math.log10(energy) + d) * unit for d in (-0.05, 0.05))
                joule = count * energy * unit
                rows.append(
                    f"{head},{pairing},{a},{b},{quantity},{low!r},{high!r},{count!r},{joule!r}"
                )
                sums[pairing] += joule if quantity == "dissipated" else 0.0
    for pairing, ended in sums.items():
        for quantity, joule in (
            ("open_at_begin", 1.0 * unit),
            ("open_at_end", 1.5 * unit),
            ("all_contacts", (ended + 0.5 * unit) * all_contacts),
        ):
            rows.append(f"{head},{pairing},0,0,{quantity},0,0,10,{joule!r}")
    path = folder / SPECTRA
    path.write_text("\n".join([",".join(COLUMNS), *rows, ""]))
    return path
