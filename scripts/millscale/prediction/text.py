"""Rows of a result as aligned text, and as HTML for notebooks."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape


def aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return a line for each row; the first column is aligned to the left, others to the right, but
    the last."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(
            cell.ljust(width) if i in (0, len(row) - 1) else cell.rjust(width)
            for i, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]


def html_table(
    title: str, headings: Sequence[str], rows: Sequence[Sequence[str]], notes: Sequence[str]
) -> str:
    """Return a table with a caption above and notes below."""

    def cells(tag: str, row: Sequence[str]) -> str:
        return "<tr>" + "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in row) + "</tr>"

    body = "".join(cells("td", row) for row in rows)
    below = "".join(f"<div>{escape(note)}</div>" for note in notes)
    head = f"<caption>{escape(title)}</caption><thead>{cells('th', headings)}</thead>"
    return f"<table>{head}<tbody>{body}</tbody></table>{below}"
