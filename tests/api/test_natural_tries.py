"""What people type first at `import millscale as ms` works as typed."""

import matplotlib
import pytest

from paper_campaign import CAMPAIGNS
from synthetic_mills import SEEDS, charge_case, write_mills

TRIES = {
    "open by string": 'ms.open("runs/quick")',
    "list cases": "list(runs)",
    "frame": 'runs.cases.query("S > 1")[["scheme", "S", "balls", "power_kW"]]',
    "series": 'case.series.plot(x="mill_angle_rad", y="drive_power_W")',
    "contour at an angle": "case.contour(angle=1.0)",
    "curtain overlap": "case.curtains(angle=1.0).overlap(other.curtains(angle=1.0))",
    "3-D": 'case.view(angle=1.0, colour="radius")',
    "physical power": "case.power(physical=True)",
    "plan from a dictionary": "ms.plan(mine)",
    "errors table": "runs.errors()",
    "compare two runs": "case.errors(against=other)",
    "predict": 'ms.predict("runs/slices")["power"].value',
    "export": 'case.series.to_csv("series.csv"), case.mesh(angle=1.0).save("charge.vtm")',
    "export for ParaView": 'runs.export("paraview", "files", only="mb-cg-*S2.600*seed1")',
    "compare two runs folders": 'ms.compare("runs/quick", "runs/slices").table',
    "help": "help(ms), help(ms.open)",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory, throws):
    """A folder with runs/quick, runs/slices and campaigns. Read only but for exports."""
    root = tmp_path_factory.mktemp("tries")
    (root / "runs").mkdir()
    (root / "runs/quick").symlink_to(throws)
    write_mills(
        root / "runs/slices", *(charge_case(S, seed) for S in (1.696, 2.6) for seed in SEEDS)
    )
    (root / "campaigns").symlink_to(CAMPAIGNS)
    return root


@pytest.fixture(scope="module")
def names():
    """Names as a session has them after its first lines."""
    return {}


@pytest.fixture
def session(folder, names, monkeypatch):
    monkeypatch.chdir(folder)
    matplotlib.use("agg")
    if not names:
        start = (
            'import millscale as ms\nruns = ms.open("runs/quick")\n'
            'case, other = (runs[f"mb-cg-paper-S{S}-fixed-seed1"] for S in ("2.600", "1.000"))\n'
            'import tomllib\nmine = tomllib.load(open("campaigns/quick.toml", "rb"))\n'
        )
        exec(start, names)
    return names


@pytest.mark.parametrize("line", TRIES.values(), ids=TRIES)
def test_it_works_as_typed(line, session, capsys):
    found = eval(line, session)
    assert found is not None
    if "help" in line:
        shown = capsys.readouterr().out
        assert "Open a runs folder" in shown and "runs/quick" in shown
        return
    # What a prompt shows is short.
    text = repr(found)
    assert text and len(text.splitlines()) < 40


def test_exports_are_whole(session, folder):
    eval(TRIES["export"], session)
    case = session["case"]
    assert len((folder / "series.csv").read_text().splitlines()) == len(case.series) + 1
    import pyvista as pv

    read = pv.read(folder / "charge.vtm")
    assert read["balls"].n_points == case.case.ball.count
    assert read["liner"].n_cells > 0


def test_help_lists_every_function(session, capsys):
    help(session["ms"])
    shown = capsys.readouterr().out
    for name in session["ms"]._API:
        assert f"\n    {name}(" in shown, name


def test_a_notebook_shows_tables(session):
    for shown in ("runs", "case", "case.curtains(1.0)", "ms.plan(mine)", "runs.cases"):
        html = eval(shown, session)._repr_html_()
        assert "<table" in html and "</table>" in html
    scaled = eval("ms.scale(2.6, radius_m=3.9, ball_radius_m=0.02, speed_rpm=9.55)", session)
    assert "<td>1.612</td>" not in repr(scaled) and "1.5" in scaled._repr_html_()
