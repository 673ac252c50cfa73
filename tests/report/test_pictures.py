"""Pictures of a charge."""

import shutil

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.image import imread
from matplotlib.path import Path as Polygon
from numpy.testing import assert_allclose

from millscale.analysis.shapes.cross_section import liner_outline, turned
from millscale.analysis.shapes.snapshots import (
    first_dump,
    mill_angle_at,
    snapshots_near,
    starts_on_rising_side,
)
from millscale.report.ball_classes import colours_of_classes
from millscale.report.charge_pictures import draw_pictures
from millscale.report.figures.ball_picture import (
    PIXELS,
    VIEW,
    WALL,
    WALL_THICKNESS,
    wall_picture,
)
from millscale.runs.case_folder import load_case
from millscale.runs.dumps import Dump
from millscale.runs.untrusted import RunFolderError


@pytest.fixture
def charge_folder(runs):
    return runs / "cases/mb-cg-paper-S2.600"


def balls(x, y, z, radius, ids=None, step=0) -> Dump:
    columns = {"x": x, "y": y, "z": z, "radius": radius, "id": ids or range(1, len(x) + 1)}
    return Dump(step, {name: np.array(values, float) for name, values in columns.items()})


def write_balls(folder, step, places, sizes, kinds=None):
    kinds = kinds or dict.fromkeys(places, 1)
    rows = [f"{i} {kinds[i]} {x} 0.1 {z} 0 0 0 {sizes[i]}" for i, (x, z) in places.items()]
    path = folder / f"dump/charge.{step:09d}.liggghts"
    path.write_text(
        f"ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n{len(rows)}\n"
        "ITEM: ATOMS id type x y z vx vy vz radius\n" + "\n".join(rows) + "\n"
    )


def test_turning_moves_the_bottom_towards_minus_x():
    bottom = np.array([[0.0, -1.0]])
    assert_allclose(turned(bottom, 0.1), [[-np.sin(0.1), -np.cos(0.1)]])
    assert_allclose(turned(turned(bottom, 0.7), -0.7), bottom, atol=1e-15)


def test_outline_has_the_liner_s_radii(charge_folder):
    case = load_case(charge_folder)
    distance = np.hypot(*liner_outline(case, 0.3).T)
    assert_allclose(distance.max(), case.mill.radius_m, rtol=1e-9)
    # The outline's corners are those of the flat lifter tops, half their width off the middle.
    corner = np.hypot(case.mill.lifter_top_radius_m, case.mill.lifter_top_width_m / 2)
    assert_allclose(distance.min(), corner, rtol=1e-9)


def test_nearest_dump_is_chosen_once(charge_folder):
    chosen = snapshots_near(charge_folder, [0.0, 0.1, 0.45, 5.0])
    assert_allclose([s.mill_angle for s in chosen], [0.0, 0.5, 1.0], atol=1e-3)


def test_dump_before_the_first_row_is_at_rest():
    series = {"step": np.array([7564.0, 7686.0]), "mill_angle_rad": np.array([0.0197, 0.0393])}
    angles = mill_angle_at(np.array([7000.0, 7442.0, 7625.0, 7808.0]), series)
    assert_allclose(angles, [0.0, 0.0197 - 0.0196, 0.0295, 0.0589], atol=1e-12)


def test_colours_follow_the_start_by_id():
    first = balls([-1.0, 1.0, -0.2], [0] * 3, [0] * 3, [0.1] * 3)
    later = balls([2.0, 2.0], [0] * 2, [0] * 2, [0.1] * 2, ids=[3, 2], step=9)
    assert starts_on_rising_side(later, first).tolist() == [True, False]


def test_ball_unknown_at_the_start_is_refused():
    first = balls([-1.0], [0], [0], [0.1])
    later = balls([2.0], [0], [0], [0.1], ids=[7], step=9)
    with pytest.raises(ValueError, match="ball 7 of step 9 is not in step 0"):
        starts_on_rising_side(later, first)


