"""The report as a PDF file: its page, printed by Chromium without a window."""

from __future__ import annotations

import base64
import io
import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

from PIL import Image as Picture

from millscale.runs.untrusted import RunFolderError
from millscale.runs.writing import writing_by_name

PDF = "report.pdf"
# Names of the browser; the variable names another one.
BROWSERS = ("chromium", "chromium-browser", "google-chrome-stable", "google-chrome", "chrome")
VARIABLE = "MILLSCALE_BROWSER"
_SECONDS = 300
_QUALITY = 88
_SCRIPT = re.compile(r"<script\b.*?</script>", re.S)
_IMAGE = re.compile(r"data:image/webp;base64,([A-Za-z0-9+/=]+)")
_INSTALL = f"install it (apt-get install chromium), or name it in the variable {VARIABLE}"


def print_page(page: Path, to: Path) -> Path:
    """Print a page of this package as PDF and return the file.

    The style sheet of the page opens folded parts, keeps figures whole and fits tables.

    Raises:
        RunFolderError: no browser, or one that fails.
    """
    browser = _browser(to)
    with (
        tempfile.TemporaryDirectory(prefix="millscale-print-") as folder,
        writing_by_name(to) as pdf,
    ):
        source = Path(folder) / page.name
        source.write_text(printable(page.read_text(encoding="utf-8")), encoding="utf-8")
        line = [
            browser,
            "--headless",
            "--disable-gpu",
            "--no-first-run",
            "--no-pdf-header-footer",
            "--generate-pdf-document-outline",
            f"--user-data-dir={folder}/profile",
            f"--print-to-pdf={pdf.absolute()}",
            source.as_uri(),
        ]
        # Root has no sandbox of its own, such as in a container.
        if os.geteuid() == 0:
            line.insert(1, "--no-sandbox")
        try:
            done = subprocess.run(
                line, capture_output=True, encoding="utf-8", errors="replace", timeout=_SECONDS
            )
        except subprocess.TimeoutExpired:
            cause = f"{browser} did not end within {_SECONDS} s"
            raise RunFolderError(to, cause, "repeat the command; see memory and load") from None
        if not pdf.is_file() or pdf.read_bytes()[:5] != b"%PDF-":
            lines = [x for x in done.stderr.splitlines() if x.strip() and "dbus" not in x]
            last = lines[-1] if lines else f"exit code {done.returncode}"
            raise RunFolderError(to, f"{browser} wrote no PDF: {last}", _INSTALL)
    return to


def printable(text: str) -> str:
    """Return a page without scripts, whose images keep their size in a PDF.

    Without scripts the images are shown instead of the charts. Chromium stores JPEG as it is, and
    other formats without loss, which takes more space.
    """
    return _IMAGE.sub(_as_jpeg, _SCRIPT.sub("", text))


def _as_jpeg(found: re.Match[str]) -> str:
    small = io.BytesIO()
    with Picture.open(io.BytesIO(base64.b64decode(found[1]))) as picture:
        picture.convert("RGB").save(small, "JPEG", quality=_QUALITY, subsampling=0)
    return "data:image/jpeg;base64," + base64.b64encode(small.getvalue()).decode()


def _browser(to: Path) -> str:
    named = os.environ.get(VARIABLE)
    for name in [named] if named else BROWSERS:
        if found := shutil.which(name):
            return found
    cause = f"{VARIABLE}={named} is no program" if named else "no Chromium to print it with"
    raise RunFolderError(to, cause, _INSTALL)
