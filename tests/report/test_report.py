"""The report of a campaign."""

import base64
import json
import math
import os
import re
import shutil
import subprocess
import sys
from html.parser import HTMLParser

import numpy as np
import pytest
from PIL import Image

from millscale.analysis.finished_campaign import OUTDATED, load_campaign
from millscale.analysis.measures import COMMON_ANGLES
from millscale.analysis.paper import numbers as paper
from millscale.analysis.shapes.snapshots import snapshots_near
from millscale.analysis.single_ball.comparison import single_ball_rows
from millscale.report import build as report
from millscale.report import images as report_figures
from millscale.report import overview as first_screen
from millscale.report.ball_classes import colours_of_classes
from millscale.report.build import build_report
from millscale.report.figures import single_ball as figures
from millscale.runs.case_digest import case_digest
from millscale.runs.dumps import read_dump
from millscale.runs.untrusted import RunFolderError
from page_tables import PageTables
from synthetic_case import record_stages
from synthetic_result import with_result


class Page(HTMLParser):
    """What a test looks at: images, links, text, numbers of the paper; and that tags close."""

    VOID = ("meta", "img", "br", "link", "input")

    def __init__(self, text: str) -> None:
        super().__init__()
        self.images, self.links, self.text, self.open = [], [], "", []
        self.of_paper, self.in_paper = [], False
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        if tag == "img":
            self.images.append(values)
        self.links += [values[key] for key in ("href", "src") if key in values]
        self.in_paper = values.get("class") == "paper"
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag
        self.in_paper = False

    def handle_data(self, data):
        if self.open and self.open[-1] in ("script", "style"):
            return
        self.text += data
        if self.in_paper:
            self.of_paper.append(data)


@pytest.fixture(scope="module")
def built(runs, tmp_path_factory):
    """Report of one policy of the campaign, and of its charges."""
    copy = tmp_path_factory.mktemp("report") / "runs"
    shutil.copytree(runs, copy, ignore=shutil.ignore_patterns("*corrected*", "*offset-liner*"))
    keep_listed(copy)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report_figures, "DPI", 40)
        patch.setattr(report_figures, "draw_pictures", one_picture)
        return build_report(copy)


def one_picture(folder, mill_angles, to):
    """In place of the drawing, which has its own tests."""
    path = to / f"{folder.name}.png"
    Image.new("RGB", (4, 4), "red").save(path)
    return [(path, mill_angles[-1])]


@pytest.fixture
def page(built):
    return Page(built.read_text())


def keep_listed(runs):
    ids = sorted(path.name for path in (runs / "cases").iterdir())
    content = json.loads((runs / "campaign.json").read_text()) | {"cases": ids}
    (runs / "campaign.json").write_text(json.dumps(content))


def test_page_is_self_contained_and_closed(page):
    assert page.open == []
    for link in page.links:
        assert link.startswith(("data:image/webp;base64,", "#", "https://doi.org/"))


def test_page_holds_the_figures(page, built):
    captions = [image["alt"] for image in page.images]
    for scheme in ("constant gravity", "constant speed"):
        of = f"single ball, {scheme}, policy paper, S = 1, 1.3, 2.6"
        for begin, end in (
            ("path", "in metres"),
            ("path", "over R: similar paths coincide"),
            ("energies", "in joules"),
            ("energies", "similar curves coincide"),
        ):
            assert [x for x in captions if x.startswith(f"{begin} of a {of}") and x.endswith(end)]
        ratios = f"{scheme}, S = 1, 1.3, 2.6: energy ratio"
        assert [x for x in captions if x.startswith(ratios)]
    # Every picture of a charge names case, balls, seed and mill angle.
    pictures = [x for x in captions if x.endswith("at 1.00 rad")]
    assert pictures == [
        f"mb-{x}-paper-S2.600, 150 balls, seed 1, at 1.00 rad" for x in ("cg", "cs")
    ]
    for image in page.images:
        assert base64.b64decode(image["src"].partition(",")[2])[8:12] == b"WEBP"
    files = {path.name for path in built.parent.iterdir()}
    assert {"fig6-constant-gravity-paper.png", "fig8-constant-speed.png"} <= files


def test_no_column_of_a_table_is_empty_and_times_have_their_unit(built, of_another_mill):
    for index in (built, of_another_mill):
        tables = PageTables(index.read_text())
        assert tables.empty_columns() == []
        headings = [cell for head in tables.heads for row in head for cell in row]
        timed = [x for x in headings if re.search(r"\b(time|settling|rotation|steps)\b", x)]
        for heading in timed:
            assert "[" in heading or heading in ("steps", "largest in rotation"), heading


