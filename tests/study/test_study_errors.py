"""Errors of settings without what chance adds, on made-up distances."""

import itertools
import math
from pathlib import Path

import numpy as np
import pytest

from millscale.analysis.charge.comparison import Measured
from millscale.analysis.charge.scaled_mills import Charge
from millscale.runs.case_folder import FinishedCase
from millscale.study.errors import (
    ERRORS,
    Distances,
    compared_pairs,
    errors_of,
    models_of,
    pairs_of,
    reference_for,
)
from synthetic_case import case_document, typed

QUIET = {
    "mean_over_angles": {"contour_error_mean": 0.0, "curtain_iou_whole": 1.0},
    "massflow_rms_over_mean": 0.0,
    "power_error": 0.0,
}
# The window of the means of every charge [rad].
BEGIN = 1.0


def charge(setting, seed, S=2.6, scheme="constant-gravity", balls=100):
    case = case_document("multi-ball", scheme, "paper", S, balls) | {"seed": seed}
    case["id"] += f"-seed{seed}"
    return Charge(setting, FinishedCase(Path(), typed(case), {}, {}))


def study(charges, fields):
    """Models, references and distances of charges whose boxes hold curves, as an array each."""
    models = models_of(charges)
    references = [reference_for(model, models, "reference") for model in models]

    def rms(ours, theirs):
        return float(np.sqrt(np.mean((fields[ours] - fields[theirs]) ** 2)))

    pairs = compared_pairs(models, references)
    errors = {pair: QUIET | {"massflow_rms_over_mean": rms(*pair)} for pair in pairs}
    angles = {one.key: {0.5: 9.0, 1.0: 1.1, 2.0: 1.3} for one in charges}
    begin = dict.fromkeys((one.key for one in charges), BEGIN)
    measured = Measured(errors, angles, begin, {}, {one.key: [] for one in charges})
    return models, references, Distances(models, measured)


def test_curves_around_means_a_known_distance_apart_are_that_far_apart():
    """Many samples of independent noise: what is left of chance in the estimate is small."""
    generator, offset, noise, samples = np.random.default_rng(3), 0.05, 0.2, 200_000
    charges = [charge(name, seed) for name in ("reference", "other") for seed in (1, 2, 3)]
    fields = {
        one.key: offset * (one.campaign == "other") + noise * generator.normal(size=samples)
        for one in charges
    }
    models, references, distances = study(charges, fields)
    told = errors_of(models[1], references[1], distances)["mass_flow"]
    # D^2 = 0.0825 is known to 2 noise^2 sqrt(2 / samples) = 2.5e-4 a pair, the error, from
    # D^2 - V - V = 0.0025, to a third of that over 2 * 0.05.
    assert told["error"] == pytest.approx(offset, abs=2.5e-3)
    assert told["distance"] == pytest.approx(math.hypot(offset, math.sqrt(2.0) * noise), rel=0.01)
    assert told["scatter"] == pytest.approx(noise, rel=0.01)
    assert told["spread"] == pytest.approx(noise * math.sqrt(2.0 / 3.0), rel=0.01)
    assert told["within_spread"]


def test_error_and_spread_of_a_number_are_the_difference_of_means_and_its_standard_error():
    """Averaged over all ways that chance may fall: exact, as the docstring of the module says."""
    noise = [-1.0, 0.0, 1.0]
    offset, squared, spreads = 2.0, [], []
    for ours in itertools.product(noise, repeat=2):
        for theirs in itertools.product(noise, repeat=2):
            charges = [charge("reference", s) for s in (1, 2)] + [charge("x", s) for s in (3, 4)]
            values = [*theirs, *(offset + value for value in ours)]
            fields = {c.key: np.array([v]) for c, v in zip(charges, values, strict=True)}
            models, references, distances = study(charges, fields)
            model, reference = models[1], references[1]
            chance = [distances.chance(one, "mass_flow") for one in (model, reference)]
            squared.append(distances.between(model, reference, "mass_flow") ** 2 - sum(chance))
            spreads.append(sum(v / 2 for v in chance))
    assert np.mean(squared) == pytest.approx(offset**2)
    # Variance of the difference of two means of two each.
    assert np.mean(spreads) == pytest.approx(2.0 * np.var(noise) / 2.0)


