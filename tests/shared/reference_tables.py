"""Tables of docs/reference/files.md."""

from __future__ import annotations

from pathlib import Path

REFERENCE = Path(__file__).parents[2] / "docs/reference/files.md"


def documented(title: str, number: int = 0) -> list[str]:
    """Return the names in the first column of a table of a section, in order.

    Args:
        number: of the table in the section, from 0.
    """
    text = REFERENCE.read_text(encoding="utf-8")
    section = text.partition(f"\n## {title}\n")[2].partition("\n## ")[0]
    table = section.split("\n|---")[1 + number].partition("\n\n")[0].splitlines()[1:]
    return [name for row in table for name in row.split("|")[1].strip().split(", ")]
