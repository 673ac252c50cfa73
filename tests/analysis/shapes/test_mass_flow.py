"""Mass-flow curves of known difference."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from millscale.analysis.shapes.mass_flow import MassFlow, compare_flow


def test_curve_agrees_with_itself_whatever_its_sampling():
    fine, coarse = np.linspace(0.0, 8.0, 801), np.linspace(0.0, 7.5, 376)
    rms, _, correlation = compare_flow(*(MassFlow(x, np.sin(x)) for x in (fine, coarse)))
    # Error of linear interpolation: (0.01)^2 / 8.
    assert rms < 1.3e-5
    assert_allclose(correlation, 1.0, atol=1e-8)


def test_rms_and_correlation_are_those_of_the_definition():
    angle = np.linspace(0.0, 2.0 * np.pi, 1001)
    mean, shift = 0.02, 0.3
    a, b = mean + 0.01 * np.sin(angle), mean + 0.01 * np.sin(angle - shift)
    rms, over_mean, correlation = compare_flow(MassFlow(angle, a), MassFlow(angle, b))
    # sin x - sin(x - s) = 2 sin(s/2) cos(x - s/2); its mean square over a period is 2 sin^2(s/2).
    assert_allclose(rms, 0.01 * np.sqrt(2.0) * np.sin(shift / 2.0), rtol=2e-3)
    assert_allclose(correlation, np.cos(shift), rtol=2e-3)
    assert_allclose(over_mean, rms / mean, rtol=1e-3)
    naive = np.sqrt(sum((p - q) ** 2 for p, q in zip(a, b, strict=True)) / angle.size)
    assert_allclose(rms, naive, rtol=1e-12)


def test_only_common_mill_angles_count():
    a, b = np.linspace(0.0, 4.0, 41), np.linspace(1.0, 8.0, 71)
    share = np.where(b > 4.0, 100.0, b)
    assert compare_flow(MassFlow(a, a), MassFlow(b, share))[0] < 1e-12


def test_a_constant_curve_has_no_correlation_and_too_short_ones_are_refused():
    angle = np.linspace(0.0, 1.0, 11)
    curve = MassFlow(angle, angle)
    assert compare_flow(curve, MassFlow(angle, 0.0 * angle))[2] is None
    with pytest.raises(ValueError, match="share 1 mill angles"):
        compare_flow(curve, MassFlow(angle + 1.0, angle))
