"""Number of ranks of interrupted attempts, which a resumed run keeps.

Results are bit-identical only on the same number of ranks. Another number is refused unless the
attempt is deleted.
"""

from __future__ import annotations

import shutil
from collections.abc import Collection, Sequence
from dataclasses import replace
from pathlib import Path

from millscale.engine.machine import Allocation, CoreWish
from millscale.errors import CampaignError
from millscale.runs.case_file import Case
from millscale.runs.layout import CASES_FOLDER, STAGES
from millscale.workflow.stage_work import EarlierAttempt, attempt_of

START_OVER = "--start-over"


def keep_ranks(
    allocation: Allocation,
    cases: Sequence[Case],
    changed: Collection[str],
    runs: Path,
    asked: CoreWish,
) -> Allocation:
    """Return an allocation with the ranks of the attempts that the cases resume.

    Args:
        changed: ids of the cases whose case.json is about to change; they start again.
        asked: the options of the command.

    Raises:
        CampaignError: the options ask for other ranks, or the target has fewer cores.
    """
    kept = {}
    for case in cases:
        attempt = attempt_of(runs / CASES_FOLDER / case.id, case)
        if attempt is None or not attempt.ranks or case.id in changed:
            continue
        kept[case.id] = attempt.ranks
        if case.kind == "multi-ball" and asked.ranks not in (None, attempt.ranks):
            raise _refused(case, attempt, asked.ranks)
    most = max(kept.values(), default=1)
    if most > allocation.cores and not asked.oversubscribe:
        case_id = max(kept, key=kept.__getitem__)
        cause = f"{case_id} resumes on the {most} ranks it began with"
        accepted = f"on {allocation.cores} cores: --oversubscribe, or {START_OVER} to start again"
        raise CampaignError("millscale run", "", cause, accepted)
    return replace(
        allocation, ranks={**allocation.ranks, **kept}, cores=max(allocation.cores, most)
    )


def _refused(case: Case, attempt: EarlierAttempt, ranks: int | None) -> CampaignError:
    cause = (
        f"stage {attempt.stage} of {case.id} {attempt.note}, on {attempt.ranks} ranks; "
        f"on {ranks} ranks the results would not be bit-identical"
    )
    accepted = f"--ranks {attempt.ranks} or no --ranks to resume, {START_OVER} to start it again"
    return CampaignError("millscale run", f"--ranks {ranks}", cause, accepted)


def drop_attempts(folder: Path, kind: str) -> None:
    """Delete what interrupted engine stages of a case have left."""
    for stage in STAGES[kind]:
        part = folder / f"{stage.name}.part"
        if stage.deck and part.is_symlink():
            part.unlink()
        elif stage.deck:
            shutil.rmtree(part, ignore_errors=True)
