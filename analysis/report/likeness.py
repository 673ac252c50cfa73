"""Whether runs folders are alike in what a comparison supposes, and what to do where they are not.

The questions have the form of those on the first screen of a report.
"""

from __future__ import annotations

from collections.abc import Sequence

from millscale.analysis.differences import CHARGE, CONTACT, LINER, MILL, SETTING, SPEED, FactRow
from millscale.formats import counted
from millscale.report.overview import GOOD, LOOK, Trust
from millscale.report.side_by_side import Group, SideBySide

# Settings that change with S, and so are compared between mills of one S.
_OF_INPUT = (MILL, LINER, SPEED, CHARGE, CONTACT)
# Facts that follow from another one, or from the seed.
_DERIVED = ("mass of balls", "balls simulated")


def questions(found: SideBySide) -> list[Trust]:
    """Return the questions about likeness with their answers."""
    return [
        _same_mill(found),
        _one_difference(found),
        _same_scaling(found),
        _same_settings(found),
        *([_steady(found.groups), _seeds(found.groups)] if found.groups else []),
        _whole(found),
    ]


def differing_parts(found: SideBySide) -> list[str]:
    """Return the parts of the cases in which runs folders differ: liner, speed, ..."""
    return list(dict.fromkeys(row.fact.about for row in found.differing
                              if row.fact.about in _OF_INPUT
                              and row.fact.label not in _DERIVED))  # fmt: skip


def _listed(rows: Sequence[FactRow]) -> str:
    return "; ".join(f"{row.fact.heading} {' | '.join(map(row.text, row.values))}" for row in rows)


def _same_mill(found: SideBySide) -> Trust:
    rows = [row for row in found.differing if row.fact.about == MILL]
    if not rows:
        return Trust("The same mill?", GOOD, "one physical mill: diameter, length and gravity")
    remedy = "take physical units for the design, dimensionless numbers for the similarity"
    return Trust("The same mill?", LOOK, f"different mills: {_listed(rows)}", remedy)


def _one_difference(found: SideBySide) -> Trust:
    parts = differing_parts(found)
    question = "One difference?"
    if not parts:
        return Trust(question, GOOD, "mill, liner, speed, charge and contacts are the same")
    if len(parts) == 1:
        return Trust(question, GOOD, f"they differ in the {parts[0]} alone")
    remedy = "an effect is not that of one of them; vary one at a time to tell them apart"
    return Trust(question, LOOK, f"they differ in {', '.join(parts)}", remedy)


def _same_scaling(found: SideBySide) -> Trust:
    question = "Scaled alike?"
    sides = len(found.sides)
    kinds = [(group.kind, len(group.rows)) for group in found.groups]
    kinds += [(group.kind, len(group.sides)) for group in found.balls]
    of_all = [kind for kind, count in kinds if kind is not None and count == sides]
    if of_all:
        names = list(dict.fromkeys(kind.text for kind in of_all))
        more = f" and {len(names) - 3} more" if len(names) > 3 else ""
        return Trust(question, GOOD, f"all have {'; '.join(names[:3])}{more}")
    known = any(kind is not None for kind, _ in kinds)
    text = "no scaled mill is in all of them" if known else "no scaled mill is in two of them"
    remedy = "run one S, scheme and policy in all: a difference holds the error of the scaled mills"
    return Trust(question, LOOK, text, remedy)


def _same_settings(found: SideBySide) -> Trust:
    rows = [
        row
        for row in found.differing
        if row.fact.about == SETTING and row.fact.label not in _DERIVED
    ]
    if not rows:
        return Trust("The same settings?", GOOD, "step, walls, contacts and length are the same")
    remedy = "a setting has an error of its own; millscale study measures it"
    return Trust("The same settings?", LOOK, _listed(rows), remedy)


def _steady(groups: Sequence[Group]) -> Trust:
    bad = [
        f"{row.side.name}: {charge.id}"
        for group in groups
        for row in group.rows
        for charge in row.charges
        if not charge.result.steady.is_steady
    ]
    if not bad:
        return Trust("Steady?", GOOD, "every charge is")
    return Trust("Steady?", LOOK, f"not: {'; '.join(bad)}", "increase rotation_angle_rad")


def _seeds(groups: Sequence[Group]) -> Trust:
    fewest = min(len(row.charges) for group in groups for row in group.rows)
    if fewest > 1:
        return Trust("Seeds?", GOOD, f"{fewest} or more of each mill")
    text = "a mill has one: intervals are those of its lifter pitches"
    return Trust("Seeds?", LOOK, text, "seeds = [1, 2, 3]")


def _whole(found: SideBySide) -> Trust:
    missing = [
        f"{side.name}: {counted(len(side.campaign.missing), 'case')}"
        for side in found.sides
        if side.campaign.missing
    ]
    problems = [str(x) for own in found.measured.problems.values() for x in own]
    if not missing and not problems:
        return Trust("Whole?", GOOD, "every case is finished and was read")
    text = "; ".join(([f"not finished: {', '.join(missing)}"] if missing else []) + problems[:3])
    return Trust("Whole?", LOOK, text, "millscale run FILE --runs DIR")
