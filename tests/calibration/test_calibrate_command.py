"""`millscale calibrate` of a calibration file, with runs whose charges follow a known law."""

import json
import math
import tomllib

import numpy as np
import pytest
from typer.testing import CliRunner

from millscale.analysis.finished import Charge
from millscale.calibration.command import plan_lines
from millscale.calibration.targets import surface_distances, velocities
from millscale.campaign.build import load_campaign
from millscale.cli.main import app
from millscale.runs.case_folder import finished_or_reason
from millscale.runs.layout import CASES_FOLDER, STAGES
from millscale.study import running
from paper_campaign import campaign_text
from synthetic_case import finish_case, write_campaign, write_case
from synthetic_charge import charge_columns, write_charge

CHARGE = {"multi_ball": {"count": [1431], "rotation_angle_rad": 6.0, "step_s": 1e-4}}
ONE_MILL = {"scaling__S": [2.6], "scaling__schemes": ["constant-gravity"], "single_ball": None}
TRUE_FRICTION, TRUE_ROLLING = 0.42, 0.02
TEXT = """
[calibration]
base = "mill.toml"
samples = 16
samples_per_round = 5
rounds = 3

[[parameter]]
keys = ["material.static_friction_pp"]
name = "friction"
least = 0.1
most = 0.9

[[parameter]]
keys = ["material.rolling_friction_pp"]
name = "rolling"
least = 1e-3
most = 0.1
scale = "logarithmic"

[[target]]
torque = {torque}
uncertainty = 0.004

[[target]]
kinetic = {kinetic}
uncertainty = 0.006
"""


def torque_of(friction, rolling):
    return 0.4 * (1.0 - math.exp(-friction / 0.3)) + 0.4 * rolling


def kinetic_of(friction, rolling):
    return 0.5 - 0.15 * friction - 1.5 * rolling


def columns_of(case, noise=0.0):
    """The series of a steady charge of this law."""
    columns, mill, material = charge_columns(case, 6.0), case["mill"], case["material"]
    values = material["static_friction_pp"], material["rolling_friction_pp"]
    mass, radius = columns["mass_kg"][0], mill["radius_m"]
    torque = torque_of(*values) + noise
    weight = mass * mill["gravity_m_s2"] * radius
    columns["drive_work_J"] = weight * torque * columns["mill_angle_rad"]
    columns["centre_x_m"] = (
        -torque * radius * (1.0 + 0.02 * np.sin(25.0 * columns["mill_angle_rad"]))
    )
    columns["kinetic_translation_J"] *= kinetic_of(*values) / 0.3
    return columns


@pytest.fixture
def engine(monkeypatch):
    """Replaces the runs by charges in closed form; returns the folders that were run."""
    ran = []

    def run(asked, _):
        for case in asked.cases:
            folder = asked.runs / CASES_FOLDER / case.id
            if not folder.exists():
                ran.append(asked.runs.name)
                document = json.loads(case.text())
                write_case(asked.runs, document, columns_of(document))
                for product in (x for stage in STAGES["multi-ball"] for x in stage.products):
                    if not (folder / product).exists():
                        (folder / product).write_text("{}")
                finish_case(folder)
        write_campaign(asked.runs, [case.id for case in asked.cases])
        return True

    monkeypatch.setattr(running, "run_campaign", run)
    return ran


def write(folder, text=TEXT, friction=TRUE_FRICTION, rolling=TRUE_ROLLING):
    (folder / "mill.toml").write_text(campaign_text(**ONE_MILL, **CHARGE))
    file = folder / "calibrate.toml"
    values = {"torque": torque_of(friction, rolling), "kinetic": kinetic_of(friction, rolling)}
    file.write_text(text.format(**values))
    return file


def calibrated(file, runs, *options):
    line = ["calibrate", str(file), "--runs", str(runs), "--ranks", "1", "--jobs", "1", *options]
    return CliRunner().invoke(app, line)


@pytest.fixture
def done(tmp_path, engine):
    result = calibrated(write(tmp_path), tmp_path / "runs")
    assert result.exit_code == 0, result.output
    return tmp_path, result, engine


def content_of(folder):
    return json.loads((folder / "runs/calibration.json").read_text())


def test_known_parameters_are_found_and_confirmed_by_a_run(done):
    folder, result, _ = done
    content = content_of(folder)
    assert {"command", "commit", "machine", "date"} <= content.keys()
    found = {one["name"]: one for one in content["parameters"]}
    for name, truth in (("friction", TRUE_FRICTION), ("rolling", TRUE_ROLLING)):
        assert found[name]["lower"] < truth < found[name]["upper"]
        assert found[name]["is_determined"]
    assert content["is_converged"]
    for target in content["targets"]:
        assert abs(target["difference_over_uncertainty"]) < 0.5
    assert content["targets"][0]["simulated"] == pytest.approx(
        content["targets"][0]["measured"], abs=0.002
    )
    assert "converged:" in result.output


def test_the_calibrated_campaign_has_the_best_values(done):
    folder, _, _ = done
    tree = tomllib.loads((folder / "runs/calibrated.toml").read_text())
    best = {one["keys"][0]: one["best"] for one in content_of(folder)["parameters"]}
    assert tree["material"]["static_friction_pp"] == pytest.approx(
        best["material.static_friction_pp"], rel=1e-5
    )
    campaign = load_campaign(folder / "runs/calibrated.toml")
    assert campaign.material.restitution_pp == 0.1


def test_the_page_shows_parameters_targets_and_figures(done):
    page = (done[0] / "runs/report/index.html").read_text()
    assert page.count("data:image/webp;base64,") == 2
    assert "friction" in page and "torque number" in page and "static_friction_pp" in page


