"""The finished cases of a campaign, gathered from its runs folder, and report/results.json."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from millscale.analysis.charge.comparison import ChargeComparison, compare_charges
from millscale.analysis.checks import Check, campaign_checks
from millscale.analysis.finished import Charge, SingleBall, damage
from millscale.analysis.paper import numbers as paper
from millscale.analysis.single_ball.comparison import (
    Regression,
    SingleBallRow,
    regressions,
    single_ball_rows,
)
from millscale.analysis.single_ball.windows import common_windows
from millscale.runs.case_file import is_outdated
from millscale.runs.case_folder import (
    SCHEMA,
    case_folders,
    finished_or_reason,
    read_json,
    verify_line,
)
from millscale.runs.untrusted import understood

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
    single: list[SingleBall]
    charges: list[Charge]
    missing: dict[str, str] = field(default_factory=dict)

    @property
    def cases(self) -> list[SingleBall | Charge]:
        return [*self.single, *self.charges]

    @cached_property
    def rows(self) -> list[SingleBallRow]:
        """Return a row for each single-ball case."""
        return single_ball_rows(self.single)

    @cached_property
    def fits(self) -> list[Regression]:
        """Return a row for each scheme and policy."""
        return regressions(self.rows)

    @cached_property
    def comparison(self) -> ChargeComparison:
        """Return every multi-ball case against the physical mill; reads their dumps."""
        return compare_charges(self.charges)

    @cached_property
    def checks(self) -> dict[str, Check]:
        fits = self.fits if self.of_paper else []
        return campaign_checks(self.rows, fits, self.charges, self.missing)

    @cached_property
    def of_paper(self) -> bool:
        """Return whether the physical mill is the paper's, whose numbers are shown then."""
        return all(paper.is_papers_mill(case.case) for case in self.cases)

    @property
    def name(self) -> str:
        return campaign_name(self.runs, self.about)

    def results(self) -> dict[str, Any]:
        """Return the content of report/results.json.

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
            "single_ball": [row.document() for row in self.rows],
            "regressions": [fit.document() for fit in self.fits],
            "energy_windows": {
                scheme: {
                    "begin_rad": window.begin,
                    "end_rad": window.end,
                    "from_throw_rad": window.from_throw,
                    "limited_by": window.limited_by,
                }
                for scheme, window in windows.items()
            },
            "multi_ball": [_charge_document(charge) for charge in self.charges],
            "charge_errors": [row.document() for row in self.comparison.rows],
            "charge_schemes": [row.document() for row in self.comparison.schemes],
            "checks": {name: asdict(check) for name, check in self.checks.items()},
            "missing": self.missing,
        }


def campaign_name(runs: Path, about: dict[str, Any]) -> str:
    """Return the name of the campaign of a runs folder.

    Args:
        about: content of campaign.json.
    """
    return str(about.get("name") or runs.resolve().name)


def load_campaign(runs: Path) -> Campaign:
    """Gather the finished cases of a runs folder.

    Raises:
        RunFolderError: it holds no campaign.
    """
    runs = Path(runs)
    folders = case_folders(runs)
    about = read_json(runs / "campaign.json", "millscale generate FILE --runs DIR")
    single, charges, missing = [], [], {}
    for folder in folders:
        found = finished_or_reason(folder)
        if isinstance(found, str):
            missing[folder.name] = found
        elif is_outdated(about, found.case):
            missing[folder.name] = OUTDATED
        elif found.case.kind == "single-ball":
            single.append(SingleBall(found))
        else:
            charges.append(Charge(found, campaign_name(runs, about)))
    for cases in (single, charges):
        damaged = {case: why for case in cases if (why := damage(case))}
        missing |= {case.id: why for case, why in damaged.items()}
        cases[:] = sorted(
            (case for case in cases if case not in damaged), key=lambda case: case.place
        )
    return Campaign(runs, about, single, charges, missing)


def _charge_document(charge: Charge) -> dict[str, Any]:
    """Return the row of a multi-ball case in results.json."""
    case, result, timing = charge.case, charge.result, charge.timing
    reported = paper.reported_charge(charge.S) if paper.is_papers_mill(case) else None
    document = result.document()
    return {
        **{key: getattr(case, key) for key in ("id", "scheme", "policy", "S", "seed")},
        "balls": charge.balls,
        "ranks": timing.ranks,
        "wall_time_s": timing.wall_time_s,
        "settle_wall_time_s": charge.settled.wall_time_s,
        "particle_steps_per_s_core": timing.particle_steps_per_s_core,
        "paper_wall_time_h": reported["elapsed_h"] if reported else None,
        **result.mean,
        **{key: document[key] for key in document if key not in ("mean", "ledger", "impacts")},
    }
