"""Wrong campaign files: one line with the cause and what is accepted, and nothing is written."""

import math
import time
from dataclasses import asdict

import pytest

from millscale.campaign.build import load_campaign
from millscale.cases.case import cases_of, numbers
from millscale.cases.generate import generate
from millscale.errors import CampaignError
from paper_campaign import MULTI_BALL, campaign_text, write_campaign

ROTATION = {"rotation_angle_rad": 1.0, "step_s": 1e-4}

# changes to a valid campaign, key that the error names, part of the cause, part of the remedy
WRONG = {
    "unknown key": (
        {"mill__radus_m": 3.9},
        "mill.radus_m",
        "unknown key, nearest is radius_m",
        "ends, froude, gravity_m_s2, length_m",
    ),
    "unknown section": (
        {"liners": {"lifters": 3}},
        "liners",
        "unknown section, nearest is liner",
        "ball, campaign, liner",
    ),
    "wrong unit": (
        {"ball__radius_kg": 20.0},
        "ball.radius_kg",
        "wrong unit 'kg', nearest is radius_m",
        "radius_m, radius_mm, radius_cm",
    ),
    "wrong unit of speed": (
        {"mill__speed_m_s": 1.0},
        "mill.speed_m_s",
        "wrong unit 'm_s', nearest is speed_rad_s",
        "speed_rpm",
    ),
    "a slip in another spelling": (
        {"ball__diamter_mm": 20.0},
        "ball.diamter_mm",
        "unknown key, nearest is diameter_mm",
        "density_kg_m3, radius_m",
    ),
    "a unit in capitals": (
        {"material__youngs_modulus_GPa": 20.0},
        "material.youngs_modulus_GPa",
        "unknown key, nearest is youngs_modulus_gpa",
        "youngs_modulus_pa",
    ),
    "radius and diameter that contradict": (
        {"mill__diameter_mm": 7810.0},
        "mill.diameter_mm",
        "contradicts radius_m: diameter_mm = 7810.0 is radius_m = 3.905, radius_m = 3.9",
        "one of the two, or values that agree within 0.1%",
    ),
    "two spellings that contradict": (
        {"ball__radius_m": None, "ball__diameter_mm": 40, "ball__radius_cm": 2.1},
        "ball.radius_cm",
        "contradicts diameter_mm: radius_cm = 2.1 is radius_m = 0.021, diameter_mm = 40 is "
        "radius_m = 0.02",
        "one of the two",
    ),
    "lists that contradict": (
        {"scaling__scaled_radius_m": [3.9, 1.5], "scaling__scaled_diameter_mm": [7800, 3010]},
        "scaling.scaled_diameter_mm",
        "contradicts scaled_radius_m: scaled_diameter_mm = [7800, 3010] is scaled_radius_m = "
        "[3.9, 1.505], scaled_radius_m = [3.9, 1.5]",
        "one of the two",
    ),
    "out of range in another unit": (
        {"ball__radius_m": None, "ball__diameter_mm": -40},
        "ball.diameter_mm",
        "got -40",
        "a number > 0",
    ),
    "beyond what a mill has in another unit": (
        {"ball__radius_m": None, "ball__radius_mm": 2e12},
        "ball.radius_mm",
        "beyond what a mill has",
        "0.001 to 1e+09",
    ),
    "lifter height that contradicts": (
        {"liner__lifter_height_mm": 300},
        "liner.lifter_height_mm",
        "as lifter_height_m: contradicts lifter_top_radius_m: 0.3 is 0.3 m of lifter height, "
        "lifter_top_radius_m = 3.61 is 0.29",
        "one of the two",
    ),
    "a lifter as high as the mill": (
        {"liner__lifter_top_radius_m": None, "liner__lifter_height_m": 3.9},
        "liner.lifter_height_m",
        "got 3.9 in a mill of mill.radius_m = 3.9",
        "< 3.9",
    ),
    "account of stock contacts": (
        MULTI_BALL | {"multi_ball__ledger": True, "model__contacts": "stock"},
        "multi_ball.ledger",
        'got true with model.contacts = "stock", which keeps no account of energy',
        'model.contacts = "fast", or ledger = false',
    ),
    "account of a mesh wall": (
        MULTI_BALL | {"multi_ball__ledger": True, "wall__kind": "mesh"},
        "multi_ball.ledger",
        'got true with wall.kind = "mesh"',
        'wall.kind = "analytic"',
    ),
    "impacts of stock contacts": (
        MULTI_BALL | {"multi_ball__impacts": True, "model__contacts": "stock"},
        "multi_ball.impacts",
        'got true with model.contacts = "stock", which records no impacts',
        'model.contacts = "fast", or impacts = false',
    ),
    "missing key": (
        {"ball__density_kg_m3": None},
        "ball.density_kg_m3",
        "missing",
        "a number > 0",
    ),
    "missing section": ({"material": None}, "material", "[material] is missing", "mill"),
    "text for a number": (
        {"mill__radius_m": "3.9"},
        "mill.radius_m",
        'got "3.9"',
        "a number > 0",
    ),
    "flag for a number": ({"mill__length_m": True}, "mill.length_m", "got true", "a number > 0"),
    "number for a count": (
        {"liner__lifters": 25.0},
        "liner.lifters",
        "got 25.0",
        "a whole number >= 0 and <= 1000",
    ),
    "unknown word": (
        {"scaling__schemes": ["constant_gravity"]},
        "scaling.schemes",
        'nearest is "constant-gravity"',
        '"constant-gravity" or "constant-speed" or "froude"',
    ),
    "friction exponent of another policy": (
        MULTI_BALL | {"scaling__friction_exponent": 1.2},
        "scaling.friction_exponent",
        "got 1.2: only policy friction-matched takes one",
        'policies = ["friction-matched"]',
    ),
    "friction exponent out of range": (
        MULTI_BALL
        | {"scaling__friction_exponent": 2.1, "scaling__policies": ["paper", "friction-matched"]},
        "scaling.friction_exponent",
        "got 2.1",
        "a number > 0 and <= 2",
    ),
    "speeds that contradict": (
        {"mill__speed_rpm": 10.0},
        "mill.speed_rpm",
        "contradicts speed_rad_s: 10 is 1.0472 rad/s",
        "agree within 0.1%",
    ),
    "no speed": (
        {"mill__speed_rad_s": None},
        "mill",
        "the speed is missing",
        "speed_rad_s, speed_rpm, period_s, percent_of_critical, froude",
    ),
    "moduli that contradict": (
        {"material__youngs_modulus_pa": 5.9e7},
        "material.youngs_modulus_pa",
        "contradicts shear_modulus_pa",
        "one of the two",
    ),
    "S below one": ({"scaling__S": [0.5]}, "scaling.S", "got 0.5", "a list of numbers >= 1"),
    "scaled radius above the mill's": (
        {"scaling__S": None, "scaling__scaled_radius_m": [4.0]},
        "scaling.scaled_radius_m",
        "4 makes S = 0.975",
        "<= mill.radius_m = 3.9",
    ),
    "radii that contradict S": (
        {"scaling__scaled_radius_m": [3.9, 1.6]},
        "scaling.scaled_radius_m",
        "contradicts S: 1.6 is S = 2.4375",
        "agree within 0.1%",
    ),
    "mill smaller than a ball": (
        {"scaling__S": [200.0]},
        "scaling.S",
        "is not above ball.radius_m",
        "S < 195",
    ),
    "balls too small for the mill": (
        {"ball__radius_m": 1e-3},
        "ball.radius_m",
        "got 0.001 in a mill of 3.9 m",
        ">= 0.00195 and < 3.9",
    ),
    "rpm taken for rad/s": (
        {"mill__speed_rad_s": 9.55},
        "mill.speed_rad_s",
        "the mill centrifuges",
        "allow_centrifuging = true",
    ),
    "lifters above the liner": (
        {"liner__lifter_top_radius_m": 4.0},
        "liner",
        "impossible liner: lifter top radius: must be > 0 and < 3.9 m",
        "",
    ),
    "lifters too wide": (
        {"liner__groove_width_m": 1.2},
        "liner",
        "impossible liner: groove width",
        "",
    ),
    "groove width and face angle": (
        {"liner__face_angle_deg": 9.0},
        "liner.groove_width_m",
        "both given",
        "one of the two",
    ),
    "sloping faces read as parallel": (
        {"liner__reading": "parallel", "liner__face_angle_deg": 9.0},
        "liner.face_angle_deg",
        "contradicts reading",
        'reading = "trapezoid"',
    ),
    "lifter keys of a plain drum": (
        {"liner__lifters": 0},
        "liner.lifter_top_radius_m",
        "plain drum",
        "lifters = 0",
    ),
    "negative time": (
        {"single_ball__rest_s": -1.0},
        "single_ball.rest_s",
        "got -1.0",
        "a number >= 0",
    ),
    "infinite time": (
        {"single_ball__rotation_angle_rad": None, "single_ball__rotation_s": float("inf")},
        "single_ball.rotation_s",
        "got inf",
        "a number > 0",
    ),
    "step beyond the Rayleigh limit": (
        {"single_ball__step_s": 4e-4},
        "single_ball.step_s",
        "55% of the Rayleigh time",
        '<= 0.000293 or "advised"',
    ),
    "neither word nor number": (
        {"single_ball__step_s": "adviced"},
        "single_ball.step_s",
        'nearest is "advised"',
        'a number > 0 or "advised"',
    ),
    "nothing to simulate": ({"single_ball": None}, "", "nothing to simulate", "[single_ball]"),
    "counts that do not match": (
        {"multi_ball": {**MULTI_BALL["multi_ball"], "count": [5]}},
        "multi_ball.count",
        "1 counts for 2 S",
        "one for each S",
    ),
    "count and filling": (
        {"multi_ball": {**MULTI_BALL["multi_ball"], "filling": 0.3}},
        "multi_ball.count",
        "both given",
        "one of the two",
    ),
    "more balls than fit": (
        {"multi_ball": {**ROTATION, "filling": 0.7, "porosity": 0.1}},
        "multi_ball.filling",
        "balls at S = 1",
        "the most an initial packing holds",
    ),
    "a slice longer than the mill": (
        {"multi_ball": {**MULTI_BALL["multi_ball"], "slice_length_m": 0.5}},
        "multi_ball.slice_length_m",
        "longer than the shortest scaled mill",
        "<= 0.384615",
    ),
    "a slice of more diameters than the mill": (
        {"multi_ball": {**MULTI_BALL["multi_ball"], "slice_diameters": 12.5}},
        "multi_ball.slice_diameters",
        "makes 0.5 m, longer than the shortest scaled mill",
        "<= 0.384615",
    ),
    "a slice given twice": (
        {"multi_ball": {**MULTI_BALL["multi_ball"], "slice_diameters": 5, "slice_length_m": 0.2}},
        "multi_ball.slice_length_m",
        "and slice_diameters both given",
        "one of the two",
    ),
    "a term nobody knows": (
        {"model": {"force": ["roling"]}},
        "model.force",
        'nearest is "rolling"',
        '"pair" or "rolling" or "history" or "dumps"',
    ),
    "seeds from an S beyond the models'": (
        {"multi_ball": {**MULTI_BALL["multi_ball"], "seeds": [1, 2], "seeds_from_S": 3.0}},
        "multi_ball.seeds_from_S",
        "got 3, with 2 seeds and S up to 2.6",
        "several seeds",
    ),
    "one seed from some S": (
        {"multi_ball": {**MULTI_BALL["multi_ball"], "seeds_from_S": 2.0}},
        "multi_ball.seeds_from_S",
        "with 1 seeds",
        "several seeds",
    ),
    "a slice thinner than a ball": (
        {"multi_ball": {**MULTI_BALL["multi_ball"], "slice_length_m": 0.03}},
        "mill.length_m",
        "shorter than a ball of 0.04 m",
        "one ball diameter",
    ),
    "froude without time factor": (
        {"scaling__schemes": ["froude"]},
        "scaling.time_factor",
        "missing for scheme froude",
        "one of the two",
    ),
    "time factor without froude": (
        {"scaling__time_factor": 0.5},
        "scaling.time_factor",
        "only scheme froude",
        'schemes = ["froude"]',
    ),
    "cases of the same name": (
        {"scaling__S": [1.3, 1.3001]},
        "scaling.S",
        "two cases are called sb-cg-paper-S1.300",
        "differ by 0.001",
    ),
    "a value twice": ({"scaling__S": [1.3, 1.3]}, "scaling.S", "given twice", "different values"),
    "slivers for panels": (
        {"mill__length_m": 10.0, "wall": {"kind": "mesh", "axial_divisions": 1}},
        "wall.axial_divisions",
        "got 1, S = 1: the folds between chords of a groove, 1.56 degrees, do not lie below",
        "3, or no such key",
    ),
    "too many panels": (
        {"wall": {"kind": "mesh", "chord_error_m": 1e-6, "axial_divisions": 1000}},
        "wall.axial_divisions",
        "triangles at S = 1",
        "fewer axial_divisions",
    ),
    "a chord error of a ball": (
        {"wall": {"chord_error_m": 1e6}},
        "wall.chord_error_m",
        "as large as a ball",
        "< 0.02",
    ),
    "a ball wider than a groove": (
        {"scaling__S": [1.0, 20.0]},
        "scaling.S",
        "got 20, policy paper: balls of 0.04 m do not fit the grooves, 0.03175 m wide",
        "S <= 15.874, or smaller balls",
    ),
    "a ball wider than a groove, corrected": (
        {"scaling__S": [1.0, 20.0], "scaling__policies": ["corrected"]},
        "scaling.S",
        "got 20, policy corrected: balls of 0.04 m do not fit",
        "S <= 15.87",
    ),
    "a largest ball wider than a groove": (
        {
            "multi_ball": {**MULTI_BALL["multi_ball"], "S": [1.0, 15.0], "slice_diameters": 1.5},
            "single_ball": None,
            "ball__radius_std_m": 0.001,
        },
        "scaling.S",
        "got 15, policy paper: balls of 0.044 m do not fit",
        "S <= 14.43",
    ),
    "a sample beyond the rotation": (
        {"single_ball__sample_angle_rad": 250},
        "single_ball.sample_angle_rad",
        "got 250, longer than the rotation of 6 rad",
        "<= 6",
    ),
    "a dump beyond the rotation": (
        {"multi_ball": {**MULTI_BALL["multi_ball"], "dump_angle_rad": 1.5}},
        "multi_ball.dump_angle_rad",
        "got 1.5, longer than the rotation of 1 rad",
        "<= 1",
    ),
    "balls too soft": (
        {"multi_ball": MULTI_BALL["multi_ball"], "material__shear_modulus_pa": 1e5},
        "material.youngs_modulus_pa",
        "at rest balls overlap by 0.57 of their radius on average, at S = 1: 1.06",
        ">= 1.1e+07, which makes it 0.05",
    ),
    "no time to fall": (
        {"multi_ball": {**MULTI_BALL["multi_ball"], "settle_s": 0.02}},
        "multi_ball.settle_s",
        "got 0.02: at S = 1 a ball falls by 0.00196 m meanwhile, 0.098 of its radius",
        ">= 0.064; usual is 0.8",
    ),
    "a number no mill has": (
        {"ball__density_kg_m3": 1e300},
        "ball.density_kg_m3",
        "got 1e+300, beyond what a mill has",
        "0.001 to 1e+06",
    ),
    "a name no folder should have": (
        {"campaign": {"name": "../up"}},
        "campaign.name",
        'got "../up"',
        "lower-case letters",
    ),
}


