"""Generated decks in the engine: they run by hand; the fix derives the numbers of case.json."""

from pathlib import Path

import pytest
from msgspec import structs

from millscale.cases.decks import copy_decks
from millscale.cases.generate import generate
from millscale.cases.parameters import write_parameters
from millscale.cases.wall_panels import panels_of
from millscale.mesh import curvature_deg
from millscale.packing.charge import write_charge
from millscale.runs.liner import liner_of
from millscale.workflow.stage_work import write_mesh
from scene import run_file

QUICK = Path(__file__).parents[2] / "campaigns" / "quick.toml"
PUBLISHED = {
    "gravity_m_s2": 3,
    "froude": 4,
    "radius_m": 5,
    "omega_rad_s": 6,
}
CHARGE_SERIES = (
    "step,time_s,mill_angle_rad,balls,mass_kg,"
    "kinetic_translation_J,kinetic_rotation_J,potential_J,"
    "centre_x_m,centre_z_m,angular_momentum_Nms,drive_work_J,drive_torque_Nm,drive_power_W,"
    "alternating_torque_Nm,balls_on_wall,balls_in_bed,balls_in_flight,"
    "box_fixed_mass_fraction,box_rotating_mass_fraction,toe_angle_rad,shoulder_angle_rad,"
    "largest_overlap_m,largest_speed_m_s,ends_work_J,ends_impulse_Nms,"
    "liner_slip"
)
CHARGE_DUMP = (
    "id type x y z vx vy vz radius "
    "c_detach[1] c_detach[12] c_detach[14] c_detach[15] c_detach[22] c_detach[23] c_detach[24]"
)
pytestmark = pytest.mark.engine


def _run(folder, deck, ranks=1):
    done = run_file(folder, deck, ranks)
    assert done.code == 0, done.text[-2000:]
    return done.text


@pytest.fixture(scope="module")
def cases(tmp_path_factory):
    """Cases of quick.toml, each rotated by no more than 0.02 rad."""
    folder = tmp_path_factory.mktemp("decks")
    short = QUICK.read_text()
    for long in ("rotation_angle_rad = 7.0", "rotation_angle_rad = 12.0"):
        assert long in short
        short = short.replace(long, "rotation_angle_rad = 0.02")
    short = short.replace("settle_s = 0.8", "settle_s = 0.11")
    short = short.replace("dump_angle_rad = 0.5\n", "")
    short = short.replace("count = [13370]", "count = [2600]")
    (folder / "short.toml").write_text(short)
    return {case.id: case for case in generate(folder / "short.toml", folder / "runs")}


def _prepare(case, folder, deck):
    copy_decks((deck,), folder)
    write_parameters(case, folder)
    return folder


IDS = [
    f"sb-{scheme}-{policy}-S2.600"
    for scheme in ("cg", "cs")
    for policy in ("paper", "corrected", "offset-liner")
]


@pytest.mark.parametrize("case_id", [*IDS, "sb-cg-paper-S1.000"])
def test_the_fix_derives_the_numbers_of_case_json(cases, tmp_path, case_id):
    case = cases[case_id]
    _prepare(case, tmp_path, "single_ball.in")
    words = " ".join(f"$(f_mill[{k}])" for k in (*PUBLISHED.values(), 7, 9, 10, 11, 1))
    (tmp_path / "show.in").write_text(f'include single_ball.in\nprint "values {words}"\n')
    text = _run(tmp_path, "show.in")
    line = next(x for x in text.splitlines() if x.startswith("values"))
    values = [float(word) for word in line.split()[1:]]
    mill, factors = case.mill, case.factors
    assert values[:4] == [getattr(mill, name) for name in PUBLISHED]
    assert values[4:6] == [factors.length, factors.time]
    assert values[6:8] == [case.predicted_energy_ratio, case.centre_path_energy_ratio]
    # The rotation ends on a whole step.
    assert values[8] == pytest.approx(0.02, abs=mill.omega_rad_s * case.time.step_s)


