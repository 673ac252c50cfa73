"""The notebooks answer their questions on a small run, and are stored without outputs."""

import re
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

import millscale as ms
import small_quick
from paper_campaign import REPOSITORY
from synthetic_mills import SEEDS, charge_case, write_mills

FOLDER = REPOSITORY / "analysis/notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
NAMES = [path.stem for path in NOTEBOOKS]
each = pytest.mark.parametrize("path", NOTEBOOKS, ids=NAMES)
# Pictures that a notebook shows at least, and text of its outputs.
SHOWN = {
    "1_single_ball": (7, ("constant-gravity", "offset-liner")),
    "2_charge": (3, ("contour_error_mean", "mb-cg-paper-S2.600")),
    "3_energy": (4, ("residual", "M g R omega", "Morrell")),
    "4_speed_against_error": (1, ("the study recommends", "millscale study")),
    "5_physical_mill": (2, ("Physical mill: radius 3.9 m", r"[\d.]+ kW, [\d.]+ to [\d.]+ kW")),
    "6_your_own_mill": (2, ("unknown key, nearest is speed_rpm", "sb-cg-paper-S1.500")),
    "7_live": (3, ("1 case to run", "rotation of 1 case", "kW in the whole mill")),
}
LONGEST_CELL_S = 300.0


def cells(path, kind):
    notebook = nbformat.read(path, as_version=4)
    return [cell for cell in notebook.cells if cell.cell_type == kind]


@each
def test_a_notebook_has_no_stored_output(path):
    for cell in cells(path, "code"):
        assert cell.outputs == [] and cell.execution_count is None


@each
def test_a_notebook_opens_with_its_question(path):
    first = nbformat.read(path, as_version=4).cells[0]
    assert first.cell_type == "markdown"
    assert re.match(r"# [^\n]+\?\n", first.source)


def test_the_list_of_the_documentation_is_complete():
    text = (FOLDER / "README.md").read_text(encoding="utf-8")
    titles = {
        path.name: cells(path, "markdown")[0].source.splitlines()[0][2:] for path in NOTEBOOKS
    }
    for name, title in titles.items():
        assert f"| [{name}]({name}) | {title} |" in text
    assert len(titles) == len(SHOWN) == 7


@pytest.fixture(scope="session")
def small_runs(tmp_path_factory):
    """A runs folder of the engine. Read only."""
    folder = tmp_path_factory.mktemp("notebooks") / "runs"
    return ms.run(small_quick.content(), folder, ranks=1, quiet=True).folder


@pytest.fixture(scope="session")
def scaled_mills(tmp_path_factory):
    """A runs folder of made-up steady mills: whether a small real charge is steady is chance."""
    cases = [charge_case(S, seed) for S in (1.696, 2.6) for seed in SEEDS]
    return write_mills(tmp_path_factory.mktemp("mills"), *cases)


@pytest.mark.engine
@each
def test_a_notebook_answers_on_a_small_run(path, small_runs, scaled_mills, monkeypatch, tmp_path):
    pytest.importorskip("ipykernel")
    runs = scaled_mills if path.stem == "5_physical_mill" else small_runs
    monkeypatch.setenv("MILLSCALE_RUNS", str(runs))
    monkeypatch.setenv("MILLSCALE_MINE", str(tmp_path))
    monkeypatch.setenv("PYTHONPATH", str(Path(ms.__file__).parents[1]), prepend=":")
    notebook = nbformat.read(path, as_version=4)
    where = {"metadata": {"path": str(FOLDER)}}
    client = NotebookClient(
        notebook, timeout=LONGEST_CELL_S, kernel_name="python3", resources=where
    )
    client.execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    data = [output.get("data", {}) for output in outputs]
    pictures, wanted = SHOWN[path.stem]
    assert sum("image/png" in x for x in data) >= pictures
    text = "".join(output.get("text", "") for output in outputs)
    text += "".join(str(x.get("text/html", x.get("text/plain", ""))) for x in data)
    for words in wanted:
        assert re.search(words, text), words
    problems = [x.text for x in outputs if x.output_type == "stream" and x.name == "stderr"]
    assert not [x for x in problems if "Warning" in x and "trame" not in x]
