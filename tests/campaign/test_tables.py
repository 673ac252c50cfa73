"""Arrays of tables: declared in a few lines, then read, located, respelled and written."""

import tomllib

import pytest

from millscale.campaign import keys, reader
from millscale.campaign.build import load_campaign
from millscale.campaign.keys import REQUIRED, Key, Table
from millscale.campaign.writer import toml_text
from millscale.errors import CampaignError, Mistakes
from paper_campaign import campaign_text

CLASS = Table(
    "balls of one size",
    {
        "radius_m": Key("number", "radius", REQUIRED, above=0.0),
        "share": Key("number", "of the mass", 1.0, above=0.0, most=1.0),
    },
    most=3,
)
SPEED = Table("speed from an angle on", {"from_rad": Key("number", "angle", REQUIRED)})


@pytest.fixture(autouse=True)
def declared(monkeypatch):
    monkeypatch.setitem(keys.TABLES, "ball.class", CLASS)
    monkeypatch.setitem(keys.TABLES, "speed", SPEED)


def read(path, tail):
    path.write_text(campaign_text() + tail)
    mistakes = Mistakes()
    sections = reader.checked_sections(path, reader.parse_toml(path), mistakes)
    mistakes.raise_all()
    return sections


def test_entries_are_read_in_the_units_of_their_keys_with_defaults(tmp_path):
    tail = "[[ball.class]]\ndiameter_mm = 40\nshare_percent = 30\n"
    tail += "[[ball.class]]\nradius_m = 0.03\n"
    sections = read(tmp_path / "a.toml", tail + "[[speed]]\nfrom_deg = 180\n")
    assert sections["ball"]["class"] == (
        {"radius_m": 0.02, "share": 0.3},
        {"radius_m": 0.03, "share": 1.0},
    )
    assert sections["speed"] == ({"from_rad": pytest.approx(3.14159265)},)


def test_a_campaign_without_entries_has_none(tmp_path):
    sections = read(tmp_path / "a.toml", "")
    assert sections["ball"]["class"] == () and sections["speed"] == ()


@pytest.mark.parametrize(
    ("tail", "line", "key", "cause"),
    [
        ("[[ball.class]]\nradius_m = 1\n[[ball.class]]\nradius_m = 0\n", 4,
         "ball.class[2].radius_m", "radius: got 0"),
        ("[[ball.class]]\n", 1, "ball.class[1].radius_m", "missing"),
        ("[[ball.class]]\nradius_m = 1\nshare_percent = 130\n", 3,
         "ball.class[1].share_percent", "of the mass: got 130"),
        ("[[ball.clas]]\nradius_m = 1\n", 1, "ball.clas", "unknown key, nearest is class"),
        ("[[speed]]\nform_rad = 1\nfrom_rad = 2\n", 2, "speed[1].form_rad",
         "unknown key, nearest is from_rad"),
        ("[speed]\nfrom_rad = 2\n", 1, "speed", "speed from an angle on: got"),
        ("[[ball.class]]\nradius_m = 1\n" * 4, 1, "ball.class", "balls of one size: got 4"),
        ("[[sped]]\nfrom_rad = 2\n", 1, "sped", "unknown section, nearest is speed"),
    ],
)  # fmt: skip
def test_a_mistake_in_an_entry_has_its_number_and_line(tmp_path, tail, line, key, cause):
    path, before = tmp_path / "a.toml", campaign_text()
    path.write_text(before + tail)
    with pytest.raises(CampaignError) as caught:
        load_campaign(path)
    (mistake,) = caught.value.mistakes
    assert (mistake.line, mistake.key) == (before.count("\n") + line, key)
    assert mistake.cause.startswith(cause)


def test_a_tree_with_declared_keys_is_written_and_read_again(tmp_path):
    path = tmp_path / "a.toml"
    tail = "[[ball.class]]\ndiameter_mm = 40\n[[ball.class]]\nradius_m = 0.03\n"
    path.write_text(campaign_text(mill__radius_m=None, mill__diameter_m=7.8) + tail)
    tree = reader.campaign_tree(path)
    assert tree["mill"]["radius_m"] == 3.9 and "diameter_m" not in tree["mill"]
    assert tree["ball"]["class"] == [{"radius_m": 0.02}, {"radius_m": 0.03}]
    assert tomllib.loads(toml_text(tree)) == tree
