"""The report in a real browser: charts, views, print and accessibility, without a network."""

import shutil
import subprocess

import pytest
from PIL import Image

from millscale.report import images as report_figures
from millscale.report.build import build_report

playwright = pytest.importorskip("playwright.sync_api")
axe = pytest.importorskip("axe_playwright_python.sync_playwright")

CHROMIUM = shutil.which("chromium")
ARGUMENTS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
MOST_PRINTED_PAGES = 15

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")


def one_picture(folder, mill_angles, to):
    """In place of the drawing, which has its own tests."""
    path = to / f"{folder.name}.png"
    Image.new("RGB", (40, 40), "red").save(path)
    return [(path, mill_angles[-1])]


def built(runs, folder):
    """Return the address of the report of a copy of a campaign."""
    copy = folder / "runs"
    shutil.copytree(runs, copy)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report_figures, "DPI", 40)
        patch.setattr(report_figures, "draw_pictures", one_picture)
        return build_report(copy).as_uri()


@pytest.fixture(scope="module")
def url(runs, tmp_path_factory):
    return built(runs, tmp_path_factory.mktemp("browser"))


@pytest.fixture(scope="module")
def browser():
    with playwright.sync_playwright() as p:
        found = p.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield found
        found.close()


@pytest.fixture
def page(browser, url):
    """Return the open page; fails if the page printed an error or asked for another file."""
    context = browser.new_context(viewport={"width": 1400, "height": 1000}, offline=True)
    page = context.new_page()
    errors, requests = [], []
    page.on("console", lambda x: errors.append(x.text) if x.type == "error" else None)
    page.on("pageerror", lambda x: errors.append(str(x)))
    page.on("request", lambda x: requests.append(x.url))
    page.goto(url)
    page.wait_for_selector("html[data-ready]", timeout=60_000)
    yield page
    assert errors == []
    others = {x for x in requests if not x.startswith(("data:", "blob:"))}
    assert others == {url}
    context.close()


def drawn(page, figure):
    figure.scroll_into_view_if_needed()
    figure.locator(".plot .main-svg").first.wait_for(timeout=60_000)
    return figure.locator(".plot")


def test_a_click_in_a_legend_hides_the_curves_of_that_name(page):
    plot = drawn(page, page.locator("#trajectory figure.chart").first)
    names = plot.locator(".legendtext").all_text_contents()
    assert names == ["S = 1", "S = 1.3", "S = 2.6"]
    visible = "p => p.data.filter(t => t.visible !== 'legendonly').length"
    before = plot.evaluate(visible)
    plot.locator(".legendtoggle").first.click()
    page.wait_for_function("([p, n]) => p.data.filter(t => t.visible !== 'legendonly').length < n",
                           arg=[plot.element_handle(), before])  # fmt: skip
    assert 0 < plot.evaluate(visible) < before


def test_the_slider_turns_the_mill_and_moves_the_rule_of_the_charts(page):
    view = page.locator(".view").first
    view.scroll_into_view_if_needed()
    view.locator("canvas").first.wait_for(timeout=60_000)
    plot = view.locator(".plot")
    before = plot.evaluate("p => Array.from(p.data[0].x).slice(0, 20)")
    page.locator("#charge details.series summary").first.click()
    chart = drawn(page, page.locator("#charge details.series figure.chart").first)
    view.locator("input").focus()
    page.keyboard.press("ArrowRight")
    page.wait_for_function("p => (p.layout.shapes || []).length > 0", arg=chart.element_handle())
    angle = chart.evaluate("p => p.layout.shapes[0].x0")
    assert angle == pytest.approx(0.5, abs=0.05)  # of the second dump
    assert view.locator("output").inner_text() == f"{angle:.2f} rad"
    assert plot.evaluate("p => Array.from(p.data[0].x).slice(0, 20)") != before
    # Balls lie inside the liner at rest, and it turns with them.
    reach = plot.evaluate(
        "p => Math.max(...p.data[0].x.map((x, i) => x * x + p.data[0].z[i] ** 2))"
    )
    assert 0.1 < reach <= 1.0


def test_the_legend_of_a_view_names_the_classes_and_hides_one(browser, classes, tmp_path):
    page = browser.new_page(viewport={"width": 1400, "height": 1000})
    page.goto(built(classes, tmp_path))
    page.wait_for_selector("html[data-ready]", timeout=60_000)
    view = page.locator(".view").first
    view.scroll_into_view_if_needed()
    view.locator("canvas").first.wait_for(timeout=60_000)
    plot = view.locator(".plot")
    assert plot.locator(".legendtext").all_text_contents() == ["100 mm", "40 mm", "60 mm"]
    shown = (
        "p => p.data.map(t => [t.x.length, t.marker && t.marker.color, t.marker && t.marker.size])"
    )
    *balls, _ = plot.evaluate(shown)
    assert [count for count, _, _ in balls] == [50, 50, 50]
    assert len({colour for _, colour, _ in balls}) == 3
    large, small, middle = (size for _, _, size in balls)
    assert large / small == pytest.approx(2.5, rel=0.01) and middle / small == pytest.approx(
        1.5, rel=0.01
    )
    before = plot.evaluate("p => Array.from(p.data[2].x)")
    view.locator("input").focus()
    page.keyboard.press("ArrowRight")
    page.wait_for_function(
        "([p, x]) => p.data[2].x[0] != x", arg=[plot.element_handle(), before[0]]
    )
    assert [count for count, _, _ in plot.evaluate(shown)][:3] == [50, 50, 50]
    plot.locator(".legendtoggle").first.click()
    page.wait_for_function("p => p.data[0].visible === 'legendonly'", arg=plot.element_handle())
    page.close()


def test_a_phone_shows_the_page_without_scrolling_sideways(browser, url, tmp_path):
    page = browser.new_page(viewport={"width": 390, "height": 844})
    page.goto(url)
    page.wait_for_selector("html[data-ready]", timeout=60_000)
    drawn(page, page.locator("#trajectory figure.chart").first)
    assert page.evaluate("document.documentElement.scrollWidth") == 390
    page.screenshot(path=tmp_path / "phone.png")
    with Image.open(tmp_path / "phone.png") as picture:
        assert picture.width == 390 and len(picture.getcolors(1 << 20)) > 20
    page.close()


def test_print_opens_what_is_folded_and_is_short(page, tmp_path):
    page.pdf(path=tmp_path / "print.pdf", format="A4", print_background=True)
    text = subprocess.run(["pdftotext", tmp_path / "print.pdf", "-"],
                          capture_output=True, text=True, check=True).stdout  # fmt: skip
    assert 1 < text.count("\f") <= MOST_PRINTED_PAGES
    text = " ".join(text.split())
    assert "policy offset-liner" in text and "balls on the wall" in text  # folded on the screen


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_the_page_has_no_faults_of_accessibility(browser, url, scheme):
    page = browser.new_page(viewport={"width": 1400, "height": 1000}, color_scheme=scheme)
    page.goto(url)
    page.wait_for_selector("html[data-ready]", timeout=60_000)
    found = axe.Axe().run(page).response["violations"]
    assert [(x["id"], x["nodes"][0]["html"]) for x in found] == []
    page.close()
