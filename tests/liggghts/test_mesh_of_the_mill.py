"""Meshes that fix mill/similarity turns: they must be the scaled mill's, on its axis, with a
`curvature` below their ridges."""

import numpy as np
import pytest

from millscale import _core
from scene import HEAD, material, run, write_liner

DRUM = _core.Lifters(0.5, 0.45, 0.05, 0.09, 14)
WALL = (
    "fix wall all wall/gran model hertz tangential history rolling_friction cdt "
    "mesh n_meshes 1 meshes liner\n"
)
MILL = "fix mill all mill/similarity radius 0.5 gravity 9.81 omega 2.0 ball_radius 0.02 mesh liner"


def _deck(mesh, mill=MILL, box=0.6, ball="0 0.1 0"):
    return (
        HEAD
        + f"region box block -{box} {box} 0 0.2 -{box} {box} units box\ncreate_box 2 box\n"
        + material(0.02, 2e-5)
        + f"create_atoms 1 single {ball} units box\nset type 1 diameter 0.04 density 2678\n"
        + f"fix liner all mesh/surface file liner.stl type 2 {mesh}\n"
        + WALL
        + mill
        + "\nfix integrate all nve/sphere\nrun 1\n"
    )


@pytest.fixture
def curvature(tmp_path):
    return f"curvature {write_liner(tmp_path, DRUM, 0.2, 1e-3)!r}"


WRONG = {
    "diameter": ("", MILL.replace("radius 0.5", "radius 1.0"), 0.6, "radius",
                 "a factor of 0.5, accepted is 0.95 to 1.05; was a diameter given as radius? "
                 "Then give `radius 0.5`"),
    "mm": ("scale 1000", MILL, 600, "radius",
           "a factor of 1000, accepted is 0.95 to 1.05; is the mesh in mm? Then multiply "
           "`scale` of fix mesh/surface by 0.001"),
    "S": ("", MILL + " scale 2 scheme constant-gravity", 0.6, "radius",
          "a factor of 2, accepted is 0.95 to 1.05"),
    "origin": ("move 0.1 0 0.2", MILL, 0.9, "origin",
               "0.224 m off the axis, 0.447 of the scaled mill's radius (f_ID[14]), accepted is "
               "0.05; give `origin 0.1 0.1 0.2`"),
}  # fmt: skip


@pytest.mark.parametrize("ranks", [1, 2])
@pytest.mark.parametrize("kind", WRONG)
def test_a_mesh_of_another_mill_is_refused(tmp_path, curvature, kind, ranks):
    mesh, mill, box, key, cause = WRONG[kind]
    result = run(tmp_path, _deck(f"{mesh} {curvature}", mill, box), ranks)
    assert result.code != 0
    assert f"Fix mill/similarity (id mill): {key}: " in result.error
    assert cause in result.error
    assert "Setting up run" not in result.text


def test_a_radius_that_differs_by_less_than_panels_do_is_accepted(tmp_path, curvature):
    for radius, accepted in ((0.48, True), (0.52, True), (0.47, False), (0.53, False)):
        mill = MILL.replace("radius 0.5", f"radius {radius}")
        assert (run(tmp_path, _deck(curvature, mill)).code == 0) == accepted


@pytest.mark.parametrize("ranks", [1, 2])
def test_the_mesh_of_a_scaled_mill_is_compared_with_its_radius(tmp_path, curvature, ranks):
    mill = MILL.replace("radius 0.5", "radius 1.3") + " scale 2.6 scheme constant-gravity"
    result = run(tmp_path, _deck(curvature, mill), ranks)
    assert result.code == 0
    assert "WARNING: Fix mill/similarity" not in result.text


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_mesh_a_little_off_its_axis_is_warned_of(tmp_path, curvature, ranks):
    for off, warned in ((1e-4, False), (0.01, True)):
        result = run(tmp_path, _deck(f"move {off} 0 0 {curvature}"), ranks)
        assert result.code == 0
        assert ("origin: the centre of the meshes' area is 0.01 m off the axis, 0.02 of the scaled "
                "mill's radius (f_ID[14])" in result.text) == warned  # fmt: skip
        assert result.text.count("WARNING: Fix mill/similarity") == warned


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_hole_is_warned_of(tmp_path, curvature, ranks):
    path = tmp_path / "liner.stl"
    head, *triangles = path.read_text().split("facet normal")
    path.write_text("facet normal".join([head, *triangles[1:]]))
    result = run(tmp_path, _deck(curvature), ranks)
    assert result.code == 0
    assert "mesh: from the axis no wall is seen in " in result.text


