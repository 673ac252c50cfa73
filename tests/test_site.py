"""The documentation as a site: it builds without a warning, and opens without a network."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
LOADED = re.compile(r"""<(?:script|img|link rel="stylesheet")[^>]*(?:src|href)="(?:https?:)?//""")


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The site, built by the command of scripts/docs; a broken link or anchor is an error."""
    folder = tmp_path_factory.mktemp("site")
    line = re.search(r"^\.venv/bin/python (-m sphinx .*) build/site$", command(), re.MULTILINE)
    done = subprocess.run(
        [sys.executable, *line[1].split(), folder], cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    return folder


def command():
    return (ROOT / "scripts/docs").read_text()


def test_every_page_has_a_place_in_the_contents(site):
    menu = (site / "README.html").read_text()
    pages = {p.relative_to(ROOT).with_suffix(".html") for p in (ROOT / "docs").rglob("*.md")}
    pages -= {Path("docs/README.html")}
    assert [str(page) for page in pages if f'href="{page}"' not in menu] == []


def test_a_page_loads_nothing_from_the_network(site):
    pages = list(site.rglob("*.html"))
    assert len(pages) > 50
    assert [page.name for page in pages if LOADED.search(page.read_text())] == []


def test_pictures_of_pages_are_part_of_the_site(site):
    for page in site.rglob("*.html"):
        for source in re.findall(r'<img[^>]*src="([^"]+)"', page.read_text()):
            assert (page.parent / source).is_file(), f"{page.name}: {source}"


def test_the_search_knows_the_keys_of_a_campaign(site):
    assert "rotation_angle_rad" in (site / "searchindex.js").read_text()
