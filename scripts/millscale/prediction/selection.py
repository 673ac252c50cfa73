"""Which charges a prediction uses: scaled mills of one physical mill, finished and steady, within
the range of the law of their errors."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from msgspec import structs

from millscale.analysis.charge.physical_mill import balls_per_length
from millscale.analysis.charge.range_of_law import outside_range
from millscale.analysis.finished import Charge
from millscale.analysis.finished_campaign import load_campaign
from millscale.campaign.keys import FRICTION_MATCHED
from millscale.errors import PredictionError
from millscale.formats import number
from millscale.prediction.extrapolation import (
    ExtrapolationError,
    Group,
    by_ratio,
    check_norm,
    weights_norm,
)
from millscale.prediction.kinds import Kind
from millscale.prediction.result import PredictedNumber
from millscale.runs.case_file import Case

# Differences of the filling beyond this are differences of the mill [share].
SAME_FILLING = 0.01
# Charges that are not used, of which an error names as many.
MOST_NAMED = 3


def usable_charges(
    folders: Sequence[Path], every: bool = False
) -> tuple[list[Charge], dict[str, str]]:
    """Return the finished, steady charges within the range of the law, by S and seed, and why the
    others are not used.

    Args:
        every: return all finished charges, also those that are not steady or out of range.

    Raises:
        RunFolderError: a folder holds no campaign, or a damaged one.
    """
    charges: list[Charge] = []
    excluded: dict[str, str] = {}
    for folder in {Path(folder).resolve(): folder for folder in folders}.values():
        campaign = load_campaign(folder)
        excluded |= {name: why for name, why in campaign.missing.items() if name.startswith("mb-")}
        for charge in campaign.charges:
            if every or not (why := why_not_usable(charge)):
                charges.append(charge)
            else:
                excluded[charge.id] = why
    return sorted(charges, key=lambda charge: (charge.S, charge.seed)), excluded


def why_not_usable(charge: Charge) -> str:
    """Return why a finished charge is not used; empty if it is."""
    steady = charge.result.steady
    why = "" if steady.is_steady else "; ".join(steady.reasons) or "not steady"
    return outside_range(charge.case) or why


def chosen_scaling(
    charges: Sequence[Charge],
    scheme: str | None,
    policy: str | None,
    excluded: Mapping[str, str] | None = None,
) -> tuple[str, str]:
    """Return scheme and policy of the scaled mills; at S = 1 all are the same mill.

    Args:
        scheme, policy: as asked for; None: the only one there is.
        excluded: charges that are not used, and why, by id.

    Raises:
        PredictionError: there is none, or several.
    """
    found = sorted(
        {
            (charge.scheme, charge.policy)
            for charge in charges
            if not charge.case.is_physical
            and scheme in (None, charge.scheme)
            and policy in (None, charge.policy)
        }
    )
    if len(found) == 1:
        return found[0]
    asked = " and ".join(x for x in (scheme, policy) if x)
    if not found:
        raise PredictionError(
            f"no finished and steady charge of a scaled mill{f' of {asked}' if asked else ''}"
            f"{_unused(excluded or {})}; accepted: two values of S or more; "
            + (
                "next: run smaller S or longer rotations, as the reasons state"
                if excluded
                else "next: millscale status DIR"
            )
        )
    listed = ", ".join(" with ".join(pair) for pair in found)
    raise PredictionError(
        f"scaled mills of {listed}; accepted: one scheme and policy; "
        "next: choose with --scheme and --policy"
    )


def by_physical_mill(charges: Iterable[Charge]) -> list[list[Charge]]:
    """Return the charges of each physical mill and filling, in the order of their first charges."""
    mills: list[list[Charge]] = []
    for charge in charges:
        for mill in mills:
            try:
                check_one_mill([mill[0], charge])
            except PredictionError:
                continue
            mill.append(charge)
            break
        else:
            mills.append([charge])
    return mills


def check_one_mill(charges: Sequence[Charge]) -> None:
    """Refuse charges that are not scaled models of one physical mill, filled alike.

    Raises:
        PredictionError: names two charges and what differs.
    """
    first = charges[0]
    for other in charges[1:]:
        ours, theirs = _of_physical_mill(first), _of_physical_mill(other)
        for key, value in ours.items():
            if not _is_close(value, theirs[key]):
                raise PredictionError(
                    f"{first.id} and {other.id} are not of one physical mill: {key} is {value} and "
                    f"{theirs[key]}; accepted: scaled models of one mill; "
                    "next: predict each mill from folders of its own"
                )
        filling = balls_per_length(other.case) / balls_per_length(first.case)
        if abs(filling - 1.0) > SAME_FILLING:
            raise PredictionError(
                f"{first.id} and {other.id} are not filled alike: {filling:.3f} times the balls "
                f"per length, scaled; accepted: within {100.0 * SAME_FILLING:g} %; "
                "next: run them with N / S^3 balls, or with [multi_ball] filling"
            )


def _of_physical_mill(charge: Charge) -> dict[str, Any]:
    """Return what all scaled mills of one physical mill share, by name."""
    case = charge.case
    mill, material = case.physical, case.material
    friction = material.static_friction_pp / (case.factors.friction or 1.0)
    return {
        **{f"physical.{name}": getattr(mill, name) for name in mill.__struct_fields__},
        "ball density": case.ball.density_kg_m3,
        "spread of ball radii": case.ball.radius_std_m,
        "poisson_ratio": material.poisson_ratio,
        "restitution_pp": material.restitution_pp,
        "restitution_pw": material.restitution_pw,
        "static_friction_pp": friction,
        "static_friction_pw": material.static_friction_pw,
        "rolling_friction_pp": material.rolling_friction_pp,
        "rolling_friction_pw": material.rolling_friction_pw,
    }


def _is_close(first: Any, second: Any) -> bool:
    if isinstance(first, float) and isinstance(second, float):
        return math.isclose(first, second, rel_tol=1e-9, abs_tol=1e-12)
    return bool(first == second)


def check_each_once(charges: Iterable[Charge]) -> None:
    """Refuse a run that stands in two folders: its copy is no second seed.

    Raises:
        PredictionError: names both.
    """
    seen: list[tuple[Case, Charge]] = []
    for charge in charges:
        # At S = 1 all schemes and policies are the same mill.
        names = {"id": "", "campaign": ""}
        names |= {"scheme": "", "policy": ""} if charge.case.is_physical else {}
        case = structs.replace(charge.case, **names)
        for other, first in seen:
            if case == other:
                raise PredictionError(
                    f"{first.folder} and {charge.folder} are the same run; accepted: each run "
                    "once, or other seeds; next: leave one of the folders out"
                )
        seen.append((case, charge))


def check_scaled_mills(charges: Sequence[Charge], excluded: Mapping[str, str]) -> None:
    """Refuse charges of fewer than two values of S, or of two friction exponents.

    Args:
        excluded: charges that are not used, and why, by id.

    Raises:
        PredictionError: states which there are and which charges are not used.
    """
    scaled = [charge.case for charge in charges if not charge.case.is_physical]
    exponents = sorted({case.friction_exponent or 1.0 for case in scaled})
    if len(exponents) > 1:
        raise PredictionError(
            f"scaled mills of friction_exponent {' and '.join(f'{k:g}' for k in exponents)}; "
            "accepted: one exponent; next: predict each from folders of its own"
        )
    if len(by_ratio((charge.S, charge) for charge in charges)) > 1:
        return
    found = f"S = {charges[0].S:.4g} alone" if charges else "no scaled mill"
    raise PredictionError(
        f"{found} is finished and steady{_unused(excluded)}; accepted: two values of S or more; "
        "next: run another S, such as 1.7 beside 2.6, which millscale advise plans"
    )


def check_spread(charges: Sequence[Charge]) -> None:
    """Refuse values of S whose weights multiply the noise too much for every kind of observable.

    Raises:
        PredictionError: states S, the norm of the weights and what would do.
    """
    groups = [Group(S, (0.0,) * len(runs)) for S, runs in by_ratio((x.S, x) for x in charges)]
    norm = min(weights_norm(groups, kind.prior) for kind in Kind)
    try:
        check_norm([group.S for group in groups], norm)
    except ExtrapolationError as error:
        raise PredictionError(str(error)) from None


def _unused(excluded: Mapping[str, str]) -> str:
    """Return which charges are not used, and why."""
    if not excluded:
        return ""
    named = [f"{name} ({why})" for name, why in itertools.islice(excluded.items(), MOST_NAMED)]
    more = len(excluded) - len(named)
    return f"; not used: {', '.join(named)}" + (f" and {more} more" if more else "")


def warnings_of(charges: Sequence[Charge]) -> Iterable[str]:
    """Yield what may mislead about the charges of a prediction."""
    if any(charge.policy == FRICTION_MATCHED for charge in charges):
        yield (
            "the errors of friction-matched mills change sign with S: three in four of their "
            "intervals hold, not 95 % (docs/results/coverage.md); predict from mills of policy "
            "paper"
        )
    diameters = [_slice_diameters(charge.case) for charge in charges]
    sliced = [d for d in diameters if d is not None]
    if sliced and len(sliced) < len(charges):
        yield "some runs are slices, others have the mill's whole length"
    short = min(sliced, default=4.0)
    if short < 4.0 * (1.0 - SAME_FILLING):
        yield (
            f"a slice is {short:.2g} ball diameters long: below four the ends act on the charge "
            "(docs/results/slice-length.json)"
        )
    steps = {charge.case.time.step_s for charge in charges}
    if max(steps) > 1.01 * min(steps):
        yield f"time steps of {min(steps):.3g} to {max(steps):.3g} s"
    if len({charge.stiffness for charge in charges}) > 1:
        yield "some runs have a fixed Young's modulus, others a matched overlap"


def warnings_of_order(numbers: Iterable[PredictedNumber]) -> Iterator[str]:
    """Yield which observables do not change in one direction with S."""
    for row in numbers:
        if row.reverses and not row.observable.restates:
            means = ", ".join(
                f"{number(x.mean, row.digits)} at S = {x.S:.4g}" for x in row.measured
            )
            yield f"{row.observable.label} is not monotonic in S: {means} {row.observable.unit}"


def _slice_diameters(case: Case) -> float | None:
    """Return the length of a slice in ball diameters; None for the whole length."""
    mill = case.mill
    if math.isclose(mill.simulated_length_m, mill.length_m, rel_tol=1e-9):
        return None
    return float(mill.simulated_length_m / (2.0 * case.ball.radius_m))
