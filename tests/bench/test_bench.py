"""Bench: the state every engine starts from, the decks, and the evaluation of the times."""

import json
import re
import shutil
from dataclasses import replace

import numpy as np
import pytest

from millscale.bench.charge_means import SLICES, WALLS, edited
from millscale.bench.command import bench, campaign_over_bare
from millscale.bench.engines import (
    ANALYTIC_WALL_ONLY,
    BARE,
    BARE_MIXED,
    CAMPAIGN,
    CAMPAIGN_MIXED,
    CONTACTS,
    LAMMPS,
    LIGGGHTS,
    MILLSCALE,
    YADE,
    Phases,
    time_run,
)
from millscale.bench.rounds import Plan, ratio_of_medians, rows
from millscale.bench.scenes import MILLS, SCENES, SIZES
from millscale.bench.size_figure import draw_sizes
from millscale.bench.state import State, read_data, write_data
from millscale.campaign.build import load_campaign
from millscale.cases.case import cases_of
from millscale.errors import CampaignError
from millscale.mesh import build_liner_mesh, write_stl
from millscale.runs.dumps import read_dump
from millscale.runs.liner import liner_of

COLUMNS = "id type x y z vx vy vz omegax omegay omegaz radius density"


def write_dump(path, balls):
    lines = ["ITEM: TIMESTEP", "0", "ITEM: NUMBER OF ATOMS", str(len(balls))]
    lines += ["ITEM: BOX BOUNDS ff pp ff", "-2 2", "0 1", "-2 2", f"ITEM: ATOMS {COLUMNS}"]
    lines += [" ".join(repr(float(x)) if k > 1 else str(int(x)) for k, x in enumerate(ball))
              for ball in balls]  # fmt: skip
    path.write_text("\n".join(lines) + "\n")


def some_balls():
    """Return two layers of balls above the bottom of the mill at S = 2.6, in random order."""
    rng = np.random.default_rng(5)
    places = [(0.045 * i, 0.045 * k + 0.02, -1.30 + 0.05 * j)
              for i in range(-3, 4) for k in range(4) for j in range(2)]  # fmt: skip
    rows = [(n + 1, 1, *place, *rng.normal(size=6), 0.02, 2678.0) for n, place in enumerate(places)]
    rng.shuffle(rows)
    return [tuple(row) for row in rows]


def test_the_data_file_has_every_number_of_the_dump(tmp_path):
    balls = some_balls()
    write_dump(tmp_path / "state.dump", balls)
    count = write_data(tmp_path / "state.dump", (1.54, 0.385), tmp_path / "state.data")
    assert count == len(balls)
    text = (tmp_path / "state.data").read_text()
    atoms, velocities = text.split("Atoms\n\n")[1].split("Velocities\n\n")
    atoms = np.loadtxt(atoms.splitlines())
    velocities = np.loadtxt(velocities.splitlines())
    dump = read_dump(tmp_path / "state.dump")
    expected = np.column_stack(
        [dump["id"], dump["type"], 2 * dump["radius"], dump["density"], dump.positions]
    )
    assert np.array_equal(atoms, expected)
    motion = ["id", "vx", "vy", "vz", "omegax", "omegay", "omegaz"]
    assert np.array_equal(velocities, np.column_stack([dump[name] for name in motion]))
    assert "-1.54 1.54 xlo xhi\n0.0 0.385 ylo yhi" in text


def test_the_ratio_is_the_median_of_the_rounds():
    # The second round was disturbed: both engines took three times as long.
    assert ratio_of_medians([10.0, 30.0, 11.0], [2.0, 6.0, 2.0]) == 5.0
    with pytest.raises(ValueError):
        ratio_of_medians([1.0], [1.0, 2.0])


def test_rows_compare_with_stock_liggghts(tmp_path):
    state = State({}, tmp_path, tmp_path, 0.0, 13370)
    fast, slow = Phases(100.0, 60.0, 20.0, 5.0, 15.0), Phases(400.0, 250.0, 60.0, 10.0, 80.0)
    ours, stock = rows(
        "s2.6", (MILLSCALE, LIGGGHTS), state, Plan(1, 0, 100, 3), [[fast] * 3, [slow] * 3]
    )
    assert ours["ratio_to_liggghts"] == 4.0
    assert stock["ratio_to_liggghts"] == 1.0
    assert ours["ns_per_particle_step_core"] == {"median": 100.0, "min": 100.0, "max": 100.0}
    assert ours["split_ns"] == {"pair": 60.0, "neigh": 20.0, "comm": 5.0, "other": 15.0}
    assert fast.outside_pair_and_neigh == 20.0
    json.dumps([ours, stock], allow_nan=False)


def test_an_unknown_scene_is_an_error_that_names_the_known_ones(tmp_path):
    with pytest.raises(
        CampaignError, match=r"s3.*s2\.6, s1, drum, mixture, wall, slices, size, campaign"
    ):
        bench("s3", True, tmp_path / "runs", None)
    assert not (tmp_path / "runs").exists()


