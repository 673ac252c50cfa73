"""Several runs folders side by side: which of their mills are alike, and how these differ."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

from millscale.analysis.charge.comparison import ChargeComparison
from millscale.analysis.charge.measured import Measured, measure
from millscale.analysis.charge.pair_errors import PairErrors, mean_of_pairs
from millscale.analysis.charge.rows import between_seeds
from millscale.analysis.charge.scaled_mills import Charges, ScaledMill, scaled_mills
from millscale.analysis.differences import FactRow, KeyRow, fact_rows, key_rows
from millscale.analysis.finished import Charge, SingleBall
from millscale.analysis.finished_campaign import Campaign, load_campaign
from millscale.analysis.means import mean_known
from millscale.analysis.single_ball.comparison import SingleBallRow
from millscale.report.overview import QUANTITIES, Estimate, PhysicalRow, physical_rows
from millscale.runs.case_file import Case
from millscale.runs.untrusted import RunFolderError

PHYSICAL = "physical mill"


@dataclass(frozen=True, eq=False)
class Side:
    """A runs folder of a comparison.

    Attributes:
        name: of its campaign, or of its folder where names of campaigns are not distinct.
        charges: its finished multi-ball cases; `name` is their campaign.
    """

    name: str
    campaign: Campaign
    charges: tuple[Charge, ...]

    @property
    def runs(self) -> Path:
        return self.campaign.runs

    @cached_property
    def mills(self) -> dict[MillKind, ScaledMill]:
        """Return its scaled mills by what makes them comparable."""
        return {kind_of(mill.first): mill for mill in scaled_mills(self.charges)}

    @cached_property
    def balls(self) -> dict[MillKind, SingleBallRow]:
        """Return its single balls by what makes them comparable."""
        return {kind_of(row.ball): row for row in self.campaign.rows}


class MillKind(NamedTuple):
    """What scaled mills share that are compared; of the physical mill scheme and policy have no
    meaning."""

    scheme: str
    policy: str
    stiffness: str
    S: float

    @property
    def text(self) -> str:
        if self.scheme == PHYSICAL:
            return PHYSICAL
        words = [f"S = {self.S:.4g}", self.scheme.replace("-", " "), f"policy {self.policy}"]
        return ", ".join(words + ["E matched"] * (self.stiffness != "fixed"))

    @property
    def file_name(self) -> str:
        """Return its name in the names of files."""
        return "-".join([f"S{self.S:.3f}", self.scheme.replace(" ", "-"), self.policy]).strip("-")


def kind_of(case: SingleBall | Charge) -> MillKind:
    """Return what a case may be compared with."""
    if case.is_physical:
        return MillKind(PHYSICAL, case.state, "fixed", 1.0)
    return MillKind(case.scheme, case.variant, case.case.material.stiffness, round(case.S, 6))


@dataclass(frozen=True)
class Change:
    """A number of a runs folder less that of the first.

    Attributes:
        half_width: of the interval; None where one of the two has none.
        share: difference over the number of the first; None of an angle.
    """

    value: float
    half_width: float | None
    share: float | None

    @property
    def is_chance(self) -> bool | None:
        """Return whether the interval holds zero; None without interval."""
        return None if self.half_width is None else abs(self.value) <= self.half_width


@dataclass(frozen=True)
class SideRow:
    """A scaled mill of a runs folder, beside that of the first.

    Attributes:
        row: the physical mill by it.
        numbers: dimensionless, by name, mean over the seeds.
        changes: of the numbers of `QUANTITIES`; None of the first, and where a number is missing.
        errors: mean over all pairs of seeds; None of the first.
        between_seeds: errors of its own seeds against one another; None of one seed.
    """

    side: Side
    row: PhysicalRow
    numbers: dict[str, float | None]
    changes: tuple[Change | None, ...]
    errors: PairErrors | None
    between_seeds: PairErrors | None

    @property
    def charges(self) -> tuple[Charge, ...]:
        return self.row.mill.seeds

    @property
    def case(self) -> Case:
        return self.row.mill.first.case


@dataclass(frozen=True)
class Group:
    """Scaled mills of one kind, of two runs folders or more.

    Attributes:
        kind: None if the runs folders have no mill in common.
    """

    kind: MillKind | None
    rows: tuple[SideRow, ...]

    @property
    def title(self) -> str:
        if self.kind is not None:
            return self.kind.text
        return "no scaled mill in common: the most trusted of each"

    @property
    def file_name(self) -> str:
        return self.kind.file_name if self.kind else "nearest"

    @property
    def charges(self) -> list[Charge]:
        return [charge for row in self.rows for charge in row.charges]


@dataclass(frozen=True)
class BallGroup:
    """Single balls of one kind; a row for each runs folder that has one."""

    kind: MillKind
    sides: tuple[Side, ...]

    @property
    def rows(self) -> tuple[SingleBallRow, ...]:
        return tuple(side.balls[self.kind] for side in self.sides)


Entries = list[tuple[Side, ScaledMill]]


@dataclass(frozen=True)
class SideBySide:
    """Runs folders side by side.

    Attributes:
        groups: like mills with a charge, by S.
        balls: like single balls, by S.
        facts: of the case of each runs folder that `cases` holds.
        keys: of campaign files that differ.
    """

    sides: tuple[Side, ...]
    groups: tuple[Group, ...]
    balls: tuple[BallGroup, ...]
    measured: Measured
    cases: tuple[Case, ...]
    facts: tuple[FactRow, ...]
    keys: tuple[KeyRow, ...]

    @property
    def differing(self) -> list[FactRow]:
        """Return the facts that differ."""
        return [row for row in self.facts if row.differs]

    @property
    def varied(self) -> FactRow | None:
        """Return the fact that was varied: the first numeric one of mill, liner, speed and charge
        that has another value in each runs folder."""
        for row in self.differing:
            if row.is_numeric and len(set(row.values)) == len(row.values):
                return row
        return None


def side_by_side(runs: Sequence[Path]) -> SideBySide:
    """Compare the finished cases of two runs folders or more; reads the dumps of like mills.

    Raises:
        RunFolderError: fewer than two folders, one twice, or one without finished case.
    """
    sides = load_sides(runs)
    kinds = common_kinds([side.mills for side in sides])
    chosen: list[tuple[MillKind | None, Entries]] = [
        (kind, [(side, side.mills[kind]) for side in sides if kind in side.mills]) for kind in kinds
    ]
    with_charges = [side for side in sides if side.mills]
    if not chosen and len(with_charges) > 1:
        chosen = [(None, [(side, _best(side)) for side in with_charges])]
    measured = _measured([entries for _, entries in chosen])
    groups = tuple(_group(kind, entries, measured) for kind, entries in chosen)
    balls = tuple(
        BallGroup(kind, tuple(side for side in sides if kind in side.balls))
        for kind in common_kinds([side.balls for side in sides])
    )
    cases = _cases_to_set_beside(sides, groups, balls)
    return SideBySide(
        sides=tuple(sides),
        groups=groups,
        balls=balls,
        measured=measured,
        cases=cases,
        facts=tuple(fact_rows(cases)),
        keys=tuple(key_rows([side.runs for side in sides])),
    )


def load_sides(runs: Sequence[Path]) -> list[Side]:
    """Return the runs folders, each with a name of its own."""
    if len(runs) < 2:
        raise RunFolderError(runs[0] if runs else Path(), "one runs folder", "name two or more")
    places = [Path(folder).resolve() for folder in runs]
    if len(set(places)) < len(places):
        twice = next(folder for folder in runs if places.count(Path(folder).resolve()) > 1)
        raise RunFolderError(twice, "is named twice", "name each runs folder once")
    campaigns = [load_campaign(Path(folder)) for folder in runs]
    for campaign in campaigns:
        if not campaign.cases:
            remedy = f"run them with: millscale run FILE --runs {campaign.runs}"
            raise RunFolderError(campaign.runs, "no case is finished", remedy)
    names = [campaign.name for campaign in campaigns]
    if len(set(names)) < len(names):
        names = [place.name for place in places]
    if len(set(names)) < len(names):
        names = ["/".join(place.parts[-2:]) for place in places]
    if len(set(names)) < len(names):
        names = [str(place) for place in places]
    return [
        Side(name, campaign, tuple(replace(x, campaign=name) for x in campaign.charges))
        for name, campaign in zip(names, campaigns, strict=True)
    ]


def common_kinds(known: Sequence[Mapping[MillKind, object]]) -> list[MillKind]:
    """Return the kinds that two runs folders or more have, by S."""
    every = [kind for found in known for kind in found]
    return sorted({kind for kind in every if every.count(kind) > 1}, key=lambda kind: kind[::-1])


def _best(side: Side) -> ScaledMill:
    """Return the scaled mill of a runs folder to trust most: steady, of the smallest S."""
    return min(
        side.mills.values(),
        key=lambda mill: (not all(x.result.steady.is_steady for x in mill.seeds), mill.name.S),
    )


def _measured(groups: Sequence[Entries]) -> Measured:
    """Return the charges of all groups measured, each group against its first entry."""
    charges: dict[Charge, None] = {}
    pairs: dict[tuple[Charge, Charge], None] = {}
    for entries in groups:
        _, first = entries[0]
        for _, mill in entries:
            charges |= dict.fromkeys(mill.seeds)
            pairs |= dict.fromkeys(mill.pairs())
            if mill is not first:
                pairs |= dict.fromkeys((a, b) for a in mill.seeds for b in first.seeds)
    return measure(list(charges), list(pairs))


def _group(kind: MillKind | None, entries: Entries, measured: Measured) -> Group:
    rows = [
        physical_rows(ChargeComparison(Charges(mill.seeds), measured))[0] for _, mill in entries
    ]
    first = rows[0]
    return Group(
        kind,
        tuple(
            SideRow(
                side=side,
                row=row,
                numbers=_numbers(row.mill, measured),
                changes=_changes(row, first),
                errors=_errors(row.mill, first.mill, measured),
                between_seeds=between_seeds(row.mill, measured) if row.mill.pairs() else None,
            )
            for (side, _), row in zip(entries, rows, strict=True)
        ),
    )


def _numbers(mill: ScaledMill, measured: Measured) -> dict[str, float | None]:
    names = measured.numbers[mill.first]
    return {
        name: mean_known(
            x for charge in mill.seeds if (x := measured.numbers[charge][name]) is not None
        )
        for name in names
    }


def _changes(row: PhysicalRow, first: PhysicalRow) -> tuple[Change | None, ...]:
    if row is first:
        return (None,) * len(QUANTITIES)
    return tuple(
        _change(ours, theirs, quantity.unit)
        for ours, theirs, quantity in zip(row.estimates, first.estimates, QUANTITIES, strict=True)
    )


def _change(ours: Estimate, theirs: Estimate, unit: str) -> Change | None:
    if ours.value is None or theirs.value is None:
        return None
    value = ours.value - theirs.value
    half = None
    if ours.half_width is not None and theirs.half_width is not None:
        half = math.hypot(ours.half_width, theirs.half_width)
    share = value / theirs.value if theirs.value and unit != "deg" else None
    return Change(value, half, share)


def _errors(mill: ScaledMill, first: ScaledMill, measured: Measured) -> PairErrors | None:
    if mill is first:
        return None
    return mean_of_pairs([measured.errors[a, b] for a in mill.seeds for b in first.seeds])


def _cases_to_set_beside(
    sides: Sequence[Side], groups: Sequence[Group], balls: Sequence[BallGroup]
) -> tuple[Case, ...]:
    """Return a case of each runs folder: of the first kind that all have, else its first case."""
    for group in groups:
        if len(group.rows) == len(sides):
            return tuple(row.case for row in group.rows)
    for of_balls in balls:
        if len(of_balls.sides) == len(sides):
            return tuple(row.ball.case for row in of_balls.rows)
    return tuple((side.charges or side.campaign.single)[0].case for side in sides)
