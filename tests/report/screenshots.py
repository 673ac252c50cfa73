"""Screenshots of a report, to look at: 1400 and 390 px wide, light and dark, and as printed.

    python tests/report/screenshots.py runs/quick/report/index.html DIR

writes into DIR the first screen and every section of each width, and the pages of the print, small
enough to be kept in docs. Needs chromium, playwright and pdftoppm of poppler-utils.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

from PIL import Image
from playwright.sync_api import Page, sync_playwright

ARGUMENTS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
WIDTHS = {"wide": (1400, 1000), "phone": (390, 844)}
DRAWN_MS = 400  # for the charts near a place to be drawn
COLOURS = 128  # of a kept file
PRINT_DPI, PRINT_COLUMNS = 45, 5


def main(report: Path, to: Path) -> None:
    to.mkdir(parents=True, exist_ok=True)
    with sync_playwright() as p:
        browser = p.chromium.launch(executable_path=shutil.which("chromium"), args=ARGUMENTS)
        for name, (width, height) in WIDTHS.items():
            for scheme in ("light", "dark"):
                page = browser.new_page(
                    viewport={"width": width, "height": height}, color_scheme=scheme
                )
                page.goto(report.resolve().as_uri())
                page.wait_for_selector("html[data-ready]", timeout=60_000)
                look(page, to / f"{name}-{scheme}", sections=scheme == "light")
                if name == "wide" and scheme == "light":
                    page.pdf(path=to / "print.pdf", format="A4", print_background=True)
                page.close()
        browser.close()
    pages = print_pages(to / "print.pdf", to)
    keep(sheet_of(pages), to / "print.png")


def look(page: Page, base: Path, sections: bool) -> None:
    """Write the first screen, and the sections, once their charts are drawn."""
    keep_bytes(page, base.with_name(f"{base.name}-first.png"))
    if not sections:
        return
    for section in page.locator("main > section").all():
        height = section.evaluate("s => s.getBoundingClientRect().height")
        for y in range(0, int(height), 600):
            section.evaluate("(s, y) => scrollTo(0, s.offsetTop + y)", y)
            page.wait_for_timeout(DRAWN_MS)
        identity = section.get_attribute("id")
        section.screenshot(path=base.with_name(f"{base.name}-{identity}.png"))


def keep_bytes(page: Page, path: Path) -> None:
    page.screenshot(path=path)
    with Image.open(path) as picture:
        keep(picture, path)


def keep(picture: Image.Image, path: Path) -> None:
    """Write a picture with few colours, in a third of the size."""
    picture.convert("RGB").quantize(COLOURS).save(path, optimize=True)


def print_pages(pdf: Path, to: Path) -> list[Path]:
    """Return the pages of a PDF as pictures."""
    subprocess.run(["pdftoppm", "-r", str(PRINT_DPI * 2), "-png", pdf, to / "print"], check=True)
    return sorted(to.glob("print-*.png"))


def sheet_of(pages: list[Path]) -> Image.Image:
    """Return all pages beside each other."""
    pictures = [Image.open(path).convert("RGB").reduce(2) for path in pages]
    width, height = pictures[0].size
    rows = -(-len(pictures) // PRINT_COLUMNS)
    sheet = Image.new("RGB", (PRINT_COLUMNS * (width + 6), rows * (height + 6)), "#ccd2d8")
    for i, picture in enumerate(pictures):
        sheet.paste(
            picture, ((i % PRINT_COLUMNS) * (width + 6), (i // PRINT_COLUMNS) * (height + 6))
        )
    return sheet


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
