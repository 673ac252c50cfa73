"""The JSON schema for editors: current, valid, and neither stricter nor laxer than the loader."""

import json
import tomllib

import jsonschema
import pytest

from millscale.campaign.keys import SECTIONS
from millscale.campaign.schema import campaign_schema, schema_text
from paper_campaign import CAMPAIGNS, MULTI_BALL, REPOSITORY, campaign_text

FILE = REPOSITORY / "docs/reference/campaign.schema.json"
CHECKER = jsonschema.Draft7Validator(campaign_schema())
# Studies and calibrations are no campaigns.
FILES = sorted(
    path for path in CAMPAIGNS.rglob("*.toml") if not path.name.startswith(("study-", "calibrate-"))
)


def mistakes(text):
    return [error.message for error in CHECKER.iter_errors(tomllib.loads(text))]


def test_the_schema_is_a_schema_and_the_file_in_docs_is_current():
    jsonschema.Draft7Validator.check_schema(campaign_schema())
    assert FILE.read_text(encoding="utf-8") == schema_text(), (
        "millscale schema > docs/reference/campaign.schema.json"
    )
    assert json.loads(schema_text())["properties"].keys() >= SECTIONS.keys()


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_shipped_campaign_follows_the_schema_and_names_it_for_editors(path):
    text = path.read_text(encoding="utf-8")
    assert mistakes(text) == []
    directive, _, name = text.splitlines()[0].partition(" ")
    assert directive == "#:schema"
    assert (path.parent / name).resolve() == FILE


@pytest.mark.parametrize(
    "changes",
    [
        {"mill__radius_m": None, "mill__diameter_mm": 7800},
        {"ball__density_kg_m3": None, "ball__density_g_cm3": 2.678},
        {"liner__lifter_top_radius_m": None, "liner__lifter_height_in": 11},
        {"single_ball__step_s": "advised"},
        {"scaling__S": 2.6},
        MULTI_BALL | {"multi_ball__seeds": [1, 2]},
    ],
)
def test_what_the_loader_accepts_follows_the_schema(changes):
    assert mistakes(campaign_text(**changes)) == []


@pytest.mark.parametrize(
    "changes",
    [
        {"mill__radus_m": 3.9},
        {"mill__radius_m": None},
        {"mill__diameter_mm": -1},
        {"mill__diameter_kg": 1},
        {"liners": {"lifters": 3}},
        {"liner__lifters": 25.5},
        {"liner__face_angle_deg": 90.0},
        {"material__poisson_ratio": "0.3"},
        {"single_ball__step_s": "adviced"},
        {"scaling__S": [0.5]},
        {"scaling__schemes": ["constant_gravity"]},
        {"material": None},
        {"single_ball": None},
    ],
)
def test_a_wrong_key_type_word_or_range_breaks_the_schema(changes):
    assert mistakes(campaign_text(**changes))
