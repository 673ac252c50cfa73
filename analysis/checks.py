"""What a campaign must show, each claim with its value and its limit."""

from __future__ import annotations

from typing import Any

from millscale.runs.case_folder import FinishedCase

LEAST_CORRELATION = 0.999
MOST_DEVIATION = {"paper": 0.04}
MOST_DEVIATION_CORRECTED = 0.015  # of the better of the other policies
MOST_ANGLE_SPREAD_DEG = 1.5
MOST_OFF_PARABOLA = 1e-3  # of the energy change
MOST_OVERLAP = 0.1  # of the ball radius
# Over M g R. The two ways to the torque differ by how finely the centre of mass is sampled.
MOST_TORQUE_DIFFERENCE = 1e-3
# Of the torque between even and odd steps: beyond it a time step is too long for the wall.
MOST_ALTERNATING = 5e-3

Row = dict[str, Any]


def campaign_checks(
    rows: list[Row], fits: list[Row], charges: list[FinishedCase], missing: dict[str, str]
) -> dict[str, Row]:
    """Checks by name. `passed` is None where the campaign does not hold enough to tell.

    Args:
        rows: of `comparison.single_ball_rows`.
        fits: of `comparison.regressions`, of the paper's mill: the limits are about its numbers.
        charges: finished multi-ball cases.
        missing: why a case is not in the report, by its id.
    """
    checks = {"all_cases_finished": _check("no case is missing", len(missing), 0)}
    if rows:
        checks |= _single_ball(rows)
    for scheme in dict.fromkeys(fit["scheme"] for fit in fits):
        checks |= _law(scheme, [fit for fit in fits if fit["scheme"] == scheme])
    for case in charges:
        checks[f"balls_kept/{case.id}"] = _check(
            f"{case.id}: no ball is lost", int(case.result["problem"] is not None), 0
        )
        checks |= _torque(case)
        overlap = case.result["largest_overlap_over_radius"]
        if overlap is not None:
            text = f"{case.id}: largest overlap over ball radius, at the rows of series.csv"
            checks[f"overlap/{case.id}"] = _check(text, overlap, MOST_OVERLAP)
    return checks


def _torque(case: FinishedCase) -> dict[str, Row]:
    result, steady = case.result, case.result["steady"]
    why = f": {'; '.join(steady['reasons'])}" if steady["reasons"] else ""
    return {
        f"torque_balance/{case.id}": _check(
            f"{case.id}: torque summed over the steps less that by weight and angular momentum, "
            "over M g R",
            abs(result["torque_balance"]["difference"]),
            MOST_TORQUE_DIFFERENCE,
        ),
        f"alternating_torque/{case.id}": _check(
            f"{case.id}: part of the torque that alternates from step to step, over M g R",
            result["alternating_torque"],
            MOST_ALTERNATING,
        ),
        f"steady/{case.id}": _check(
            f"{case.id}: reasons why the charge is not steady{why}", len(steady["reasons"]), 0
        ),
    }


def _single_ball(rows: list[Row]) -> dict[str, Row]:
    idle = sum(row["problem"] is not None for row in rows)
    thrown = [row for row in rows if row["off_parabola"] is not None]
    return {
        "every_ball_is_thrown": _check("cases without a throw", idle, 0),
        "flight_is_a_parabola": _check(
            "samples of the throw off the parabola of its release, over the energy change",
            max((row["off_parabola"] for row in thrown), default=None),
            MOST_OFF_PARABOLA,
        ),
        "kinetic_gain_is_potential_loss": _check(
            "kinetic energy gained less potential energy lost, in the samples, over the change",
            max((row["energy_imbalance"] for row in thrown), default=None),
            MOST_OFF_PARABOLA,
        ),
    }


def _law(scheme: str, fits: list[Row]) -> dict[str, Row]:
    checks = {}
    for fit in fits:
        policy = fit["policy"]
        correlation = fit["correlation"]
        checks[f"linear_in_prediction/{scheme}/{policy}"] = {
            "text": f"{scheme}, {policy}: correlation of the energy ratio with its prediction",
            "value": correlation,
            "limit": LEAST_CORRELATION,
            "sense": ">=",
            "passed": None if correlation is None else correlation >= LEAST_CORRELATION,
        }
        if policy in MOST_DEVIATION:
            checks[f"worst_deviation/{scheme}/{policy}"] = _check(
                f"{scheme}, {policy}: worst deviation of the energy ratio from its prediction",
                _size(fit),
                MOST_DEVIATION[policy],
            )
    better = _better([fit for fit in fits if fit["policy"] not in MOST_DEVIATION])
    return checks | (_better_policy(scheme, better) if better else {})


def _better_policy(scheme: str, fit: Row) -> dict[str, Row]:
    which = f"{scheme}, {fit['policy']} (the better of the policies for the ball radius)"
    checks = {
        f"worst_deviation/{scheme}/better": _check(
            f"{which}: worst deviation of the energy ratio from its prediction",
            _size(fit),
            MOST_DEVIATION_CORRECTED,
        )
    }
    for name, what in (("detach_angle", "free flight begun"), ("liner_off_angle", "liner left")):
        checks[f"{name}_spread/{scheme}/better"] = _check(
            f"{which}: spread of the angle, {what}, over S [deg]",
            fit[f"{name}_spread_deg"],
            MOST_ANGLE_SPREAD_DEG,
        )
    return checks


def _better(fits: list[Row]) -> Row | None:
    return min((fit for fit in fits if _size(fit) is not None), key=_size, default=None)


def _size(fit: Row) -> float | None:
    worst = fit["worst_relative_error"]
    return None if worst is None else abs(worst)


def _check(text: str, value: float | None, limit: float) -> Row:
    return {
        "text": text,
        "value": value,
        "limit": limit,
        "sense": "<=",
        "passed": None if value is None else value <= limit,
    }