def refused(folder, text: str | bytes) -> CampaignError:
    """Return the first mistake of a campaign file; assert one line each and that nothing was
    written."""
    path = folder / "wrong.toml"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(CampaignError) as caught:
        generate(path, folder / "runs")
    assert list(folder.iterdir()) == [path]
    mistakes = caught.value.mistakes
    assert str(caught.value).splitlines() == [str(mistake) for mistake in mistakes]
    for mistake in mistakes:
        place = f"{path}:{mistake.line}" if mistake.line else str(path)
        assert str(mistake).startswith(f"{place}: ")
    return mistakes[0]


@pytest.mark.parametrize("name", WRONG)
def test_a_wrong_campaign_is_refused_in_one_line_and_leaves_nothing(name, tmp_path):
    changes, key, cause, accepted = WRONG[name]
    text = campaign_text(**changes).replace("Infinity", "inf")
    error = refused(tmp_path, text)
    assert error.key == key
    assert cause in error.cause
    assert accepted in error.accepted
    assert error.key in str(error)
    assert error.accepted in str(error)


@pytest.mark.parametrize(
    ("content", "cause"),
    [
        (b"[mill\nradius_m = 3.9\n", "not TOML"),
        (b"[mill]\nradius_m = \xff\n", "not UTF-8"),
        (b"x = " + b"[" * 5000 + b"]" * 5000, "not TOML"),
        (b"#" * (2 << 20), "larger than 1048576 bytes"),
        (b"mill = 3\n[ball]\n[material]\n", "got 3"),
    ],
    ids=["syntax", "bytes", "nesting", "size", "not a section"],
)
def test_what_is_not_a_campaign_file_is_refused(content, cause, tmp_path):
    assert cause in refused(tmp_path, content).cause


