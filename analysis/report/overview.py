"""The first screen of a report: the physical mill, its power and shape, and how far to trust them.

Numbers of a scaled mill are shown as those of the physical mill with its whole charge: a
dimensionless number times the scale of `physical_mill.PhysicalMill`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from scipy.special import stdtrit

from millscale.analysis.charge.comparison import ChargeComparison
from millscale.analysis.charge.physical_mill import PhysicalMill, balls_per_length, physical_mill
from millscale.analysis.charge.range_of_law import largest_S, outside_range
from millscale.analysis.charge.rows import ChargeRow
from millscale.analysis.charge.scaled_mills import ScaledMill
from millscale.analysis.checks import MOST_OVERLAP, MOST_SLIP, Check
from millscale.analysis.finished import Charge
from millscale.analysis.finished_campaign import Campaign
from millscale.analysis.means import deviation, mean_known
from millscale.formats import NONE, counted, number
from millscale.power_models import ModelPower, models_for
from millscale.runs.case_file import Case

LEVEL = 0.95
MOST_RESIDUAL = 0.01  # of the energy budget, over the work of the mill
GOOD, LOOK, BAD, UNKNOWN = "good", "look", "bad", "unknown"


@dataclass(frozen=True)
class Quantity:
    """A number of the physical mill.

    Attributes:
        name: of the dimensionless number in `measures.NUMBERS`, or of an angle [rad].
        scale: returns what a number of 1 is in the unit.
        error: name of its standard error in result.json; empty if it has none.
        predicted: name of its observable in a prediction, if it is another.
        on_first_screen: whether it is an answer; else the table alone has it.
        digits: decimals where no interval decides them.
    """

    name: str
    label: str
    unit: str
    scale: Callable[[PhysicalMill], float]
    error: str = ""
    predicted: str = ""
    on_first_screen: bool = True
    digits: int | None = None

    @property
    def heading(self) -> str:
        return f"{self.label} [{self.unit}]"


def _degrees(_: PhysicalMill) -> float:
    return math.degrees(1.0)


QUANTITIES = (
    Quantity("power", "power", "kW", lambda mill: 1e-3 * mill.power_scale, "torque"),
    Quantity(
        "power",
        "power per tonne of balls",
        "kW/t",
        lambda mill: mill.power_scale / mill.mass,
        "torque",
        "specific_power",
    ),
    Quantity("torque", "torque", "kN m", lambda mill: 1e-3 * mill.torque_scale, "torque"),
    Quantity("kinetic", "kinetic energy", "kJ", lambda mill: 1e-3 * mill.energy_scale, "kinetic"),
    Quantity("toe_angle_rad", "toe", "deg", _degrees, digits=1),
    Quantity("shoulder_angle_rad", "shoulder", "deg", _degrees, digits=1),
    Quantity("throw_angle_rad", "balls thrown at", "deg", _degrees, "", "", False, 1),
    Quantity("landing_angle_rad", "balls land at", "deg", _degrees, "", "", False, 1),
)


@dataclass(frozen=True)
class Estimate:
    """A number of the physical mill with its interval.

    Attributes:
        half_width: of the interval of `LEVEL`; None if it is not known.
        source: of the interval; empty without one.
        own_digits: decimals where no interval decides them; None for three figures.
    """

    value: float | None
    half_width: float | None = None
    source: str = ""
    own_digits: int | None = None

    @property
    def digits(self) -> int:
        """Return the decimals to show: two figures of the half width, or three of the value."""
        if self.own_digits is not None and not self.half_width:
            return self.own_digits
        figures, size = (2, self.half_width) if self.half_width else (3, abs(self.value or 0.0))
        return max(0, figures - 1 - math.floor(math.log10(size))) if size else 0

    @property
    def text(self) -> str:
        return NONE if self.value is None else f"{self.value:,.{self.digits}f}"

    @property
    def error_text(self) -> str:
        """Return ± half of the interval; empty without one."""
        return f"± {number(self.half_width, self.digits)}" if self.half_width else ""


@dataclass(frozen=True)
class PhysicalRow:
    """The physical mill by one scaled mill, mean over its seeds."""

    mill: ScaledMill
    physical: PhysicalMill
    estimates: tuple[Estimate, ...]


@dataclass(frozen=True)
class Predicted:
    """A number of the physical mill that was extrapolated from several scaled mills.

    Attributes:
        name: of the observable; of `Quantity.predicted` or `Quantity.name`.
    """

    name: str
    value: float
    half_width: float


@dataclass(frozen=True)
class Answer:
    """A number of the first screen, as text."""

    label: str
    unit: str
    estimate: Estimate
    note: str = ""


@dataclass(frozen=True)
class Trust:
    """A question about the runs, its answer, and what to do if the answer is not good."""

    question: str
    state: str
    found: str
    remedy: str = ""

    @property
    def mark(self) -> str:
        return {GOOD: "✓", LOOK: "!", BAD: "✗", UNKNOWN: "?"}[self.state]


@dataclass(frozen=True)
class Overview:
    """The first screen.

    Attributes:
        facts: label and value of the physical mill.
        answers: of the physical mill.
        source: which runs the answers are from.
        rows: the physical mill by each scaled mill.
        models: its power by published models.
        slipping: what a charge that slips on the liner means for the answers; empty without one.
    """

    facts: list[tuple[str, str]]
    answers: list[Answer]
    source: str
    trust: list[Trust]
    rows: list[PhysicalRow]
    models: list[ModelPower]
    slipping: str = ""


def overview(campaign: Campaign, predicted: Sequence[Predicted] = ()) -> Overview:
    """Return the first screen of a campaign.

    Args:
        predicted: numbers that were extrapolated from several scaled mills.
    """
    rows = physical_rows(campaign.comparison)
    first = campaign.cases[0].case
    if not rows:
        return Overview(_facts(first, None), [], "", [], [], [])
    best = nearest(rows)
    return Overview(
        facts=_facts(best.mill.first.case, best),
        answers=[*_answers(best, predicted), *_reach(campaign.comparison, best)],
        source=_source(best, bool(predicted)),
        trust=_trust(campaign, best),
        rows=rows,
        models=models_for(best.mill.first.case),
        slipping=_slipping(campaign.charges, campaign.checks),
    )


def nearest(rows: Sequence[PhysicalRow]) -> PhysicalRow:
    """Return the row to show first: steady, of the smallest S, in the order of the campaign."""
    return min(rows, key=lambda row: (not _is_steady(row.mill), row.mill.name.S))


def physical_rows(comparison: ChargeComparison) -> list[PhysicalRow]:
    """Return the physical mill by each scaled mill of a campaign."""
    by_charge = {row.charge: row for row in comparison.rows}
    found = []
    for mill in comparison.charges.mills:
        rows = [by_charge[charge] for charge in mill.seeds]
        physical = physical_mill(mill.first.case, balls_per_length(mill.first.case))
        estimates = tuple(estimate(rows, quantity, physical) for quantity in QUANTITIES)
        found.append(PhysicalRow(mill, physical, estimates))
    return found


def estimate(rows: Sequence[ChargeRow], quantity: Quantity, physical: PhysicalMill) -> Estimate:
    """Return a number of the physical mill by the seeds of one scaled mill.

    The interval is Student's: from the scatter of the seeds, or from that of the lifter pitches of
    a single run. It does not hold the error of the scaled mill.
    """
    scale = quantity.scale(physical)
    values = [x for row in rows if (x := row.numbers.get(quantity.name)) is not None]
    mean, spread = mean_known(values), deviation(values)
    if mean is None:
        return Estimate(None)
    if spread is not None:
        half = _student(len(values) - 1) * spread / math.sqrt(len(values))
        return Estimate(scale * mean, scale * half, counted(len(values), "seed"))
    result = rows[0].charge.result
    error = result.standard_error.get(quantity.error)
    if error is None or result.pitches < 2:
        return Estimate(scale * mean, own_digits=quantity.digits)
    half = _student(result.pitches - 1) * error
    return Estimate(scale * mean, scale * half, "lifter pitches of one run")


def _student(freedom: int) -> float:
    return float(stdtrit(freedom, 0.5 * (1.0 + LEVEL)))


def _is_steady(mill: ScaledMill) -> bool:
    return all(charge.result.steady.is_steady for charge in mill.seeds)


def _facts(case: Case, row: PhysicalRow | None) -> list[tuple[str, str]]:
    mill = case.physical
    rpm = 30.0 * mill.omega_rad_s / math.pi
    facts = [
        ("inner diameter", f"{2.0 * mill.radius_m:.3g} m"),
        ("length", f"{mill.length_m:.3g} m"),
        ("speed", f"{rpm:.3g} rpm ({mill.omega_rad_s:.3g} rad/s)"),
        ("of critical", f"{mill.percent_of_critical:.1f} %"),
        ("liner", _liner(case)),
        ("ball diameter", f"{2000.0 * mill.ball_radius_m:.3g} mm"),
    ]
    if row:
        facts += [
            ("balls", f"{row.physical.balls:,.0f}"),
            ("mass of balls", f"{1e-3 * row.physical.mass:,.3g} t"),
            ("filling", _filling(row.mill.first)),
        ]
    return facts


def _liner(case: Case) -> str:
    mill = case.physical
    if not mill.lifters:
        return "smooth"
    height = 1000.0 * (mill.radius_m - mill.lifter_top_radius_m)
    return f"{mill.lifters} lifters, {height:.3g} mm high"


def _filling(charge: Charge) -> str:
    """Return the share of the mill that the bed fills: as the campaign gives it, or the volume of
    the balls over the solid fraction of the bed at rest."""
    given = charge.case.charge
    if given is None:
        return NONE
    if given.filling is not None:
        return f"{100.0 * given.filling:.3g} %"
    if charge.settled.bulk_fraction:
        share = given.solid_fraction / charge.settled.bulk_fraction
        return f"{100.0 * share:.3g} %, by the bed at rest"
    return f"{100.0 * given.solid_fraction:.3g} % of the volume are balls"


def _source(row: PhysicalRow, has_prediction: bool) -> str:
    name = row.mill.name
    seeds = counted(len(row.mill.seeds), "seed")
    by = f"{name.scheme.replace('-', ' ')}, policy {name.policy}, S = {name.S:.4g}, {seeds}"
    if has_prediction:
        return (
            "Power, torque and angles are extrapolated to S = 1 from the scaled mills, with "
            f"{100.0 * LEVEL:g} % intervals; what could not be is by {by}."
        )
    what = "the physical mill itself" if row.mill.is_physical else "one scaled mill"
    left_out = (
        ""
        if row.mill.is_physical
        else " The intervals do not hold the error of the scaled mill: a second S beside this one "
        "gives it (millscale predict)."
    )
    return f"By {what}: {by}. Intervals of {100.0 * LEVEL:g} %.{left_out}"


def _answers(row: PhysicalRow, predicted: Sequence[Predicted]) -> list[Answer]:
    by_name = {x.name: x for x in predicted}
    found = []
    for quantity, own in zip(QUANTITIES, row.estimates, strict=True):
        better = by_name.get(quantity.predicted or quantity.name)
        shown = Estimate(better.value, better.half_width, "extrapolation") if better else own
        if shown.value is not None and quantity.on_first_screen:
            found.append(Answer(quantity.label, quantity.unit, shown))
    return found


def _reach(comparison: ChargeComparison, row: PhysicalRow) -> list[Answer]:
    """Return where balls land against the toe, the largest S to trust, and the speed-up."""
    values = {q.name: e.value for q, e in zip(QUANTITIES, row.estimates, strict=True)}
    toe, landing = values["toe_angle_rad"], values["landing_angle_rad"]
    found = []
    if toe is not None and landing is not None:
        on_charge = landing <= toe
        label = f"impact point {'before' if on_charge else 'beyond'} the toe"
        where = "on the charge" if on_charge else "on the bare liner"
        found.append(Answer(label, "deg", Estimate(abs(landing - toe), own_digits=1), where))
    case = row.mill.first.case
    most = largest_S(case)
    if case.mill.lifters:
        note = "beyond it lifters hold no whole balls"
    else:
        note = "beyond it the mill is a few balls across"
    found.append(Answer("trusted up to S", "-", Estimate(most), note))
    measured = [x.speed_up for x in comparison.rows if x.mill is row.mill and x.speed_up]
    if row.mill.is_physical:
        return found
    if measured and any(x.reference.is_physical for x in comparison.rows if x.mill is row.mill):
        found.append(Answer("speed-up", "-", Estimate(mean_known(measured)), "measured"))
    else:
        ratio = row.physical.balls / row.mill.first.balls / case.factors.time
        note = "fewer balls and steps than the whole physical mill at the same time step"
        found.append(Answer("speed-up", "-", Estimate(ratio), note))
    return found


def _trust(campaign: Campaign, row: PhysicalRow) -> list[Trust]:
    charges = campaign.charges
    checks = campaign.checks
    return [
        _lifts(charges, checks),
        _steady(charges),
        _energy(charges),
        _overlap(charges, checks),
        _seeds(campaign.comparison.charges.mills),
        _step(charges, checks),
        _range(charges),
    ]


def _slipping(charges: Sequence[Charge], checks: dict[str, Check]) -> str:
    found = [x for x in charges if (x.result.liner_slip or 0.0) > MOST_SLIP]
    if not found:
        return ""
    worst = max(found, key=lambda x: x.result.liner_slip or 0.0)
    return (
        f"In {len(found)} of {counted(len(charges), 'charge')} the balls on the liner stay behind "
        f"it by more than {100.0 * MOST_SLIP:g} % of its speed (most: {worst.id}, "
        f"{100.0 * (worst.result.liner_slip or 0.0):.0f} %), so the numbers below are those of a "
        f"mill that does not lift. To do: {checks[f'liner_slip/{worst.id}'].remedy}."
    )


def _lifts(charges: Sequence[Charge], checks: dict[str, Check]) -> Trust:
    known = [(slip, x) for x in charges if (slip := x.result.liner_slip) is not None]
    if not known:
        return Trust("Lifts?", UNKNOWN, "slip on the liner not recorded", "run the cases again")
    slip, charge = max(known, key=lambda pair: pair[0])
    text = f"balls on the liner stay behind it by at most {100.0 * slip:.2g} % of its speed"
    if slip <= MOST_SLIP:
        return Trust("Lifts?", GOOD, text)
    return Trust("Lifts?", BAD, text, checks[f"liner_slip/{charge.id}"].remedy)


def _steady(charges: Sequence[Charge]) -> Trust:
    bad = [charge for charge in charges if not charge.result.steady.is_steady]
    if not bad:
        fewest = min(charge.result.pitches for charge in charges)
        return Trust("Steady?", GOOD, f"means over {fewest} lifter pitches or more")
    reasons = "; ".join(bad[0].result.steady.reasons)
    text = f"{len(bad)} of {counted(len(charges), 'charge')} are not: {reasons}"
    return Trust("Steady?", BAD, text, "increase rotation_angle_rad")


def _energy(charges: Sequence[Charge]) -> Trust:
    budgets = [x.result.ledger for x in charges if x.result.ledger is not None]
    if not budgets:
        worst = max(abs(charge.result.torque_balance.difference) for charge in charges)
        text = f"no energy budget; the torque by two ways differs by {worst:.1g} of M g R"
        return Trust("Energy closed?", UNKNOWN, text, "ledger = true in [multi_ball] measures it")
    worst = max(abs(budget.closure) for budget in budgets)
    text = f"residual {100.0 * worst:.2g} % of the work of the mill"
    if worst <= MOST_RESIDUAL:
        return Trust("Energy closed?", GOOD, text)
    return Trust("Energy closed?", BAD, text, "reduce step_s")


def _overlap(charges: Sequence[Charge], checks: dict[str, Check]) -> Trust:
    known = [
        (charge, x)
        for charge in charges
        if (x := charge.result.largest_overlap_over_radius) is not None
    ]
    if not known:
        return Trust("Overlap?", UNKNOWN, "not recorded", "run the cases again")
    charge, largest = max(known, key=lambda pair: pair[1])
    text = f"at most {number(largest)} of the ball radius"
    if largest <= MOST_OVERLAP:
        return Trust("Overlap?", GOOD, text)
    check = checks[f"overlap/{charge.id}"]
    of_steady = _steady_overlap(charge)
    if of_steady is not None and of_steady <= MOST_OVERLAP:
        text += f" at the start, {number(of_steady)} in the steady part"
        return Trust("Overlap?", LOOK, text, "none for the means; else " + check.remedy)
    return Trust("Overlap?", BAD, text, check.remedy)


def _steady_overlap(charge: Charge) -> float | None:
    if not charge.has("largest_overlap_m"):
        return None
    steady = charge.series["mill_angle_rad"] >= charge.steady_from
    largest = charge.series["largest_overlap_m"][steady].max(initial=0.0)
    return float(largest) / charge.case.ball.radius_m


def _seeds(mills: Sequence[ScaledMill]) -> Trust:
    fewest = min(len(mill.seeds) for mill in mills)
    if fewest > 1:
        return Trust("Seeds?", GOOD, f"{fewest} of each scaled mill or more")
    text = "one for some scaled mills: chance is known from the lifter pitches alone"
    return Trust("Seeds?", LOOK, text, "seeds = [1, 2, 3] in [multi_ball]")


def _step(charges: Sequence[Charge], checks: dict[str, Check]) -> Trust:
    share = max(charge.case.time.limit_fraction for charge in charges)
    text = f"{number(share, 2)} of the damping limit"
    if not all(checks[f"alternating_torque/{charge.id}"].passed for charge in charges):
        return Trust("Step?", BAD, f"{text}; the torque alternates", 'step_s = "advised"')
    if share > 1.0:
        text += "; the torque does not alternate"
        return Trust("Step?", LOOK, text, 'step_s = "advised" has no spin noise')
    return Trust("Step?", GOOD, text)


def _range(charges: Sequence[Charge]) -> Trust:
    reasons = {charge.id: why for charge in charges if (why := outside_range(charge.case))}
    if not reasons:
        return Trust("S in range?", GOOD, "lifters and grooves hold whole balls")
    name, why = next(iter(reasons.items()))
    reason, _, advice = why.rpartition(": ")
    return Trust("S in range?", BAD, f"{name}: {reason}", advice)
