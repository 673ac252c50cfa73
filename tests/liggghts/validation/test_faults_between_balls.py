"""Faults other engines had, between two balls; those with walls are in tests/styles."""

import numpy as np
import pytest

from contact_paths import CONTACT_PATHS, available_paths
from impacts import Impact, Material, force_at_rest, in_engine

pytestmark = pytest.mark.engine
INCIDENCE = np.radians([*range(5, 90, 5), 76])
PAPER = Material(5.98e7, 0.3, 2678.0)


def _needs(path):
    if path not in available_paths():
        pytest.skip(f"this machine cannot run {path}")


@pytest.mark.parametrize("share", [500.0, 15.0])
@pytest.mark.parametrize("path", CONTACT_PATHS)
def test_kinetic_energy_of_two_balls_never_rises(tmp_path, contact_row, path, share):
    _needs(path)
    for restitution in (0.2, 0.98):
        impact = Impact.of(
            PAPER, 0.02, restitution, 0.5, 3.9 * np.cos(INCIDENCE), 3.9 * np.sin(INCIDENCE),
            other=Material(5.98e7, 0.3, 8000.0), other_radius=0.03,
        )  # fmt: skip
        dt = impact.duration / share
        got = in_engine(tmp_path / f"{restitution}", impact, path, "none", dt)[-1]
        other_mass = 4.0 / 3.0 * np.pi * 0.03**3 * 8000.0
        after = sum(
            0.5 * mass * (r.away**2 + r.along**2 + 0.4 * (radius * r.spin) ** 2)
            for r, mass, radius in ((got, impact.mass, 0.02), (got.other, other_mass, 0.03))
        )
        ratio = after / (0.5 * impact.mass * 3.9**2)
        assert (got.force == 0.0).all()  # they have parted
        assert ratio.max() > 0.8  # grazing: not lost by other means
        contact_row(
            "fault: grazing impacts gain energy",
            path,
            "none",
            "kinetic energy after / before, above 1",
            dt=dt,
            expected=0.0,
            got=np.maximum(ratio - 1.0, 0.0),
            tolerance=1e-14,
            reason="rounding",
            at=[f"{angle:.0f} deg" for angle in np.degrees(INCIDENCE)],
        )


@pytest.mark.parametrize("path", CONTACT_PATHS)
def test_the_force_of_two_balls_is_hertz_with_both_moduli_and_radii(tmp_path, contact_row, path):
    _needs(path)
    forces, hertz = [], []
    for other in (PAPER, Material(1e7, 0.2, 2678.0), Material(9e8, 0.4, 2678.0)):
        for depth in (1e-5, 1e-3):
            impact = Impact.of(PAPER, 0.02, 0.2, 0.5, 1.0, other=other, other_radius=0.03)
            folder = tmp_path / f"{other.youngs_modulus:g} {depth:g}"
            forces.append(force_at_rest(folder, impact, path, depth)[0])
            young = 1.0 / (0.91 / 5.98e7 + (1.0 - other.poisson_ratio**2) / other.youngs_modulus)
            hertz.append(4.0 / 3.0 * young * np.sqrt(0.02 * 0.03 / 0.05) * depth**1.5)
    contact_row(
        "fault: moduli of two balls are not mixed",
        path,
        "none",
        "normal force / Hertz",
        expected=1.0,
        got=np.array(forces) / hertz,
        tolerance=1.2e-6 if "mixed" in path else 1e-9,
        reason="some twenty roundings of 6e-8 of single precision"
        if "mixed" in path
        else "an overlap of 1e-5 m is a difference of coordinates of 0.1 m",
    )