def test_a_repeated_command_runs_nothing_and_finds_the_same(done):
    folder, _, engine = done
    ran, before = list(engine), content_of(folder)
    again = calibrated(folder / "calibrate.toml", folder / "runs", "--json")
    assert again.exit_code == 0 and engine == ran
    shown = json.loads(again.stdout)
    assert shown == {key: before[key] for key in shown}


def test_other_targets_use_the_same_samples(done):
    folder, _, engine = done
    ran = len(engine)
    file = write(folder, friction=0.5, rolling=0.01)
    assert calibrated(file, folder / "runs", "--no-run").exit_code == 0
    assert len(engine) == ran
    (friction, _) = content_of(folder)["parameters"]
    assert friction["lower"] < 0.5 < friction["upper"]


def test_finished_cases_of_another_folder_are_reused(done):
    folder, _, engine = done
    ran = len(engine)
    options = [x for path in sorted((folder / "runs/settings").iterdir()) for x in ("--from", path)]
    assert (
        calibrated(folder / "calibrate.toml", folder / "other", *map(str, options)).exit_code == 0
    )
    assert len(engine) == ran
    assert json.loads((folder / "other/calibration.json").read_text())["is_converged"]


def test_a_folder_of_another_mill_or_of_something_else_is_refused(done):
    folder, _, _ = done
    other = write(folder, TEXT.replace("material.rolling_friction_pp", "material.restitution_pp")
                  .replace("1e-3", "0.1").replace("0.1\nscale", "0.8\nscale"))  # fmt: skip
    result = calibrated(other, folder / "runs")
    assert result.exit_code != 0
    assert "whose mill or parameters differ" in str(result.exception)
    result = calibrated(write(folder), folder)
    assert "holds" in str(result.exception) and "no samples.json" in str(result.exception)


def test_samples_that_failed_are_left_out_and_named(tmp_path, engine, monkeypatch):
    broken = []

    def fails(asked, console):
        if asked.runs.name in ("sample-002", "sample-005"):
            broken.append(asked.runs.name)
            return False
        return succeeds(asked, console)

    succeeds = running.run_campaign
    monkeypatch.setattr(running, "run_campaign", fails)
    result = calibrated(write(tmp_path), tmp_path / "runs")
    assert result.exit_code == 1 and broken
    content = content_of(tmp_path)
    assert content["parameters"][0]["lower"] < TRUE_FRICTION < content["parameters"][0]["upper"]
    assert sum("not used: sample" in text for text in content["warnings"]) == 2


def test_without_samples_it_says_what_is_missing(tmp_path, engine):
    result = calibrated(write(tmp_path), tmp_path / "runs", "--no-run")
    assert "no finished sample" in str(result.exception)


def test_the_plan_states_samples_and_time_and_writes_nothing(tmp_path):
    file = write(tmp_path)
    before = sorted(tmp_path.iterdir())
    text = "\n".join(plan_lines(file))
    assert "round 1: 16 samples" in text and "at most 27 samples" in text
    assert CliRunner().invoke(app, ["calibrate", str(file), "--plan"]).output.startswith(text[:40])
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize(
    ("options", "message"),
    [((), "--runs: missing"), (("--S", "2", "--runs", "x"), "scaling.S in its")],
)
def test_wrong_options_are_refused(tmp_path, options, message):
    result = CliRunner().invoke(app, ["calibrate", str(write(tmp_path)), *options])
    assert message in str(result.exception)


def test_options_of_a_calibration_are_refused_for_a_campaign(tmp_path):
    write(tmp_path)
    line = ["calibrate", str(tmp_path / "mill.toml"), "--runs", "x", "--no-run"]
    assert "no [calibration]" in str(CliRunner().invoke(app, line).exception)


@pytest.fixture
def turning(tmp_path):
    """A finished charge that turns as a rigid block, with velocities in its dumps."""
    folder = write_charge(tmp_path, "constant-gravity", 900)
    case = json.loads((folder / "case.json").read_text())
    omega = case["mill"]["omega_rad_s"]
    for path in (folder / "dump").iterdir():
        head, rows = path.read_text().split("radius \n")
        made = []
        for row in rows.splitlines():
            i, kind, x, y, z, *_, radius = row.split()
            # The bottom of the mill moves to -x.
            velocity = f"{omega * float(z):.9g} 0 {-omega * float(x):.9g}"
            made.append(f"{i} {kind} {x} {y} {z} {velocity} {radius} ")
        path.write_text(head + "radius \n" + "\n".join(made) + "\n")
    finish_case(folder)
    return Charge(finished_or_reason(folder), "synthetic")


def test_velocities_are_those_of_the_physical_mill(turning):
    """A block that turns with the mill: omega r down the slope, counted up-slope below the axis."""
    distances = np.array([-1.2, -1.8, 5.0])
    found = velocities(turning, distances, slope=0.0, within=0.3)
    assert found[:2] == pytest.approx(1.0 * distances[:2], rel=0.08)
    assert math.isnan(found[2])


def test_the_distance_of_the_surface_is_that_along_the_normal(turning):
    """Moved points lie as far from the surface as they were moved."""
    from millscale.prediction.contour import mean_contour, with_normals

    line, _ = with_normals(mean_contour(turning))
    points = line[5:-5:4] * 3.88
    tangents = np.gradient(points, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1)[:, None]
    normals = np.column_stack([-tangents[:, 1], tangents[:, 0]])
    moved = surface_distances(turning, points - 0.1 * normals)
    assert surface_distances(turning, points) == pytest.approx(np.zeros(len(points)), abs=0.03)
    assert np.median(moved) == pytest.approx(0.1, abs=0.02)
