"""Published measurements beside runs: profiles, landings, and the page of the stored results."""

import json
import math

import numpy as np
import pytest

from in_process import millscale
from millscale.analysis.finished_campaign import load_campaign
from millscale.analysis.single_ball.flight import impact_speed_ratio, release_on_circle
from millscale.campaign.build import load_campaign as read_campaign
from millscale.cases.case import cases_of
from millscale.runs.dumps import Dump
from millscale.runs.untrusted import RunFolderError
from millscale.validate import experiments, experiments_page
from millscale.validate.experiments import (
    MEASURED,
    Profile,
    landing_on_liner,
    profile_of,
    read_profile,
)
from millscale.validate.experiments_page import write_experiments
from paper_campaign import REPOSITORY

RESULTS = REPOSITORY / "docs/results"
CAMPAIGNS = REPOSITORY / "campaigns/experiments"
FILE = REPOSITORY / MEASURED


@pytest.fixture(scope="module")
def stored():
    return json.loads((RESULTS / "experiments.json").read_text(encoding="utf-8"))


def test_the_measured_profile_is_that_of_the_source():
    measured = read_profile(FILE)
    assert len(measured.distance) == 36
    assert measured.zero() == pytest.approx(0.0594, abs=2e-4)
    deep = measured.distance < -0.09
    over_rigid = measured.velocity[deep] / (11.6 * math.pi / 30.0 * measured.distance[deep])
    assert measured.over_rigid(experiments.OMEGA) == pytest.approx(over_rigid.mean())
    assert ((over_rigid > 1.02) & (over_rigid < 1.17)).all()


def test_rms_and_change_of_sign_of_a_line():
    y = np.array([-0.09, -0.03, -0.05, -0.07])
    line = Profile(y, 10.0 * (y + 0.055))
    assert line.zero() == pytest.approx(0.055)
    assert line.rms_from(Profile(y, line.velocity + np.array([0.1, -0.1, 0.1, 0.1]))) == (
        pytest.approx(0.1)
    )
    deep = line.rms_from(Profile(y, line.velocity + np.array([0.1, 0.5, 0.5, 0.1])), 0.06)
    assert deep == pytest.approx(0.1)
    gap = Profile(y, np.array([np.nan, 0.5, np.nan, -0.5]))
    assert gap.zero() == pytest.approx(0.05)
    assert gap.rms_from(Profile(y, np.full(4, 0.5))) == pytest.approx(math.sqrt(0.5))
    assert Profile(y, np.full(4, 0.1)).zero() is None
    assert Profile(y, np.full(4, np.nan)).rms_from(line) is None


@pytest.mark.parametrize("S", [2.0, 4.0])
def test_a_drum_that_turns_rigidly_has_the_physical_velocities(S):
    case = next(x for x in cases_of(read_campaign(CAMPAIGNS / "drum-240-mm.toml")) if x.S == S)
    omega, reach = case.mill.omega_rad_s, case.mill.radius_m
    random = np.random.default_rng(3)
    x, z = random.uniform(-reach, reach, (2, 800_000))
    y = random.uniform(0.0, case.mill.simulated_length_m, x.size)
    moving = np.abs(y / case.mill.simulated_length_m - 0.5) < 0.31  # nothing moves at the ends
    dump = Dump(0, {"x": x, "y": y, "z": z, "vx": omega * z * moving, "vz": -omega * x * moving})
    distance = np.array([-0.1, -0.06, 0.05])
    counts, profile = profile_of([dump], case, distance)
    expected = 11.6 * math.pi / 30.0 * distance
    # Balls within 3 mm of a point, some hundreds.
    assert min(counts) > 100
    np.testing.assert_allclose(profile.velocity, expected, atol=1e-3)
    part = Dump(0, {name: column[:300] for name, column in dump.columns.items()})
    few, empty = profile_of([part], case, distance)
    assert max(few) < 30 and np.isnan(empty.velocity).all()


def test_a_ball_that_leaves_the_circle_lands_where_the_closed_forms_say():
    radius, phi, gravity = 2.47, 0.93, 9.81
    found = landing_on_liner(release_on_circle(radius, phi, gravity), radius)
    speed = math.sqrt(gravity * radius * math.cos(phi)) * impact_speed_ratio(phi)
    assert found.angle == pytest.approx(3.0 * phi)
    assert found.speed == pytest.approx(speed)


@pytest.mark.parametrize(
    ("text", "cause"),
    [
        ("distance,velocity\n1,2\n3,4\n", "not a table of distance_from_axis_m"),
        ("distance_from_axis_m,velocity_m_s\n0.1,fast\n0.2,1\n", "could not convert"),
        ("distance_from_axis_m,velocity_m_s\n0.1,1\n", "1 rows, at least 2"),
        (None, "No such file"),
    ],
)
def test_a_wrong_table_is_refused_in_one_line(tmp_path, runs, text, cause):
    file = tmp_path / "m.csv"
    if text is not None:
        file.write_text(text)
    with pytest.raises(RunFolderError, match=cause) as error:
        write_experiments([runs], tmp_path / "x.json", file)
    assert "\n" not in str(error.value) and "drum-240-mm.csv" in str(error.value)
    assert not (tmp_path / "x.json").exists()


def test_other_campaigns_have_their_slip_and_their_throws(runs, tmp_path):
    text = write_experiments([runs], tmp_path / "x.json", FILE)
    document = json.loads((tmp_path / "x.json").read_text())
    campaign = load_campaign(runs)
    assert [row["liner_slip"] for row in document["charges"]] == [
        charge.result.liner_slip for charge in campaign.charges
    ]
    assert len(document["throws"]) == len(campaign.single)
    assert document["drums"] == []
    assert text == experiments_page.tables(document)
    assert (tmp_path / experiments_page.THROWS).exists()