def test_picture_shows_balls_at_their_place_size_and_colour(charge_folder, tmp_path):
    """One red ball at the left, a larger blue one near the top, which started on the right."""
    folder = tmp_path / "case"
    shutil.copytree(charge_folder, folder, ignore=shutil.ignore_patterns("dump"))
    (folder / "dump").mkdir()
    size = {1: 0.1, 2: 0.2}
    write_balls(folder, 0, {1: (-0.1, 0.0), 2: (0.1, 0.9)}, size)
    write_balls(folder, 5000, {1: (-0.8, 0.0), 2: (-0.2, 0.9)}, size)
    ((picture, _),) = draw_pictures(folder, [1.0], tmp_path)
    image = 255.0 * imread(picture)[..., :3]
    scale = 0.5 * image.shape[0] / (VIEW * load_case(folder).mill.radius_m)
    pixels = np.indices(image.shape[:2]) + 0.5 - 0.5 * image.shape[0]
    x, z = pixels[1] / scale, -pixels[0] / scale
    for centre_x, centre_z, radius, channel in ((-0.8, 0.0, 0.1, 0), (-0.2, 0.9, 0.2, 2)):
        disc = np.hypot(x - centre_x, z - centre_z) < 1.3 * radius
        shown = disc & (image.sum(axis=2) < 600.0)
        area = shown.sum() / scale**2
        assert_allclose([x[shown].mean(), z[shown].mean()], [centre_x, centre_z], atol=0.005)
        assert_allclose(area, np.pi * radius**2, rtol=0.05)
        assert image[shown].mean(axis=0).argmax() == channel


def test_balls_of_several_classes_have_the_colours_of_their_classes(classes, tmp_path):
    source = classes / "cases/mb-cg-paper-S2.600"
    folder = shutil.copytree(source, tmp_path / "case", ignore=shutil.ignore_patterns("dump"))
    (folder / "dump").mkdir()
    places, sizes = {1: (-0.8, 0.0), 2: (0.0, 0.0), 3: (0.8, 0.0)}, {1: 0.1, 2: 0.04, 3: 0.06}
    kinds = {1: 1, 2: 2, 3: 3}
    for step in (0, 5000):
        write_balls(folder, step, places, sizes, kinds)
    ((picture, _),) = draw_pictures(folder, [1.0], tmp_path)
    image = imread(picture)[..., :3]
    case = load_case(folder)
    scale = 0.5 * image.shape[0] / (VIEW * case.mill.radius_m)
    colours = np.array([to_rgb(colour) for colour in colours_of_classes(case.ball)])
    for i, (x, z) in places.items():
        row, column = (round(0.5 * PIXELS + scale * v) for v in (-z, x))
        # Shading changes brightness more than hue: of the classes its own colour is nearest.
        apart = np.linalg.norm(colours - image[row, column], axis=1)
        assert apart.argmin() == i - 1


def test_the_wall_is_a_band_around_the_turned_liner(charge_folder):
    case = load_case(charge_folder)
    picture = wall_picture(case, 0.3)
    scale = 0.5 * PIXELS / (VIEW * case.mill.radius_m)
    pixels = np.indices(picture.shape[:2]) + 0.5 - 0.5 * PIXELS
    places = np.stack([pixels[1], -pixels[0]], axis=-1).reshape(-1, 2) / scale
    band = np.hypot(*places.T) < (1.0 + WALL_THICKNESS) * case.mill.radius_m
    band &= ~Polygon(liner_outline(case, 0.3)).contains_points(places)
    found = picture.reshape(-1, 3).sum(axis=1) < 0.5 * (765 + sum(WALL))
    # Only pixels on an edge may differ: the perimeter has about 5 PIXELS of them.
    assert np.sum(found != band) < 0.25 * 5 * PIXELS
    assert band.sum() > 10 * PIXELS


def test_a_ball_that_is_not_in_the_first_dump_is_named(charge_folder, tmp_path):
    folder = shutil.copytree(
        charge_folder, tmp_path / "case", ignore=shutil.ignore_patterns("dump")
    )
    (folder / "dump").mkdir()
    write_balls(folder, 0, {1: (0.0, 0.0)}, {1: 0.1})
    write_balls(folder, 5000, {7: (0.0, 0.0)}, {7: 0.1})
    with pytest.raises(RunFolderError, match="ball 7 of step 5000 is not in step 0"):
        draw_pictures(folder, [1.0], tmp_path)


def test_the_dump_nearest_to_an_angle_is_drawn(charge_folder, tmp_path):
    ((path, angle),) = draw_pictures(charge_folder, [0.6], tmp_path)
    assert_allclose(angle, 0.5, atol=1e-3)
    assert path.read_bytes().startswith(b"\x89PNG")
    assert list(tmp_path.iterdir()) == [path]
    assert first_dump(charge_folder).step == 0


def test_case_without_dumps_is_refused(folder, tmp_path):
    with pytest.raises(RunFolderError, match="no dumps"):
        draw_pictures(folder, [1.0], tmp_path)
