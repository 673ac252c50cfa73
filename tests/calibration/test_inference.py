"""Statistics of a calibration: known parameters of closed models are found, and what the data do
not determine is named."""

from __future__ import annotations

import math

import numpy as np
import pytest

from millscale.calibration.inference import (
    CalibrationError,
    Evidence,
    Parameter,
    contributions,
    infer,
    next_places,
    target_model,
)
from millscale.calibration.posterior import particles_of
from millscale.calibration.surrogate import fit

FRICTION = Parameter("friction", ("material.static_friction_pp",), 0.1, 0.9)
ROLLING = Parameter("rolling", ("material.rolling_friction_pp",), 1e-3, 0.1, logarithmic=True)


def places(count, dimensions=2, seed=4):
    """Evenly spread places of the cube."""
    from scipy.stats import qmc

    sequence = qmc.Sobol(dimensions, rng=np.random.default_rng(seed))
    return sequence.random_base2(math.ceil(math.log2(count)))[:count]


def torque(at):
    """A number that friction saturates and rolling friction raises."""
    mu, rolling = FRICTION.value(at[:, 0]), ROLLING.value(at[:, 1])
    return 0.35 * (1.0 - np.exp(-mu / 0.25)) + 0.6 * rolling


def shoulder(at):
    """A number that depends on the two in another way."""
    return 0.3 + 0.05 * FRICTION.value(at[:, 0]) + 2.5 * ROLLING.value(at[:, 1])


def evidence(at, models, truth, uncertainties, generator=None):
    made = []
    for (name, model), deviation in zip(models.items(), uncertainties, strict=True):
        measured = model(np.array([truth]))[0]
        values = model(at)
        if generator is not None:
            values = values + 0.3 * deviation * generator.normal(size=len(at))
        made.append(Evidence(name, (values - measured)[:, None] / deviation, (None,) * len(at)))
    return made


TRUTH = np.array([0.45, 0.6])
MODELS = {"torque": torque, "shoulder": shoulder}


def refined(models, uncertainties, generator=None, rounds=3, first=16, later=6):
    """The result after rounds of samples, as the command makes them."""
    at, found = places(first), None
    given = [at]
    for _ in range(rounds):
        every = np.vstack(given)
        found = infer(
            (FRICTION, ROLLING),
            every,
            evidence(every, models, TRUTH, uncertainties, generator),
            before=found,
        )
        given.append(next_places(found, later))
    return found


def test_known_parameters_are_found():
    found = refined(MODELS, (0.004, 0.004))
    for one, parameter, place in zip(found.found, (FRICTION, ROLLING), TRUTH, strict=True):
        truth = float(parameter.value(place))
        assert one.lower < truth < one.upper
        assert one.width < 0.35 and one.is_determined
        assert abs(parameter.place(one.best) - place) < 0.35 * one.width
    assert found.is_converged and found.warnings() == []


def test_the_interval_is_that_of_a_linear_model():
    """A linear model of known noise has a normal density with a covariance in closed form."""
    slopes = np.array([[2.0, 1.0], [0.5, -2.0], [1.0, 1.0]])
    at = places(12)
    made = [
        Evidence(f"t{i}", ((at - 0.5) @ row * 10.0)[:, None], (0.0,) * len(at))
        for i, row in enumerate(slopes)
    ]
    found = infer((Parameter("a", ("x",), 0.0, 1.0), Parameter("b", ("y",), 0.0, 1.0)), at, made)
    covariance = np.linalg.inv(100.0 * slopes.T @ slopes)
    for j, one in enumerate(found.found):
        assert one.best == pytest.approx(0.5, abs=0.1 * math.sqrt(covariance[j, j]))
        assert one.width == pytest.approx(2.0 * 1.96 * math.sqrt(covariance[j, j]), rel=0.08)
    expected = covariance[0, 1] / math.sqrt(covariance[0, 0] * covariance[1, 1])
    assert found.correlation[0, 1] == pytest.approx(expected, abs=0.06)


def test_intervals_hold_the_truth_as_often_as_they_state():
    """Measured numbers scatter by their uncertainty about those of the truth."""
    generator, held = np.random.default_rng(8), []
    at = places(16)
    for _ in range(24):
        truth = generator.random(2)
        made = []
        for name, model in MODELS.items():
            measured = model(truth[None])[0] + 0.01 * generator.normal()
            made.append(Evidence(name, (model(at) - measured)[:, None] / 0.01, (None,) * 16))
        found = infer((FRICTION, ROLLING), at, made, level=0.8)
        held += [
            one.lower <= parameter.value(place) <= one.upper
            for one, parameter, place in zip(found.found, (FRICTION, ROLLING), truth, strict=True)
        ]
    # 48 intervals of 80 %: three standard deviations of the count of a binomial.
    assert 0.8 - 0.173 < np.mean(held) < 0.8 + 0.173


