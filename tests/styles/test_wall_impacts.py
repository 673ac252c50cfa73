"""Impacts on the wall, mesh and analytic: energy, restitution, moduli. Faults other engines had."""

import mill_core
import numpy as np
import pytest
from numpy.testing import assert_allclose

from wall_bench import (
    DENSITY,
    WALLS,
    Balls,
    Materials,
    Mill,
    columns,
    flats,
    fly,
    kinetic_energy,
    over_flat,
)

FLATS = 12
LINER, CHORD_ERROR = flats(FLATS)
SPEED, RADIUS = 3.9, 0.02
INCIDENCE = np.radians([*range(5, 90, 5), 76])  # at 76 degrees another engine gained energy
KINDS = [(0.2, 0.092), (0.2, 0.5), (0.98, 0.092), (0.98, 0.5)]  # restitution, friction
FINE, COARSE = 1e-5, 1e-4  # steps: a five-hundredth of an impact, and those of a campaign [s]


def _thrown(wall, incidence, kind, speed=SPEED, inclined=0.0):
    """Balls half a millimetre before the wall, thrown on the flats' middles (or the arc there) at
    incidences from the normal [rad]. `inclined` turns the plane of incidence towards the axis
    [rad]."""
    n = len(incidence)
    middle, inward, along = over_flat(LINER, CHORD_ERROR, np.arange(n) % FLATS)
    middle[:, 1] = 0.05 + 0.1 * (np.arange(n) // FLATS % 7)
    aside = np.cos(inclined) * along + np.sin(inclined) * np.array([0.0, 1.0, 0.0])
    velocity = speed * (np.sin(incidence)[:, None] * aside - np.cos(incidence)[:, None] * inward)
    from_flat = RADIUS + 5e-4 - (CHORD_ERROR if wall == "arc" else 0.0)
    position = middle + from_flat * inward
    return Balls.of(position, velocity, radius=RADIUS, kind=kind), inward


def _mill(wall):
    return Mill(wall, LINER, CHORD_ERROR, length=0.7)


def _all_incidences(wall):
    incidence = np.tile(INCIDENCE, len(KINDS))
    kind = np.repeat(np.arange(len(KINDS)), len(INCIDENCE))
    restitution, friction = map(list, zip(*KINDS, strict=True))
    balls, inward = _thrown(wall, incidence, kind, inclined=0.6)
    return balls, inward, Materials(restitution, friction)


@pytest.fixture(scope="module")
def after(tmp_path_factory):
    """State of all balls after their impacts, by wall and time step."""
    states = {}
    for wall in (*WALLS, "arc"):
        balls, _, materials = _all_incidences(wall)
        for dt in (FINE, COARSE):
            folder = tmp_path_factory.mktemp("impacts")
            steps = round(0.02 / dt)
            states[wall, dt] = fly(folder, _mill(wall), balls, materials, dt, steps)[-1]
    return states


@pytest.mark.parametrize("dt", [FINE, COARSE])
@pytest.mark.parametrize("wall", [*WALLS, "arc"])
def test_kinetic_energy_never_rises_at_any_incidence(after, wall, dt):
    balls, inward, _ = _all_incidences(wall)
    state = after[wall, dt]
    velocity, spin = columns(state, "vx vy vz"), columns(state, "omegax omegay omegaz")
    assert (np.sum(velocity * inward, axis=1) > 0.0).all()  # all have left
    assert np.abs(columns(state, "fx fy fz")).max() < 1e-9  # but for what weight there is
    before = kinetic_energy(balls, balls.velocity, balls.spin)
    ratio = kinetic_energy(balls, velocity, spin) / before
    assert ratio.max() < 1.0
    assert ratio.max() > 0.9  # grazing, nearly elastic: not all energy is lost by other means


@pytest.mark.parametrize("dt", [FINE, COARSE])
def test_an_impact_is_the_same_on_both_walls(after, dt):
    # Positions at rest are 1.5 m, so overlaps differ by 1e-16 m in 1e-3 m; an impact of hundreds of
    # steps amplifies that little, since it does not depend on where it begins.
    names = "x y z vx vy vz", "omegax omegay omegaz"
    for columns_of, scale in zip(names, (SPEED, SPEED / RADIUS), strict=True):
        mesh, analytic = (columns(after[wall, dt], columns_of) for wall in WALLS)
        assert_allclose(analytic, mesh, rtol=0.0, atol=1e-10 * scale)


RESTITUTION = np.arange(0.1, 1.01, 0.1)


def _restitution_error(restitution, radius, dt):
    """Bound of |realised - requested| restitution at a time step.

    Derived here. Forces use velocities half a step old: a linear spring with such a dashpot behaves
    as one with less mass, its damping ratio z grows by the factor 1 + c dt / 2, c = -ln(e) / t_c
    being its rate of decay, so e falls by e ln(e)^2 dt / (2 t_c (1 - z^2)). And contact begins up
    to a step late, x = v dt / (largest overlap) deep: the dashpot (force ~ x^(1/4) v) then misses
    up to x^(5/4) of its work on the way in, half of the -2 ln(e) it takes off ln(energy), and the
    spring x^(5/2) of the energy.
    """
    stiffness = 4.0 / 3.0 * 5.98e7 / (2.0 * (1.0 - 0.3**2)) * np.sqrt(radius)
    mass = 4.0 / 3.0 * np.pi * radius**3 * DENSITY
    overlap = (1.25 * mass * SPEED**2 / stiffness) ** 0.4  # Hertz, ball and wall of one material
    time = 2.94 * overlap / SPEED
    damping = np.array([mill_core.damping_ratio(e) for e in restitution])
    lag = restitution * np.log(restitution) ** 2 * dt / (2.0 * time * (1.0 - damping**2))
    late = (SPEED * dt / overlap) ** 1.25
    return lag - 0.5 * restitution * np.log(restitution) * late + 0.5 * restitution * late**2


def _realised_restitution(folder, wall, balls, inward, materials, dt):
    state = fly(folder, _mill(wall), balls, materials, dt, round(0.02 / dt))[-1]
    return np.sum(columns(state, "vx vy vz") * inward, axis=1) / SPEED


@pytest.mark.parametrize("dt", [2e-5, 5e-6])
@pytest.mark.parametrize("wall", [*WALLS, "arc"])
def test_restitution_is_as_requested(tmp_path, wall, dt):
    kind = np.arange(len(RESTITUTION))
    materials = Materials(RESTITUTION.tolist(), [0.5] * len(kind))
    balls, inward = _thrown(wall, 0.0 * RESTITUTION, kind)
    realised = _realised_restitution(tmp_path, wall, balls, inward, materials, dt)
    bound = _restitution_error(RESTITUTION, RADIUS, dt)
    assert (np.abs(realised - RESTITUTION) < bound).all()


@pytest.mark.parametrize("wall", [*WALLS, "arc"])
def test_each_ball_rebounds_with_its_own_radius_and_mass(tmp_path, wall):
    radius, dt = np.array([0.01, 0.02, 0.03, 0.05]), 5e-6
    same, inward = _thrown(wall, 0.0 * radius, 0)
    place = same.position + (radius - RADIUS)[:, None] * inward
    balls = Balls.of(place, same.velocity, radius=radius)
    realised = _realised_restitution(tmp_path, wall, balls, inward, Materials([0.3]), dt)
    restitution = np.full(len(radius), 0.3)
    assert (np.abs(realised - 0.3) < _restitution_error(restitution, radius, dt)).all()


@pytest.mark.parametrize("wall", [*WALLS, "arc"])
def test_force_is_hertz_with_both_moduli(tmp_path, wall):
    moduli, wall_modulus = [5.98e7, 1e7, 9e8], 3e8
    overlap = np.array([1e-5, 1e-4, 1e-3])
    kind, depth = (grid.ravel() for grid in np.meshgrid([0, 1, 2], overlap))
    radius = np.where(np.arange(len(kind)) % 2, 0.02, 0.03)
    balls, inward = _thrown(wall, np.zeros(len(kind)), kind)
    rest = balls.position + (radius - depth - RADIUS - 5e-4)[:, None] * inward
    materials = Materials([0.2] * 3, [0.5] * 3, 0.01, moduli, wall_modulus)
    resting = Balls.of(rest, radius=radius, kind=kind)
    force = columns(fly(tmp_path, _mill(wall), resting, materials, FINE, 0)[-1], "fx fy fz")
    effective = 1.0 / ((1.0 - 0.3**2) * (1.0 / np.array(moduli)[kind] + 1.0 / wall_modulus))
    hertz = 4.0 / 3.0 * effective * np.sqrt(radius) * depth**1.5
    # An overlap of 1e-5 m is a difference of coordinates of 1.5 m, rounded to 2e-16 m.
    assert_allclose(force, hertz[:, None] * inward, rtol=1e-9, atol=1e-9 * hertz.min())
