"""Radial segregation of classes: mixed, core and shell in closed form."""

import numpy as np
import pytest

from millscale.analysis.shapes.segregation import segregation_indices


def test_a_core_and_a_shell_have_the_indices_of_their_rings():
    random = np.random.default_rng(1)
    angle = random.uniform(0.0, 2.0 * np.pi, 200)
    # Pairs of opposite places keep the centre of mass.
    angle = np.concatenate([angle, angle + np.pi])
    kinds = np.concatenate([np.zeros(200, int), np.ones(200, int)])
    radius = np.where(kinds == 0, 0.1, 0.3)
    angle = np.concatenate([angle[:100], angle[200:300], angle[100:200], angle[300:]])
    places = np.column_stack([radius * np.cos(angle) + 5.0, radius * np.sin(angle) - 2.0])
    mass = np.where(kinds == 0, 3.0, 1.0)
    core, shell = segregation_indices(places, mass, kinds, 2)
    mean = (3.0 * 0.1**2 + 0.3**2) / 4.0
    assert core == pytest.approx(1.0 - 0.1**2 / mean)
    assert shell == pytest.approx(1.0 - 0.3**2 / mean)


def test_classes_mixed_at_random_have_none():
    random = np.random.default_rng(2)
    places = random.normal(size=(20000, 2))
    kinds = random.integers(0, 3, 20000)
    found = segregation_indices(places, np.array([1.0, 4.0, 9.0])[kinds], kinds, 3)
    # The mean square of 6,700 normal numbers in two directions scatters by 1.2 %.
    assert np.abs(found).max() < 0.05
