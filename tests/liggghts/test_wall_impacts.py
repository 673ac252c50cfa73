"""Impacts on the wall, mesh and analytic: energy, restitution, moduli. Faults other engines had."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from contact_bounds import restitution_bound
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
def test_kinetic_energy_never_rises_at_any_incidence(after, contact_row, wall, dt):
    balls, inward, _ = _all_incidences(wall)
    state = after[wall, dt]
    velocity, spin = columns(state, "vx vy vz"), columns(state, "omegax omegay omegaz")
    assert (np.sum(velocity * inward, axis=1) > 0.0).all()  # all have left
    assert np.abs(columns(state, "fx fy fz")).max() < 1e-9  # but for what weight there is
    before = kinetic_energy(balls, balls.velocity, balls.spin)
    ratio = kinetic_energy(balls, velocity, spin) / before
    contact_row(
        "fault: grazing impacts gain energy",
        "-",
        wall,
        "kinetic energy after / before, above 1",
        dt=dt,
        expected=0.0,
        got=np.maximum(ratio - 1.0, 0.0),
        tolerance=1e-14,
        reason="rounding",
    )
    assert ratio.max() > 0.9  # grazing, nearly elastic: not all energy is lost by other means


@pytest.mark.parametrize("dt", [FINE, COARSE])
def test_an_impact_is_the_same_on_both_walls(after, contact_row, dt):
    # Positions at rest are 1.5 m, so overlaps differ by 1e-16 m in 1e-3 m; an impact of hundreds of
    # steps amplifies that little, since it does not depend on where it begins.
    names = "x y z vx vy vz", "omegax omegay omegaz"
    for columns_of, scale in zip(names, (SPEED, SPEED / RADIUS), strict=True):
        mesh, analytic = (columns(after[wall, dt], columns_of) for wall in WALLS)
        contact_row(
            "fault: mesh and analytic wall differ",
            "-",
            "mesh, analytic",
            f"difference of {columns_of} after an impact",
            dt=dt,
            expected=0.0,
            got=np.abs(analytic - mesh).max() / scale,
            tolerance=1e-10,
            reason="overlaps of 1e-3 m are known to 1e-16 m, which an impact of hundreds of steps "
            "amplifies little",
        )


RESTITUTION = np.arange(0.1, 1.01, 0.1)


def _restitution_error(restitution, radius, dt):
    """Bound of |realised - requested| restitution at a time step."""
    stiffness = 4.0 / 3.0 * 5.98e7 / (2.0 * (1.0 - 0.3**2)) * np.sqrt(radius)
    mass = 4.0 / 3.0 * np.pi * radius**3 * DENSITY
    overlap = (1.25 * mass * SPEED**2 / stiffness) ** 0.4  # Hertz, ball and wall of one material
    time = 2.94 * overlap / SPEED
    return restitution_bound(restitution, dt / time, SPEED * dt / overlap)


def _realised_restitution(folder, wall, balls, inward, materials, dt):
    state = fly(folder, _mill(wall), balls, materials, dt, round(0.02 / dt))[-1]
    return np.sum(columns(state, "vx vy vz") * inward, axis=1) / SPEED


@pytest.mark.parametrize("dt", [2e-5, 5e-6])
@pytest.mark.parametrize("wall", [*WALLS, "arc"])
def test_restitution_is_as_requested(tmp_path, contact_row, wall, dt):
    kind = np.arange(len(RESTITUTION))
    materials = Materials(RESTITUTION.tolist(), [0.5] * len(kind))
    balls, inward = _thrown(wall, 0.0 * RESTITUTION, kind)
    realised = _realised_restitution(tmp_path, wall, balls, inward, materials, dt)
    bound = _restitution_error(RESTITUTION, RADIUS, dt)
    contact_row(
        "fault: restitution is not as requested",
        "-",
        wall,
        "restitution",
        dt=dt,
        expected=RESTITUTION,
        got=realised,
        tolerance=bound,
        reason="dashpot half a step late, first contact up to a step deep",
        at=[f"e = {e:.1f}" for e in RESTITUTION],
    )


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
def test_force_is_hertz_with_both_moduli(tmp_path, contact_row, wall):
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
    contact_row(
        "fault: moduli of ball and wall are not mixed",
        "-",
        wall,
        "normal force / Hertz",
        expected=1.0,
        got=np.sum(force * inward, axis=1) / hertz,
        tolerance=2e-9,
        reason="an overlap of 1e-5 m is a difference of coordinates of 1.5 m, to which "
        "the triangles add roundings of their own",
    )