def test_columns_without_a_number_are_left_out_and_notes_stay():
    table = (
        "<table><thead><tr><th>a</th><th>b</th><th>c</th></tr></thead><tbody>"
        "<tr><th>1</th><td>–</td><td><i>– / –</i></td></tr>"
        "<tr class='x'><th>–</th><td> </td><td>0</td></tr>"
        "<tr><td colspan='3'>a note</td></tr></tbody></table>"
    )
    shown = report.tables.full_columns(table)
    assert "<th>b</th>" not in shown and shown.count("<td>") == 2
    assert "<tr class='x'><th>–</th><td>0</td></tr>" in shown
    assert "<tr><td colspan='3'>a note</td></tr>" in shown
    assert report.tables.full_columns(shown) == shown


@pytest.fixture(scope="module")
def of_another_mill(runs, tmp_path_factory):
    """Report of the same cases as of a mill that is not the paper's: one lifter is another."""
    copy = tmp_path_factory.mktemp("another") / "runs"
    shutil.copytree(runs, copy, ignore=shutil.ignore_patterns("*corrected*", "*offset-liner*"))
    keep_listed(copy)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report_figures, "DPI", 40)
        patch.setattr(report_figures, "draw_pictures", one_picture)
        patch.setattr(paper, "LIFTERS", paper.LIFTERS - 1)
        return build_report(copy)


def test_the_page_of_another_mill_does_not_speak_of_the_paper(of_another_mill, page):
    other = Page(of_another_mill.read_text())
    assert other.open == [] and other.of_paper == []
    # The words are on the page of the paper's mill.
    for words in ("the paper", "Powder Technology", "Tables 8", "Fig."):
        assert words not in other.text
        assert words in page.text
    captions = " ".join(image["alt"] for image in other.images)
    assert "Fig" not in captions and "Table" not in captions
    for row in (x for x in other.text.splitlines() if "2.600" in x):
        assert "0.65" not in row


def test_the_page_of_another_mill_has_its_power_in_its_own_units(of_another_mill):
    page = Page(of_another_mill.read_text())
    campaign = load_campaign(of_another_mill.parent.parent)
    for charge in campaign.charges:
        case, mill = charge.case, charge.case.physical
        balls = case.ball.count * case.S**2 * mill.length_m / case.mill.simulated_length_m
        scale = balls * case.ball.mass_kg * mill.gravity_m_s2 * mill.radius_m * mill.omega_rad_s
        power = 1e-3 * scale * charge.result.dimensionless["power"]
        assert f"power{first_screen.Estimate(power).text} kW" in page.text.replace("\n", "")


def test_the_page_has_the_power_by_published_models(page):
    text = page.text.replace("\n", "")
    assert "Its power by published models" in text
    assert re.search(r"Hogg-Fuerstenau\d+\.\dcharge", text)


def test_failed_checks_come_first_with_what_to_do(page):
    text = page.text
    assert text.index("failed checks") < text.index("What was run")
    failed = text[text.index("failed checks") : text.index("by each scaled mill")]
    assert "is not steady" in failed and "increase rotation_angle_rad" in failed
    assert {"#case-mb-cg-paper-S2.600", "#failed"} <= set(page.links)
    checks = text[text.rindex("Health of the runs") :]
    assert checks.index("no ball is lost") < checks.index("Claims about the law")
    assert checks.index("Claims about the law") < checks.index("worst deviation")


def test_checks_and_results_of_another_mill_hold_no_numbers_of_the_paper(of_another_mill, built):
    ours, other = (
        json.loads((x.parent / "results.json").read_text()) for x in (built, of_another_mill)
    )
    about_the_law = [x for x in ours["checks"] if "deviation" in x or "linear" in x]
    assert about_the_law and not set(about_the_law) & set(other["checks"])
    assert all(row["paper_energy_ratio"] is None for row in other["single_ball"])
    assert any(row["paper_energy_ratio"] is not None for row in ours["single_ball"])
    assert all(row["paper_wall_time_h"] is None for row in other["multi_ball"])


@pytest.mark.filterwarnings("error")
def test_ratios_of_another_mill_without_a_reference_are_drawn_in_silence(runs):
    rows = single_ball_rows([ball for ball in load_campaign(runs).single if ball.S > 1.0])
    assert all(row.energies[COMMON_ANGLES].ratio is None for row in rows)
    figure = figures.energy_ratios("constant-gravity", rows, of_paper=False)
    assert figure.axes[0].get_legend() is None