def typed(old: str, new: str) -> str:
    """Return a valid campaign with `old` replaced by `new`."""
    text = campaign_text(campaign={"name": "typed"})
    assert old in text
    return text.replace(old, new, 1)


def test_a_byte_order_mark_is_read(tmp_path):
    path = tmp_path / "bom.toml"
    path.write_bytes(campaign_text().encode("utf-8-sig"))
    assert load_campaign(path).mill.radius == 3.9


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-16-be", "utf-32"])
def test_wide_characters_are_refused_with_what_to_do(encoding, tmp_path):
    error = refused(tmp_path, campaign_text().encode(encoding))
    assert "UTF-16" in error.cause
    assert "save the file anew with the encoding UTF-8" in error.accepted


def test_a_byte_of_another_encoding_is_refused_with_its_place(tmp_path):
    error = refused(tmp_path, typed('"typed"', '"Mühle"').encode("latin-1"))
    assert "byte 0xfc (at line 29, column 10)" in error.cause
    assert "UTF-8" in error.accepted


@pytest.mark.parametrize(
    ("old", "new", "cause", "accepted"),
    [
        ("= 3.9", "= 3,9", "3,9 (at line 2, column 12), with a decimal comma", "3.9"),
        ("5e-05", "5,5e-5  # s", "5,5e-5 (at line", "5.5e-5"),
        ("5e-05", "5e−05", "minus sign (at line 27, column 12)", "hyphen-minus, -"),
        ("= 6.0", "= –6.0", "en dash (at line", "hyphen-minus, -"),
        ('"typed"', "“typed”", "left double quotation mark (at line", '"'),
        ("= 3.9", "= ３.9", "fullwidth digit three (at line 2, column 12)", "3"),
        ("radius_m =", "radius_m =", "no-break space (at line 2, column 9)", "a plain space"),
        ("[mill]", "​[mill]", "zero width space (at line 1, column 1)", "a plain space"),
    ],
)
def test_characters_of_typesetting_are_refused_with_what_to_write(
    old, new, cause, accepted, tmp_path
):
    error = refused(tmp_path, typed(old, new).encode())
    assert cause in error.cause
    assert accepted in error.accepted


