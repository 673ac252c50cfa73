"""Verdicts of hard cases, against their definitions."""

import numpy as np
import pytest

from millscale.validate.cases import CASES, IMPACT, REST, base_campaign, mill_of
from millscale.validate.deck import BACKENDS, SERIES, Ran, read_frames, run_case
from millscale.validate.scenes import balls_of
from millscale.validate.verdict import (
    INACCURATE,
    STABLE,
    UNSTABLE,
    Measured,
    energy_error,
    energy_put_in,
    measure,
    spin_noise,
    verdict,
)

BASE = base_campaign()
BY_NAME = {case.name: case for case in CASES}
MILL, BLOW, BED = BY_NAME["the mill itself"], BY_NAME["Fr 0.9"], BY_NAME["a bed at rest"]
FINE = Measured(1.0, 0.1, 0.0, 0, None)


@pytest.mark.parametrize(
    ("found", "error", "expected"),
    [
        (FINE, 0.14, STABLE),
        (FINE, 0.16, INACCURATE),
        (Measured(1.0, 0.31, 0.0, 0, None), 0.0, INACCURATE),
        (Measured(1.0, 0.1, 0.11, 0, None), 0.0, INACCURATE),
        (Measured(1.0, 0.1, 0.0, 1, None), 0.0, UNSTABLE),
        (Measured(1.0, 0.1, 0.0, 0, "ERROR: fix mill/guard: ..."), 0.0, UNSTABLE),
        (Measured(np.nan, 0.1, 0.0, 0, None), np.nan, UNSTABLE),
    ],
)
def test_a_verdict_is_the_worst_of_its_limits(found, error, expected):
    assert verdict(MILL, found, error) == expected


def test_a_blow_and_a_bed_have_limits_of_their_own():
    blow = next(case for case in CASES if case.kind == IMPACT)
    assert verdict(blow, FINE, 0.06) == INACCURATE
    assert verdict(BED, FINE, 2e-3) == INACCURATE
    assert energy_error(BED, Measured(2e-3, 0.1, 0.0, 0, None), np.nan) == 2e-3
    assert energy_error(MILL, Measured(1.1, 0.1, 0.0, 0, None), 1.0) == pytest.approx(0.1)
    assert energy_error(blow, Measured(0.3, 0.1, 0.0, 0, None), 0.2) == pytest.approx(0.1)


def test_spin_noise_is_what_flips_and_not_what_grows():
    mill = mill_of(MILL, BASE)
    steps = np.arange(12)[:, None, None]
    steady = np.ones((12, 5, 3)) * (3.0 + 2.0 * steps)
    flipping = steady + 0.7 * (-1.0) ** steps * np.array([1.0, 0.0, 0.0])
    scale = mill.radii[0] / np.sqrt(mill.gravity * mill.radii[0])
    assert spin_noise(steady, mill) == pytest.approx(0.0, abs=1e-12)
    assert spin_noise(flipping, mill) == pytest.approx(0.7 * scale, rel=1e-12)


def test_overlapping_balls_start_with_the_hertz_energy_of_every_pair():
    case = BY_NAME["balls that begin 0.1 radii deep"]
    mill = mill_of(case, BASE)
    balls = balls_of(case, mill, 1)
    # 4 x 4 x 2 in a grid; along the axis each ball is in contact with its neighbour on both sides.
    pairs = 2 * 4 * 3 * 2 + 16 * 2
    young, radius, depth = 0.5 * 5.98e7 / 0.91, 0.01, 0.002
    each = 8.0 / 15.0 * young * np.sqrt(radius) * depth**2.5
    assert energy_put_in(mill, balls) == pytest.approx(pairs * each, rel=1e-3)


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_every_case_begins_inside_its_liner_and_only_one_with_overlaps(case):
    mill = mill_of(case, BASE)
    balls = balls_of(case, mill, 1)
    section = np.ascontiguousarray(balls.position[:, [0, 2]])
    assert (mill.liner.nearest(section).distance >= balls.radius * (1.0 - 1e-9)).all()
    apart = np.full(len(balls.radius), np.inf)
    for seam in (-mill.length, 0.0, mill.length):
        gap = np.linalg.norm(
            balls.position[:, None] - balls.position[None] + np.array([0.0, seam, 0.0]), axis=2
        ) - (balls.radius[:, None] + balls.radius[None])
        if seam == 0.0:
            np.fill_diagonal(gap, np.inf)
        apart = np.minimum(apart, gap.min(axis=1))
    assert (apart.min() >= 0.0) == (case.scene != "overlapping")


def test_a_run_that_ended_early_has_no_energy():
    mill = mill_of(MILL, BASE)
    balls = balls_of(MILL, mill, 1)
    series = np.zeros((3, len(SERIES)))
    series[:, 1] = len(balls.radius)
    found = measure(MILL, mill, balls, Ran(series, np.empty((0, 0, 3)), "ERROR: why"))
    assert np.isnan(found.energy)
    assert found.stopped_by == "ERROR: why"
    assert found.lost == 0


@pytest.mark.engine
@pytest.mark.parametrize("backend", BACKENDS)
def test_a_step_far_too_long_is_stopped_by_the_guard_with_the_ball(tmp_path, backend):
    mill = mill_of(MILL, BASE)
    balls = balls_of(MILL, mill, 1)
    step = 0.6 * mill.rayleigh_time
    ran = run_case(tmp_path / backend, MILL, mill, balls, backend, step)
    assert "fix mill/guard: ball " in ran.stopped_by
    assert "; step " in ran.stopped_by
    found = measure(MILL, mill, balls, ran)
    assert verdict(MILL, found, np.nan) == UNSTABLE
    assert found.lost == 0


def test_every_kind_of_hard_case_is_present():
    assert {case.kind for case in CASES} == {"mill", IMPACT, REST}


def test_a_run_stopped_before_its_spins_were_written_has_none(tmp_path):
    (tmp_path / "spins.dump").write_text("")
    assert read_frames(tmp_path / "spins.dump")[..., 1:].size == 0
