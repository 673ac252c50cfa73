"""Cases that share a settled bed, which is settled once."""

import json
import shutil
import zlib

import pytest
from msgspec.structs import replace

import small_campaign
from millscale.cases.decks import copy_decks
from millscale.cases.generate import generate
from millscale.cases.parameters import write_parameters
from millscale.packing.charge import write_charge
from millscale.runs.case_file import load_case
from millscale.runs.digests import digest_of
from millscale.runs.layout import PROFILE_FILE, STAGES
from millscale.runs.provenance import read_provenance, write_provenance
from millscale.workflow.shared_settling import FOLDER, SharedBed, give, settling_key, take
from millscale.workflow.stage_work import inputs_of
from small_campaign import CHARGE

PRODUCTS = ("settled.restart", "settled.json")
BOTH_SCHEMES = small_campaign.TEXT.replace(
    'schemes = ["constant-gravity"]', 'schemes = ["constant-gravity", "constant-speed"]'
).replace("S = [2.0]\ncount = [50]", "S = [1.0, 2.0]\ncount = [200, 50]")


def prepared(folder, text=BOTH_SCHEMES, runs="runs"):
    """Case folders of the charges, up to the deck stage, by id."""
    (folder / "small.toml").write_text(text)
    folders = {}
    for case in generate(folder / "small.toml", folder / runs):
        if case.kind == "multi-ball":
            folders[case.id] = folder / runs / "cases" / case.id
            copy_decks(("settle.in", "mill.in"), folders[case.id])
            write_parameters(case, folders[case.id])
            write_charge(case, folders[case.id])
    return folders


def key(folder):
    return settling_key(load_case(folder), folder)


def test_a_bed_serves_both_schemes_where_gravity_is_the_same(tmp_path):
    keys = {name: key(folder) for name, folder in prepared(tmp_path).items()}
    assert len(keys) == 4
    assert keys["mb-cg-paper-S1.000"] == keys["mb-cs-paper-S1.000"]
    assert len(set(keys.values())) == 3


@pytest.mark.parametrize(
    "change",
    [
        ("settle_s = 0.1", "settle_s = 0.2"),
        ("count = [200, 50]", "count = [199, 50]"),
        ("count = [200, 50]", "count = [200, 50]\nseeds = [7]"),
        ("static_friction_pp = 0.545", "static_friction_pp = 0.5"),
        ("lifter_top_width_m = 0.06", "lifter_top_width_m = 0.061"),
        ("poisson_ratio = 0.3", "poisson_ratio = 0.29"),
    ],
    ids=lambda change: change[1],
)
def test_every_input_of_the_settling_changes_the_key(tmp_path, change):
    assert change[0] in BOTH_SCHEMES
    name = "mb-cg-paper-S1.000"
    one = key(prepared(tmp_path)[name])
    assert key(prepared(tmp_path, BOTH_SCHEMES.replace(*change), "other")[name]) != one


def test_balls_of_one_packing_on_another_liner_make_another_bed(tmp_path):
    folder = prepared(tmp_path)["mb-cg-paper-S1.000"]
    case, keys = load_case(folder), {key(folder)}
    narrower = replace(case.mill, groove_width_m=0.99 * case.mill.groove_width_m)
    nodes = ((1.38, -0.05, 0.0, 2, 0), (1.45, 0.1, 0.0, 0, 0))
    profiles = [replace(case.mill, profile=((*nodes[0][:4], ahead), nodes[1])) for ahead in (0, 1)]
    for mill in (narrower, *profiles):
        changed = replace(case, mill=mill)
        write_parameters(changed, folder)
        keys.add(settling_key(changed, folder))
    assert len(keys) == 4 and None not in keys


def test_the_engine_reads_the_profile_of_a_liner(tmp_path):
    folder = prepared(tmp_path)["mb-cg-paper-S1.000"]
    for stage in STAGES["multi-ball"]:
        assert PROFILE_FILE not in inputs_of(stage, folder)
    (folder / PROFILE_FILE).write_text("")
    reading = [
        stage.name for stage in STAGES["multi-ball"] if PROFILE_FILE in inputs_of(stage, folder)
    ]
    assert reading == ["settle", "rotate"]


def test_inputs_of_the_rotation_alone_keep_the_key(tmp_path):
    name = "mb-cg-paper-S1.000"
    one = key(prepared(tmp_path)[name])
    longer = BOTH_SCHEMES.replace("rotation_angle_rad = 1.0", "rotation_angle_rad = 2.0")
    assert key(prepared(tmp_path, longer)[name]) == one
    faster = BOTH_SCHEMES.replace("speed_rad_s = 2.0", "speed_rad_s = 1.5")
    assert key(prepared(tmp_path, faster, "other")[name]) == one


def test_decks_edited_by_hand_change_the_key_or_are_not_shared(tmp_path):
    folder = prepared(tmp_path)["mb-cg-paper-S1.000"]
    one = key(folder)
    with (folder / "settle.in").open("a") as deck:
        deck.write("# mine\n")
    assert key(folder) not in (one, None)
    text = (folder / "parameters.in").read_text()
    (folder / "parameters.in").write_text(
        text.replace("gravity_physical string 9.81", "x string 1")
    )
    assert key(folder) is None