def test_the_scenes_are_mills_of_the_campaign():
    ids = {case.id for case in cases_of(load_campaign(MILLS))}
    assert {scene.case for scene in SCENES.values() if scene.campaign == MILLS} < ids
    assert {scene.case for scene in SIZES} == ids
    for scene in SCENES.values():
        assert scene.case in {case.id for case in cases_of(load_campaign(scene.campaign))}


def test_cost_against_size_is_drawn_with_a_line_for_each_engine_and_rank(tmp_path):
    plan = [
        (State({}, tmp_path, tmp_path, 0.0, n), Plan(r, 0, 9, 1)) for n in (9, 99) for r in (1, 2)
    ]
    phases = [[Phases(100.0, 60.0, 20.0, 5.0, 15.0)]] * 2
    table = [
        row for state, p in plan for row in rows("size", (MILLSCALE, LIGGGHTS), state, p, phases)
    ]
    figure = draw_sizes(table, tmp_path / "size.png")
    labels = {text.get_text() for text in figure.legends[0].get_texts()}
    assert labels == {
        f"{name}, {ranks}"
        for name in ("millscale", "stock LIGGGHTS")
        for ranks in ("1 rank", "2 ranks")
    }
    assert (tmp_path / "size.png").stat().st_size > 10_000


def mixed_state(tmp_path):
    """Return a state of the mixture's drum: large balls, clear of the wall, hit small ones."""
    case = next(iter(cases_of(load_campaign(SCENES["mixture"].campaign))))
    small, large = (one.radius_m for one in case.ball.classes)
    bottom = -case.mill.radius_m
    rows = [(0.0, y, bottom + 1.3 * large, large, 2, 0.5) for y in (0.06, 0.18)]
    rows += [(0.0125 * i, 0.012 * k + 0.006, bottom + 0.1455 + 0.0125 * j, small, 1, 0.0)
             for i in range(-4, 5) for k in range(20) for j in range(3)]  # fmt: skip
    spins = np.random.default_rng(2).normal(size=(len(rows), 3))
    balls = [
        (n, kind, x, y, z, 0.0, 0.0, up, *spin, radius, 2678.0)
        for n, ((x, y, z, radius, kind, up), spin) in enumerate(zip(rows, spins, strict=True), 1)
    ]
    write_dump(tmp_path / "state.dump", balls)
    box = (case.domain.half_box_m, case.mill.simulated_length_m)
    count = write_data(tmp_path / "state.dump", box, tmp_path / "state.data", 3)
    surface = build_liner_mesh(liner_of(case.mill), box[1], case.wall.chord_error_m, 1)
    write_stl(tmp_path / "liner.stl", surface)
    return State(case, tmp_path / "state.data", tmp_path / "liner.stl", 0.0, count)


@pytest.mark.engine
def test_the_engines_move_a_mixture_alike(tmp_path):
    state, energies = mixed_state(tmp_path), []
    for variant in (MILLSCALE, LIGGGHTS):
        folder = tmp_path / variant.engine
        assert time_run(variant, state, 1, 100, 200, folder).total > 0.0
        log = (folder / "log.bench").read_text()
        energies.append(float(re.findall(rf"^ *300 +{state.balls} +(\S+)", log, re.M)[-1]))
        # A skin of 20 or 15 mm of balls of 20 mm, for 6 mm.
        assert f"neighbor        {0.3 * variant.skin:g} bin" in log
    # Both classes have collided, none with the wall: rounding, printed with eight digits.
    assert energies[0] == pytest.approx(energies[1], rel=1e-6)


def moving_state(tmp_path):
    """Return a state of a few balls in the mill at S = 2.6, with the files that it needs."""
    case = next(c for c in cases_of(load_campaign(MILLS)) if c.S == 2.6)
    write_dump(tmp_path / "state.dump", some_balls())
    box = (case.domain.half_box_m, case.mill.simulated_length_m)
    count = write_data(tmp_path / "state.dump", box, tmp_path / "state.data")
    surface = build_liner_mesh(liner_of(case.mill), box[1], case.wall.chord_error_m, 1)
    write_stl(tmp_path / "liner.stl", surface)
    return State(case, tmp_path / "state.data", tmp_path / "liner.stl", 0.3, count)


@pytest.mark.engine
@pytest.mark.parametrize("variant", [MILLSCALE, ANALYTIC_WALL_ONLY, LIGGGHTS])
def test_every_engine_runs_the_state_and_its_time_adds_up(tmp_path, variant):
    state = moving_state(tmp_path)
    phases = time_run(variant, state, 1, 2, 50, tmp_path / "run")
    assert phases.total > 0.0
    parts = phases.pair + phases.neigh + phases.comm + phases.other
    assert parts == pytest.approx(phases.total, rel=0.02)


