"""A deck without terms that its scene does not need gives the results of a full deck."""

import numpy as np
import pytest

from millscale.campaign.keys import FORCIBLE
from millscale.cases.decks import copy_decks
from millscale.cases.parameters import write_parameters
from millscale.packing.charge import write_charge
from millscale.workflow.stage_work import write_mesh
from paper_campaign import cases
from scene import read_dump, run_file

pytestmark = pytest.mark.engine

SINGLE = {"rotation_angle_rad": 6.0, "step_s": 5e-5}
CHARGE = {
    "count": [3000],
    "slice_diameters": 2.5,
    "settle_s": 0.3,
    "rotation_angle_rad": 0.02,
    "dump_angle_rad": 0.02,
    "step_s": 1e-4,
}
NOTHING_FORCED: list[str] = []


def ran(folder, wall, study, force, **changes):
    """Return the folder in which the decks of a case ran.

    Args:
        study: {section: content}.
    """
    folder.mkdir()
    case = cases(
        folder,
        scaling__S=[2.6],
        scaling__schemes=["constant-gravity"],
        wall__kind=wall,
        model__force=force,
        **({"single_ball": None} | study),
        **changes,
    )[0]
    return run_decks(folder, case)


def run_decks(folder, case):
    """Return the folder, in which the decks of a case ran."""
    single, wall = case.kind == "single-ball", case.wall.kind
    decks = ("single_ball.in",) if single else ("settle.in", "mill.in")
    copy_decks(decks, folder)
    write_parameters(case, folder)
    (folder / "dump").mkdir()
    if wall == "mesh":
        write_mesh(case, folder)
    if not single:
        write_charge(case, folder)
    for deck in decks:
        done = run_file(folder, deck)
        assert done.code == 0, done.text[-2000:]
        (folder / f"out.{deck}").write_text(done.text)
    return folder


def series(folder):
    return (folder / "series.csv").read_text()


@pytest.mark.parametrize(("wall", "angle"), [("analytic", 6.0), ("mesh", 0.3)])
@pytest.mark.parametrize("force", [["pair"], ["dumps"]], ids=str)
def test_a_single_ball_moves_the_same_without_pair_style_and_dumps(tmp_path, wall, angle, force):
    study = {"single_ball": SINGLE | {"rotation_angle_rad": angle}}
    bare = ran(tmp_path / "bare", wall, study, NOTHING_FORCED)
    full = ran(tmp_path / "full", wall, study, force)
    assert not list((bare / "dump").iterdir())
    assert bool(list((full / "dump").iterdir())) == (force == ["dumps"])
    # The ball's motion depends on neither, so that the results are bit-identical.
    assert series(bare) == series(full)
    assert len(series(bare).splitlines()) > 30


def test_a_single_ball_alone_has_no_ghosts_and_no_pair_time(tmp_path):
    study = {"single_ball": SINGLE | {"rotation_angle_rad": 0.1}}
    bare = ran(tmp_path / "bare", "analytic", study, NOTHING_FORCED)
    text = (bare / "out.single_ball.in").read_text()
    assert "Nghost:    0 ave" in text
    assert "Pair  time (%) = 0 (0)" in text


@pytest.mark.parametrize("wall", ["analytic", "mesh"])
def test_a_plain_drum_runs_from_the_same_decks(tmp_path, wall):
    for name, study in {
        "single": {"single_ball": SINGLE | {"rotation_angle_rad": 0.1}},
        "charge": {"multi_ball": CHARGE | {"count": [500], "settle_s": 0.11}},
    }.items():
        folder = ran(tmp_path / name, wall, study, NOTHING_FORCED, liner=None)
        assert len(series(folder).splitlines()) > 1


@pytest.mark.parametrize("wall", ["analytic", "mesh"])
@pytest.mark.parametrize("term", ["rolling", "history"])
def test_a_charge_moves_the_same_without_friction_that_is_zero(tmp_path, wall, term):
    kind = {"rolling": "rolling", "history": "static"}[term]
    zero = {f"material__{kind}_friction_{pair}": 0.0 for pair in ("pp", "pw")}
    study = {"multi_ball": CHARGE}
    bare = ran(tmp_path / "bare", wall, study, NOTHING_FORCED, **zero)
    full = ran(tmp_path / "full", wall, study, [term], **zero)
    last = sorted((bare / "dump").iterdir())[-1].name
    one, other = (read_dump(folder / "dump" / last) for folder in (bare, full))
    assert len(one["id"]) == 780
    # The term adds exact zeros: equal to the last digit of the dumps, after many collisions.
    for name in ("x", "y", "z", "vx", "vy", "vz"):
        np.testing.assert_array_equal(one[name], other[name], err_msg=name)
    parameters = [(folder / "parameters.in").read_text() for folder in (bare, full)]
    assert parameters[0] != parameters[1]


@pytest.mark.parametrize("modulus", [2e6, 5.98e7, 2e9])
def test_soft_and_hard_balls_are_accepted(tmp_path, modulus):
    study = {"single_ball": SINGLE | {"rotation_angle_rad": 0.01, "step_s": 1e-5}}
    changes = {"material__shear_modulus_pa": None, "material__youngs_modulus_pa": modulus}
    for force in (NOTHING_FORCED, list(FORCIBLE)):
        folder = ran(tmp_path / str(len(force)), "analytic", study, force, **changes)
        assert len(series(folder).splitlines()) > 1
