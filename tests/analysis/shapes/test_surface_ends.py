"""Toe and shoulder where a known surface meets a circle."""

import numpy as np
import pytest

from millscale.analysis.shapes.contour import Contour, surface_contour
from millscale.analysis.shapes.shape import END_CIRCLE, end_circle
from millscale.analysis.shapes.solid_fraction import Grid
from millscale.analysis.shapes.surface_ends import surface_ends
from synthetic_case import case_document, typed
from synthetic_shapes import CIRCLE, packed_bed

GRID, RADIUS = Grid(0.02), 0.85
TILT = np.radians(35.0)  # the surface falls from the shoulder, at -x, to the toe


def flat(height, tilt=TILT, wave=0.0):
    """The surface -s sin + h cos of a bed below it, with a wave along it, from wall to wall."""
    along = np.linspace(-1.0, 1.0, 4001) * np.sqrt(1.0 - height**2)
    across = height + wave * np.sin(40.0 * along)
    c, s = np.cos(tilt), np.sin(tilt)
    line = np.column_stack([along * c + across * s, across * c - along * s])
    x, z = np.meshgrid(GRID.nodes, GRID.nodes)
    inside = (x * s + z * c < height) & (np.hypot(x, z) < 1.0)
    return Contour([line], 0.55, inside)


def expected(height, tilt=TILT):
    """The angles from the vertical of the ends of the chord of a circle, by hand."""
    half = np.arccos(height / RADIUS)
    # The chord's normal, away from the bed, lies at -tilt from the vertical.
    return -tilt + 2.0 * np.pi - half, -tilt + half


@pytest.mark.parametrize("height", [-0.5, -0.2, -0.01, 0.01, 0.3])
def test_ends_of_a_flat_surface_are_those_of_a_chord(height):
    found = surface_ends(flat(height), GRID, RADIUS)
    assert (found.toe, found.shoulder) == pytest.approx(expected(height), abs=1e-6)


def test_a_line_drawn_the_other_way_has_the_same_ends():
    bed = flat(-0.2)
    back = Contour([bed.lines[0][::-1]], bed.bulk_fraction, bed.inside)
    ends = [surface_ends(one, GRID, RADIUS) for one in (bed, back)]
    assert ends[0].toe == pytest.approx(ends[1].toe, abs=1e-12)
    assert ends[0].shoulder == pytest.approx(ends[1].shoulder, abs=1e-12)


def test_the_first_crossing_from_the_middle_counts_and_short_lines_do_not():
    bed = flat(-0.2)
    line = bed.lines[0]
    beyond = line[np.hypot(*line.T) > RADIUS + 0.02]
    hook = np.vstack([line, beyond[-1:] * 0.8])  # goes back inside the circle at the end
    found = surface_ends(Contour([line[:5], hook], 0.55, bed.inside), GRID, RADIUS)
    assert (found.toe, found.shoulder) == pytest.approx(expected(-0.2), abs=1e-6)


def test_a_surface_that_does_not_reach_the_circle_has_no_ends():
    bed = flat(-0.2)
    line = bed.lines[0]
    short = line[line[:, 0] > -0.2]
    for lines in ([], [short]):
        assert surface_ends(Contour(lines, 0.55, bed.inside), GRID, RADIUS) is None


def test_ends_of_a_bed_of_balls_are_within_a_third_of_a_ball_radius():
    a, height = 0.02, -0.2
    places, areas = packed_bed(a, 1.0, -TILT, height)
    found = surface_ends(surface_contour(places[:, [0, 2]], areas, CIRCLE, GRID), GRID, RADIUS)
    # Angle at which a surface moved by a third of a radius meets the circle.
    allowed = abs(np.arccos((height + a / 3.0) / RADIUS) - np.arccos(height / RADIUS))
    assert (found.toe, found.shoulder) == pytest.approx(expected(height), abs=allowed)


def test_the_circle_is_the_same_share_of_every_scaled_mill():
    for S in (1.0, 2.6):
        case = typed(case_document("multi-ball", "constant-gravity", "paper", S, 10))
        mill = case.physical
        assert end_circle(case) == pytest.approx(
            END_CIRCLE * mill.lifter_top_radius_m / (mill.radius_m - mill.ball_radius_m), rel=1e-12
        )