def test_characters_of_typesetting_are_accepted_in_a_comment(tmp_path):
    path = tmp_path / "comment.toml"
    path.write_text("# Mühle – 3,9 m\n" + campaign_text(), encoding="utf-8")
    assert load_campaign(path).mill.radius == 3.9


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(CampaignError, match="no such file"):
        generate(tmp_path / "none.toml", tmp_path / "runs")
    assert list(tmp_path.iterdir()) == []


def test_a_number_too_large_for_a_float_is_refused(tmp_path):
    text = campaign_text().replace("length_m = 1.0", "length_m = 1" + "0" * 400)
    assert "bits" in refused(tmp_path, text).cause


def test_a_list_without_end_is_refused(tmp_path):
    error = refused(tmp_path, campaign_text(scaling__S=[1.0 + 0.01 * i for i in range(10_001)]))
    assert error.accepted == "1 to 10,000 values"


MANY = """\
[mill]
radus_m = 3.9
length_m = "1 m"
speed_rad_s = 1.0

[ball]
diameter_mm = 40
density_g_cm3 = -2.678

[liner]
lifters = 25
face_angle_deg = [
  7,  # of both faces
]

[material]
youngs_modulus_gpa = 0.0598
poisson_ratio = 0.3
restitution_pp = 0.1
restitution_pw = 0.2
static_friction_pp = 0.545
static_friction_pw = 0.5
rolling_friction_pp = 0.01

[multiball]
"""