def test_page_shows_ours_beside_the_paper(page):
    for value in ("A made-up CPU", "35.50", "63.90", "2.1839", "0.3874"):
        assert value in page.text
    # Tables 8, 9, 10, 4 and 7, section 4.1; the worst deviation of Table 8.
    for value in (
        "4.57",
        "0.66",
        "0.753",
        "0.151",
        "0.65",
        "3610",
        "3.77",
        "0.998",
        "0.996",
        "68",
        "-2.08",
    ):
        assert value in page.of_paper
    assert "None" not in page.text
    assert "nan" not in page.text


def test_results_json_has_rows_for_all_cases(built):
    results = json.loads((built.parent / "results.json").read_text())
    assert results["schema"] == 1
    assert results["campaign"] == "synthetic"
    promised = "id scheme policy S detach_angle_deg liner_off_angle_deg energy_change_J "
    promised += "energy_ratio predicted_ratio relative_error wall_time_s"
    assert len(results["single_ball"]) == 6
    for row in results["single_ball"]:
        assert set(promised.split()) <= row.keys()
    assert len(results["multi_ball"]) == 2
    assert results["checks"]["all_cases_finished"]["passed"] is True


def edited(folder):
    """A case.json that says twice the speed."""
    case = json.loads((folder / "case.json").read_text())
    case["mill"]["omega_rad_s"] *= 2.0
    (folder / "case.json").write_text(json.dumps(case))


def test_products_of_another_case_are_named_and_left_out(runs, tmp_path):
    copy = tmp_path / "runs"
    shutil.copytree(runs, copy)
    whole = load_campaign(copy).results()
    one, two, three = ("sb-cg-paper-S1.300", "sb-cs-paper-S2.600", "mb-cg-paper-S2.600")
    edited(copy / "cases" / one)
    with (copy / "cases" / two / "series.csv").open("a") as series:
        series.write("\n")
    # The result of another case, and all that it was made from.
    for name in ("result.json", "series.csv", "timing.json"):
        shutil.copyfile(copy / "cases/mb-cs-paper-S2.600" / name, copy / "cases" / three / name)
    results = load_campaign(copy).results()
    assert set(results["missing"]) == {one, two, three}
    assert "stale: case.json has changed since stage mesh read it" in results["missing"][one]
    assert "stale: series.csv is not what stage rotate made" in results["missing"][two]
    assert "is not what stage rotate made" in results["missing"][three]
    assert results["missing"][one].endswith(f"--runs {copy} --only {one}")
    assert not results["checks"]["all_cases_finished"]["passed"]
    kept = [row for row in whole["single_ball"] if row["id"] not in (one, two)]
    ratios = [(row["id"], row["energy_ratio"]) for row in results["single_ball"]]
    assert ratios == [(row["id"], row["energy_ratio"]) for row in kept]


def test_a_case_that_the_campaign_now_describes_otherwise_is_left_out(runs, tmp_path):
    copy = tmp_path / "runs"
    shutil.copytree(runs, copy)
    about = json.loads((copy / "campaign.json").read_text())
    cases = {x: json.loads((copy / "cases" / x / "case.json").read_text()) for x in about["cases"]}
    about["digests"] = {name: case_digest(case) for name, case in cases.items()}
    (copy / "campaign.json").write_text(json.dumps(about))
    assert load_campaign(copy).missing == {}
    about["digests"]["sb-cg-paper-S1.000"] = "0" * 64
    (copy / "campaign.json").write_text(json.dumps(about))
    assert load_campaign(copy).missing == {"sb-cg-paper-S1.000": OUTDATED}


def test_partial_campaign_lists_what_is_missing(runs, tmp_path, monkeypatch):
    copy = tmp_path / "runs"
    shutil.copytree(runs, copy, ignore=shutil.ignore_patterns("mb-*"))
    (copy / "cases/sb-cs-paper-S1.000/series.csv").unlink()
    (copy / "cases/sb-cg-corrected-S1.300/result.json").write_text('{"schema": 1,')
    record_stages(copy / "cases/sb-cg-corrected-S1.300")
    failed = copy / "cases/sb-cs-corrected-S1.300"
    (failed / "timing.json").unlink()
    record = {"stage": "rotate", "state": "failed", "cause": "lost ball: 1 <i>", "advice": "look"}
    (failed / "stage.json").write_text(json.dumps(record))
    for drawn in ("policy_figures", "ratio_figures"):
        monkeypatch.setattr(report_figures, drawn, lambda *_: {})
    monkeypatch.setattr(report.tables, "energy_tables", lambda _: [])
    page = Page(build_report(copy).read_text())
    results = json.loads((copy / "report/results.json").read_text())
    assert results["missing"]["sb-cs-paper-S1.000"] == "no series.csv yet"
    assert "cut short" in results["missing"]["sb-cg-corrected-S1.300"]
    assert results["missing"]["mb-cg-paper-S2.600"].startswith("no case.json, series.csv")
    why = "rotate failed: lost ball: 1 <i>; to do: look"
    assert results["missing"][failed.name] == why and why in page.text
    assert len(results["single_ball"]) == 15
    assert "sb-cs-paper-S1.000" in page.text
    # A policy without its own S = 1 is compared with another policy's: the same mill.
    ratios = [row["energy_ratio"] for row in results["single_ball"]]
    assert None not in ratios


