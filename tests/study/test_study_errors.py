"""Errors of settings without what chance adds, on made-up distances."""

import itertools
import math
from pathlib import Path

import numpy as np
import pytest

from millscale.analysis.charge.measured import Measured
from millscale.analysis.charge.pair_errors import OF_DUMPS, PairErrors
from millscale.analysis.charge.scaled_mills import scaled_mills
from millscale.analysis.finished import Charge
from millscale.analysis.measures import ERRORS, STUDIED
from millscale.runs.case_folder import FinishedCase
from millscale.study.errors import (
    Distances,
    compared_pairs,
    errors_of,
    pairs_of,
    reference_for,
)
from synthetic_case import case_document, typed

# Of two charges that do not differ.
SAME = {error.name: error.same for error in ERRORS}


def charge(setting, seed, S=2.6, scheme="constant-gravity", balls=100):
    case = case_document("multi-ball", scheme, "paper", S, balls) | {"seed": seed}
    case["id"] += f"-seed{seed}"
    return Charge(FinishedCase(Path(), typed(case), {}, {}), setting)


def pair_errors(**changes):
    values = SAME | changes
    return PairErrors(values, {name: values[name] for name in OF_DUMPS})


def study(charges, fields):
    """Mills, references and distances of charges whose boxes hold curves, as an array each."""
    mills = scaled_mills(charges)
    references = [reference_for(mill, mills, "reference") for mill in mills]

    def rms(ours, theirs):
        return float(np.sqrt(np.mean((fields[ours] - fields[theirs]) ** 2)))

    pairs = compared_pairs(mills, references)
    errors = {pair: pair_errors(massflow_rms_over_mean=rms(*pair)) for pair in pairs}
    return mills, references, Distances(mills, Measured(errors=errors))


def test_curves_around_means_a_known_distance_apart_are_that_far_apart():
    """Many samples of independent noise: what is left of chance in the estimate is small."""
    generator, offset, noise, samples = np.random.default_rng(3), 0.05, 0.2, 200_000
    charges = [charge(name, seed) for name in ("reference", "other") for seed in (1, 2, 3)]
    fields = {
        one: offset * (one.campaign == "other") + noise * generator.normal(size=samples)
        for one in charges
    }
    mills, references, distances = study(charges, fields)
    found = errors_of(mills[1], references[1], distances)["mass_flow"]
    # D^2 = 0.0825 is known to 2 noise^2 sqrt(2 / samples) = 2.5e-4 a pair, the error, from
    # D^2 - V - V = 0.0025, to a third of that over 2 * 0.05.
    assert found.error == pytest.approx(offset, abs=2.5e-3)
    assert found.distance == pytest.approx(math.hypot(offset, math.sqrt(2.0) * noise), rel=0.01)
    assert found.scatter == pytest.approx(noise, rel=0.01)
    assert found.spread == pytest.approx(noise * math.sqrt(2.0 / 3.0), rel=0.01)
    assert found.within_spread


def test_error_and_spread_of_a_number_are_the_difference_of_means_and_its_standard_error():
    """Averaged over all ways that chance may fall: exact, as the docstring of the module says."""
    noise = [-1.0, 0.0, 1.0]
    offset, squared, spreads = 2.0, [], []
    for ours in itertools.product(noise, repeat=2):
        for theirs in itertools.product(noise, repeat=2):
            charges = [charge("reference", s) for s in (1, 2)] + [charge("x", s) for s in (3, 4)]
            values = [*theirs, *(offset + value for value in ours)]
            fields = {c: np.array([v]) for c, v in zip(charges, values, strict=True)}
            mills, references, distances = study(charges, fields)
            model, reference = mills[1], references[1]
            chance = [distances.chance(one, "mass_flow") for one in (model, reference)]
            squared.append(distances.between(model, reference, "mass_flow") ** 2 - sum(chance))
            spreads.append(sum(v / 2 for v in chance))
    assert np.mean(squared) == pytest.approx(offset**2)
    # Variance of the difference of two means of two each.
    assert np.mean(spreads) == pytest.approx(2.0 * np.var(noise) / 2.0)


