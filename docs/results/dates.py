"""Write the column `measured` of the index: the dates of measurement that each page states.

Run it as `python docs/results/dates.py`.
"""

from __future__ import annotations

import re
from pathlib import Path

FOLDER = Path(__file__).parent
INDEX = FOLDER / "README.md"
# Not the date before which something was measured.
DATE = re.compile(r"(?<!before )\b20\d\d-\d\d-\d\d\b")
ROW = re.compile(r"^\| (?P<link>\[[^]]*\]\((?P<page>[\w-]+\.md)\)) \| (?P<question>[^|]*) \|", re.M)


def measured(page: str) -> str:
    """Return the first and the last date of a page, or that it states none."""
    dates = sorted(DATE.findall((FOLDER / page).read_text(encoding="utf-8")))
    if not dates:
        return "not stated"
    return dates[0] if dates[0] == dates[-1] else f"{dates[0]} to {dates[-1]}"


def dated(index: str) -> str:
    """Return the index with the dates of its pages."""

    def row(found: re.Match[str]) -> str:
        return f"| {found['link']} | {found['question']} | {measured(found['page'])} |"

    lines = re.sub(ROW.pattern + r"[^\n]*", row, index, flags=re.M)
    heading = "| page | question | measured |\n|---|---|---|\n"
    return re.sub(r"\| page \| question \|[^\n]*\n\|[-|]*\n", heading, lines)


if __name__ == "__main__":
    INDEX.write_text(dated(INDEX.read_text(encoding="utf-8")), encoding="utf-8")