def test_failed_report_leaves_the_earlier_one(built, monkeypatch):
    before = built.read_bytes()
    monkeypatch.setattr(report, "_page", lambda *_: 1 / 0)
    with pytest.raises(RunFolderError, match="not understood: ZeroDivisionError"):
        build_report(built.parent.parent)
    assert built.read_bytes() == before


def test_pictures_that_cannot_be_drawn_are_explained(runs, tmp_path, monkeypatch):
    def cannot(folder, angles, to):
        raise RunFolderError(folder, "drawing failed", "apt-get install libegl1")

    monkeypatch.setattr(report_figures, "draw_pictures", cannot)
    drawn = report_figures.charge_images(load_campaign(runs).charges[0], tmp_path)
    assert drawn.pictures == []
    assert "apt-get install libegl1" in drawn.problem
    assert len(drawn.series) == 2


def test_campaign_without_a_finished_case_is_refused(folder, tmp_path):
    (tmp_path / "campaign.json").write_text(json.dumps({"cases": [folder.name]}))
    with pytest.raises(RunFolderError, match="none of its 1 cases is finished; run them with"):
        build_report(tmp_path)
    assert not (tmp_path / "report").exists()


@pytest.mark.parametrize(
    ("end", "angles"),
    [
        (1.0, [0.0, 0.5, 1.0]),
        (2.499, [0.0, 0.5, 1.0, 1.5, 2.0, 2.5]),
        (8.0, [0.0, 2.0, 4.0, 6.0, 8.0]),
        (20.0, [0.0, 4.0, 8.0, 12.0, 16.0, 20.0]),
    ],
)
def test_pictures_are_at_round_mill_angles(runs, monkeypatch, tmp_path, end, angles):
    case = with_result(load_campaign(runs).charges[0], rotation_angle_rad=end)
    asked = []
    monkeypatch.setattr(report_figures, "draw_pictures", lambda *a: asked.extend(a[1]) or [])
    monkeypatch.setattr(report_figures, "save_image", lambda *a: None)
    report_figures.charge_images(case, tmp_path)
    assert asked == angles


def test_campaign_of_charges_alone_has_a_report(runs, tmp_path, monkeypatch):
    ignored = shutil.ignore_patterns("sb-*", "mb-cs-*", "report")
    shutil.copytree(runs, tmp_path / "runs", ignore=ignored)
    (tmp_path / "runs/campaign.json").write_text('{"schema": 1, "cases": ["mb-cg-paper-S2.600"]}')
    monkeypatch.setattr(report_figures, "draw_pictures", one_picture)
    monkeypatch.setattr(report_figures, "DPI", 20)
    page = Page(build_report(tmp_path / "runs").read_text())
    assert page.open == []
    assert "runs" in page.text
    assert len(page.images) == 7  # with Figs. 9, 11, Table 10


def test_a_page_of_a_slipping_charge_begins_with_it(runs, tmp_path, monkeypatch):
    copy = tmp_path / "runs"
    shutil.copytree(runs, copy, ignore=shutil.ignore_patterns("sb-*", "mb-cs-*", "report"))
    (copy / "campaign.json").write_text('{"schema": 1, "cases": ["mb-cg-paper-S2.600"]}')
    result = copy / "cases/mb-cg-paper-S2.600/result.json"
    result.write_text(json.dumps(json.loads(result.read_text()) | {"liner_slip": 0.93}))
    record_stages(result.parent)
    monkeypatch.setattr(report_figures, "draw_pictures", one_picture)
    monkeypatch.setattr(report_figures, "DPI", 20)
    text = Page(build_report(copy).read_text()).text
    words = ("The charge slips on the liner.", "mb-cg-paper-S2.600, 93 %", "The answer")
    places = [text.index(word) for word in words]
    assert places == sorted(places)
    assert "does not lift its charge" in text[: places[-1]]


