"""Tables of a page as text."""

from __future__ import annotations

from html.parser import HTMLParser


class PageTables(HTMLParser):
    """The tables of a page.

    Attributes:
        heads, bodies: of each table the rows, each a list of cells; a cell that spans columns is
            repeated.
    """

    def __init__(self, text: str) -> None:
        super().__init__()
        self.heads: list[list[list[str]]] = []
        self.bodies: list[list[list[str]]] = []
        self._rows: list[list[str]] = []
        self._cell: list[str] | None = None
        self._span = 1
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        if tag in ("thead", "tbody"):
            self._rows = []
            (self.heads if tag == "thead" else self.bodies).append(self._rows)
        elif tag == "tr":
            self._rows.append([])
        elif tag in ("td", "th"):
            self._cell, self._span = [], int(dict(attributes).get("colspan", 1))

    def handle_data(self, data):
        if self._cell is not None:
            self._cell.append(data)

    def handle_endtag(self, tag):
        if tag in ("td", "th") and self._cell is not None:
            self._rows[-1] += ["".join(self._cell).strip()] * self._span
            self._cell = None

    def empty_columns(self) -> list[tuple[str, int]]:
        """Return the columns that hold no number or word, by the heading of their table."""
        found = []
        for head, body in zip(self.heads, self.bodies, strict=True):
            width = max((len(row) for row in body), default=0)
            for i in range(width):
                cells = {row[i] for row in body if i < len(row)}
                if all(set(cell) <= set("– /±()") for cell in cells):
                    found.append((" | ".join(head[-1]), i))
        return found
