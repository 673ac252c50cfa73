"""A ball released in a smooth drum meets the wall where the parabola says, at any S, scheme."""

import math

import numpy as np
import pytest

from millscale import _core
from millscale.analysis.single_ball import flight
from scene import mill_deck, run

A = 0.02
LENGTH = 0.1
CHORD_ERROR = 2e-4
# The wall is met within a step (1 mm of path) and within the chord error (0.2 mm) of the closed
# form: 1e-3 of the mill's radius at S = 2.6, less elsewhere.
TOLERANCE = 1e-3


def _release(mill):
    """Where a ball on the drum detaches by Eq. 3 for its centre: angle, position, velocity."""
    path = mill.radius - A
    phi = math.acos(mill.omega**2 * path / mill.gravity)
    free = path - CHORD_ERROR  # not in contact: the release is prescribed
    position = np.array([-free * math.sin(phi), LENGTH / 2, free * math.cos(phi)])
    return phi, position, mill.omega * path * np.array([math.cos(phi), 0.0, math.sin(phi)])


@pytest.mark.parametrize("scheme", ["constant-gravity", "constant-speed"])
@pytest.mark.parametrize("S", [1.0, 1.3, 2.6])
def test_flight_follows_the_closed_forms(tmp_path, S, scheme):
    physical = _core.OperatingPoint(3.9, A, 9.81, 1.0)
    scaled = _core.scale(physical, S, scheme, "corrected")
    phi, position, velocity = _release(scaled.mill)
    speed = math.hypot(*velocity)
    expected_time = flight.flight_time(speed, phi, scaled.mill.gravity)
    dt = 1e-4 * scaled.base.time

    deck = mill_deck(
        tmp_path,
        position[None, :],
        S,
        scheme,
        dt=dt,
        lifters=0,
        chord_error=CHORD_ERROR,
        length=LENGTH,
    )
    deck = deck.replace("start now", "policy corrected start never")
    deck = deck.replace("neighbor 0.02 bin", "neighbor 0.3 bin")
    deck += (
        f"velocity all set {float(velocity[0])!r} 0.0 {float(velocity[2])!r}\n"
        'fix track all print 1 "$(step) $(x[1]) $(z[1]) $(vx[1]) $(vz[1]) $(c_detach[1][1])" '
        "file track.csv screen no\n"
        f"run {int(1.02 * expected_time / dt)}\n"
    )
    result = run(tmp_path, deck)
    assert result.code == 0, result.text[-2000:]
    step, x, z, vx, vz, state = np.loadtxt(tmp_path / "track.csv").T
    assert state[0] == 3
    hit = np.flatnonzero(state == 1)[0]
    before = hit - 1  # the contact itself slows the ball

    assert step[hit] * dt == pytest.approx(expected_time, rel=TOLERANCE)
    angle = math.atan2(x[hit], z[hit]) % (2 * math.pi)  # from the top, on the falling side
    assert angle == pytest.approx(flight.impact_angle(phi), rel=TOLERANCE)
    ratio = math.hypot(vx[before], vz[before]) / speed
    assert ratio == pytest.approx(flight.impact_speed_ratio(phi), rel=TOLERANCE)
    print(f"S {S} {scheme}: {angle / flight.impact_angle(phi) - 1:.1e} in angle")
