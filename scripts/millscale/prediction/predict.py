"""Prediction of a physical mill from the finished charges of its scaled mills."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

from millscale.analysis.charge.measured import measure
from millscale.analysis.charge.physical_mill import PhysicalMill, balls_per_length, physical_mill
from millscale.analysis.finished import Charge
from millscale.errors import PredictionError
from millscale.prediction.contour import predict_contour
from millscale.prediction.extrapolation import (
    ExtrapolationError,
    Group,
    by_ratio,
    extrapolate,
    reverses,
)
from millscale.prediction.field import predict_field
from millscale.prediction.impacts import Scales, predict_spectra
from millscale.prediction.mass_flow import predict_mass_flow
from millscale.prediction.noise import noise_of
from millscale.prediction.observables import (
    Numbers,
    Observable,
    observables_of,
)
from millscale.prediction.result import PredictedNumber, Prediction, ScaledValue
from millscale.prediction.selection import (
    check_each_once,
    check_one_mill,
    check_scaled_mills,
    check_spread,
    chosen_scaling,
    usable_charges,
    warnings_of,
    warnings_of_order,
    why_not_usable,
)
from millscale.runs.untrusted import RunFolderError

# Residuals that only one mill in a hundred would have if the law held refuse the law.
LEAST_RESIDUAL_PROBABILITY = 0.01


def predict(
    folders: Sequence[Path],
    scheme: str | None = None,
    policy: str | None = None,
    level: float = 0.95,
    leave_out_physical: bool = False,
) -> Prediction:
    """Predict the physical mill from runs folders of its scaled mills.

    Args:
        scheme, policy: of the scaled mills to use, where the folders hold several.
        level: probability of the intervals.
        leave_out_physical: do not use S = 1, but compare with it.

    Raises:
        PredictionError: the charges are not scaled mills of one physical mill, are too few or too
            close together.
        RunFolderError: a folder holds no campaign, or a damaged one.
    """
    if not 0.5 <= level < 1.0:
        raise PredictionError(f"level: got {level:g}; accepted: 0.5 to below 1, such as 0.95")
    try:
        used, left_out, excluded = _chosen(folders, scheme, policy, leave_out_physical)
    except PredictionError as error:
        where = ", ".join(str(folder) for folder in folders)
        raise PredictionError(f"{where}: {error}") from None
    values = measure([*used, *left_out], []).numbers
    return predict_charges(used, left_out, values, level, excluded)


def _chosen(
    folders: Sequence[Path], scheme: str | None, policy: str | None, leave_out_physical: bool
) -> tuple[list[Charge], list[Charge], dict[str, str]]:
    """Return the charges to use, those to compare with, and why others are not used, by id."""
    charges, excluded = usable_charges(folders)
    return *_chosen_of(charges, excluded, scheme, policy, leave_out_physical), excluded


def _chosen_of(
    charges: Sequence[Charge],
    excluded: Mapping[str, str],
    scheme: str | None = None,
    policy: str | None = None,
    leave_out_physical: bool = False,
) -> tuple[list[Charge], list[Charge]]:
    """Return which of the usable charges to use, and those to compare with."""
    scheme, policy = chosen_scaling(charges, scheme, policy, excluded)
    wanted = [
        charge
        for charge in charges
        if charge.case.is_physical or (charge.scheme == scheme and charge.policy == policy)
    ]
    check_one_mill(wanted)
    check_each_once(wanted)
    if leave_out_physical and not any(charge.case.is_physical for charge in wanted):
        raise PredictionError(
            "no finished charge of S = 1 to compare with; accepted: one or more; "
            "next: run one, or leave --check out"
        )
    used = [x for x in wanted if not (leave_out_physical and x.case.is_physical)]
    check_scaled_mills(used, excluded)
    check_spread(used)
    return used, [charge for charge in wanted if charge not in used]


def predict_numbers(
    charges: Sequence[Charge],
    values: Mapping[Charge, Mapping[str, float | None]],
    level: float = 0.95,
) -> list[PredictedNumber]:
    """Return the numbers of `predict` alone, from finished charges that are measured.

    Args:
        values: of each charge, by the name of the quantity (`measured.measure`).

    Raises:
        PredictionError: as of `predict`.
    """
    why = {charge: why_not_usable(charge) for charge in charges}
    usable = sorted((x for x in charges if not why[x]), key=lambda x: (x.S, x.seed))
    excluded = {charge.id: reason for charge, reason in why.items() if reason}
    used, _ = _chosen_of(usable, excluded)
    mill = _physical_mill(used)
    return [_predicted(row, used, values, mill, level) for row in observables_of(used)]


def _physical_mill(used: Sequence[Charge]) -> PhysicalMill:
    return physical_mill(used[0].case, _mean(balls_per_length(charge.case) for charge in used))


def predict_charges(
    used: Sequence[Charge],
    left_out: Sequence[Charge],
    values: Mapping[Charge, Mapping[str, float | None]],
    level: float = 0.95,
    excluded: Mapping[str, str] | None = None,
) -> Prediction:
    """Predict the physical mill from charges of one physical mill that are measured.

    Args:
        used: of one scheme and policy, and two values of S or more, or of S = 1 alone.
        left_out: charges of S = 1 to compare with.
        values: of each charge, by the name of the quantity (`measured.measure`).
        excluded: charges that are not used, and why, by id.
    """
    mill = _physical_mill(used)
    numbers = [_predicted(row, used, values, mill, level) for row in observables_of(used)]
    if left_out:
        numbers = [_with_check(number, left_out, values) for number in numbers]
    contour, refused = _or_reason(predict_contour, used, left_out, level)
    mass_flow, flow_refused = _or_reason(predict_mass_flow, used, left_out, level)
    field, field_refused = _or_reason(predict_field, used, left_out)
    impacts = Scales(mill.energy_scale / mill.balls, mill.balls * mill.omega / math.tau)
    spectra, spectra_refused = _or_reason(predict_spectra, used, left_out, level, impacts)
    # At S = 1 all schemes and policies are the same mill.
    scaled = next((charge for charge in used if not charge.case.is_physical), used[0])
    return Prediction(
        mill=mill,
        scheme=scaled.scheme,
        policy=scaled.policy,
        numbers=tuple(numbers),
        contour=contour,
        contour_refused=refused,
        runs=tuple(used),
        excluded=excluded or {},
        warnings=(*warnings_of(used), *warnings_of_order(numbers)),
        level=level,
        mass_flow=mass_flow,
        mass_flow_refused=flow_refused,
        field=field,
        field_refused=field_refused,
        spectra=spectra or (),
        spectra_refused=spectra_refused,
    )


def _predicted(
    observable: Observable,
    charges: Sequence[Charge],
    values: Mapping[Charge, Numbers],
    mill: PhysicalMill,
    level: float,
) -> PredictedNumber:
    scale = observable.scale(mill)
    groups = _groups(observable, charges, values)
    measured = tuple(ScaledValue(g.S, scale * g.mean, len(g.values)) for g in groups)
    number = PredictedNumber(observable, scale, None, None, "", measured, "")
    if observable.refuse and (reason := observable.refuse(charges)):
        return replace(number, refused=reason)
    if len(groups) < 2 and not all(charge.case.is_physical for charge in charges):
        return replace(number, refused="measured at fewer than two values of S")
    noise, noise_from = noise_of(observable.measured_as, groups, charges)
    if noise is None:
        return replace(number, refused="its noise is not known: add a seed")
    try:
        found = extrapolate(groups, noise, level, observable.kind.prior)
    except ExtrapolationError as error:
        return replace(number, refused=str(error))
    number = replace(
        number, found=found, noise=noise, noise_from=noise_from, reverses=reverses(groups, noise)
    )
    probability = found.residual_probability
    if probability is not None and probability < LEAST_RESIDUAL_PROBABILITY:
        reason = f"its values do not follow a power of S (probability {probability:.1g})"
        return replace(number, found=None, refused=reason)
    return number


def _groups(
    observable: Observable, charges: Sequence[Charge], values: Mapping[Charge, Numbers]
) -> list[Group]:
    """Return the values of an observable by S."""
    known = (
        (charge.S, value)
        for charge in charges
        if (value := observable.read(charge, values[charge])) is not None
    )
    return [Group(S, tuple(found)) for S, found in by_ratio(known)]


T = TypeVar("T")


def _or_reason(predicted: Callable[..., T], *given: object) -> tuple[T | None, str]:
    """Return what is predicted from what is given, or why it is not."""
    try:
        return predicted(*given), ""
    except (ExtrapolationError, RunFolderError) as error:
        return None, str(error)


def _with_check(
    number: PredictedNumber,
    truth: Sequence[Charge],
    values: Mapping[Charge, Numbers],
) -> PredictedNumber:
    read = number.observable.read
    known = [x for charge in truth if (x := read(charge, values[charge])) is not None]
    return replace(number, check=number.scale * _mean(known)) if known else number


def _mean(values: Iterable[float]) -> float:
    known = list(values)
    return math.fsum(known) / len(known)