KEY = "0123456789abcdef" * 4


@pytest.fixture
def bed(tmp_path):
    """A part folder with a signed bed, an empty part folder and the shared folder."""
    shared, part, other = (tmp_path / name for name in (KEY[:16], "part", "other"))
    for folder in (shared, part, other):
        folder.mkdir()
    signature = f"step 10 bytes 3 crc32 {zlib.crc32(b'bed'):08x}"
    text = f"bed\nmillscale restart {signature} loop_time_s 1.0 processor_time_s 1.0\n"
    (part / "settled.restart").write_text(text)
    return SharedBed(shared, KEY), part, other


def given(shared, part):
    record = {"inputs": {}, "products": {name: digest_of(part / name) for name in PRODUCTS}}
    give(shared, part, PRODUCTS, record)


def test_an_incomplete_bed_is_not_used(bed):
    shared, part, other = bed
    with pytest.raises(FileNotFoundError):
        give(shared, part, PRODUCTS, {})
    assert not take(shared, other, PRODUCTS)
    assert not list(other.iterdir())
    (part / "settled.json").write_text("{}")
    given(shared, part)
    assert take(shared, other, PRODUCTS)
    assert {path.name for path in other.iterdir()} == set(PRODUCTS)


def flip(path):
    content = bytearray(path.read_bytes())
    content[1] ^= 1
    path.write_bytes(content)


def sign_no_more(folder):
    """A bed whose digest fits and whose signature does not."""
    flip(folder / "settled.restart")
    stages = read_provenance(folder)
    stages["settle"]["products"]["settled.restart"] = digest_of(folder / "settled.restart")
    write_provenance(folder, stages)


def other_key(folder):
    stages = read_provenance(folder)
    stages["settle"]["key"] = KEY[:16] + "f" * 48
    write_provenance(folder, stages)


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda x: flip(x / "settled.restart"), "settled.restart does not match its digest"),
        (lambda x: flip(x / "settled.json"), "settled.json does not match its digest"),
        (sign_no_more, "settled.restart is not what was written: its signature differs"),
        (lambda x: (x / "provenance.json").unlink(), "provenance.json has no record of it"),
        (lambda x: (x / "settled.json").unlink(), "settled.json is missing"),
        (other_key, "it was settled from other inputs"),
    ],
    ids=["bit", "bit of json", "signature", "no provenance", "half", "other inputs"],
)
def test_a_changed_bed_is_refused_and_removed(bed, capsys, damage, message):
    shared, part, other = bed
    (part / "settled.json").write_text("{}")
    given(shared, part)
    damage(shared.folder)
    assert not take(shared, other, PRODUCTS)
    assert message in capsys.readouterr().out
    assert not list(other.iterdir())
    assert not {*PRODUCTS, "provenance.json"} & {path.name for path in shared.folder.iterdir()}


def test_a_flipped_bit_of_a_shared_bed_is_found_and_the_bed_settled_anew(finished):
    (shared,) = (finished.runs / FOLDER).iterdir()
    flip(shared / "settled.restart")
    done = finished("verify")
    assert done.returncode == 1
    assert f"{FOLDER}/{shared.name}/settled.restart: settled.restart does not match" in done.stdout
    case = finished.case(CHARGE)
    (case / "settled.restart").unlink()
    before = (case / "log.settle").stat().st_mtime_ns
    assert finished("run").returncode == 0
    assert (case / "log.settle").stat().st_mtime_ns > before, "the engine has not settled anew"
    assert (shared / "settled.restart").read_bytes() == (case / "settled.restart").read_bytes()
    assert "no differences" in finished("verify").stdout


@pytest.mark.parametrize("jobs", ["1", "2"])
def test_cases_that_share_a_bed_settle_it_once(millscale, jobs):
    millscale.file.write_text(BOTH_SCHEMES)
    line = ("--only", "mb-*-S1.000", "--ranks", "1", "--jobs", jobs, "--oversubscribe")
    done = millscale("run", *line, STAND_IN_SECONDS="1")
    assert done.returncode == 0, done.stdout + done.stderr
    folders = [millscale.case(f"mb-{scheme}-paper-S1.000") for scheme in ("cg", "cs")]
    beds = [(folder / "settled.restart").read_text() for folder in folders]
    assert beds[0] == beds[1]
    by = {json.loads((folder / "settled.json").read_text())["settled_by"] for folder in folders}
    assert len(by) == 1
    assert sum((folder / "log.settle").exists() for folder in folders) == 1
    assert len(list((millscale.runs / FOLDER).iterdir())) == 1


def test_a_shared_bed_is_settled_again_if_its_inputs_change(millscale):
    millscale.file.write_text(BOTH_SCHEMES)
    line = ("--only", "mb-*-S1.000", "--ranks", "1", "--jobs", "1")
    assert millscale("run", *line).returncode == 0
    before = millscale.dates()
    assert millscale("run", *line).returncode == 0
    assert millscale.dates() == before
    shutil.rmtree(millscale.runs / FOLDER)
    folder = millscale.case("mb-cs-paper-S1.000")
    (folder / "settled.restart").unlink()
    assert millscale("run", *line).returncode == 0
    assert json.loads((folder / "settled.json").read_text())["settled_by"] == folder.name
