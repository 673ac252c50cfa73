"""An opened runs folder: numbers against the files and the readers they come from, and refusals."""

import re
from math import tau

import numpy as np
import pytest

import millscale as ms
from millscale.analysis.columns import unit_of
from millscale.analysis.measures import ERRORS
from millscale.analysis.shapes.curtain import curtain_overlaps
from millscale.api.frames import error_unit
from millscale.errors import CampaignError
from millscale.runs.untrusted import RunFolderError
from paper_campaign import REPOSITORY
from synthetic_mills import SEEDS, charge_case, write_mills
from synthetic_throw import DUMPS

PHYSICAL, SCALED = (f"mb-cg-paper-S{S}-fixed-seed1" for S in ("1.000", "2.600"))


@pytest.fixture(scope="module")
def opened(throws):
    return ms.open(throws)


def test_a_folder_is_a_text_or_a_path(throws, opened):
    assert list(ms.open(str(throws))) == list(opened)
    assert opened.folder == throws and opened.name == "synthetic" and opened.missing == {}


def test_the_table_has_a_row_for_each_case_and_a_unit_for_each_column(opened):
    cases = opened.cases
    assert list(cases.index) == list(opened)
    assert set(cases.attrs["units"]) == set(cases.columns)
    assert cases.loc[SCALED, "radius_m"] == opened[SCALED].case.mill.radius_m
    assert (cases["mass_kg"] > 0.0).all() and cases["is_steady"].notna().all()


def test_single_balls_are_rows_of_the_same_table(runs):
    opened = ms.open(runs)
    cases = opened.cases
    single = cases[cases["kind"] == "single-ball"]
    assert single["detach_angle_deg"].notna().all() and single["power_kW"].isna().all()
    rows = opened.single_balls
    assert list(rows.index) == list(single.index)
    assert rows.loc[single.index[0], "energy_ratio"] == 1.0


def test_the_series_is_that_of_the_file(opened):
    case = opened[SCALED]
    rows = np.genfromtxt(case.folder / "series.csv", delimiter=",", names=True)
    assert tuple(case.series.columns) == rows.dtype.names
    for name in rows.dtype.names:
        assert (case.series[name] == rows[name]).all()


def test_units_are_those_of_the_reference():
    """The tables of files.md that describe series.csv name the same units."""
    text = (REPOSITORY / "docs/reference/files.md").read_text(encoding="utf-8")
    part = text.partition("## series.csv")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| ([\w, ]+) \| [^|]* \| ([^|]*) \|", part, re.M)
    checked = 0
    for names, units in rows:
        columns, known = names.split(", "), units.strip().replace(" s", " s").split(", ")
        if columns == ["column"] or not units.strip():
            continue
        known = known * len(columns) if len(known) == 1 else known
        assert [unit_of(name) for name in columns] == known, names
        checked += len(columns)
    assert checked > 30


def test_units_of_errors():
    units = {error.name: error_unit(error) for error in ERRORS}
    assert units["contour_error_mean"] == "R - a" and units["massflow_rms_over_mean"] == "mean"
    assert units["power_error"] == "-" and units["curtain_iou_upper"] == "-"


def test_a_dump_is_found_by_its_mill_angle(opened):
    case = opened[SCALED]
    assert case.angles == pytest.approx(DUMPS, abs=1e-3)
    balls = case.dump(angle=0.5)
    assert balls.attrs["mill_angle_rad"] == pytest.approx(0.5, abs=1e-3)
    assert case.dump().attrs["mill_angle_rad"] == pytest.approx(1.0, abs=1e-3)
    assert balls.index.is_monotonic_increasing and balls.attrs["units"]["x"] == "m"


def test_shapes_are_those_of_the_analysis(opened):
    case = opened[SCALED]
    shape = case.shape(1.0)
    assert case.shape(1.0) is shape
    lines = [part[["x", "z"]].to_numpy() for _, part in case.contour(1.0).groupby("line")]
    assert all((a == b).all() for a, b in zip(lines, shape.contour.lines, strict=True))
    assert (case.liner(shape.mill_angle).to_numpy() == shape.outline).all()
    assert dict(case.curtains(1.0)) == shape.curtains


def test_overlaps_are_those_of_the_comparison(opened):
    ours, theirs = opened[SCALED].curtains(1.0), opened[PHYSICAL].curtains(1.0)
    each, *means = curtain_overlaps(dict(ours), dict(theirs))
    table = ours.overlap(theirs)
    assert table["whole"].to_dict() == {int(n): parts["whole"] for n, parts in each.items()}
    assert table["whole"].mean() == pytest.approx(means[0])
    assert 0.0 < means[0] < 1.0


def test_physical_power_is_M_g_R_omega_times_the_power_number(tmp_path):
    """Of slices of scaled mills by the law: the power of the slice times S^2 L / L' balls, and the
    factor of the power of one ball, length^2 / time^3."""
    schemes = ("constant-gravity", "constant-speed")
    cases = [charge_case(S, 1, scheme) for S in (1.0, 2.6) for scheme in schemes]
    for case in cases:
        case["mill"]["simulated_length_m"] *= 0.5
        case["ball"]["count"] //= 2
    powers = {}
    for case_id, opened in ms.open(write_mills(tmp_path, *cases)).items():
        case, number = opened.case, opened.result.dimensionless["power"]
        physical = case.physical
        balls = case.ball.count * case.S**2 * physical.length_m / case.mill.simulated_length_m
        scale = balls * case.ball.mass_kg * physical.gravity_m_s2 * physical.radius_m
        assert opened.power() == pytest.approx(1e-3 * scale * physical.omega_rad_s * number)
        of_ball = case.factors.length**2 / case.factors.time**3
        share = case.S**2 * physical.length_m / case.mill.simulated_length_m
        by_law = opened.power(physical=False) / of_ball * share
        assert opened.power(physical=True) == pytest.approx(by_law, rel=1e-9)
        powers[case_id] = opened.power()
    assert max(powers.values()) == pytest.approx(min(powers.values()), rel=0.1)


