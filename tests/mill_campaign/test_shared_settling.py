"""Which cases share a settled bed, and that it is settled once."""

import json
import shutil

import pytest
import small_campaign

from mill_campaign.charge import write_charge
from mill_campaign.decks import copy_decks
from mill_campaign.generate import generate
from mill_campaign.parameters import write_parameters
from mill_campaign.shared_settling import FOLDER, give, settling_key, take

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
    return settling_key(json.loads((folder / "case.json").read_text()), folder)


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
def test_whatever_decides_the_settling_makes_another_bed(tmp_path, change):
    assert change[0] in BOTH_SCHEMES
    name = "mb-cg-paper-S1.000"
    one = key(prepared(tmp_path)[name])
    assert key(prepared(tmp_path, BOTH_SCHEMES.replace(*change), "other")[name]) != one


def test_what_only_the_rotation_knows_leaves_the_bed(tmp_path):
    name = "mb-cg-paper-S1.000"
    one = key(prepared(tmp_path)[name])
    longer = BOTH_SCHEMES.replace("rotation_angle_rad = 1.0", "rotation_angle_rad = 2.0")
    assert key(prepared(tmp_path, longer)[name]) == one
    faster = BOTH_SCHEMES.replace("speed_rad_s = 2.0", "speed_rad_s = 1.5")
    assert key(prepared(tmp_path, faster, "other")[name]) == one


def test_what_was_edited_by_hand_is_not_shared_unseen(tmp_path):
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


def test_half_a_bed_is_not_taken(tmp_path):
    shared, part, other = (tmp_path / name for name in ("shared", "part", "other"))
    for folder in (shared, part, other):
        folder.mkdir()
    (part / "settled.restart").write_text("bed")
    with pytest.raises(FileNotFoundError):
        give(shared, part, PRODUCTS)
    assert not take(shared, other, PRODUCTS)
    assert not list(other.iterdir())
    (part / "settled.json").write_text("{}")
    give(shared, part, PRODUCTS)
    assert take(shared, other, PRODUCTS)
    assert {path.name for path in other.iterdir()} == set(PRODUCTS)


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


def test_a_bed_taken_is_settled_again_when_its_own_inputs_change(millscale):
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
