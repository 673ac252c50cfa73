"""Lines of the keys of a TOML text."""

import tomllib

import pytest

from millscale.campaign.lines import key_lines
from paper_campaign import CAMPAIGNS

TEXT = """\
name = "[not]" # = a comment
[ mill ] # [ball]
radius_m = 3.9
"length_m" = 1.0
text = '''
[ball]
radius_m = 1
'''
list = [ # a list
  1, 2, # [x]
  "]",
]
about = \"\"\"a "quoted"
[word]\"\"\"

[[ball.class]]
radius_m = 1
[[ball.class]]
radius_m = 2
share = 0.5
[a."b c".d]
e.f = {x = 1, y = [
  2]}
last = "a \\" [ = #"
"""


def test_every_statement_has_its_line():
    tomllib.loads(TEXT)
    assert key_lines(TEXT) == {
        "name": 1,
        "mill": 2,
        "mill.radius_m": 3,
        "mill.length_m": 4,
        "mill.text": 5,
        "mill.list": 9,
        "mill.about": 13,
        "ball.class": 16,
        "ball.class[1]": 16,
        "ball.class[1].radius_m": 17,
        "ball.class[2]": 18,
        "ball.class[2].radius_m": 19,
        "ball.class[2].share": 20,
        "a.b c.d": 21,
        "a.b c.d.e.f": 22,
        "a.b c.d.last": 24,
    }


@pytest.mark.parametrize("path", sorted(CAMPAIGNS.rglob("*.toml")), ids=lambda path: path.stem)
def test_every_key_of_a_shipped_campaign_is_found_on_its_line(path):
    text = path.read_text(encoding="utf-8")
    lines = text.splitlines()
    found = key_lines(text)
    for section, content in tomllib.loads(text).items():
        for key in content if isinstance(content, dict) else ():
            where = f"{section}.{key}"
            if where in found:
                begin = (key, f"{section}.{key}", f"[[{section}.{key}]]")
                assert lines[found[where] - 1].startswith(begin)
            else:
                # A dotted key of a study file.
                assert any(name.startswith(where) for name in found)