def test_all_mistakes_of_a_file_are_stated_with_their_lines(tmp_path):
    path = tmp_path / "many.toml"
    path.write_text(MANY)
    with pytest.raises(CampaignError) as caught:
        load_campaign(path)
    found = {(mistake.line, mistake.key) for mistake in caught.value.mistakes}
    assert found == {
        # The misspelt key is not missing besides.
        (2, "mill.radus_m"),
        (3, "mill.length_m"),
        (8, "ball.density_g_cm3"),
        (12, "liner.face_angle_deg"),
        (16, "material.rolling_friction_pw"),
        (25, "multiball"),
        (None, ""),
    }
    lines = str(caught.value).splitlines()
    assert len(lines) == len(found)
    assert lines[1].startswith(f"{path}:3: mill.length_m: length of the mill along")
    assert lines[1].endswith('got "1 m"; accepted: a number > 0')


def test_mistakes_of_sections_that_depend_on_none_are_all_found(tmp_path):
    """Contradictions inside a section are found beside wrong values of another section."""
    changes = {
        "ball__radius_std_m": 0.02,
        "material__youngs_modulus_pa": 1e7,
        "liner__face_angle_deg": 7.0,
        "wall__kind": "meshes",
    }
    path = tmp_path / "several.toml"
    path.write_text(campaign_text(**changes))
    with pytest.raises(CampaignError) as caught:
        load_campaign(path)
    assert {mistake.key for mistake in caught.value.mistakes} == {
        "ball.radius_std_m",
        "material.youngs_modulus_pa",
        "liner.groove_width_m",
        "wall.kind",
    }
    assert all(mistake.line for mistake in caught.value.mistakes)