def test_a_charge_of_several_classes_has_a_table_of_them(classes, tmp_path, monkeypatch):
    monkeypatch.setattr(report_figures, "draw_pictures", one_picture)
    monkeypatch.setattr(report_figures, "DPI", 20)
    text = build_report(shutil.copytree(classes, tmp_path / "runs")).read_text()
    page = Page(text)
    assert page.open == [] and "None" not in page.text
    several, equal = load_campaign(classes).charges
    begin, other = (text.index(f'id="case-{charge.id}"') for charge in (several, equal))
    assert text.count("segregation index</th>") == 1
    table = text[begin:other].partition("<tbody>")[2].partition("</tbody>")[0]
    rows = [re.findall(r"<t[hd].*?</t[hd]>", row) for row in table.split("</tr>")[:-1]]
    cells = [[re.sub("<.*?>", "", cell).strip() for cell in row] for row in rows]
    (snapshot,) = snapshots_near(several.folder, [1.0])
    dump = read_dump(snapshot.path)
    mass = 2678.0 * 4.0 / 3.0 * math.pi * dump["radius"] ** 3
    x, z = (dump[a] - np.average(dump[a], weights=mass) for a in "xz")
    square = x**2 + z**2
    for row, radius in zip(cells, (0.1, 0.04, 0.06), strict=True):
        of = dump["radius"] == radius
        index = 1.0 - square[of].mean() / np.average(square, weights=mass)
        share = 100.0 * mass[of].sum() / mass.sum()
        assert row[:3] == [f"{1e3 * radius:g} mm", "33.33", "50"]
        assert float(row[3]) == pytest.approx(mass[of].sum(), abs=0.06)
        assert float(row[4]) == pytest.approx(share, abs=0.006)
        assert float(row[5]) == pytest.approx(index, abs=0.002)
    # The legend of the pictures; equal balls are coloured as before.
    for colour in colours_of_classes(several.case.ball):
        assert text[begin:other].count(f"background: {colour}") == 2
    assert "rising side" not in text[begin:other] and "rising side" in text[other:]
    assert "coloured by class" in text[begin:other] and "coloured by speed" in text[other:]


def test_detach_angles_are_listed_under_their_own_policy(runs, tmp_path, monkeypatch):
    copy = tmp_path / "runs"
    shutil.copytree(runs, copy, ignore=shutil.ignore_patterns("mb-*"))
    keep_listed(copy)
    monkeypatch.setattr(report_figures, "DPI", 40)
    text = build_report(copy).read_text()
    table = text[text.index("free flight begins [deg]</th>") :]
    table = table[: table.index("</table>")]
    for policy in ("paper", "corrected", "offset-liner"):
        assert table.count(f'<td class="text">{policy}</td>') == 2  # once a scheme


def test_charges_are_compared_with_the_physical_mill(throws, tmp_path, monkeypatch):
    shutil.copytree(throws, tmp_path / "runs")
    monkeypatch.setattr(report_figures, "draw_pictures", one_picture)
    monkeypatch.setattr(report_figures, "DPI", 20)
    index = build_report(tmp_path / "runs")
    page = Page(index.read_text())
    assert page.open == []
    shapes = page.text[page.text.index("Charge of scaled mills") :]
    for words in ("Speed against error", "reference", "constant speed", "mb-cg-paper-S1.000"):
        assert words in shapes
    assert "None" not in page.text
    assert "nan" not in shapes
    assert {"231,461", "20600", "13,370", "1190"} <= set(page.of_paper)  # Table 10
    assert "No physical mill" not in shapes
    assert [image["alt"] for image in page.images if image["alt"].startswith("Fig. 12")]
    results = json.loads((index.parent / "results.json").read_text())
    for row in results["charge_errors"]:
        assert f"{math.degrees(row['shoulder_angle_rad']):.1f}" in shapes
    assert len(results["charge_errors"]) == 4
    assert len(results["charge_schemes"]) == 1


def test_report_is_written_in_utf8_under_a_locale_without_it(runs, tmp_path):
    copy = shutil.copytree(runs, tmp_path / "läufe")
    (copy / "campaign.json").write_text(
        json.dumps(json.loads((copy / "campaign.json").read_text()) | {"name": "Mühle"})
    )
    ascii_only = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    line = [sys.executable, "-m", "millscale", "report", str(copy)]
    done = subprocess.run(line, env=os.environ | ascii_only, capture_output=True)
    assert done.returncode == 0, done.stderr.decode()
    assert "Mühle" in (copy / "report" / "index.html").read_text(encoding="utf-8")
