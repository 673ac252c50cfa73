"""A runs folder: its finished cases, their errors, the prediction of the physical mill."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from html import escape
from os import PathLike
from pathlib import Path
from typing import Any

import pandas as pd

from millscale.analysis.case_rows import case_rows
from millscale.analysis.finished_campaign import Campaign, load_campaign
from millscale.api.case_folder import CaseFolder
from millscale.api.frames import error_frame, frame
from millscale.api.predicting import predict
from millscale.errors import nearest
from millscale.formats import counted
from millscale.prediction.result import Prediction

Folder = str | PathLike[str]
# Ids that a message lists.
_LISTED = 8


class RunsFolder(Mapping[str, CaseFolder]):
    """A runs folder, as a mapping of its finished cases by id.

    >>> case = runs["mb-cg-paper-S1.000-fixed-seed1"]
    >>> "mb-cg-paper-S1.000-fixed-seed1" in runs, len(runs) == len(runs.cases)
    (True, True)

    Attributes:
        campaign: the folder as `millscale.analysis` reads it.
    """

    def __init__(self, runs: Folder) -> None:
        self.campaign: Campaign = load_campaign(Path(runs))
        self._cases = {case.id: CaseFolder(case) for case in self.campaign.cases}

    @property
    def folder(self) -> Path:
        """The runs folder."""
        return self.campaign.runs

    @property
    def name(self) -> str:
        """Name of the campaign."""
        return self.campaign.name

    @property
    def missing(self) -> dict[str, str]:
        """Why a case is not among the finished ones, by its id."""
        return dict(self.campaign.missing)

    def __getitem__(self, case_id: str) -> CaseFolder:
        """Return a finished case.

        Raises:
            KeyError: no such case, or one that is not finished; the message states why.
        """
        if case_id in self._cases:
            return self._cases[case_id]
        if case_id in self.missing:
            raise KeyError(f"{case_id}: {self.missing[case_id]}")
        near = nearest(case_id, self._cases)
        hint = f", nearest is {near}" if near else ""
        listed = ", ".join(list(self)[:_LISTED]) + (", ..." if len(self) > _LISTED else "")
        raise KeyError(f"{case_id}: no such case{hint}; accepted: {listed or 'none is finished'}")

    def __iter__(self) -> Iterator[str]:
        return iter(self._cases)

    def __len__(self) -> int:
        return len(self._cases)

    @property
    def cases(self) -> pd.DataFrame:
        """A row for each finished case: what it is and its main results; units in `attrs`.

        power_kW is that of the physical mill, power_number is power over M g R omega. Both are of
        multi-ball cases, detach_angle_deg is of single balls.

        >>> runs.cases.loc["mb-cg-paper-S1.000-fixed-seed1", "S"]
        np.float64(1.0)
        >>> runs.cases.attrs["units"]["power_kW"]
        'kW'
        """
        return frame(case_rows(self.campaign), "id")

    @property
    def single_balls(self) -> pd.DataFrame:
        """A row for each single-ball case: throw and energy ratio, with the keys of results.json
        (docs/reference/files.md)."""
        return frame([row.document() for row in self.campaign.rows], "id")

    def errors(self) -> pd.DataFrame:
        """Return a row for each multi-ball case: its errors against its reference; reads all dumps.

        The reference is the physical mill, or the largest mill there is. `attrs` has the units and
        labels. docs/theory/charge-shape.md defines the errors.

        >>> runs.errors().attrs["units"]["contour_error_mean"]
        'R - a'
        """
        return error_frame(self.campaign.comparison.rows)

    def predict(self, **options: Any) -> Prediction:
        """Return `millscale.predict` of this folder."""
        return predict(self.folder, **options)

    def export(self, kind: str, to: Folder | None = None, **options: Any) -> list[Path]:
        """Return `millscale.export` of this folder: files for ParaView, OVITO, or tables."""
        return export(self.folder, kind, to, **options)

    def report(self) -> Path:
        """Write report/index.html as `millscale report` does, and return its path."""
        from millscale.report.build import build_report

        return build_report(self.folder)

    def _title(self) -> str:
        singles, charges = len(self.campaign.single), len(self.campaign.charges)
        text = f"{self.folder}: {counted(singles, 'single ball')}, {counted(charges, 'charge')}"
        missing = len(self.campaign.missing)
        return text + (f", {counted(missing, 'case')} not finished" if missing else "")

    def __repr__(self) -> str:
        return f"<runs folder {self._title()}>"

    def _repr_html_(self) -> str:
        lines = [f"{name}: {why}" for name, why in self.campaign.missing.items()]
        notes = "".join(f"<div>{escape(line)}</div>" for line in lines)
        return f"<div>{escape(self._title())}</div>{self.cases._repr_html_()}{notes}"


def open(runs: Folder) -> RunsFolder:
    """Open a runs folder of `millscale run`.

    Args:
        runs: such as "runs/quick"; a str or a Path.

    >>> import millscale as ms
    >>> ms.open(runs.folder).name
    'synthetic'

    Raises:
        RunFolderError: the folder holds no campaign.
    """
    return RunsFolder(runs)


def export(
    runs: Folder,
    kind: str,
    to: Folder | None = None,
    *,
    only: str | Sequence[str] = (),
    every: int = 1,
    replace: bool = False,
) -> list[Path]:
    """Write the finished cases of a runs folder for another program, as `millscale export` does.

    Args:
        kind: paraview, ovito or csv.
        to: folder to write; None for DIR/export/KIND. It must be new, unless `replace`.
        only: ids of cases, or patterns with `*`; empty for every case.
        every: write every so many dumps.
        replace: replace an earlier export.

    Returns:
        The files to open.

    >>> import millscale as ms
    >>> tables = ms.export(runs.folder, "csv", new_folder, only="*S2.600-fixed-seed1", every=3)
    >>> [path.name for path in tables]
    ['cases.csv', 'series.csv', 'series.csv']

    Raises:
        RunFolderError: no such case, nothing to write, or a folder that is there.
        ValueError: no such format.
    """
    from millscale.exports.command import FORMATS
    from millscale.exports.command import export as write

    if kind not in FORMATS:
        raise ValueError(f"kind: got {kind!r}; accepted: {', '.join(FORMATS)}")
    if every < 1:
        raise ValueError(f"every: got {every}; accepted: >= 1")
    patterns = [only] if isinstance(only, str) else list(only)
    target = None if to is None else Path(to)
    return write(Path(runs), kind, target, patterns, every, replace).files
