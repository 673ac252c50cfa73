"""Campaigns at the limits of their keys are planned, or refused in one line, and quickly."""

import json
import math
import random
import time
from pathlib import Path

import pytest

from millscale.campaign.build import campaign_of, load_campaign
from millscale.campaign.keys import KINDS, SECTIONS, Key, size_range
from millscale.errors import CampaignError
from millscale.workflow.plan import plan_rows
from millscale.workflow.plan_display import render_plan
from paper_campaign import BASE, MULTI_BALL, campaign_text

# For a key that is set to a limit: the keys that state the same quantity.
SPEEDS = {"speed_rad_s", "speed_rpm", "period_s", "percent_of_critical", "froude"}
INSTEAD = [
    ("mill", SPEEDS),
    ("material", {"shear_modulus_pa", "youngs_modulus_pa"}),
    ("multi_ball", {"count", "filling"}),
    ("liner", {"lifter_top_radius_m", "lifter_height_m"}),
    *((kind, {"rotation_angle_rad", "revolutions", "rotation_s"}) for kind in KINDS),
]
MOST_SECONDS = 2.0


def an_end(name: str, key: Key, chance: random.Random):
    """Return a value of a key: the smallest, the largest, or any between them."""
    if key.choices and (key.type == "text" or chance.random() < 0.2):
        value = chance.choice(key.choices)
    elif key.type in ("flag", "text"):
        return chance.random() < 0.5 if key.type == "flag" else "text"
    else:
        smallest, largest = size_range(name)
        least, most = max(smallest, key.least or 0.0), min(largest, key.most or largest)
        between = 10.0 ** chance.uniform(math.log10(least), math.log10(most))
        value = chance.choice([least, most, min(max(between, least), most)])
        if key.least is not None and key.least <= 0.0 and chance.random() < 0.3:
            value = chance.choice([0.0, key.least])
        value = max(round(value), key.least or 0) if key.type == "integer" else value
    return [value] if key.many else value


def a_campaign(chance: random.Random) -> dict:
    """Return the paper's mill with some keys at their limits."""
    tree = {name: dict(content) for name, content in (BASE | MULTI_BALL).items()}
    if chance.random() < 0.6:
        del tree[chance.choice(list(KINDS))]
    for _ in range(chance.choice([1, 1, 2, 3, 6])):
        section = chance.choice([x for x in SECTIONS if x in tree or x not in KINDS])
        name = chance.choice(list(SECTIONS[section]))
        content = tree.setdefault(section, {})
        for where, same in INSTEAD:
            if where == section and name in same:
                tree[section] = content = {k: v for k, v in content.items() if k not in same}
        content[name] = an_end(name, SECTIONS[section][name], chance)
    if "froude" in tree["scaling"].get("schemes", ()):
        key = chance.choice(["time_factor", "time_exponent"])
        tree["scaling"].setdefault(key, an_end(key, SECTIONS["scaling"][key], chance))
    return tree


def is_planned(tree: dict) -> bool:
    """Return whether a campaign is planned in finite numbers; if not, assert a line for each
    mistake."""
    try:
        campaign = campaign_of(Path("ends.toml"), tree)
        rows = plan_rows(campaign)
    except CampaignError as error:
        lines = str(error).splitlines()
        assert len(lines) == len(error.mistakes)
        assert all(line.startswith("ends.toml: ") for line in lines)
        return False
    json.dumps(rows, allow_nan=False)
    render_plan(campaign, rows)
    return True


@pytest.mark.parametrize(
    "first", [0, pytest.param(1, marks=pytest.mark.validate)], ids=["few", "many"]
)
def test_campaigns_at_the_ends_are_planned_or_refused_in_one_line(first):
    seeds = range(300) if first == 0 else range(300, 10_000)
    planned = 0
    for seed in seeds:
        tree = a_campaign(random.Random(seed))
        begin = time.process_time()
        try:
            planned += is_planned(tree)
        except Exception as error:
            raise AssertionError(f"seed {seed}: {json.dumps(tree)}") from error
        assert time.process_time() - begin < MOST_SECONDS, f"seed {seed}: {json.dumps(tree)}"
    # Both outcomes occur.
    assert 0.2 * len(seeds) < planned < 0.8 * len(seeds)


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"scaling__schemes": ["froude"], "scaling__time_factor": 1e200}, "scaling.time_factor"),
        ({"scaling__schemes": ["froude"], "scaling__time_factor": 1e-200}, "scaling.time_factor"),
        ({"ball__density_kg_m3": 1e300}, "ball.density_kg_m3"),
        ({"mill__speed_rad_s": 1e-320}, "mill.speed_rad_s"),
        ({"mill__gravity_m_s2": 1e-300}, "mill.gravity_m_s2"),
        ({"mill__radius_m": 1e200}, "mill.radius_m"),
        ({"material__shear_modulus_pa": 1e-300}, "material.shear_modulus_pa"),
        ({"wall": {"chord_error_m": 1e6}}, "wall.chord_error_m"),
        ({"single_ball__step_s": 1e-300}, "single_ball.step_s"),
        ({"single_ball__rotation_angle_rad": 1e300}, "single_ball.rotation_angle_rad"),
    ],
)
def test_a_size_that_no_mill_has_is_refused_with_its_key(tmp_path, changes, key):
    path = tmp_path / "ends.toml"
    path.write_text(campaign_text(**changes), encoding="utf-8")
    with pytest.raises(CampaignError) as refused:
        plan_rows(load_campaign(path))
    assert refused.value.key == key


def test_every_size_of_a_default_or_the_papers_mill_is_accepted():
    for section, keys in SECTIONS.items():
        for name, key in keys.items():
            value = {**BASE, **MULTI_BALL}.get(section, {}).get(name, key.default)
            if isinstance(value, float):
                smallest, largest = size_range(name)
                assert value == 0.0 or smallest <= value <= largest