def test_what_the_targets_do_not_determine_is_named():
    found = refined({"torque": torque}, (0.004,))
    by_name = {one.name: one for one in found.found}
    assert by_name["friction"].is_determined
    assert not by_name["rolling"].is_determined
    assert any(text.startswith("rolling is not determined") for text in found.warnings())


def test_a_combination_is_named():
    at = places(16)
    line = ((at.sum(axis=1) - 1.0) / 0.02)[:, None]
    wide = ((at[:, 0] - 0.5) / 0.1)[:, None]
    made = [Evidence("sum", line, (0.0,) * 16), Evidence("first", wide, (0.0,) * 16)]
    found = infer((Parameter("a", ("x",), 0.0, 1.0), Parameter("b", ("y",), 0.0, 1.0)), at, made)
    assert found.correlation[0, 1] < -0.95
    assert any("determine a combination" in text for text in found.warnings())


def test_each_target_informs_what_it_depends_on():
    at = places(16)
    made = [
        Evidence("left", ((at[:, 0] - 0.4) / 0.03)[:, None], (0.0,) * 16),
        Evidence("right", ((at[:, 1] - 0.7) / 0.05)[:, None], (0.0,) * 16),
    ]
    found = infer((Parameter("a", ("x",), 0.0, 1.0), Parameter("b", ("y",), 0.0, 1.0)), at, made)
    parts = contributions(found)
    assert parts["left"].alone[0] < 0.15 and parts["left"].alone[1] > 0.85
    assert parts["right"].alone[0] > 0.85 and parts["right"].alone[1] < 0.25
    assert parts["left"].without[0] > 0.85 and parts["right"].without[0] < 0.15


def test_a_range_that_does_not_hold_the_truth_is_named():
    at = places(16)
    made = [Evidence("t", ((at[:, 0] - 1.02) / 0.05)[:, None], (0.0,) * 16)]
    found = infer((Parameter("a", ("x",), 0.0, 1.0), Parameter("b", ("y",), 0.0, 1.0)), at, made)
    assert found.found[0].cut_by == "most"
    assert "the interval of a ends at its most value: widen the range" in found.warnings()


def test_a_target_that_no_parameters_meet_is_named():
    at = places(16)
    made = [
        Evidence("low", ((at[:, 0] - 0.3) / 0.02)[:, None], (0.0,) * 16),
        Evidence("high", ((at[:, 0] - 0.7) / 0.02)[:, None], (0.0,) * 16),
    ]
    found = infer((Parameter("a", ("x",), 0.0, 1.0), Parameter("b", ("y",), 0.0, 1.0)), at, made)
    assert [one.is_met for one in found.met] == [False, False]
    assert sum("is not met" in text for text in found.warnings()) == 2


def test_two_regions_are_both_in_the_interval():
    at = places(24, 1)
    made = [Evidence("t", (((at[:, 0] - 0.5) ** 2 - 0.09) / 0.01)[:, None], (0.0,) * 24)]
    (one,) = infer((Parameter("a", ("x",), 0.0, 1.0),), at, made).found
    assert one.lower == pytest.approx(0.2, abs=0.05) and one.upper == pytest.approx(0.8, abs=0.05)
    # Their mean fits nothing, so the best value is in one of them.
    assert min(abs(one.best - 0.2), abs(one.best - 0.8)) < 0.05


def test_noise_of_the_runs_widens_the_interval():
    quiet = refined(MODELS, (0.004, 0.004))
    noisy = refined(MODELS, (0.004, 0.004), np.random.default_rng(1))
    assert noisy.met[0].surrogate > 3.0 * quiet.met[0].surrogate
    truth = [float(p.value(x)) for p, x in zip((FRICTION, ROLLING), TRUTH, strict=True)]
    for one, value in zip(noisy.found, truth, strict=True):
        assert one.lower < value < one.upper


def test_a_profile_counts_as_the_directions_in_which_the_runs_differ():
    at, x = places(16), np.linspace(-1.0, 1.0, 9)

    def profile(place):
        return place[0] * x + place[1] * (x**2 - 0.5)

    differences = np.array([profile(place) - profile(TRUTH) for place in at]) / 0.02
    model = target_model(at, Evidence("profile", differences, (None,) * 16))
    assert len(model.directions) == 2
    assert model.differences(at[3]) == pytest.approx(differences[3], abs=0.3)
    parameters = (Parameter("a", ("x",), 0.0, 1.0), Parameter("b", ("y",), 0.0, 1.0))
    found = infer(parameters, at, [Evidence("profile", differences, (0.0,) * 16)])
    for one, place in zip(found.found, TRUTH, strict=True):
        assert one.best == pytest.approx(place, abs=0.01)
    design = np.column_stack([x, x**2 - 0.5]) / 0.02
    deviation = np.sqrt(np.diag(np.linalg.inv(design.T @ design)))
    assert [one.deviation for one in found.found] == pytest.approx(deviation, rel=0.1)


