"""Campaign files written by users that earlier versions refused, accepted or explained wrongly.

Each command is run as it is typed, and what it prints is what is tested.
"""

import json
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

import in_process

MATERIAL = """
[material]
youngs_modulus_pa = 1.0e7
poisson_ratio = 0.3
restitution_pp = 0.5
restitution_pw = 0.5
static_friction_pp = 0.4
static_friction_pw = 0.4
rolling_friction_pp = 0.01
rolling_friction_pw = 0.01
[scaling]
schemes = ["constant-gravity"]
"""
PAPERS_LINER = """
[liner]
lifters = 25
lifter_top_radius_m = 3.610
lifter_top_width_m = 0.250
groove_width_m = 0.635
[ball]
radius_m = 0.020
density_kg_m3 = 2678.0
"""
BAFFLES = f"""
[mill]
radius_m = 0.12
length_m = 0.1
speed_rpm = 1.5708
[liner]
lifters = 6
lifter_top_radius_m = 0.100
lifter_top_width_m = 0.004
face_angle_deg = 2.0
[ball]
radius_m = 0.002
density_kg_m3 = 1000.0
{MATERIAL.replace("1.0e7", "1.0e6")}
[multi_ball]
S = [1.0]
filling = 0.2
slice_diameters = 4.0
rotation_angle_rad = 3.0
"""
SHARP_LIFTERS = f"""
[mill]
radius_m = 1.0
length_m = 1.0
gravity_m_s2 = 50.0
speed_rad_s = 5.0
[liner]
lifters = 20
lifter_top_radius_m = 0.93
lifter_top_width_m = 0.001
face_angle_deg = 30.0
[ball]
radius_m = 0.03
density_kg_m3 = 1000.0
radius_std_m = 0.00693
truncation = 1.732
{MATERIAL}
[multi_ball]
S = [1.0]
filling = 0.25
slice_diameters = 6.0
rotation_angle_rad = 4.0
"""
SINGLE_BALL = f"""
[mill]
radius_m = 3.9
length_m = 1.0
speed_rad_s = 1.0
{PAPERS_LINER}{MATERIAL.replace("1.0e7", "5.98e7")}
[single_ball]
S = [2.6]
rotation_angle_rad = 3.0
"""
SMALL_DRUM = f"""
[mill]
radius_m = 0.05
length_m = 0.04
gravity_m_s2 = 9.81
froude = 0.3
[ball]
radius_m = 0.001
density_kg_m3 = 2500.0
{MATERIAL}
[multi_ball]
S = [2.0]
filling = 0.3
slice_diameters = 4.0
rotation_angle_rad = 0.1
settle_s = 0.8
"""
SLENDER_DRUM = f"""
[mill]
radius_m = 0.12
length_m = 0.36
speed_rpm = 11.6
[ball]
radius_m = 0.0015
density_kg_m3 = 2500.0
{MATERIAL}
[multi_ball]
S = [4.0]
filling = 0.3
slice_diameters = 10.0
rotation_angle_rad = 1.0
"""


def with_(text: str, *pairs: tuple[str, str]) -> str:
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new, 1)
    return text


def millscale(*arguments: str | Path) -> tuple[int, str]:
    """Return the exit code of a command and everything it printed."""
    done = in_process.millscale(*arguments)
    return done.returncode, done.stdout + done.stderr


@dataclass(frozen=True)
class Input:
    """A campaign, and the exit code and output that `millscale plan` must give."""

    text: str | bytes
    code: int
    says: str = ""