def test_power_is_that_of_the_prediction(tmp_path):
    """Tolerance: the numbers of balls of a scaled mill are rounded."""
    cases = [charge_case(S, seed) for S in (1.0, 2.6) for seed in SEEDS]
    opened = ms.open(write_mills(tmp_path, *cases))
    for found in opened.predict()["power"].measured:
        mean = np.mean([case.power() for case in opened.values() if case.S == found.S])
        assert found.mean == pytest.approx(mean, rel=1e-3)


def test_errors_are_those_of_results_json(opened):
    rows = {row.charge.id: row for row in opened.campaign.comparison.rows}
    table = opened.errors()
    assert list(table.index) == list(rows)
    for name in ("contour_error_mean", "curtain_iou_whole", "power_error"):
        wanted = rows[SCALED].errors.steady(name)
        assert table.loc[SCALED, name] == wanted is not None
        assert opened[SCALED].errors(against=opened[PHYSICAL])[name] == wanted
    assert table.loc[SCALED, "reference"] == PHYSICAL


def test_a_mesh_has_the_balls_of_the_dump_and_the_turned_liner(opened):
    case = opened[SCALED]
    mesh, dump = case.mesh(angle=0.5), case.dump(angle=0.5)
    assert np.allclose(mesh["balls"].points, dump[["x", "y", "z"]], atol=1e-6)
    rest = case.mesh(angle=0.0)["liner"].points
    turned = mesh["liner"].points
    assert not np.allclose(rest, turned, atol=1e-3)
    x, z = rest[:, 0], rest[:, 2]
    c, s = np.cos(dump.attrs["mill_angle_rad"]), np.sin(dump.attrs["mill_angle_rad"])
    assert np.allclose(turned[:, 0], c * x + s * z, atol=1e-5)


@pytest.mark.parametrize(
    ("try_it", "error", "message"),
    [
        (lambda x: ms.open("runs/absent"), RunFolderError, "absent/campaign.json: no such file"),
        (lambda x: x["mb-cg-paper-S2.6-fixed-seed1"], KeyError, f"nearest is {SCALED}"),
        (lambda x: x[SCALED].contour(angle=0.7), RunFolderError, "no dump at 0.7 rad, nearest"),
        (lambda x: x[SCALED].ledger, RunFolderError, "ledger.csv: no such file"),
        (lambda x: x[SCALED].view(1.0, "spede"), ValueError, "got 'spede'; accepted: .*radius"),
        (lambda x: ms.plan({"mill": {"radius_mm": 3}}), CampaignError, "campaign: "),
        (lambda x: ms.plan("absent.toml"), CampaignError, "absent.toml: no such file"),
    ],
)  # fmt: skip
def test_errors_are_those_of_the_command_line(opened, try_it, error, message):
    with pytest.raises(error, match=message):
        try_it(opened)


def test_a_single_ball_has_no_shape(runs):
    opened = ms.open(runs)
    ball = next(case for case in opened.values() if case.case.kind == "single-ball")
    for ask in (ball.contour, ball.power, ball.mesh, lambda: ball.occupancy):
        with pytest.raises(RunFolderError, match="a single ball, which has no"):
            ask()


def test_a_case_that_is_not_finished_states_why(tmp_path):
    runs = write_mills(tmp_path, charge_case(2.6, 1), charge_case(2.6, 2))
    lost = runs / "cases/mb-cg-paper-S2.600-seed2"
    (lost / "result.json").unlink()
    opened = ms.open(runs)
    assert list(opened.missing) == [lost.name] and "1 case not finished" in repr(opened)
    assert "no result.json yet" in opened._repr_html_()
    with pytest.raises(KeyError, match=r"no result\.json yet"):
        _ = opened[lost.name]


def test_a_scaled_mill_is_that_of_the_law():
    mill = ms.scale(2.6, radius_m=3.9, ball_radius_m=0.02, speed_rad_s=1.0, scheme="constant-speed")
    assert (mill.radius_m, mill.omega_rad_s) == (1.5, 1.0)
    assert mill.gravity_m_s2 == pytest.approx(9.81 / 2.6)
    assert mill.factor(length=2, mass=1, time=-2) == pytest.approx(2.6**-2)
    same = ms.scale(2.6, radius_m=3.9, ball_radius_m=0.02, speed_rpm=60.0 / tau)
    assert same.physical.omega == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"speed_rad_s": None}, "the speed is missing"),
        ({"speed_rpm": 20.0}, "contradicts speed_rad_s"),
        ({"scheme": "constant-sped"}, "nearest is constant-speed"),
        ({"S": 0.5}, "S = 0.5"),
    ],
)
def test_a_scaled_mill_is_refused_with_what_is_accepted(changes, message):
    given = {"S": 2.6, "radius_m": 3.9, "ball_radius_m": 0.02, "speed_rad_s": 1.0} | changes
    with pytest.raises(CampaignError, match=message):
        ms.scale(given.pop("S"), **given)
