"""Twin theorem: scheme A with modulus E and scheme B with E/S move alike in scaled time."""

import math

import numpy as np
import pytest

from scene import SLICE, loose_bed, mill_deck, read_dump, run

S = 2.6
RADIUS = 3.9 / S
DUMP = (
    "dump end all custom 1000 end.dump id x y z\n"
    'dump_modify end format "%d %.17g %.17g %.17g"\nrun 1000\n'
)


def _positions_after_1000_steps(folder, balls, scheme, youngs_modulus, dt, wall="analytic"):
    folder.mkdir()
    deck = mill_deck(folder, balls, S, scheme, youngs_modulus=youngs_modulus, dt=dt, wall=wall)
    result = run(folder, deck + DUMP)
    assert result.code == 0, result.text[-2000:]
    dump = read_dump(folder / "end.dump")
    return np.column_stack([dump["x"], dump["y"], dump["z"]])


@pytest.mark.parametrize("wall", ["analytic", "mesh"])
@pytest.mark.parametrize("count", [1, 100])
def test_both_schemes_agree_in_scaled_time(tmp_path, count, wall):
    balls = loose_bed(RADIUS, count, SLICE, seed=3)
    if count == 1:
        balls = np.array([[0.01, 0.1, -(RADIUS - 0.02) + 1e-4]])  # touches within the 1,000 steps
    E, dt = 5.98e7, 5e-5
    gravity = _positions_after_1000_steps(tmp_path / "a", balls, "constant-gravity", E, dt, wall)
    speed = _positions_after_1000_steps(
        tmp_path / "b", balls, "constant-speed", E / S, math.sqrt(S) * dt, wall
    )
    # Round-off alone parts the two: 1e-16 a step and contact, grown by colliding balls.
    assert np.abs(gravity - speed).max() < 1e-9 * RADIUS
    assert np.abs(gravity - balls).max() > 1e-3 * RADIUS  # the balls have moved


def test_without_matching_the_modulus_they_part(tmp_path):
    balls = loose_bed(RADIUS, 100, SLICE, seed=3)
    E, dt = 5.98e7, 5e-5
    gravity = _positions_after_1000_steps(tmp_path / "a", balls, "constant-gravity", E, dt)
    speed = _positions_after_1000_steps(
        tmp_path / "b", balls, "constant-speed", E, math.sqrt(S) * dt
    )
    assert np.abs(gravity - speed).max() > 1e-6 * RADIUS, np.abs(gravity - speed).max()