def test_the_decks_of_a_charge_run_by_hand_on_two_ranks(cases, tmp_path):
    case = cases["mb-cg-paper-S2.600"]
    folder = _prepare(case, tmp_path, "settle.in")
    copy_decks(("mill.in",), folder)
    write_charge(case, folder)
    (folder / "dump").mkdir()
    _run(folder, "settle.in", ranks=2)
    _run(folder, "mill.in", ranks=2)
    header, *rows = (folder / "series.csv").read_text().splitlines()
    assert header == CHARGE_SERIES
    last = dict(zip(header.split(","), rows[-1].split(","), strict=True))
    assert int(float(last["balls"])) == case.ball.count
    assert float(last["mill_angle_rad"]) == pytest.approx(0.02, rel=0.05)
    states = ("balls_on_wall", "balls_in_bed", "balls_in_flight")
    assert sum(float(last[name]) for name in states) == case.ball.count
    dumps = sorted((folder / "dump").glob("charge.*.liggghts"))
    assert f"ITEM: ATOMS {CHARGE_DUMP} \n" in dumps[0].read_text()
    _check_measurements(case, {name: float(value) for name, value in last.items()})
    occupancy = (folder / "occupancy.csv").read_text().splitlines()
    assert len(occupancy) == 1 + 50 * 180
    half = 0.5 * float(last["mill_angle_rad"])  # averaged over the second half of the rotation
    assert float(occupancy[1].split(",")[0]) >= half * (1 - 1e-9)


@pytest.mark.parametrize("precision", ["double", "mixed"])
def test_the_decks_request_the_precision_of_the_campaign(cases, tmp_path, precision):
    case = cases["mb-cg-paper-S2.600"]
    case = structs.replace(case, deck=structs.replace(case.deck, precision=precision))
    folder = _prepare(case, tmp_path, "settle.in")
    write_charge(case, folder)
    _run(folder, "settle.in")
    assert f"tangential_damping bounded precision {precision}\n" in _log(folder)


def _log(folder):
    return "".join(path.read_text() for path in folder.glob("log.*"))


def _check_measurements(case, last):
    """A charge early in its fall: limits that fail if two columns are exchanged."""
    radius, ball = case.mill.radius_m, case.ball.radius_m
    mass = case.ball.mass_kg * case.ball.count
    assert last["potential_J"] == pytest.approx(
        mass * case.mill.gravity_m_s2 * last["centre_z_m"], rel=1e-9
    )
    assert -radius < last["centre_z_m"] < 0
    assert last["kinetic_rotation_J"] < last["kinetic_translation_J"]
    assert 0 < last["box_fixed_mass_fraction"] < 0.2
    # The two frames differ by 0.02 rad: nearly all balls are the same.
    assert last["box_rotating_mass_fraction"] == pytest.approx(
        last["box_fixed_mass_fraction"], rel=0.2
    )
    assert 0 < last["shoulder_angle_rad"] < 3.14 < last["toe_angle_rad"] < 6.28
    assert 0 <= last["largest_overlap_m"] < ball
    assert last["largest_speed_m_s"] >= (2 * last["kinetic_translation_J"] / mass) ** 0.5


def test_the_mesh_wall_runs_from_the_same_decks(cases, tmp_path):
    case = cases["sb-cs-paper-S2.600"]
    liner, wall, length = liner_of(case.mill), case.wall, case.mill.simulated_length_m
    panels = panels_of(liner, length, wall.chord_error_m, wall.axial_divisions)
    meshed = structs.replace(wall, kind="mesh", curvature_deg=curvature_deg(panels))
    case = structs.replace(case, wall=meshed)
    folder = _prepare(case, tmp_path, "single_ball.in")
    write_mesh(case, folder)
    assert "ERROR" not in _run(folder, "single_ball.in")
    rows = (folder / "series.csv").read_text().splitlines()
    assert len(rows) > 3
