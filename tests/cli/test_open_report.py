"""`millscale open`: which page it shows, and where."""

import os
import webbrowser

import pytest

from in_process import millscale


@pytest.fixture
def opened(monkeypatch):
    """Addresses that were opened."""
    found = []
    monkeypatch.setattr(webbrowser, "open", found.append)
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    return found


@pytest.fixture
def pages(tmp_path, monkeypatch):
    """Two runs folders with a report, the second written last."""
    monkeypatch.chdir(tmp_path)
    made = []
    for age, name in ((20, "old"), (10, "new")):
        page = tmp_path / "runs" / name / "report/index.html"
        page.parent.mkdir(parents=True)
        page.write_text("<html></html>")
        os.utime(page, (1e9 - age, 1e9 - age))
        made.append(page)
    return made


def test_without_a_display_the_path_is_printed(pages, opened):
    done = millscale("open", "runs/old")
    assert (done.stdout, done.returncode) == ("runs/old/report/index.html\n", 0)
    assert opened == []


def test_with_a_display_the_browser_shows_it(pages, opened):
    old, new = pages
    assert millscale("open", "runs/old", DISPLAY=":0").returncode == 0
    assert millscale("open", DISPLAY=":0").stdout == "runs/new/report/index.html\n"
    assert millscale("open", old, WAYLAND_DISPLAY="wayland-0").returncode == 0
    assert opened == [page.as_uri() for page in (old, new, old)]


def test_a_folder_without_report_names_the_command(pages, opened, tmp_path):
    (tmp_path / "runs/empty").mkdir()
    assert "make it with: millscale report runs/empty" in millscale("open", "runs/empty").stderr
    done = millscale("open", "elsewhere")
    assert done.returncode == 2 and "no report in it" in done.stderr
