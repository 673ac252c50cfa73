"""`import millscale as ms`: functions, text and HTML of a prediction, the example of the guide."""

import re
import subprocess
import sys

import pytest

import millscale as ms
from millscale.errors import PredictionError
from millscale.prediction.result import Prediction
from millscale.prediction.text import aligned, html_table
from paper_campaign import CAMPAIGNS, REPOSITORY
from synthetic_mills import SEEDS, charge_case, write_mills

GUIDE = REPOSITORY / "docs/guide/predict.md"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with runs/slices: S = 1, 1.696 and 2.6, two seeds each. Read only."""
    root = tmp_path_factory.mktemp("api")
    cases = [charge_case(S, seed) for S in (1.0, 1.696, 2.6) for seed in SEEDS]
    write_mills(root / "runs" / "slices", *cases)
    (root / "campaigns").symlink_to(CAMPAIGNS)
    return root


@pytest.fixture(scope="module")
def prediction(folder):
    return ms.predict(folder / "runs" / "slices", check=True)


def test_a_folder_is_a_text_a_path_or_several(folder, prediction):
    runs = folder / "runs" / "slices"
    assert isinstance(prediction, Prediction)
    value = prediction["power"].value
    assert ms.predict(str(runs), check=True)["power"].value == value
    assert ms.predict([str(runs), runs], check=True)["power"].value == value


def test_options_are_those_of_the_command(folder):
    narrow, wide = (
        ms.predict(folder / "runs" / "slices", level=level)["power"].half_width
        for level in (0.6, 0.99)
    )
    assert narrow < wide
    with pytest.raises(PredictionError, match="no finished and steady charge"):
        ms.predict(folder / "runs" / "slices", scheme="constant-speed")


def test_a_prompt_shows_values_with_intervals(prediction):
    text = repr(prediction)
    assert text == prediction.summary() == str(prediction)
    first, heading, *rows = text.splitlines()
    assert first.startswith("Physical mill: radius 3.9 m")
    assert "95 % interval" in heading
    power = next(line for line in rows if line.startswith("power "))
    _, value, interval, _ = (prediction["power"].cells[0], *prediction["power"].cells[1:])
    assert value in power and interval in power and power.endswith("kW")
    assert any(line.startswith("not predicted: ") for line in rows)


def test_a_notebook_shows_a_table(prediction):
    html = prediction._repr_html_()
    shown = [row for row in prediction.numbers if row.value is not None]
    assert html.count("<tr>") == 1 + len(shown)
    assert f"<td>{prediction['power'].cells[1]}</td>" in html


def test_a_plan_shows_its_designs():
    plan = ms.advise(CAMPAIGNS / "slices.toml", 0.03, observables=["power"])
    title, heading, chosen, *rest = repr(plan).splitlines()
    assert title == "Runs for an error of 3 %"
    assert heading.split()[-1] == "power"
    assert chosen.startswith("chosen") and plan.chosen.runs in chosen
    assert rest[-1].startswith("errors learnt from: ")
    html = plan._repr_html_()
    assert html.count("<tr>") == 2 + len(plan.cheapest)
    assert f"<td>{plan.chosen.runs}</td>" in html


def test_text_in_html_is_escaped():
    html = html_table("a < b", ["h"], [["<script>"]], ["x & y"])
    assert "<script>" not in html and "&lt;script&gt;" in html
    assert "a &lt; b" in html and "x &amp; y" in html


def test_columns_are_aligned():
    lines = aligned([("", "predicted", ""), ("power", "1", "kW"), ("toe", "222.9", "deg")])
    assert lines == ["       predicted", "power          1  kW", "toe        222.9  deg"]


def test_a_plan_is_for_the_observables_named(folder):
    plan = ms.advise(CAMPAIGNS / "slices.toml", 0.03, observables=["power"])
    assert set(plan.chosen.half_widths) == {"power"}
    learnt = ms.advise(
        CAMPAIGNS / "slices.toml",
        0.03,
        observables=["power"],
        learn_from=folder / "runs" / "slices",
    )
    assert learnt.chosen.half_widths != plan.chosen.half_widths


def test_importing_the_package_reads_no_library():
    code = (
        "import sys, millscale as ms; assert not {'numpy', 'millscale.api'} & set(sys.modules); "
        "assert {'predict', 'advise'} <= set(dir(ms)); ms.predict; "
        "assert 'millscale.api' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_name_that_the_package_lacks_is_an_attribute_error():
    with pytest.raises(AttributeError, match="has no attribute 'predit'"):
        _ = ms.predit


def test_the_example_of_the_guide_runs(folder, monkeypatch, capsys):
    """The made-up mills have no dumps, so no contour: that line is taken out."""
    (code,) = re.findall(r"```python\n(.*?)```", GUIDE.read_text(encoding="utf-8"), re.S)
    contour = "x, z = prediction.contour.points.T  # over R - a\n"
    assert contour in code
    monkeypatch.chdir(folder)
    exec(compile(code.replace(contour, ""), str(GUIDE), "exec"), {})
    shown = capsys.readouterr().out
    assert re.search(r"^[\d.]+ kW, [\d.]+ to [\d.]+ kW$", shown, re.M)
    assert re.search(r"S = [\d.]+.* \d+ s$", shown, re.M)
