"""The campaign files shipped, and their reference in docs/reference/campaign-file.md."""

import json
import re

import pytest

from millscale.campaign.build import load_campaign
from millscale.campaign.keys import REQUIRED, SECTIONS, TABLES
from millscale.campaign.units import UNITS
from millscale.workflow.plan import plan_rows
from paper_campaign import CAMPAIGNS, REPOSITORY

REFERENCE = REPOSITORY / "docs/reference/campaign-file.md"
GUIDE = REPOSITORY / "docs/guide/campaigns.md"
# Studies are tested in tests/study, calibrations in tests/calibration.
FILES = sorted(
    (
        path
        for path in CAMPAIGNS.rglob("*.toml")
        if not path.name.startswith(("study-", "calibrate-")) and path.parent.name != "policies"
    ),
    key=lambda path: path.name,
)

UNSEEN = sorted((CAMPAIGNS / "unseen").glob("*.toml"))
POLICIES = sorted((CAMPAIGNS / "policies").glob("*.toml"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_shipped_campaign_is_accepted_named_like_its_file_and_in_the_guide(path):
    campaign = load_campaign(path)
    assert campaign.name == path.stem
    assert f"| `{path.stem}` | {len(plan_rows(campaign))} |" in GUIDE.read_text(encoding="utf-8")


def unmeant(rows):
    """Return the warnings but those of balls softened, or lifters low, on purpose."""
    meant = ("impacts at", "lifters are")
    return [text for row in rows for text in row["warnings"] if not text.startswith(meant)]


@pytest.mark.parametrize("path", UNSEEN, ids=lambda path: path.stem)
def test_an_unseen_mill_is_planned_as_meant_and_its_physical_mill_under_one_policy(path):
    rows = plan_rows(load_campaign(path))
    assert not unmeant(rows)
    assert {row["policy"] for row in rows if row["S"] == 1.0} == {"paper"}
    # Alike in all but the policy, with three seeds of the cheapest scaled mill.
    scaled = {
        policy: [(row["S"], row["seed"], row["balls"]) for row in rows if row["policy"] == policy]
        for policy in ("paper", "friction-matched")
    }
    matched = scaled["friction-matched"]
    assert [row for row in scaled["paper"] if row[0] > 1.0] == matched
    assert [seed for S, seed, _ in matched if matched[-1][0] == S] == [1, 2, 3]


def test_the_unseen_mills_differ_in_size_filling_speed_and_lifters():
    rows = [plan_rows(load_campaign(path))[0] for path in UNSEEN]
    assert len(rows) == 11
    extremes = {
        "radius_m": (0.27, 5.5),
        "percent_of_critical": (55.0, 90.0),
    }
    for key, ends in extremes.items():
        values = [row[key] for row in rows]
        assert (min(values), max(values)) == pytest.approx(ends)
    balls = [1.0 / row["groups"]["ball_radius_over_mill_radius"] for row in rows]
    assert (min(balls), max(balls)) == pytest.approx((12.0, 200.0))
    heights = [row["groups"]["lifter_height_over_ball_diameter"] for row in rows]
    assert (min(heights), max(heights)) == pytest.approx((0.5, 4.0))
    assert sorted(row["scheme"] for row in rows).count("constant-speed") == 3


def test_the_papers_single_ball_campaign_has_six_mills_two_schemes_and_three_policies():
    rows = plan_rows(load_campaign(CAMPAIGNS / "paper-single-ball.toml"))
    paper = [row for row in rows if row["policy"] == "paper"]
    others = [row for row in rows if row["policy"] != "paper"]
    assert len(paper) == 6 * 2
    # The physical mill, S = 1, is the same for every policy.
    assert len(others) == 5 * 2 * 2
    assert all(row["rotation_angle_rad"] == 20.0 for row in rows)
    assert not unmeant(rows)


def test_the_papers_multi_ball_campaign_warns_of_its_step_where_beds_are_deep():
    rows = plan_rows(load_campaign(CAMPAIGNS / "paper-multi-ball.toml"))
    # Three seeds of the two cheapest scaled mills.
    assert len(rows) == (6 + 2 * 2) * 2
    assert all(row["rotation_angle_rad"] == 8.0 for row in rows)
    first = [row for row in rows if row["seed"] == 1]
    # Up to a third above the linear limit, where the measured S = 2.6 mill is accurate.
    assert all(row["limit_fraction"] < 1.4 for row in rows)
    deep = [row for row in first if row["S"] == 1.0]
    assert all("times the damping limit" in row["warnings"][0] for row in deep)


def test_equal_filling_is_the_physical_count_over_s_cubed_in_the_same_mill():
    equal = load_campaign(CAMPAIGNS / "multi-ball-equal-filling.toml")
    paper = load_campaign(CAMPAIGNS / "paper-multi-ball.toml")
    for part in ("mill", "liner", "ball", "material", "wall"):
        assert getattr(equal, part) == getattr(paper, part)
    rows = plan_rows(equal)
    assert {row["S"] for row in rows} == {1.3, 1.696, 2.6}
    assert all(row["balls"] == round(231461 / row["S"] ** 3) for row in rows)
    assert sorted({row["seed"] for row in rows if row["S"] > 1.5}) == [1, 2, 3]


def test_the_physical_mill_is_that_of_the_paper_and_turns_for_20_s():
    physical = load_campaign(CAMPAIGNS / "physical-mill.toml")
    paper = load_campaign(CAMPAIGNS / "paper-multi-ball.toml")
    for part in ("mill", "liner", "ball", "material", "wall"):
        assert getattr(physical, part) == getattr(paper, part)
    (row,) = plan_rows(physical)
    (same,) = (r for r in plan_rows(paper) if r["id"] == "mb-cg-paper-S1.000-seed1")
    for key in ("balls", "time_step_s", "S", "scheme"):
        assert row[key] == same[key]
    assert row["rotation_angle_rad"] == 20.0 and row["omega_rad_s"] == 1.0


def test_the_quick_campaign_holds_both_kinds_and_both_schemes_and_takes_minutes():
    rows = plan_rows(load_campaign(CAMPAIGNS / "quick.toml"))
    kinds = {(row["kind"], row["scheme"]) for row in rows}
    assert len(kinds) == 4
    single = sum(r["predicted_wall_time_s"] for r in rows if r["kind"] == "single-ball")
    multi = sum(r["predicted_wall_time_s"] for r in rows if r["kind"] == "multi-ball")
    # Single balls two at a time, charges on both cores.
    assert single / 2.0 + multi < 5 * 60.0


def test_the_example_of_the_reference_is_accepted(tmp_path):
    text = REFERENCE.read_text(encoding="utf-8")
    path = tmp_path / "example.toml"
    path.write_text(text.partition("```toml\n")[2].partition("```")[0])
    assert len(plan_rows(load_campaign(path))) == 4


def test_the_reference_lists_the_units_that_the_loader_converts():
    text = REFERENCE.read_text(encoding="utf-8").partition("## Units")[2].partition("\n## ")[0]
    listed = [set(re.findall(r"`(_\w+)`", line)) for line in text.splitlines() if "`_" in line]
    dimensions = {key: unit.dimension for key, unit in UNITS.items()}
    for units in listed:
        (dimension,) = {dimensions[unit] for unit in units}
        assert units == {unit for unit in UNITS if dimensions[unit] == dimension}
    # Without the units of one spelling, and the velocity, which no key has.
    others = {"acceleration", "velocity", "share"}
    assert len(listed) == len(set(dimensions.values()) - others)


def reference_rows(keys):
    """Return the rows of the table of a section."""
    for name, key in keys.items():
        accepted = key.accepted().replace("|", "\\|")
        yield f"| `{name}` | {key.meaning} | {accepted} | {default_of(key)} |"


def default_of(key):
    """Return the default of a key as TOML writes it."""
    if key.default is None:
        return ""
    if isinstance(key.default, tuple):
        return json.dumps(list(key.default))
    if isinstance(key.default, float):
        return f"{key.default:g}"
    return "required" if key.default is REQUIRED else json.dumps(key.default)


@pytest.mark.parametrize(
    ("title", "keys"),
    [(f"## [{name}]", keys) for name, keys in SECTIONS.items()]
    + [(f"## [[{name}]]", table.keys) for name, table in TABLES.items()],
)
def test_the_reference_has_the_table_of_a_section(title, keys):
    text = REFERENCE.read_text(encoding="utf-8")
    assert title in text
    part = text.partition(f"{title}\n")[2].partition("\n## ")[0]
    rows = [line for line in part.splitlines() if line.startswith("| `")]
    assert rows == list(reference_rows(keys))


@pytest.mark.parametrize("path", POLICIES, ids=lambda path: path.stem)
def test_a_mill_with_both_policies_is_the_unseen_mill_of_its_name(path):
    campaign = load_campaign(path)
    unseen = load_campaign(CAMPAIGNS / "unseen" / path.name.replace("-policies", ""))
    assert campaign.name == path.stem
    assert (campaign.mill, campaign.liner, campaign.ball, campaign.material) == (
        unseen.mill,
        unseen.liner,
        unseen.ball,
        unseen.material,
    )
    assert len(plan_rows(campaign)) == 4 * 2 * 2 * 3
