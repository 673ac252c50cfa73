"""The curtains of a charge at one mill angle."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import pandas as pd

from millscale.analysis.shapes.curtain import Curtain, curtain_overlap
from millscale.api.frames import frame


class CurtainProfiles(Mapping[int, Curtain]):
    """Curtains by number; 1 is that of the lifter which threw last.

    Attributes:
        case_id: of the case.
        mill_angle: of the dump [rad].
    """

    def __init__(self, case_id: str, mill_angle: float, found: Mapping[int, Curtain]) -> None:
        self.case_id, self.mill_angle, self._found = case_id, mill_angle, dict(found)

    def __getitem__(self, number: int) -> Curtain:
        return self._found[number]

    def __iter__(self) -> Iterator[int]:
        return iter(self._found)

    def __len__(self) -> int:
        return len(self._found)

    @property
    def table(self) -> pd.DataFrame:
        """A row for each curtain: lifter, balls, and width over R - a."""
        rows = [
            {"number": n, "lifter": x.lifter, "balls": len(x.centres), "width": x.width}
            for n, x in self.items()
        ]
        return frame(
            rows, "number", {"width": "R - a"}, mill_angle_rad=self.mill_angle, case=self.case_id
        )

    def overlap(self, other: CurtainProfiles) -> pd.DataFrame:
        """Return the intersection over union of each curtain that both have: 1 if they are equal.

        Columns: whole, upper and lower (above and below the middle of the curtain of `other`), and
        whole by a second method.
        """
        rows = [
            {"number": n, **curtain_overlap(self[n], other[n])}
            for n in sorted(self.keys() & other.keys())
        ]
        return frame(rows, "number")

    def __repr__(self) -> str:
        return f"<{len(self)} curtains of {self.case_id} at {self.mill_angle:.4g} rad>"

    def _repr_html_(self) -> str:
        return self.table._repr_html_()
