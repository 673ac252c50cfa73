"""Figures for papers: SVG and PDF of a stated width, with text as text."""

import json
import re
import shutil
import subprocess

import pytest
from matplotlib.figure import Figure

from in_process import millscale
from millscale.analysis.forked import forked
from millscale.report.images import save_image
from millscale.report.vectors import RECORD, figures_written
from millscale.runs.untrusted import RunFolderError

LABEL = "torque / M g R"


def drawn(name, to):
    figure = Figure(figsize=(7.6, 5.0), layout="constrained")
    axes = figure.add_subplot()
    axes.plot([0, 1], [0, 1])
    axes.set_ylabel(LABEL, fontsize=9.5)
    return save_image(figure, to / f"{name}.png", f"caption of {name}")


@pytest.fixture(params=[190.0, 90.0])
def folder(request, tmp_path):
    """Return a folder of figures that forked processes drew, and their width."""
    to = tmp_path / "figures"
    with figures_written(to, request.param):
        forked(lambda name: drawn(name, tmp_path), ["one", "two"])
    drawn("later", tmp_path)
    return to, request.param


def test_figures_of_all_processes_have_the_width_and_stay_text(folder):
    to, width = folder
    names = [f"{name}.{kind}" for name in ("one", "two") for kind in ("pdf", "svg")]
    assert json.loads((to / RECORD).read_text())["files"] == names
    assert sorted(path.name for path in to.iterdir()) == sorted([*names, RECORD])
    svg = (to / "one.svg").read_text()
    points = float(re.search(r'width="([\d.]+)pt"', svg)[1])
    assert points == pytest.approx(width * 72.0 / 25.4, rel=1e-4)
    assert f">{LABEL}</text>" in svg and "caption of one" in svg
    size = float(re.search(r"font(?:-size)?: ([\d.]+)px[^>]*>torque", svg)[1])
    assert size == pytest.approx(9.5 * (0.8 if width == 90.0 else 190.0 / (7.6 * 25.4)))


@pytest.mark.skipif(shutil.which("pdffonts") is None, reason="poppler-utils is not installed")
def test_fonts_of_a_pdf_are_embedded_truetype(folder):
    to, width = folder
    fonts = subprocess.run(["pdffonts", to / "one.pdf"], capture_output=True, text=True).stdout
    rows = fonts.splitlines()[2:]
    assert rows and all("TrueType" in row and " yes " in row for row in rows)
    about = subprocess.run(["pdfinfo", to / "one.pdf"], capture_output=True, text=True).stdout
    page = float(re.search(r"Page size: +([\d.]+)", about)[1])
    assert page == pytest.approx(width * 72.0 / 25.4, rel=1e-4)
    assert "caption of one" in about


def test_another_folder_is_kept(tmp_path):
    (tmp_path / "letter").write_text("dear")
    with (
        pytest.raises(RunFolderError, match="holds no figures of an earlier report"),
        figures_written(tmp_path),
    ):
        pytest.fail("begun")
    assert (tmp_path / "letter").read_text() == "dear"


def test_an_earlier_folder_is_replaced_only_when_the_new_one_is_whole(folder, tmp_path):
    to, _ = folder
    with pytest.raises(ZeroDivisionError), figures_written(to):
        raise ZeroDivisionError
    assert (to / "one.svg").is_file()
    with figures_written(to):
        drawn("other", tmp_path)
    assert sorted(path.stem for path in to.glob("*.svg")) == ["other"]


def test_the_command_writes_every_figure_of_the_report(throws, tmp_path):
    copy, to = tmp_path / "runs", tmp_path / "figures"
    shutil.copytree(throws, copy)
    done = millscale("report", copy, "--figures", to, "--width", "120")
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == f"figures: {to}"
    names = {path.stem for path in to.glob("*.svg")}
    assert names == {path.stem for path in to.glob("*.pdf")}
    assert {"charges", "fig11-constant-gravity", "speed-against-error"} <= names
    assert names <= {path.stem for path in (copy / "report").glob("*.png")}
    refused = millscale("report", copy, "--figures", to, "--width", "10")
    assert "--width: got 10; accepted: 60 to 500 mm" in refused.stderr
