"""Swing of a charge after the start, and how long its fluctuations last."""

import math

import numpy as np
import pytest

from millscale.analysis.finished_campaign import load_campaign
from millscale.validate.averaging import (
    Swing,
    correlation_angle,
    cost_of,
    fit_swing,
    pendulum_frequency,
)

SWING = Swing(mean=-0.37, amplitude=1.5, decay=1.3, period=3.6)
STEP = 2.0 * math.pi / 25.0


def swinging(angle, phase=2.0):
    g, w = 1.0 / SWING.decay, 2.0 * math.pi / SWING.period
    return SWING.mean * (1.0 + SWING.amplitude * np.exp(-g * angle) * np.cos(w * angle + phase))


def test_a_damped_pendulum_is_found_again():
    angle = np.arange(1.3, 9.0, STEP)
    found = fit_swing(angle, swinging(angle))
    assert found.mean == pytest.approx(SWING.mean, rel=1e-6)
    assert found.amplitude == pytest.approx(SWING.amplitude, rel=1e-6)
    assert found.decay == pytest.approx(SWING.decay, rel=1e-6)
    assert found.period == pytest.approx(SWING.period, rel=1e-6)


def test_after_the_angle_the_swing_is_within_the_error():
    fine = np.linspace(0.0, 20.0, 20_001)
    off = np.abs(swinging(fine) / SWING.mean - 1.0)
    assert off[fine > SWING.angle_to(0.01)].max() <= 0.01
    assert off[fine > SWING.angle_to(0.01) - SWING.period].max() > 0.01
    assert SWING.angle_to(0.003, 0.003 * math.e) == pytest.approx(SWING.decay)


def test_the_correlation_angle_is_twice_the_integral_of_the_autocorrelation():
    fine = np.linspace(0.0, 60.0, 600_001)
    integral = np.trapezoid(SWING.autocorrelation(fine), fine)
    assert SWING.correlation_angle == pytest.approx(2.0 * integral, rel=1e-6)


def test_a_pendulum_with_kicks_has_the_autocorrelation_of_its_swing():
    """The pendulum integrated step by step, kicked at random."""
    g, w = 1.0 / SWING.decay, 2.0 * math.pi / SWING.period
    generator, dt = np.random.default_rng(5), 0.02
    kicks = generator.normal(size=100_000)
    x, v, found = 0.0, 0.0, np.empty(kicks.size)
    for i, kick in enumerate(kicks):
        v += dt * (-(w * w + g * g) * x - 2.0 * g * v) + kick
        x += dt * v
        found[i] = x
    lags = np.array([20, 60, 100, 150])
    correlation = [float(found[:-k] @ found[k:] / (found @ found)) for k in lags]
    assert correlation == pytest.approx(SWING.autocorrelation(dt * lags), abs=0.08)
    assert correlation_angle(found, dt) == pytest.approx(SWING.correlation_angle, rel=0.15)


@pytest.mark.parametrize("r", [0.0, 0.5, 0.8])
def test_correlation_angle_of_a_chain_is_that_of_its_closed_form(r):
    generator = np.random.default_rng(2)
    values = np.empty(100_000)
    values[0] = 0.0
    for i, kick in enumerate(generator.normal(size=values.size - 1)):
        values[i + 1] = r * values[i] + kick
    assert correlation_angle(values, STEP) == pytest.approx(STEP * (1.0 + r) / (1.0 - r), rel=0.1)


def test_one_run_and_one_seed_cost_the_same_and_longer_runs_waste_less():
    rows = cost_of(spin_up=8.0, angle=0.8, deviation=0.01, seed_angle=12.0)["rows"]
    assert rows[0]["one_run"] == rows[0]["by_seeds"] == pytest.approx(0.01 * math.sqrt(0.8 / 4.0))
    assert rows[2]["seeds"] == 3
    assert rows[2]["one_run"] == pytest.approx(0.01 * math.sqrt(0.8 / 28.0))
    assert rows[2]["by_seeds"] == pytest.approx(0.01 * math.sqrt(0.8 / 12.0))


def test_a_rigid_charge_has_the_frequency_of_a_compound_pendulum(throws):
    charge = load_campaign(throws).charges[0]
    found = pendulum_frequency(charge)
    # A half-disc below the axis has l = 4 R / 3 pi and I = M R^2 / 2; this bed is some less.
    mill = charge.case.mill
    radius = mill.radius_m - charge.case.ball.radius_m
    half = math.sqrt(2.0 * mill.gravity_m_s2 * 4.0 / 3.0 / math.pi / radius) / mill.omega_rad_s
    assert found == pytest.approx(half, rel=0.1)
