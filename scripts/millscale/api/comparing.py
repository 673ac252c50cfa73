"""Several runs folders side by side."""

from __future__ import annotations

from functools import cached_property
from html import escape
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from millscale.analysis.several_campaigns import compare_campaigns
from millscale.api.frames import error_frame, frame

if TYPE_CHECKING:
    from millscale.report.side_by_side import SideBySide

Folder = str | PathLike[str]


class Comparison:
    """Runs folders side by side, as `millscale compare` shows them; the first is the reference.

    Scaled mills are compared if S, scheme, policy and stiffness are the same.

    Attributes:
        found: the comparison as `millscale.report` reads it.
    """

    def __init__(self, found: SideBySide) -> None:
        self.found = found

    @property
    def differences(self) -> pd.DataFrame:
        """The facts that differ, a row for each, a column for each runs folder."""
        rows = [
            {
                "fact": row.fact.label,
                "unit": row.fact.unit or "-",
                "about": row.fact.about,
                **dict(zip(self._names, row.values, strict=True)),
            }
            for row in self.found.differing
        ]
        columns = ["unit", "about", *self._names]
        return frame(rows, "fact") if rows else pd.DataFrame(columns=columns)

    @cached_property
    def table(self) -> pd.DataFrame:
        """The physical mill by each scaled mill of each runs folder; units in `attrs`.

        Columns: group (what is compared), runs, seeds, and each number with its half width and its
        difference from the first runs folder.
        """
        from millscale.report.overview import QUANTITIES

        rows: list[dict[str, Any]] = []
        units: dict[str, str] = {}
        for group in self.found.groups:
            for row in group.rows:
                entry: dict[str, Any] = {"group": group.title, "runs": row.side.name}
                entry["seeds"] = len(row.charges)
                for quantity, estimate, change in zip(
                    QUANTITIES, row.row.estimates, row.changes, strict=True
                ):
                    name = quantity.label.replace(" ", "_")
                    units |= dict.fromkeys(
                        (name, f"{name}_half_width", f"{name}_difference"), quantity.unit
                    )
                    entry[name] = estimate.value
                    entry[f"{name}_half_width"] = estimate.half_width
                    entry[f"{name}_difference"] = change.value if change else None
                rows.append(entry)
        return frame(rows, None, units)

    def errors(self) -> pd.DataFrame:
        """Return the errors of every multi-ball case against the physical mill.

        The charges of a runs folder without the physical mill are compared with that of another.
        Columns and units are those of `RunsFolder.errors`.

        Raises:
            RunFolderError: two campaigns of the same name, or no finished multi-ball case.
        """
        return error_frame(compare_campaigns([side.runs for side in self.found.sides])[0].rows)

    def save(self, to: Folder = "comparison") -> Path:
        """Write the page of the comparison into a folder, and return its path.

        Raises:
            RunFolderError: the folder is there, and is no comparison.
        """
        from millscale.report.compare import write_comparison

        return write_comparison(self.found, Path(to))

    @property
    def _names(self) -> list[str]:
        return [side.name for side in self.found.sides]

    def __repr__(self) -> str:
        parts = list(dict.fromkeys(row.fact.about for row in self.found.differing))
        return f"<comparison of {', '.join(self._names)}: {', '.join(parts) or 'no fact'} differ>"

    def _repr_html_(self) -> str:
        return f"<div>{escape(repr(self)[1:-1])}</div>{self.table._repr_html_()}"


def compare(*runs: Folder) -> Comparison:
    """Compare two or more runs folders: new against worn liner, several speeds, two settings.

    >>> import millscale as ms
    >>> found = ms.compare(runs.folder, other.folder)
    >>> found.differences.index.tolist()
    []
    >>> found.table.query("runs == 'other'")["power_difference"].unique().tolist()
    [0.0]

    Raises:
        RunFolderError: fewer than two folders, one twice, or one without finished case.
    """
    # The figures take a second to load.
    from millscale.report.side_by_side import side_by_side

    return Comparison(side_by_side([Path(folder) for folder in runs]))
