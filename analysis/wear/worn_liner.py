"""The worn liner of the physical mill, from the finished scaled mills of a runs folder."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from millscale import _core
from millscale.analysis.finished import Charge
from millscale.analysis.finished_campaign import load_campaign
from millscale.analysis.wear.loads import read_liner_loads
from millscale.analysis.wear.rate import WearRate, mean_rate, wear_rate
from millscale.errors import CampaignError
from millscale.liner.worn import Wear, Worn, worn_liner
from millscale.runs.liner import liner_of
from millscale.runs.untrusted import RunFolderError

HOUR = 3600.0
# Of a lifter's height: deeper wear changes the motion of the charge, and with it the wear.
DEEPEST = 0.2


@dataclass(frozen=True)
class WearWish:
    """What is asked for.

    Attributes:
        law: of `rate.LAWS`.
        hours: of the physical mill.
        constant: worn volume over energy [m^3/J].
        ratio: S of the scaled mill that is read; None: the smallest.
        smoothing: as in Wear; None: the ball radius of the physical mill [m].
        plate: as in Wear [m].
    """

    law: str
    hours: float
    constant: float
    ratio: float | None = None
    smoothing: float | None = None
    plate: float | None = None


@dataclass(frozen=True)
class WornLiner:
    """A worn liner and what it was made from.

    Attributes:
        worn: of the physical mill.
        rate: of the wear.
        charges: whose loads are the mean.
        height: of the lifters before [m].
        warnings: in words.
    """

    worn: Worn
    rate: WearRate
    charges: tuple[Charge, ...]
    height: float
    warnings: tuple[str, ...]


def worn_liner_of(runs: Path, wish: WearWish) -> WornLiner:
    """Return the liner of the physical mill after some hours.

    Raises:
        RunFolderError: no finished case has loads on the liner.
        CampaignError: a number that cannot be used, or a liner that is worn away.
    """
    check_numbers(
        {"--hours": wish.hours, "--constant": wish.constant},
        {"--smoothing": wish.smoothing, "--plate": wish.plate},
    )
    charges = charges_with_loads(runs, wish.ratio)
    rate = rate_of(charges, wish.law)
    case = charges[0].case
    liner = liner_of(case.mill).scaled(1.0 / case.S)
    smoothing = case.physical.ball_radius_m if wish.smoothing is None else wish.smoothing
    worn = worn_by(liner, rate, wish.constant * wish.hours * HOUR, (smoothing, wish.plate))
    height = liner.radius - liner.clear_radius
    return WornLiner(worn, rate, charges, height, _warnings(worn, rate, height))


def worn_by(
    liner: _core.Profile, rate: WearRate, factor: float, limits: tuple[float, float | None]
) -> Worn:
    """Return a liner of the physical mill after wear.

    Args:
        factor: depth over flux, constant times time [m^3 s / J].
        limits: smoothing and plate, as in Wear [m].

    Raises:
        CampaignError: the liner is worn away.
    """
    depth = factor * rate.flux
    if not float(depth.max()) < liner.clear_radius:
        raise CampaignError(
            "millscale wear",
            "--hours",
            f"wears the liner by up to {depth.max():.3g} m, its smallest radius is "
            f"{liner.clear_radius:.3g} m",
            "fewer hours, or a smaller constant",
        )
    return worn_liner(liner, Wear(rate.edges, depth, *limits))


def check_numbers(above: Mapping[str, float], lengths: Mapping[str, float | None]) -> None:
    """Refuse options that cannot be used.

    Args:
        above: by option, accepted above 0. lengths: accepted from 0 or None [m].

    Raises:
        CampaignError: states what is accepted.
    """
    for name, value in above.items():
        if not (0.0 < value < math.inf):
            raise CampaignError("millscale wear", name, f"got {value:g}", "a number > 0")
    for name, limit in lengths.items():
        if limit is not None and not (0.0 <= limit < math.inf):
            raise CampaignError("millscale wear", name, f"got {limit:g}", "a number >= 0")


def charges_with_loads(runs: Path, ratio: float | None) -> tuple[Charge, ...]:
    """Return the seeds of the scaled mill to read: of one S, by default the smallest; of one scheme
    and policy, the first.

    Raises:
        RunFolderError: there is none.
    """
    found = [x for x in load_campaign(runs).charges if x.case.deck.liner_loads == "on"]
    remedy = "set liner_loads = true in [multi_ball] and run: millscale run FILE --runs DIR"
    if not found:
        raise RunFolderError(runs, "no finished case has loads on the liner", remedy)
    if ratio is not None:
        ratios = sorted({x.S for x in found})
        found = [x for x in found if math.isclose(x.S, ratio, rel_tol=1e-6)]
        if not found:
            known = ", ".join(f"{x:g}" for x in ratios)
            raise RunFolderError(runs, f"no case of S = {ratio:g} has loads", f"--S one of {known}")
    states = {x.state for x in found}
    if len(states) > 1:
        cause = f"its liner has several states: {', '.join(sorted(states))}"
        raise RunFolderError(runs, cause, "a runs folder of one state")
    mills = [x for x in found if min(y.S for y in found) == x.S]
    first = mills[0]
    same = (first.scheme, first.policy)
    return tuple(x for x in mills if (x.scheme, x.policy) == same)


def rate_of(charges: tuple[Charge, ...], law: str) -> WearRate:
    """Return the mean rate of wear of the physical mill by some seeds of a scaled mill."""
    return mean_rate([wear_rate(read_liner_loads(x.folder, x.case), x.case, law) for x in charges])


def _warnings(worn: Worn, rate: WearRate, height: float) -> tuple[str, ...]:
    found = []
    if height > 0.0 and worn.deepest > DEEPEST * height:
        parts = math.ceil(worn.deepest / (DEEPEST * height))
        found.append(
            f"the deepest wear, {worn.deepest:.3g} m, is more than {DEEPEST:g} of the lifters' "
            f"height: take {parts} steps, each with a campaign of the worn profile"
        )
    if worn.is_through:
        found.append("the plate is worn through")
    if np.isfinite(rate.error).all() and rate.mean > 0.0:
        share = float(np.average(rate.error, weights=np.diff(rate.edges))) / rate.mean
        if share > 0.1:
            found.append(
                f"standard error of the wear of a bin by the scatter of the lifters: "
                f"{100.0 * share:.0f} %; a longer rotation or more seeds lower it"
            )
    return tuple(found)
