import math

import numpy as np
import pytest

from millscale.campaign.campaign import Ball
from millscale.packing.ball_sizes import draw_radii, mean_volume


def test_equal_balls_have_the_volume_of_one():
    assert mean_volume(Ball(0.02, 1.0, 0.0, 2.0)) == 4.0 / 3.0 * math.pi * 0.02**3


@pytest.mark.parametrize("truncation", [0.5, 2.0, 6.0])
def test_mean_volume_is_that_of_the_balls_drawn(truncation):
    ball = Ball(0.02, 1.0, 0.003, truncation)
    radii = draw_radii(ball, 200_000, np.random.default_rng(5))
    volumes = 4.0 / 3.0 * math.pi * radii**3
    error = volumes.std() / math.sqrt(len(volumes))
    assert mean_volume(ball) == pytest.approx(volumes.mean(), abs=4.0 * error)


def test_no_radius_lies_beyond_the_truncation():
    radii = draw_radii(Ball(0.02, 1.0, 0.003, 1.5), 10_000, np.random.default_rng(1))
    assert np.abs(radii - 0.02).max() <= 1.5 * 0.003
