"""The notebook runs on a campaign and shows its figures."""

from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

import millscale

NOTEBOOK = Path(__file__).parents[2] / "analysis/notebooks/single_ball.ipynb"


def test_notebook_has_no_stored_output():
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    assert all(not cell.get("outputs") for cell in notebook.cells)


def test_notebook_shows_figures_6_to_8(runs, monkeypatch):
    pytest.importorskip("ipykernel")
    monkeypatch.setenv("MILLSCALE_RUNS", str(runs))
    monkeypatch.setenv("PYTHONPATH", str(Path(millscale.__file__).parents[1]), prepend=":")
    notebook = nbformat.read(NOTEBOOK, as_version=4)
    NotebookClient(notebook, timeout=120, kernel_name="python3").execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    images = [output for output in outputs if "image/png" in output.get("data", {})]
    assert len(images) >= 5
    text = "".join(output.get("text", "") for output in outputs)
    assert "constant-gravity" in text
