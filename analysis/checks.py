"""Checks of a campaign: claims with their values and limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from millscale.analysis.finished import Charge
from millscale.analysis.measures import COMMON_ANGLES, SINGLE_BALL_ANGLES
from millscale.analysis.single_ball.comparison import Regression, SingleBallRow
from millscale.runs.soft_balls import impact_overlap, modulus_for, physical_modulus

LEAST_CORRELATION = 0.999
MOST_DEVIATION = {"paper": 0.04}
MOST_DEVIATION_CORRECTED = 0.015  # of the better of the other policies
MOST_ANGLE_SPREAD_DEG = 1.5
MOST_OFF_PARABOLA = 1e-3  # of the energy change
MOST_OVERLAP = 0.1  # of the ball radius
# Over M g R. The two ways to the torque differ by how finely the centre of mass is sampled.
MOST_TORQUE_DIFFERENCE = 1e-3
# What a check is about: the health of the runs, or the similarity law.
RUN, LAW = "run", "law"
LAW_REMEDY = (
    "the runs are sound: the mill is less similar than the law says at this ball radius; use a "
    "smaller S, or the policy corrected or offset-liner"
)
THROW_REMEDY = "sample more often and turn by at least one revolution, or reduce step_s"

# Beyond it the charge takes up less than half of the power of the drive: docs/theory/charge.md.
MOST_SLIP = 0.5
SLIP_REMEDY = (
    "the mill does not lift its charge: check the friction of balls and wall (with a rolling "
    "friction near 0 balls roll on a smooth wall), or model lifters and end walls as in the mill"
)

# Of the torque between even and odd steps: beyond it a time step is too long for the wall.
MOST_ALTERNATING = 5e-3


@dataclass(frozen=True)
class Check:
    """A claim about a campaign.

    Attributes:
        sense: <= or >=, between value and limit.
        passed: None where the campaign does not hold enough for an answer.
        about: RUN or LAW.
        case: id of the case it is about; empty if it is about several.
        remedy: what to do if it fails.
    """

    text: str
    value: float | None
    limit: float
    sense: str
    passed: bool | None
    about: str = RUN
    case: str = ""
    remedy: str = ""

    @property
    def order(self) -> int:
        """Return the place in a list: failed, undecided, passed."""
        return {False: 0, None: 1, True: 2}[self.passed]


def at_most(text: str, value: float | None, limit: float) -> Check:
    """Return the check that a value does not exceed a limit."""
    return Check(text, value, limit, "<=", None if value is None else value <= limit)


def at_least(text: str, value: float | None, limit: float) -> Check:
    """Return the check that a value reaches a limit."""
    return Check(text, value, limit, ">=", None if value is None else value >= limit)


def campaign_checks(
    rows: Sequence[SingleBallRow],
    fits: Sequence[Regression],
    charges: Sequence[Charge],
    missing: Mapping[str, str],
) -> dict[str, Check]:
    """Return checks by name.

    Args:
        fits: of the paper's mill only: the limits are about its numbers.
        missing: why a case is not in the report, by its id.
    """
    all_finished = at_most("no case is missing", len(missing), 0)
    remedy = "millscale run FILE --runs DIR makes them; the reasons are under What was run"
    checks = {"all_cases_finished": replace(all_finished, remedy=remedy)}
    if rows:
        checks |= _single_ball(rows)
    for scheme in dict.fromkeys(fit.scheme for fit in fits):
        of_scheme = _law(scheme, [fit for fit in fits if fit.scheme == scheme])
        checks |= {
            name: replace(check, about=LAW, remedy=LAW_REMEDY) for name, check in of_scheme.items()
        }
    for charge in charges:
        checks |= _charge(charge)
    return checks


def _charge(charge: Charge) -> dict[str, Check]:
    result, steady = charge.result, charge.result.steady
    why = f": {'; '.join(steady.reasons)}" if steady.reasons else ""
    found = {}
    if result.liner_slip is not None:
        text = "speed by which the balls on the liner stay behind it, over that of the liner"
        found["liner_slip"] = (at_most(text, result.liner_slip, MOST_SLIP), SLIP_REMEDY)
    found |= {
        "balls_kept": (
            at_most("no ball is lost", int(result.problem is not None), 0),
            "reduce step_s, and look at the log of the case",
        ),
        "torque_balance": (
            at_most(
                "torque by the work of the drive less that by weight and angular momentum, over "
                "M g R",
                abs(result.torque_balance.difference),
                MOST_TORQUE_DIFFERENCE,
            ),
            "reduce sample_angle_rad, so that the centre of mass is sampled more finely",
        ),
        "alternating_torque": (
            at_most(
                "part of the torque that alternates from step to step, over M g R",
                result.alternating_torque,
                MOST_ALTERNATING,
            ),
            "reduce step_s",
        ),
        "steady": (
            at_most(f"reasons why the charge is not steady{why}", len(steady.reasons), 0),
            "increase rotation_angle_rad",
        ),
    }
    if result.largest_overlap_over_radius is not None:
        found["overlap"] = _overlap(charge, result.largest_overlap_over_radius)
    return {
        f"{name}/{charge.id}": replace(
            check, text=f"{charge.id}: {check.text}", case=charge.id, remedy=remedy
        )
        for name, (check, remedy) in found.items()
    }


def _overlap(charge: Charge, largest: float) -> tuple[Check, str]:
    """Return the check of the largest overlap, with its cause if it fails, and what to do."""
    case, at_rest = charge.case, charge.settled.largest_overlap_over_radius
    by_impact, modulus = impact_overlap(case), modulus_for(case, MOST_OVERLAP, largest)
    stiffer = (
        f"a youngs_modulus_pa of {modulus:g}, {modulus / physical_modulus(case):.2g} times the "
        f"present one, keeps overlaps below {MOST_OVERLAP:g}"
    )
    if at_rest is not None and at_rest > MOST_OVERLAP:
        cause, remedy = f"the bed at rest has {at_rest:.2g}", f"increase settle_s, or {stiffer}"
    elif largest <= by_impact:
        cause = (
            f"impacts at {case.time.impact_speed_m_s:.3g} m/s compress balls as soft as these by "
            f"{by_impact:.2g} if nothing damps them"
        )
        remedy = f"{stiffer}; a shorter step does not"
    else:
        cause = f"impacts that nothing damps cause {by_impact:.2g}"
        share = case.time.limit_fraction
        remedy = f"reduce step_s, which is {share:.2f} of the damping limit, or {stiffer}"
    text = f"largest overlap over ball radius, at the rows of series.csv{_where(charge)}"
    if largest > MOST_OVERLAP:
        text += f"; {cause}"
    return at_most(text, largest, MOST_OVERLAP), remedy


def _where(charge: Charge) -> str:
    """Return at which mill angle the overlap is largest, and the largest in the steady part."""
    if not charge.has("largest_overlap_m"):
        return ""
    angle, overlap = (charge.series[x] for x in ("mill_angle_rad", "largest_overlap_m"))
    steady = angle >= charge.steady_from
    of_steady = float(overlap[steady].max()) / charge.case.ball.radius_m if steady.any() else None
    if of_steady is None:
        return ""
    return f" (at {angle[overlap.argmax()]:.2f} rad; {of_steady:.3f} in the steady part)"


def _single_ball(rows: Sequence[SingleBallRow]) -> dict[str, Check]:
    idle = sum(row.ball.result.problem is not None for row in rows)
    thrown = [row.throw for row in rows if row.throw.off_parabola is not None]
    found = {
        "every_ball_is_thrown": at_most("cases without a throw", idle, 0),
        "flight_is_a_parabola": at_most(
            "distance of the samples of the throw from the parabola of its release, over the "
            "energy change",
            max((throw.off_parabola for throw in thrown), default=None),
            MOST_OFF_PARABOLA,
        ),
        "kinetic_gain_is_potential_loss": at_most(
            "kinetic energy gained less potential energy lost, in the samples, over the change",
            max((throw.energy_imbalance for throw in thrown), default=None),
            MOST_OFF_PARABOLA,
        ),
    }
    return {name: replace(check, remedy=THROW_REMEDY) for name, check in found.items()}


def _law(scheme: str, fits: Sequence[Regression]) -> dict[str, Check]:
    checks = {}
    for fit in fits:
        policy, common = fit.policy, fit.fits[COMMON_ANGLES]
        checks[f"linear_in_prediction/{scheme}/{policy}"] = at_least(
            f"{scheme}, {policy}: correlation of the energy ratio with its prediction",
            common.line.correlation,
            LEAST_CORRELATION,
        )
        if policy in MOST_DEVIATION:
            checks[f"worst_deviation/{scheme}/{policy}"] = at_most(
                f"{scheme}, {policy}: worst deviation of the energy ratio from its prediction",
                common.worst_size,
                MOST_DEVIATION[policy],
            )
    better = _better([fit for fit in fits if fit.policy not in MOST_DEVIATION])
    return checks | (_better_policy(scheme, better) if better else {})


def _better_policy(scheme: str, fit: Regression) -> dict[str, Check]:
    which = f"{scheme}, {fit.policy} (the better of the policies for the ball radius)"
    checks = {
        f"worst_deviation/{scheme}/better": at_most(
            f"{which}: worst deviation of the energy ratio from its prediction",
            fit.fits[COMMON_ANGLES].worst_size,
            MOST_DEVIATION_CORRECTED,
        )
    }
    for angle in SINGLE_BALL_ANGLES:
        checks[f"{angle.name}_spread/{scheme}/better"] = at_most(
            f"{which}: spread of the angle, {angle.label}, over S [deg]",
            fit.spread_deg[angle.name],
            MOST_ANGLE_SPREAD_DEG,
        )
    return checks


def _better(fits: Sequence[Regression]) -> Regression | None:
    """Return the fit with the smaller worst deviation."""
    known = [fit for fit in fits if fit.fits[COMMON_ANGLES].worst_size is not None]
    return min(known, key=lambda fit: fit.fits[COMMON_ANGLES].worst_size, default=None)