def test_a_difference_that_no_parameter_changes_stays_in_the_profile():
    at, x = places(16), np.linspace(-1.0, 1.0, 9)
    differences = at[:, :1] * x * 10.0 + 3.0
    model = target_model(at, Evidence("profile", differences, (0.0,) * 16))
    assert model.rest == pytest.approx(np.full(9, 3.0), abs=1e-6)
    found = infer((Parameter("a", ("x",), 0.0, 1.0), Parameter("b", ("y",), 0.0, 1.0)), at,
                  [Evidence("profile", differences, (0.0,) * 16)])  # fmt: skip
    assert not found.met[0].is_met


def test_too_few_samples_are_refused():
    at = places(3)
    with pytest.raises(CalibrationError, match="3 finished samples for 2 parameters: 4 are needed"):
        infer((FRICTION, ROLLING), at, [Evidence("t", at[:, :1], (None,) * 3)])


def test_the_surrogate_follows_a_smooth_function_and_states_its_error():
    at, new = places(24), places(64, seed=9)
    surrogate = fit(at, torque(at), [0.0] * 24)
    mean, deviation = surrogate.at(new)
    errors = (mean - torque(new)) / np.maximum(deviation, 1e-12)
    assert np.sqrt(np.mean((mean - torque(new)) ** 2)) < 0.01 * np.ptp(torque(new))
    assert np.sqrt(np.mean(errors**2)) < 2.5
    # The closed form of leaving one out is that of fits without it.
    i = 5
    rest = np.delete(np.arange(24), i)
    value, left = _left_out(surrogate, at, torque(at), rest, i)
    assert surrogate.left_out()[i] == pytest.approx((torque(at)[i] - value) / left, rel=1e-3)


def _left_out(surrogate, at, values, rest, i):
    """Predict one run from the others by the same process, written out."""
    from millscale.calibration.surrogate import _kernel

    trend = surrogate._trend
    matrix = _kernel(at, at, surrogate.lengths, surrogate.size, trend)
    noise = np.diag(surrogate.noise**2)
    some = np.linalg.inv(matrix[np.ix_(rest, rest)] + noise[np.ix_(rest, rest)])
    mean = surrogate._mean
    value = mean + matrix[i, rest] @ some @ (values[rest] - mean)
    variance = matrix[i, i] + noise[i, i] - matrix[i, rest] @ some @ matrix[rest, i]
    return value, math.sqrt(variance)


def test_noise_that_runs_state_is_not_taken_for_the_function():
    generator = np.random.default_rng(2)
    at = places(32, 1)
    values = at[:, 0] + 0.1 * generator.normal(size=32)
    mean, deviation = fit(at, values, [0.1] * 32).at(np.array([[0.5]]))
    assert mean[0] == pytest.approx(0.5, abs=0.06)
    assert 0.01 < deviation[0] < 0.06


def test_further_runs_are_where_the_surrogate_is_least_certain():
    at = places(12)
    found = infer((FRICTION, ROLLING), at, evidence(at, MODELS, TRUTH, (0.02, 0.02)))
    chosen = next_places(found, 4)
    assert chosen[0] == pytest.approx(found.best)
    before = found.models[0].surrogates[0]
    after = before
    for place in chosen:
        after = after.with_place(place)
    assert after.at(found.particles)[1].max() < before.at(found.particles)[1].max()
    assert apart(found, at, chosen) > 0.19


def apart(found, at, chosen):
    """The smallest distance of new places from one another and from earlier ones, in deviations."""
    every = np.vstack([at, chosen]) / found.particles.std(axis=0)
    gaps = np.linalg.norm(every[len(at) :, None] - every, axis=2)
    gaps[np.arange(len(chosen)), len(at) + np.arange(len(chosen))] = np.inf
    return gaps.min()


def test_a_place_is_not_run_twice_where_nothing_is_uncertain():
    """Linear targets: after the first samples all particles are equally certain."""
    at = places(12)
    made = [
        Evidence("left", ((at[:, 0] - 0.4) / 0.03)[:, None], (0.0,) * 12),
        Evidence("right", ((at[:, 1] - 0.7) / 0.05)[:, None], (0.0,) * 12),
    ]
    found = infer((Parameter("a", ("x",), 0.0, 1.0), Parameter("b", ("y",), 0.0, 1.0)), at, made)
    assert apart(found, at, next_places(found, 6)) > 0.19


def test_particles_have_the_moments_of_a_density_on_the_faces_of_the_cube():
    """exp(-8 x) over [0, 1] in closed form, and an even density beside it."""
    found = particles_of(lambda x: -8.0 * x[:, 0], 2, seed=3)
    mean = 1.0 / 8.0 - math.exp(-8.0) / (1.0 - math.exp(-8.0))
    assert found[:, 0].mean() == pytest.approx(mean, abs=0.01)
    assert found[:, 0].std() == pytest.approx(0.122, abs=0.008)
    assert found[:, 1].mean() == pytest.approx(0.5, abs=0.025)
    assert found[:, 1].std() == pytest.approx(1.0 / math.sqrt(12.0), abs=0.012)
    assert found.min() >= 0.0 and found.max() <= 1.0
