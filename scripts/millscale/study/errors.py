"""How far each setting of a study is from its reference, told from what chance does.

A bed is chaotic: two seeds of one setting are a distance apart. With D the root mean square
distance of two runs and V = D^2 / 2 between seeds, what a run adds by chance,

    error^2  = D^2(setting, reference) - V(setting) - V(reference), at least 0
    spread^2 = V(setting) / n + V(reference) / m

of n and m seeds: error is the distance of their means without chance, spread the distance that
means of so many seeds have by chance alone. For numbers and for root mean squares of curves both
hold exactly (the second is the standard error of a difference of means; Szekely and Rizzo 2013,
doi 10.1016/j.jspi.2013.03.018, for the first); for contours and curtains, whose distance is no
root mean square, they hold where one of error and chance is small. Derived here.

Three seeds tell V to a factor of two, so it is the mean over all settings of the same S and number
of balls: what a setting scatters beyond that counts as its error.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from millscale.analysis.charge.comparison import Key, Measured, Pairs
from millscale.analysis.charge.scaled_mills import Charge

Row = dict[str, Any]
# What is compared, in words; all are shares.
ERRORS = {
    "contour": "surface contour: mean distance over R - a",
    "curtain": "curtains: 1 - intersection over union",
    "mass_flow": "mass in the monitoring box: RMS difference over its mean",
    "power": "mean power over M g R omega: relative",
    "detach_angle": "angle from the vertical at which balls were thrown: relative",
}


@dataclass(frozen=True)
class SettingModel:
    """The seeds of one mill in one setting."""

    seeds: tuple[Charge, ...]

    @property
    def setting(self) -> str:
        return self.seeds[0].campaign

    @property
    def first(self) -> Charge:
        return self.seeds[0]


def models_of(charges: Sequence[Charge]) -> list[SettingModel]:
    """Charges by setting, scheme, policy, stiffness and S; seeds in order."""
    groups: dict[tuple, list[Charge]] = {}
    for charge in charges:
        groups.setdefault(charge.model, []).append(charge)
    ordered = (sorted(group, key=lambda charge: charge.case["seed"]) for group in groups.values())
    return [SettingModel(tuple(group)) for group in ordered]


def reference_for(
    model: SettingModel, models: Sequence[SettingModel], setting: str
) -> SettingModel:
    """The reference of a model: of the setting named, the largest mill (smallest S), there of the
    model's own scheme and policy if possible.

    Raises:
        ValueError: nothing of that setting is finished.
    """
    known = [other for other in models if other.setting == setting]
    if not known:
        raise ValueError(f"no finished case of the reference, setting {setting!r}")
    return min(
        known,
        key=lambda other: (
            other.first.S,
            *(a != b for a, b in zip(other.first.model[1:4], model.first.model[1:4], strict=True)),
        ),
    )


def pairs_of(first: SettingModel, second: SettingModel) -> list[tuple[Charge, Charge]]:
    """Runs of two models to compare: those of different seeds, since the same packing may be alike
    for a while; all if there are no others. Of one model each two once."""
    if first is second:
        seeds = first.seeds
        return [(a, b) for i, a in enumerate(seeds) for b in seeds[i + 1 :]]
    every = [(a, b) for a in first.seeds for b in second.seeds]
    return [(a, b) for a, b in every if a.case["seed"] != b.case["seed"]] or every


def compared_pairs(models: Sequence[SettingModel], references: Sequence[SettingModel]) -> Pairs:
    """What has to be measured: the seeds of each model against each other and its reference's."""
    wanted = [(model, model) for model in models]
    wanted += [(m, r) for m, r in zip(models, references, strict=True) if m is not r]
    return {(a.key, b.key): (a, b) for m, r in wanted for a, b in pairs_of(m, r)}


@dataclass(frozen=True)
class Distances:
    """Root mean square distances between the models of a study.

    Attributes:
        measured: of the `compared_pairs` of the models.
    """

    models: Sequence[SettingModel]
    measured: Measured

    def between(self, first: SettingModel, second: SettingModel, error: str) -> float | None:
        """Root mean square distance of runs of two models; None if nothing could be compared."""
        found = [distance(self.measured, (a.key, b.key), error) for a, b in pairs_of(first, second)]
        known = [value for value in found if value is not None]
        return math.sqrt(float(np.mean(np.square(known)))) if known else None

    def scatter(self, model: SettingModel, error: str) -> float | None:
        """What one run of a model is off by chance: the square root of its own V; None for one
        seed."""
        own = self.between(model, model, error)
        return None if own is None else math.sqrt(0.5) * own

    def chance(self, model: SettingModel, error: str) -> float | None:
        """V of the module's docstring for a model: the mean over those of its S and number of
        balls; if none of them has several seeds, over those nearest in S, then in balls; None if
        no model has."""

        def remoteness(other: SettingModel) -> tuple[float, int]:
            balls = [one.first.case["ball"]["count"] for one in (other, model)]
            return abs(other.first.S - model.first.S), abs(balls[0] - balls[1])

        scatters = [(remoteness(other), self.scatter(other, error)) for other in self.models]
        told = [(remote, value) for remote, value in scatters if value is not None]
        nearest = min(told, default=None)
        if nearest is None:
            return None
        return float(np.mean([value**2 for remote, value in told if remote == nearest[0]]))


def distance(measured: Measured, pair: tuple[Key, Key], error: str) -> float | None:
    """Distance of two runs in one of ERRORS."""
    row = measured.errors[pair]
    if error == "contour":
        return row["mean_over_angles"]["contour_error_mean"]
    if error == "curtain":
        overlap = row["mean_over_angles"]["curtain_iou_whole"]
        return None if overlap is None else 1.0 - overlap
    if error == "mass_flow":
        return row["massflow_rms_over_mean"]
    if error == "power":
        return None if row["power_error"] is None else abs(row["power_error"])
    return _throw_distance(measured, pair)


def _throw_distance(measured: Measured, pair: tuple[Key, Key]) -> float | None:
    """Relative, of the means over the mill angles in the windows of both that both have."""
    ours, theirs = (measured.throw_angles[key] for key in pair)
    begin = max(measured.steady_from[key] for key in pair)
    steady = [angle for angle in ours.keys() & theirs.keys() if angle >= begin]
    if not steady:
        return None
    means = [float(np.mean([known[angle] for angle in steady])) for known in (ours, theirs)]
    return abs(means[0] / means[1] - 1.0) if means[1] else None


def errors_of(model: SettingModel, reference: SettingModel, distances: Distances) -> dict[str, Row]:
    """Each of ERRORS: error and spread of the module's docstring; distance, D; scatter, what a
    single run of the setting is off by chance; within_spread, whether the error is no more than the
    spread. A value that cannot be told is None; without any V the error is D."""
    return {name: _error(model, reference, distances, name) for name in ERRORS}


def _error(model: SettingModel, reference: SettingModel, distances: Distances, name: str) -> Row:
    row: Row = dict.fromkeys(("error", "spread", "within_spread", "distance"))
    row["scatter"] = distances.scatter(model, name)
    far = None if model is reference else distances.between(model, reference, name)
    if far is None:
        return row
    row |= {"error": far, "distance": far}
    chance = [distances.chance(one, name) for one in (model, reference)]
    if None in chance:
        return row
    error = math.sqrt(max(0.0, far**2 - sum(chance)))
    counts = [len(one.seeds) for one in (model, reference)]
    spread = math.sqrt(sum(v / n for v, n in zip(chance, counts, strict=True)))
    return row | {"error": error, "spread": spread, "within_spread": error <= spread}