@pytest.mark.engine
@pytest.mark.parametrize("bare, campaign", [(BARE, CAMPAIGN), (BARE_MIXED, CAMPAIGN_MIXED)])
def test_a_campaign_s_step_measures_more_and_moves_the_balls_as_the_bare_step(
    tmp_path, bare, campaign
):
    state, energies = moving_state(tmp_path), []
    for variant in (bare, campaign):
        folder = tmp_path / variant.step
        assert time_run(variant, state, 1, 100, 200, folder).total > 0.0
        log = (folder / "log.bench").read_text()
        energies.append(re.findall(r"^ *300 +56 +(\S+) +(\S+)", log, re.M)[-1])
        measured = ("compute detach" in log, "fix guard" in log)
        assert measured == (variant == campaign,) * 2
        assert f"precision {CONTACTS[variant.pair].precision}" in log
    assert energies[0] == energies[1]
    assert not (tmp_path / "bare" / "series.csv").exists()
    series = (tmp_path / "campaign" / "series.csv").read_text().splitlines()
    assert len(series) == 1 + 300 // state.case.output.sample_steps
    assert (tmp_path / "campaign" / "occupancy.csv").stat().st_size > 1000


def test_the_step_of_a_campaign_is_compared_with_the_bare_step_of_its_round():
    bare, campaign = (
        [Phases(ns, *[None] * 4, loop) for ns in each]
        for each, loop in (
            ([10.0, 30.0, 20.0], "millscale's"),
            ([11.0, 36.0, 21.0], "the engine's"),
        )
    )
    found = campaign_over_bare(bare, campaign)
    assert found["ratio"] == pytest.approx(1.1)
    assert found["bare_time_loop"] == "millscale's"
    assert found["campaign_time_loop"] == "the engine's"


def test_the_loop_that_ran_is_read_from_the_log(tmp_path, monkeypatch):
    text = (
        "Time loop: millscale's\nLoop time of 1 on 1 procs for 5 steps with 56 atoms\n"
        "Time loop: the engine's, because of fix wall\n"
        "Loop time of 2 on 1 procs for 10 steps with 56 atoms\nPair  time (%) = 2 (100)\n"
    )
    monkeypatch.setattr("millscale.bench.engines.engine_output", lambda *_: text)
    phases = time_run(MILLSCALE, moving_state(tmp_path), 1, 5, 10, tmp_path / "run")
    assert phases.time_loop == "the engine's, because of fix wall"
    assert phases.total == pytest.approx(2e9 / 560)


@pytest.mark.parametrize("variants", [WALLS, SLICES])
def test_every_variant_is_a_campaign_of_its_own(tmp_path, variants):
    campaigns = {}
    for name, edits in variants.edits.items():
        path = tmp_path / "mills.toml"
        path.write_text(edited(edits))
        campaigns[name] = replace(load_campaign(path), file=None)
    assert variants.reference in campaigns
    assert len({repr(campaign) for campaign in campaigns.values()}) == len(campaigns)
    assert all(s.charge.seeds == (1, 2, 3) for c in campaigns.values() for s in c.parts)


def test_the_drum_is_one_mill_without_lifters_and_without_rolling_friction():
    case = next(iter(cases_of(load_campaign(SCENES["drum"].campaign))))
    assert case.id == SCENES["drum"].case
    assert case.mill.lifters == 0
    assert case.deck.rolling_model_pp == "off"


@pytest.mark.parametrize("variant", [LAMMPS, YADE], ids=["lammps", "yade"])
def test_other_engines_run_the_drum_and_report_their_time(tmp_path, variant):
    if not shutil.which({"lammps": "lmp", "yade": "yade"}[variant.engine]):
        pytest.skip(f"{variant.engine} is not installed: only the bench needs it")
    case = next(iter(cases_of(load_campaign(SCENES["drum"].campaign))))
    dump, data = tmp_path / "state.dump", tmp_path / "state.data"
    write_dump(dump, some_balls())
    box = (case.domain.half_box_m, case.mill.simulated_length_m)
    balls = write_data(dump, box, data)
    state = State(case, data, tmp_path / "none.stl", 0.3, balls)
    phases = time_run(variant, state, 1, 5, 20, tmp_path / "run")
    assert phases.total > 0.0
    if variant == LAMMPS:
        assert phases.pair + phases.neigh + phases.comm + phases.other == pytest.approx(
            phases.total
        )


def test_a_state_is_read_as_it_was_written(tmp_path):
    balls = some_balls()
    write_dump(tmp_path / "state.dump", balls)
    write_data(tmp_path / "state.dump", (1.6, 0.4), tmp_path / "state.data")
    read = read_data(tmp_path / "state.data")
    rows = np.array(sorted(balls))
    np.testing.assert_array_equal(read["place"], rows[:, 2:5])
    np.testing.assert_array_equal(read["velocity"], rows[:, 5:8])
    np.testing.assert_array_equal(read["spin"], rows[:, 8:11])
    np.testing.assert_array_equal(read["radius"], rows[:, 11])
