import re

import pytest
from msgspec.structs import replace

from millscale.cases.parameters import parameters, write_parameters
from paper_campaign import MULTI_BALL, REPOSITORY, cases
from reference_tables import documented

OF_A_MESH = {"curvature_deg", "liner_file"}
OPTIONAL = {"precision", "ledger", "impacts", "liner_loads"}
ALWAYS = set(documented("parameters.in")) - OF_A_MESH - OPTIONAL


@pytest.fixture
def both_kinds(tmp_path):
    return cases(tmp_path, **MULTI_BALL, scaling__S=[1.0, 1.696])


def read(path) -> dict[str, str]:
    lines = [line.split() for line in path.read_text().splitlines() if not line.startswith("#")]
    assert all(line[0] == "variable" and line[2] == "string" for line in lines)
    return {line[1]: " ".join(line[3:]) for line in lines}


def test_exactly_the_documented_parameters_are_written(both_kinds):
    for case in both_kinds:
        assert set(parameters(case)) == ALWAYS


def test_a_mesh_wall_has_its_file_and_curvature(tmp_path):
    for case in cases(tmp_path, **MULTI_BALL, wall__kind="mesh"):
        assert set(parameters(case)) == ALWAYS | OF_A_MESH
        assert parameters(case)["curvature_deg"] == case.wall.curvature_deg


def test_options_are_written_if_chosen(tmp_path):
    asked = {"model__precision": "mixed", "multi_ball__ledger": True}
    for case in cases(tmp_path, **MULTI_BALL, **asked, multi_ball__liner_loads=True):
        records = {"ledger", "liner_loads"} if case.kind == "multi-ball" else set()
        assert set(parameters(case)) == ALWAYS | {"precision"} | records


def test_numbers_read_back_exactly(both_kinds, tmp_path):
    for case in both_kinds:
        write_parameters(case, tmp_path)
        written = read(tmp_path / "parameters.in")
        assert float(written["S"]) == case.S
        assert float(written["time_step"]) == case.time.step_s
        assert float(written["half_box"]) == case.domain.half_box_m
        assert float(written["length"]) == case.mill.simulated_length_m
        assert written["scheme"] == case.scheme


def test_counts_are_whole_numbers(both_kinds, tmp_path):
    for case in both_kinds:
        write_parameters(case, tmp_path)
        written = read(tmp_path / "parameters.in")
        for name in written:
            if name.endswith("_steps") or name == "lifters":
                assert written[name] == str(int(written[name]))


def test_the_liner_is_stated_exactly(both_kinds, tmp_path):
    for case in both_kinds:
        write_parameters(case, tmp_path)
        entries = read(tmp_path / "parameters.in")["liner_shape"].strip('"').split()
        stated = {key: float(value) for key, value in zip(entries[::2], entries[1::2], strict=True)}
        assert stated == {
            "lifters": case.mill.lifters,
            "phase": case.mill.phase_rad,
            "lifter_top_radius": case.mill.lifter_top_radius_m,
            "lifter_top_width": case.mill.lifter_top_width_m,
            "groove_width": case.mill.groove_width_m,
        }


def test_a_liner_of_another_shape_is_stated_as_a_file(both_kinds, tmp_path):
    nodes = ((1.38, -0.05, 0.0, 2, 0), (1.45, 0.1, 0.0, 0, 0))
    case = both_kinds[0]
    mill = replace(case.mill, profile=nodes, lifters=25, phase_rad=0.1)
    write_parameters(replace(case, mill=mill), tmp_path)
    assert read(tmp_path / "parameters.in")["liner_shape"] == '"profile liner_profile.csv"'
    assert "1.3799999999999999,-0.050000000000000003,0,top,0" in (
        (tmp_path / "liner_profile.csv").read_text()
    )


def test_the_box_holds_the_mill(both_kinds):
    for case in both_kinds:
        values = parameters(case)
        assert values["half_box"] > values["mill_radius"] + values["ball_radius"]


def test_every_variable_of_the_decks_is_set(both_kinds):
    decks = "\n".join(path.read_text() for path in (REPOSITORY / "templates").glob("*.in"))
    code = "\n".join(line.partition("#")[0] for line in decks.splitlines())
    used = set(re.findall(r"\$\{(\w+)\}", code)) | set(re.findall(r"\bv_(\w+)", code))
    own = set(re.findall(r"^\s*variable\s+(\w+)", code, re.M))
    assert used, "the decks use no variables"
    assert used - own <= set(parameters(both_kinds[0])) | OF_A_MESH