INPUTS = {
    "rad/s typed as rpm": Input(
        BAFFLES, 0, "mill.speed_rpm = 1.5708 is 1.8 % of the critical speed; rad/s typed as rpm?"
    ),
    "lifter tops of a millimetre": Input(SHARP_LIFTERS, 0),
    **{
        f"the same as a mesh, {given} divisions": Input(
            f'{SHARP_LIFTERS}[wall]\nkind = "mesh"\naxial_divisions = {given}\n',
            code,
            "accepted: 22, or no such key" if code else "",
        )
        for given, code in ((1, 2), (10, 2), (40, 0), (100, 2), (400, 2))
    },
    "the same as a mesh": Input(f'{SHARP_LIFTERS}[wall]\nkind = "mesh"\n', 0),
    "an ordinary mill": Input(SLENDER_DRUM, 0),
    "an ordinary mill, another length": Input(
        with_(SLENDER_DRUM, ("slice_diameters = 10.0", "slice_diameters = 9.9")), 0
    ),
    "a ball wider than a groove": Input(
        with_(SINGLE_BALL, ("S = [2.6]", "S = [20.0]")), 2, "accepted: S <= 15.874"
    ),
    "the same, corrected": Input(
        with_(
            SINGLE_BALL,
            ("S = [2.6]", "S = [20.0]"),
            ("[scaling]", '[scaling]\npolicies = ["corrected"]'),
        ),
        2,
        "accepted: S <= 15.874",
    ),
    "the same, offset liner": Input(
        with_(
            SINGLE_BALL,
            ("S = [2.6]", "S = [20.0]"),
            ("[scaling]", '[scaling]\npolicies = ["offset-liner"]'),
        ),
        2,
        "offset",
    ),
    "a mill on an asteroid": Input(
        with_(SMALL_DRUM, ("9.81", "0.0001"), ("[2.0]", "[4.0]")),
        2,
        "so that the bed hangs in the air; accepted: >= 9; usual is 28",
    ),
    "the same with the default": Input(
        with_(SMALL_DRUM, ("9.81", "0.0001"), ("[2.0]", "[4.0]"), ("settle_s = 0.8\n", "")), 0
    ),
    "balls of jelly": Input(
        with_(SMALL_DRUM, ("9.81", "1e6")),
        2,
        "1.06 (rho g R / E)^(2/3); accepted: >= 6.2e+09",
    ),
    "a byte order mark": Input(SINGLE_BALL.encode("utf-8-sig"), 0),
    "UTF-16": Input(SINGLE_BALL.encode("utf-16"), 2, "save the file anew with the encoding UTF-8"),
    "a decimal comma": Input(with_(SINGLE_BALL, ("= 3.9", "= 3,9")), 2, "a decimal point, 3.9"),
    "a typographic minus": Input(
        with_(SINGLE_BALL, ("2678.0", "2678e\u22120")), 2, "minus sign (at line"
    ),
    "a sample beyond the rotation": Input(
        f"{SINGLE_BALL}sample_angle_rad = 250\n",
        2,
        "got 250, longer than the rotation of 3 rad; accepted: <= 3",
    ),
}


@pytest.mark.parametrize("name", INPUTS)
def test_plan_reports_what_the_engine_would_refuse_later(name, tmp_path):
    given = INPUTS[name]
    file = tmp_path / "a.toml"
    file.write_bytes(given.text if isinstance(given.text, bytes) else given.text.encode())
    code, printed = millscale("plan", file)
    assert code == given.code, printed
    assert code == 0 or len(printed.splitlines()) == 1
    assert given.says in " ".join(printed.split())
    assert [path.name for path in tmp_path.iterdir()] == ["a.toml"]


@pytest.mark.parametrize("name", ["an ordinary mill", "lifter tops of a millimetre"])
def test_a_mesh_that_the_engine_refuses_does_not_stop_an_analytic_wall(name, tmp_path):
    file = tmp_path / "a.toml"
    file.write_text(INPUTS[name].text, encoding="utf-8")
    assert millscale("generate", file, "--runs", tmp_path / "runs")[0] == 0
    (case,) = (tmp_path / "runs" / "cases").iterdir()
    about = json.loads((case / "mesh.json").read_text())
    assert about["curvature_deg"] is None and about["triangles"] > 100
    assert (case / "liner.stl").stat().st_size > 10_000


def test_a_gmsh_that_cannot_load_is_reported_with_its_package(tmp_path, monkeypatch):
    packages = tmp_path / "packages"
    packages.mkdir()
    cause = "libGLU.so.1: cannot open shared object file: No such file or directory"
    (packages / "gmsh.py").write_text(f"raise OSError({cause!r})\n")
    monkeypatch.syspath_prepend(str(packages))
    monkeypatch.delitem(sys.modules, "gmsh", raising=False)
    file = tmp_path / "a.toml"
    file.write_text(f'{SINGLE_BALL}[wall]\nkind = "mesh"\n', encoding="utf-8")
    code, printed = millscale("generate", file, "--runs", tmp_path / "runs")
    assert code == 1
    assert f"missing library: {cause}" in printed
    assert 'sudo apt-get install libglu1-mesa, or set wall.kind = "analytic"' in printed
    monkeypatch.delitem(sys.modules, "gmsh", raising=False)
