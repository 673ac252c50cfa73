"""A campaign's finished cases gathered from its runs folder, and report/results.json."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from millscale.analysis.charge.comparison import ChargeComparison, compare_charges
from millscale.analysis.charge.scaled_mills import Charge
from millscale.analysis.checks import campaign_checks
from millscale.analysis.paper import numbers as paper
from millscale.analysis.single_ball import comparison
from millscale.analysis.single_ball.windows import common_windows
from millscale.runs.case_file import is_outdated
from millscale.runs.case_folder import (
    SCHEMA,
    FinishedCase,
    case_folders,
    finished_or_reason,
    read_json,
    verify_line,
)
from millscale.runs.untrusted import understood

Row = dict[str, Any]
OUTDATED = "case.json: campaign.toml was changed since; millscale run FILE --runs DIR makes it anew"


@dataclass(frozen=True)
class Campaign:
    """What a runs folder holds.

    Attributes:
        about: content of campaign.json.
        single: finished single-ball cases, in the order of their rows.
        charges: finished multi-ball cases.
        missing: why a case is not among them, by its id.
    """

    runs: Path
    about: dict[str, Any]
    single: list[FinishedCase]
    charges: list[FinishedCase]
    missing: dict[str, str] = field(default_factory=dict)

    @cached_property
    def rows(self) -> list[Row]:
        """A row for each single-ball case."""
        return comparison.single_ball_rows(self.single)

    @cached_property
    def fits(self) -> list[Row]:
        """A row for each scheme and policy."""
        return comparison.regressions(self.rows)

    @cached_property
    def charge_rows(self) -> list[Row]:
        """A row for each multi-ball case."""
        return [_charge_row(case) for case in self.charges]

    @cached_property
    def comparison(self) -> ChargeComparison:
        """Every multi-ball case against the physical mill; reads their dumps."""
        return compare_charges([Charge(self.name, case) for case in self.charges])

    @cached_property
    def checks(self) -> dict[str, Row]:
        fits = self.fits if self.of_paper else []
        return campaign_checks(self.rows, fits, self.charges, self.missing)

    @property
    def of_paper(self) -> bool:
        """Whether the physical mill is the paper's, whose numbers stand beside these then."""
        return all(paper.is_papers_mill(case.case) for case in [*self.single, *self.charges])

    @property
    def name(self) -> str:
        return str(self.about.get("name") or self.runs.resolve().name)

    def results(self) -> dict[str, Any]:
        """Content of report/results.json.

        Raises:
            RunFolderError: a result.json or timing.json holds something else than it should.
        """
        with understood(self.runs, f"find the file with: {verify_line(self.runs)}"):
            return self._results()

    def _results(self) -> dict[str, Any]:
        windows = common_windows(self.single)
        return {
            "schema": SCHEMA,
            "campaign": self.name,
            "single_ball": self.rows,
            "regressions": self.fits,
            "energy_windows": {
                scheme: {
                    "begin_rad": window.begin,
                    "end_rad": window.end,
                    "from_throw_rad": window.from_throw,
                    "limited_by": window.limited_by,
                }
                for scheme, window in windows.items()
            },
            "multi_ball": self.charge_rows,
            "charge_errors": self.comparison.rows,
            "charge_schemes": self.comparison.schemes,
            "checks": self.checks,
            "missing": self.missing,
        }


def load_campaign(runs: Path) -> Campaign:
    """Gather the finished cases of a runs folder.

    Raises:
        RunFolderError: it holds no campaign.
    """
    folders = case_folders(runs)
    about = read_json(runs / "campaign.json", "millscale generate FILE --runs DIR")
    finished, missing = [], {}
    for folder in folders:
        found = finished_or_reason(folder)
        if isinstance(found, str):
            missing[folder.name] = found
        elif is_outdated(about, found.case):
            missing[folder.name] = OUTDATED
        else:
            finished.append(found)
    finished.sort(key=comparison.place)
    single = [case for case in finished if case.case["kind"] == "single-ball"]
    charges = [case for case in finished if case.case["kind"] == "multi-ball"]
    return Campaign(Path(runs), about, single, charges, missing)


def settling_time(case: FinishedCase) -> float | None:
    """Wall time of the settling stage [s], None if it left no record."""
    try:
        return read_json(case.folder / "settled.json", "millscale run")["wall_time_s"]
    except (OSError, ValueError, KeyError):
        return None


def _charge_row(case: FinishedCase) -> Row:
    document, result, timing = case.case, case.result, case.timing
    of_paper = paper.is_papers_mill(document)
    reported = paper.reported_charge(document["S"]) if of_paper else None
    return {
        **{key: document[key] for key in ("id", "scheme", "policy", "S", "seed")},
        "balls": document["ball"]["count"],
        "ranks": timing["ranks"],
        "wall_time_s": timing["wall_time_s"],
        "settle_wall_time_s": settling_time(case),
        "particle_steps_per_s_core": timing["particle_steps_per_s_core"],
        "paper_wall_time_h": reported["elapsed_h"] if reported else None,
        **{key: result[key] for key in ("problem", "mean_from_rad", "mean_to_rad")},
        **result["mean"],
        "dimensionless": result["dimensionless"],
        **{
            key: result[key]
            for key in (
                *("pitches", "standard_error", "torque_balance"),
                *("alternating_torque", "steady"),
            )
        },
        "largest_overlap_over_radius": result["largest_overlap_over_radius"],
    }
