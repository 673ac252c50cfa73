"""The report as PDF."""

import re
import shutil
import subprocess

import pytest
from PIL import Image

from in_process import millscale
from millscale.report import images as report_figures
from millscale.report.printed import VARIABLE, print_page
from millscale.runs.untrusted import RunFolderError

CHROMIUM = shutil.which("chromium")
needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")
MOST_PAGES = 15


def one_picture(folder, mill_angles, to):
    """In place of the drawing, which has its own tests."""
    path = to / f"{folder.name}.png"
    Image.new("RGB", (40, 40), "red").save(path)
    return [(path, mill_angles[-1])]


@pytest.fixture(scope="module")
def printed(runs, tmp_path_factory):
    copy = tmp_path_factory.mktemp("printed") / "runs"
    shutil.copytree(runs, copy)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report_figures, "DPI", 60)
        patch.setattr(report_figures, "draw_pictures", one_picture)
        done = millscale("report", copy, "--pdf")
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == f"print: {copy / 'report/report.pdf'}"
    return copy / "report/report.pdf"


def texts(pdf):
    """Return the text of each page."""
    line = ["pdftotext", "-layout", pdf, "-"]
    found = subprocess.run(line, capture_output=True, text=True, check=True).stdout
    return found.split("\f")[:-1]


@needs_chromium
def test_the_print_is_short_without_blank_pages_and_opens_what_is_folded(printed):
    pages = texts(printed)
    assert 1 < len(pages) <= MOST_PAGES
    assert all(page.strip() for page in pages)
    text = " ".join(" ".join(pages).split())
    assert "policy offset-liner" in text and "balls on the wall" in text  # folded on the screen


@needs_chromium
def test_no_column_of_a_table_is_cut(printed):
    """The last heading of the widest tables, with its last row, is inside the page."""
    line = ["pdftotext", "-bbox", printed, "-"]
    words = subprocess.run(line, capture_output=True, text=True, check=True).stdout
    width = float(re.search(r'<page width="([\d.]+)"', words)[1])
    ends = [float(x) for x in re.findall(r'xMax="([\d.]+)"', words)]
    assert max(ends) < width
    assert "critical" in words


@pytest.mark.parametrize(
    ("path", "named", "message"),
    [
        ("/nowhere", "", "no Chromium to print it with; install it (apt-get install chromium)"),
        ("/nowhere", "opera", f"{VARIABLE}=opera is no program; install it"),
        (None, "true", "true wrote no PDF: exit code 0; install it"),
    ],
)
def test_without_a_browser_the_remedy_is_named(tmp_path, monkeypatch, path, named, message):
    if path:
        monkeypatch.setenv("PATH", path)
    monkeypatch.setenv(VARIABLE, named)
    (tmp_path / "index.html").write_text("<p>page")
    with pytest.raises(RunFolderError) as error:
        print_page(tmp_path / "index.html", tmp_path / "report.pdf")
    assert message in str(error.value)
    assert not (tmp_path / "report.pdf").exists()