def test_a_file_of_other_keys_is_refused_quickly(tmp_path):
    path = tmp_path / "others.toml"
    path.write_text("[mill]\n" + "".join(f"key{i} = {i}\n" for i in range(20_000)))
    begin = time.process_time()
    with pytest.raises(CampaignError) as caught:
        load_campaign(path)
    assert time.process_time() - begin < 10.0
    found = [mistake.cause for mistake in caught.value.mistakes if mistake.key.startswith("mill")]
    assert len(found) < 30
    assert "19,980 more unknown keys" in found


def test_a_late_mistake_has_the_line_of_its_key_as_it_is_spelled(tmp_path):
    charge = {**MULTI_BALL["multi_ball"], "settle_ms": 20}
    changes = {"material__shear_modulus_pa": None, "material__youngs_modulus_mpa": 0.26}
    path = tmp_path / "late.toml"
    path.write_text(campaign_text(single_ball=None, multi_ball=charge, **changes))
    lines = path.read_text().splitlines()
    with pytest.raises(CampaignError) as caught:
        cases_of(load_campaign(path))
    found = {mistake.key: mistake for mistake in caught.value.mistakes}
    assert found.keys() == {"multi_ball.settle_ms", "material.youngs_modulus_mpa"}
    assert lines[found["multi_ball.settle_ms"].line - 1] == "settle_ms = 20"
    assert found["multi_ball.settle_ms"].cause.startswith("as settle_s: got 0.02")


def test_a_mill_in_other_units_is_the_same_campaign(tmp_path):
    one, other = tmp_path / "one", tmp_path / "other"
    one.mkdir(), other.mkdir()
    changes = {
        "mill__radius_m": None, "mill__diameter_mm": 7800, "mill__length_m": None,
        "mill__length_cm": 100, "mill__speed_rad_s": None, "mill__speed_deg_s": 180.0 / math.pi,
        "liner__lifter_top_radius_m": None, "liner__lifter_height_mm": 290,
        "liner__lifter_top_width_m": None, "liner__lifter_top_width_mm": 250,
        "ball__radius_m": None, "ball__diameter_mm": 40,
        "ball__density_kg_m3": None, "ball__density_g_cm3": 2.678,
        "material__shear_modulus_pa": None, "material__shear_modulus_mpa": 23,
        "single_ball": {"rotation_angle_deg": 6 * 180.0 / math.pi, "step_us": 50},
        "multi_ball": {"filling_percent": 27, "rotation_angle_rad": 8.0},
    }  # fmt: skip
    first = load_campaign(write_campaign(one, multi_ball={"filling": 0.27, "rotation_s": 8.0}))
    second = load_campaign(write_campaign(other, **changes))
    for part in ("mill", "liner", "ball", "material", "parts"):
        left, right = asdict_of(getattr(first, part)), asdict_of(getattr(second, part))
        assert right == pytest.approx(left, rel=1e-14), part
    # Decimal units make the double that the number in SI would be.
    assert second.mill.radius == 3.9 and second.ball.density == 2678.0


def asdict_of(part):
    """Return the numbers of a part of a campaign by their path."""
    tree = (
        {str(i): asdict(x) for i, x in enumerate(part)} if isinstance(part, tuple) else asdict(part)
    )
    return dict(numbers(tree))
