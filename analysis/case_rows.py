"""A row for each finished case: what it is and its main results."""

from __future__ import annotations

from typing import Any

from millscale.analysis.charge.physical_mill import physical_power
from millscale.analysis.finished import Charge, SingleBall
from millscale.analysis.finished_campaign import Campaign


def case_rows(campaign: Campaign) -> list[dict[str, Any]]:
    """Return a row for each finished case; the names of columns end with their unit.

    power_kW is that of the physical mill, power_number is power over M g R omega. Both are of
    multi-ball cases, detach_angle_deg is of single balls.
    """
    return [_row(case) for case in campaign.cases]


def _row(finished: SingleBall | Charge) -> dict[str, Any]:
    case, mill = finished.case, finished.case.mill
    row = {
        **{key: getattr(case, key) for key in ("id", "kind", "scheme", "policy", "S", "seed")},
        "balls": case.ball.count,
        "mass_kg": case.ball.count * case.ball.mass_kg,
        **{
            key: getattr(mill, key)
            for key in ("radius_m", "simulated_length_m", "gravity_m_s2", "omega_rad_s")
        },
        "percent_of_critical": mill.percent_of_critical,
    }
    row |= dict.fromkeys(("detach_angle_deg", "power_kW", "power_number", "is_steady"))
    if isinstance(finished, Charge):
        result = finished.result
        row |= {
            "power_kW": 1e-3 * physical_power(finished),
            "power_number": result.dimensionless["power"],
            "is_steady": result.steady.is_steady,
        }
    else:
        row["detach_angle_deg"] = finished.result.detach_angle_deg
    return row | {"wall_time_s": finished.timing.wall_time_s}
