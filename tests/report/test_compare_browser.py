"""The page of several runs folders in a real browser, without a network."""

import shutil

import pytest

from millscale.report import images as report_figures
from millscale.report.compare import compare_runs

playwright = pytest.importorskip("playwright.sync_api")
axe = pytest.importorskip("axe_playwright_python.sync_playwright")

CHROMIUM = shutil.which("chromium")
ARGUMENTS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]

pytestmark = pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")


@pytest.fixture(scope="module")
def url(throws, tmp_path_factory):
    folder = tmp_path_factory.mktemp("compared")
    copy = shutil.copytree(throws, folder / "other")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report_figures, "DPI", 40)
        return compare_runs([throws, copy], folder / "page").as_uri()


@pytest.fixture(scope="module")
def browser():
    with playwright.sync_playwright() as p:
        found = p.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS)
        yield found
        found.close()


@pytest.mark.parametrize(("width", "scheme"), [(1400, "light"), (390, "dark")])
def test_the_page_is_drawn_without_errors_and_is_accessible(browser, url, width, scheme):
    page = browser.new_page(viewport={"width": width, "height": 1000}, color_scheme=scheme)
    errors, requests = [], []
    page.on("console", lambda x: errors.append(x.text) if x.type == "error" else None)
    page.on("pageerror", lambda x: errors.append(str(x)))
    page.on("request", lambda x: requests.append(x.url))
    page.goto(url)
    page.wait_for_selector("html[data-ready]", timeout=60_000)
    chart = page.locator("#charge figure.chart").first
    chart.scroll_into_view_if_needed()
    chart.locator(".plot .main-svg").first.wait_for(timeout=60_000)
    names = chart.locator(".legendtext").all_text_contents()
    assert len(names) == 2 and "other" in names
    assert page.evaluate("document.documentElement.scrollWidth") == width
    found = axe.Axe().run(page).response["violations"]
    assert [(x["id"], x["nodes"][0]["html"]) for x in found] == []
    assert errors == [] and {x for x in requests if not x.startswith(("data:", "blob:"))} == {url}
    page.close()