def _section(folder, radii):
    """A wall of panels between these radii at equal angles, as liner.stl; folds in degrees, > 0
    where it bulges towards the axis."""
    angles = np.linspace(0, 2 * np.pi, len(radii), endpoint=False)
    x, z = radii * np.cos(angles), radii * np.sin(angles)
    lines = ["solid liner"]
    for low in (0.0, 0.05, 0.1, 0.15):
        for k in range(len(radii)):
            n = (k + 1) % len(radii)
            a, b = (x[k], low, z[k]), (x[n], low, z[n])
            c, d = (x[k], low + 0.05, z[k]), (x[n], low + 0.05, z[n])
            for triangle in ((a, b, c), (b, d, c)):
                lines += ["facet normal 0 0 0", "outer loop"]
                lines += [f"vertex {p[0]:.9g} {p[1]:.9g} {p[2]:.9g}" for p in triangle]
                lines += ["endloop", "endfacet"]
    (folder / "liner.stl").write_text("\n".join([*lines, "endsolid liner", ""]))
    edge = np.roll(x + 1j * z, -1) - (x + 1j * z)
    return np.degrees(-np.angle(edge / np.roll(edge, 1)))


@pytest.mark.parametrize("ranks", [1, 2])
def test_a_curvature_above_a_ridge_of_the_mesh_is_refused(tmp_path, ranks):
    angles = np.linspace(0, 2 * np.pi, 96, endpoint=False)
    folds = _section(tmp_path, 0.48 + 0.012 * np.cos(8 * angles))
    ridge = float(folds[folds > 0.1].min())
    valley = -folds[(folds < 0) & (-folds < ridge)].min()
    for curvature in (1.02 * ridge, 8.0, None):
        deck = _deck(f"curvature {curvature!r}" if curvature else "")
        result = run(tmp_path, deck, ranks)
        if curvature is None:
            assert result.code == 0
            continue
        assert result.code != 0
        assert (
            f"mesh 'liner': curvature: got {curvature:.3g} degrees, accepted is {valley:.3g} to "
            f"{ridge:.3g}, the largest valley and the smallest ridge" in result.error
        )
        advised = float(result.error.split("give `curvature ")[1].split("`")[0])
        assert valley < advised < ridge
        assert run(tmp_path, _deck(f"curvature {advised!r}"), ranks).code == 0


def test_over_a_ridge_that_counts_as_smooth_a_ball_falls_through(tmp_path):
    # Why such a curvature is refused: stock walls and stock contacts alone, a ball at rest.
    slope = np.radians(1.0)
    x, z = 0.1 * np.cos(slope), -0.1 * np.sin(slope)
    lines = ["solid roof"]
    for a, b in (((-x, z), (0.0, 0.0)), ((0.0, 0.0), (x, z))):
        corners = [(p[0], y, p[1]) for y in (0.0, 0.1) for p in (a, b)]
        for triangle in ((0, 1, 2), (1, 3, 2)):
            lines += ["facet normal 0 0 1", "outer loop"]
            lines += ["vertex {:.12g} {:.12g} {:.12g}".format(*corners[i]) for i in triangle]
            lines += ["endloop", "endfacet"]
    (tmp_path / "liner.stl").write_text("\n".join([*lines, "endsolid roof", ""]))
    gravity = "fix mill all gravity 9.81 vector 0 0 -1"
    depth = {}
    for curvature in (1.9, 2.1):  # the ridge folds by 2 degrees
        deck = _deck(f"curvature {curvature}", gravity, 0.2, "0 0.05 0.02")
        deck = deck.replace("run 1\n", 'run 2000\nprint "z $(z[1])"\n')
        deck = deck.replace("tangential history rolling_friction cdt", "tangential history")
        depth[curvature] = (0.02 - run(tmp_path, deck).printed("z")[0]) / 0.02
    assert abs(depth[1.9]) < 0.01
    # Half a g t^2 of the free fall in 0.04 s is 0.39 radii.
    assert depth[2.1] == pytest.approx(0.5 * 9.81 * 0.04**2 / 0.02, rel=1e-3)


@pytest.mark.parametrize("again", ["", "fix liner all mesh/surface file liner.stl type 2 {}\n"])
def test_a_mesh_that_is_removed_is_missed(tmp_path, curvature, again):
    deck = _deck(curvature).replace(WALL, "")
    result = run(tmp_path, deck + f"unfix liner\n{again.format(curvature)}run 1\n")
    assert result.code != 0
    assert "mesh 'liner' was removed or defined anew; define fix mill/similarity again" in (
        result.error
    )
