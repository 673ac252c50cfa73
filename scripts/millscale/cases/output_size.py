"""Disk that a case takes, predicted from its output intervals, and a check of the free space."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path

from millscale.errors import CampaignError
from millscale.runs.case_file import Case

# Bytes, rounded up from the files of single balls and of charges of 4,171 to 13,370 balls.
SERIES_ROW = {"single-ball": 500, "multi-ball": 420}
DUMPED_BALL, DUMP_HEAD = 90, 400
PACKED_BALL = 90  # charge.data
SETTLED_BALL = 600  # settled.restart, of which DIR/settled keeps a copy
MOVING_BALL = 1000  # a restart file of the turning mill; the last two are kept
OCCUPANCY = 640_000
LEDGER_ROW, IMPACTS = 650, 20_000
# Most rows of liner_loads.csv and lifter_loads.csv for each class of balls: 130 bins in 190 places
# and in 100 sectors.
LINER_LOADS = 220 * 130 * (190 + 100)
# impact_spectra.csv of a pair of classes of balls: 112 bins twice.
CONTACT_SPECTRA = 2 * 112 * 150
TRIANGLE = 350  # liner.stl and liner.vtp
LOG_LINE = 60  # in log.STAGE and in out.STAGE
FIXED = 150_000  # decks, records, the rest of the logs
# Left free for everything else on the disk.
SPARE = 100_000_000


def output_bytes(case: Case) -> int:
    """Return the upper limit of the disk that a case and its settled bed take [bytes]."""
    kind, balls, time, output = case.kind, case.ball.count, case.time, case.output
    rows = time.steps // output.sample_steps + 2
    lines = (time.settle_steps + time.steps) // output.thermo_steps + 10
    total = FIXED + TRIANGLE * case.wall.triangles
    total += SERIES_ROW[kind] * rows + 2 * LOG_LINE * lines
    if case.deck.dumps == "on":
        total += (time.steps // output.dump_steps + 2) * (DUMP_HEAD + DUMPED_BALL * balls)
    if case.deck.ledger == "on":
        total += LEDGER_ROW * rows + IMPACTS
    if case.deck.liner_loads == "on":
        total += LINER_LOADS * max(1, len(case.ball.classes or ()))
    if case.deck.impacts == "on":
        classes = max(1, len(case.ball.classes or ()))
        total += CONTACT_SPECTRA * classes * (classes + 3) // 2
    if kind == "multi-ball":
        total += OCCUPANCY + (PACKED_BALL + 2 * SETTLED_BALL + 2 * MOVING_BALL) * balls
    return total


def check_budget(file: Path, case: Case, budget: float) -> None:
    """Refuse a case that would write more than the campaign allows.

    Args:
        file: the campaign file.
        budget: of a case [bytes].

    Raises:
        CampaignError: names the case and its size.
    """
    size = case.predicted.output_bytes
    if size > budget:
        raise CampaignError(
            file,
            "run.output_gb",
            f"{case.id} would write {size / 1e9:.3g} GB, the budget of a case is "
            f"{budget / 1e9:.3g} GB",
            "a larger dump_angle_rad or sample_angle_rad, or a larger run.output_gb",
        )


def check_disk(runs: Path, cases: Sequence[Case], done: Sequence[bool]) -> None:
    """Refuse to begin what the disk cannot hold.

    Args:
        runs: runs folder; need not exist.
        done: whether each case has written its output already.

    Raises:
        CampaignError: says what is needed and what is free.
    """
    place = runs.absolute()
    while not place.exists():
        place = place.parent
    needed = sum(
        case.predicted.output_bytes for case, there in zip(cases, done, strict=True) if not there
    )
    free = shutil.disk_usage(place).free
    if needed and needed + SPARE > free:
        raise CampaignError(
            runs,
            "",
            f"the cases to do write {size_text(needed)}, the disk has {size_text(free)} free",
            "free some disk, another --runs, fewer cases (--only), or --ignore-disk",
        )


def size_text(size: float) -> str:
    """Return a size for people: 12 kB, 3.4 MB, 1.2 GB."""
    for unit, factor in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if size >= factor:
            value = size / factor
            return f"{value:.1f} {unit}" if value < 10.0 else f"{value:.0f} {unit}"
    return f"{size:.0f} B"