def test_a_charge_of_the_drum_has_its_row_and_its_figure(runs, tmp_path, monkeypatch):
    """Charges of another mill, taken for the drum: too large to have balls at the points."""
    monkeypatch.setattr(experiments_page, "is_measured_drum", lambda case: True)
    write_experiments([runs], tmp_path / "x.json", FILE)
    document = json.loads((tmp_path / "x.json").read_text())
    charges = load_campaign(runs).charges
    assert [row["balls"] for row in document["drums"]] == [charge.balls for charge in charges]
    assert [row["id"] for row in document["drums"]] == [charge.id for charge in charges]
    assert all(row["dumps"] == 2 for row in document["drums"])
    settings = {(row["campaign"], row["S"]) for row in document["drums"]}
    assert len(experiments_page.drum_table(document)) == 2 + len(settings)
    assert (tmp_path / experiments_page.DRUM).exists()


def test_only_the_measured_drum_is_taken_for_it(runs):
    cases = cases_of(read_campaign(CAMPAIGNS / "drum-240-mm.toml"))
    assert all(map(experiments.is_measured_drum, cases))
    assert not experiments.is_measured_drum(load_campaign(runs).charges[0].case)


# Of the stored results.


def test_the_page_has_the_tables_of_the_stored_results(stored):
    page = (RESULTS / "experiments.md").read_text(encoding="utf-8")
    tables = experiments_page.tables(stored)
    for line in filter(None, tables.splitlines()):
        assert line in page
    assert tables.count("\n| ") > 20


def test_rms_of_the_drum_is_that_of_the_stored_velocities(stored):
    """Computed here from the file of the measurements, not from what is stored beside."""
    measured = np.loadtxt(
        [x for x in FILE.read_text(encoding="utf-8").splitlines() if x[0] not in "#d"],
        delimiter=",",
    )
    lines = [x for x in experiments_page.drum_table(stored) if not x.startswith(("| S", "|--"))]
    settings = {}
    for row in stored["drums"]:
        pairs = zip(row["velocity_m_s"], measured[:, 1], strict=True)
        squares = [(u - v) ** 2 for u, v in pairs if u is not None]
        settings.setdefault((row["campaign"], row["S"]), []).append(np.sqrt(np.mean(squares)))
    assert len(lines) == len(settings) >= 8
    found = sorted(f"{np.mean(rms):.3f}" for rms in settings.values())
    assert found == sorted(line.split("|")[9].split("±")[0].strip() for line in lines)
    assert {S for _, S in settings} >= {2.0, 3.0, 4.0}


def test_impacts_are_those_of_the_stored_releases(stored):
    """By many small steps of each flight."""
    for row, line in zip(stored["throws"], experiments_page.throw_table(stored)[2:], strict=True):
        speeds = []
        for release in row["releases"]:
            position, velocity = (np.array(release[k]) for k in ("position_m", "velocity_m_s"))
            time = np.linspace(0.0, 4.0, 200_001)
            z = position[2] + velocity[2] * time - 0.5 * row["gravity_m_s2"] * time**2
            distance = np.hypot(position[0] + velocity[0] * time, z)
            out = np.flatnonzero((distance[1:] >= row["path_m"]) & (distance[:-1] < row["path_m"]))
            t = time[out[0] + 1]
            fall = velocity[2] - row["gravity_m_s2"] * t
            speeds.append(math.sqrt(velocity[0] ** 2 + velocity[1] ** 2 + fall**2))
        shown = line.split("|")[7].split("±")[0].strip()
        assert (shown == "–") == (not speeds)
        assert not speeds or float(shown) == pytest.approx(np.mean(speeds), abs=0.006)


@pytest.mark.validate
@pytest.mark.engine
def test_the_experiments_run_again_give_what_is_stored(tmp_path, stored):
    """The drum at S = 4 as published, and balls thrown in 5 m: some minutes."""
    runs = []
    for name, only in (("drum-240-mm", "*S4.000*"), ("impacts-5-m", "*")):
        runs.append(tmp_path / name)
        file = CAMPAIGNS / f"{name}.toml"
        done = millscale("run", file, "--runs", runs[-1], "--only", only, "--ranks", "1")
        assert done.returncode == 0, done.stderr
    write_experiments(runs, tmp_path / "x.json", FILE)
    again = json.loads((tmp_path / "x.json").read_text())
    (drum,) = again["drums"]
    before = next(row for row in stored["drums"] if row["campaign"] == "published")
    # The bed is chaotic: other vector kernels change the last digits, and so the motion.
    assert drum["liner_slip"] == pytest.approx(before["liner_slip"], abs=0.05)
    assert drum["torque"] == pytest.approx(before["torque"], rel=0.05)
    measured = read_profile(FILE)
    profiles = [experiments_page.simulated_profile(x, measured) for x in (drum, before)]
    rms = [profile.rms_from(measured) for profile in profiles]
    assert rms[0] == pytest.approx(rms[1], abs=0.02)
    by_id = {row["id"]: row for row in stored["throws"] if row["campaign"] == "impacts-5-m"}
    for row in again["throws"]:
        speeds = [
            np.mean([landing_on_liner(x, row["path_m"]).speed for x in experiments.releases_of(r)])
            for r in (row, by_id[row["id"]])
        ]
        assert speeds[0] == pytest.approx(speeds[1], rel=0.01)
