"""The drawings of docs/guide/liners.md are those of the presets.

    python tests/liner/test_liner_pictures.py

writes them.
"""

import math
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from millscale import _core
from millscale.liner.given import ANGLES, PRESETS, Preset, liner_of_preset, liner_of_rows
from millscale.liner.lifter_rows import LifterRow
from millscale.liner.picture import svg

GUIDE = Path(__file__).parents[2] / "docs" / "guide"
R = 4.0
HERE = Path("liners.md")


def preset(family):
    leading, trailing = ANGLES.get(family, (0.0, 0.0))
    if family == "step":
        leading = math.radians(10.0)
    lifters = {"plain": 0, "wave": 24, "step": 20}.get(family, 18)
    numbers = Preset(family, lifters, 0.24, 0.3, leading, trailing, 0.03)
    return liner_of_preset(HERE, R, numbers, 0.0).shape


def liners():
    """Return every drawn liner by the name of its file."""
    found = {name: preset(name) for name in PRESETS}
    rows = (LifterRow(0.3, 0.2, 0.3, 0.3), LifterRow(0.14, 0.2, 0.5, 0.5, 0.03))
    found["rows"] = liner_of_rows(HERE, R, rows, 24, 0.0).shape
    return found


def texts():
    return {f"liner-{name}.svg": svg(liner, f"liner {name}") for name, liner in liners().items()}


@pytest.mark.parametrize("name", texts())
def test_the_drawing_is_current_and_on_the_page(name):
    assert (GUIDE / name).read_text(encoding="utf-8") == texts()[name], (
        "python tests/liner/test_liner_pictures.py"
    )
    assert f"({name})" in (GUIDE / "liners.md").read_text(encoding="utf-8")


def test_a_drawing_shows_the_bottom_of_the_liner():
    text = svg(_core.Lifters(R, 3.7, 0.3, 0.6, 18), "t")
    root = ET.fromstring(text)
    height = float(root.get("height"))
    polygon = next(x for x in root if x.tag.endswith("polygon"))
    ys = [float(pair.split(",")[1]) for pair in polygon.get("points").split()]
    assert max(ys) == pytest.approx(height - 8.0, abs=0.6)  # height: whole pixels


if __name__ == "__main__":
    for name, text in texts().items():
        (GUIDE / name).write_text(text, encoding="utf-8")