def test_seeds_are_compared_with_other_seeds_and_with_the_same_only_if_there_are_no_others():
    mills = scaled_mills(
        [charge(n, s) for n, s in [("a", 1), ("a", 2), ("b", 1), ("b", 2), ("c", 1)]]
    )
    seeds = [
        [(a.seed, b.seed) for a, b in pairs_of(mills[i], mills[j])]
        for i, j in ((0, 1), (0, 2), (0, 0), (2, 2))
    ]
    assert seeds == [[(1, 2), (2, 1)], [(2, 1)], [(1, 2)], []]
    assert len(pairs_of(mills[2], scaled_mills([charge("d", 1)])[0])) == 1


def test_the_reference_is_the_largest_mill_of_its_setting_and_the_same_scheme():
    charges = [
        charge("reference", 1, S, scheme)
        for S in (2.6, 1.0)
        for scheme in ("constant-gravity", "constant-speed")
    ]
    mills = scaled_mills([*charges, charge("x", 1, 2.6, "constant-speed")])
    found = reference_for(mills[-1], mills, "reference").first
    assert (found.S, found.scheme) == (1.0, "constant-speed")
    found = reference_for(mills[0], mills, "reference").first
    assert (found.S, found.scheme) == (1.0, "constant-gravity")
    with pytest.raises(ValueError, match="no finished case of the reference, setting 'nowhere'"):
        reference_for(mills[0], mills, "nowhere")


def test_a_setting_of_one_seed_takes_the_chance_of_those_of_its_size():
    charges = [charge("reference", s) for s in (1, 2)] + [charge("one", 3)]
    charges += [charge("slice", s, balls=25) for s in (1, 2)]
    fields = {c: np.array([0.0]) for c in charges}
    fields[charges[1]] = np.array([0.02])  # V = 2e-4
    fields[charges[4]] = np.array([0.2])
    mills, references, distances = study(charges, fields)
    assert distances.chance(mills[1], "mass_flow") == pytest.approx(2e-4)
    assert distances.chance(mills[2], "mass_flow") == pytest.approx(2e-2)
    found = errors_of(mills[1], references[1], distances)["mass_flow"]
    assert found.spread == pytest.approx(math.sqrt(2e-4 / 1 + 2e-4 / 2))
    assert found.scatter is None


def test_without_several_seeds_anywhere_the_error_holds_all_of_chance():
    charges = [charge("reference", 1), charge("x", 1)]
    fields = {charges[0]: np.array([0.0]), charges[1]: np.array([0.03])}
    mills, references, distances = study(charges, fields)
    found = errors_of(mills[1], references[1], distances)["mass_flow"]
    assert found.error == found.distance == pytest.approx(0.03)
    assert found.spread is None and found.within_spread is None
    own = errors_of(mills[0], references[0], distances)
    assert {one.error for one in own.values()} == {None}


def test_every_error_is_read_from_what_was_measured():
    charges = [charge("reference", 1), charge("x", 2)]
    mills, references, distances = study(charges, {c: np.array([0.0]) for c in charges})
    (pair,) = distances.measured.errors
    distances.measured.errors[pair] = pair_errors(
        contour_error_mean=0.01,
        curtain_iou_whole=0.8,
        massflow_rms_over_mean=0.3,
        power_error=-0.04,
        detach_angle_error=None,
    )
    found = errors_of(mills[1], references[1], distances)
    values = {name: one.error and round(one.error, 9) for name, one in found.items()}
    assert values == {
        "contour": 0.01, "curtain": 0.2, "mass_flow": 0.3, "power": 0.04, "detach_angle": None
    }  # fmt: skip
    assert list(found) == list(STUDIED)