def test_seeds_are_compared_with_other_seeds_and_with_the_same_only_if_there_are_no_others():
    models = models_of(
        [charge(n, s) for n, s in [("a", 1), ("a", 2), ("b", 1), ("b", 2), ("c", 1)]]
    )
    seeds = [
        [(a.case["seed"], b.case["seed"]) for a, b in pairs_of(models[i], models[j])]
        for i, j in ((0, 1), (0, 2), (0, 0), (2, 2))
    ]
    assert seeds == [[(1, 2), (2, 1)], [(2, 1)], [(1, 2)], []]
    assert len(pairs_of(models[2], models_of([charge("d", 1)])[0])) == 1


def test_the_reference_is_the_largest_mill_of_its_setting_and_the_same_scheme():
    charges = [
        charge("reference", 1, S, scheme)
        for S in (2.6, 1.0)
        for scheme in ("constant-gravity", "constant-speed")
    ]
    models = models_of([*charges, charge("x", 1, 2.6, "constant-speed")])
    found = reference_for(models[-1], models, "reference").first
    assert (found.S, found.case["scheme"]) == (1.0, "constant-speed")
    found = reference_for(models[0], models, "reference").first
    assert (found.S, found.case["scheme"]) == (1.0, "constant-gravity")
    with pytest.raises(ValueError, match="no finished case of the reference, setting 'nowhere'"):
        reference_for(models[0], models, "nowhere")


def test_a_setting_of_one_seed_takes_the_chance_of_those_of_its_size():
    charges = [charge("reference", s) for s in (1, 2)] + [charge("one", 3)]
    charges += [charge("slice", s, balls=25) for s in (1, 2)]
    fields = {c.key: np.array([0.0]) for c in charges}
    fields[charges[1].key] = np.array([0.02])  # V = 2e-4
    fields[charges[4].key] = np.array([0.2])
    models, references, distances = study(charges, fields)
    assert distances.chance(models[1], "mass_flow") == pytest.approx(2e-4)
    assert distances.chance(models[2], "mass_flow") == pytest.approx(2e-2)
    told = errors_of(models[1], references[1], distances)["mass_flow"]
    assert told["spread"] == pytest.approx(math.sqrt(2e-4 / 1 + 2e-4 / 2))
    assert told["scatter"] is None


def test_without_several_seeds_anywhere_the_error_holds_all_of_chance():
    charges = [charge("reference", 1), charge("x", 1)]
    fields = {charges[0].key: np.array([0.0]), charges[1].key: np.array([0.03])}
    models, references, distances = study(charges, fields)
    told = errors_of(models[1], references[1], distances)["mass_flow"]
    assert told["error"] == told["distance"] == pytest.approx(0.03)
    assert told["spread"] is None and told["within_spread"] is None
    own = errors_of(models[0], references[0], distances)
    assert {one["error"] for one in own.values()} == {None}


def test_every_error_is_read_from_what_was_measured():
    charges = [charge("reference", 1), charge("x", 2)]
    models, references, distances = study(charges, {c.key: np.array([0.0]) for c in charges})
    (pair,) = distances.measured.errors
    distances.measured.errors[pair] = {
        "mean_over_angles": {"contour_error_mean": 0.01, "curtain_iou_whole": 0.8},
        "massflow_rms_over_mean": 0.3,
        "power_error": -0.04,
    }
    # Means over the second half, 1 and 2 rad: 1.2 and 1.26 rad.
    distances.measured.throw_angles[charges[1].key].update({1.0: 1.16, 2.0: 1.36})
    told = errors_of(models[1], references[1], distances)
    values = {name: round(one["error"], 9) for name, one in told.items()}
    assert values == {
        "contour": 0.01, "curtain": 0.2, "mass_flow": 0.3, "power": 0.04, "detach_angle": 0.05
    }  # fmt: skip
    assert list(told) == list(ERRORS)
    distances.measured.throw_angles[charges[1].key].clear()
    assert errors_of(models[1], references[1], distances)["detach_angle"]["error"] is None
