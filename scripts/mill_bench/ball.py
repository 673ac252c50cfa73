"""Steps per second of a single ball with the mesh and with the analytic wall."""

from __future__ import annotations

import shutil
import statistics
import subprocess
from pathlib import Path

from rich.console import Console

from mill_campaign.engine_log import error_line, loop_timing
from mill_campaign.engine_run import engine_environment, find_engine
from mill_campaign.errors import CampaignError
from mill_campaign.machine import CoreWish
from mill_campaign.run_command import request, run_campaign

BALL = Path(__file__).parent / "ball.toml"
CASE = "sb-cg-paper-S1.000"
KINDS = ("mesh", "analytic")


def ball_speedup(repeats: int, runs: Path, console: Console) -> dict:
    """Steps per second of both walls, in turns on one core, and the median of their ratio.

    The deck, output and all, is that of the paper's campaign.
    """
    folders = {kind: _prepare(kind, runs / f"ball-{kind}", console) for kind in KINDS}
    speeds: dict[str, list[float]] = {kind: [] for kind in KINDS}
    for turn in range(repeats):
        for kind in KINDS:
            speeds[kind].append(_steps_per_s(folders[kind], runs / "timed" / kind))
            console.print(
                f"round {turn + 1}/{repeats} {kind} wall: {speeds[kind][-1]:,.0f} steps/s"
            )
    ratios = [a / m for a, m in zip(speeds["analytic"], speeds["mesh"], strict=True)]
    return {
        "ratio": statistics.median(ratios),
        **{f"{kind}_steps_per_s": speeds[kind] for kind in KINDS},
    }


def _prepare(kind: str, folder: Path, console: Console) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    campaign = folder / BALL.name
    campaign.write_text(BALL.read_text().replace('kind = "analytic"', f'kind = "{kind}"'))
    if not run_campaign(request(campaign, folder, [CASE], CoreWish()), console):
        raise CampaignError(
            "millscale bench", "ball", "the run failed", f"see millscale status {folder}"
        )
    return folder / "cases" / CASE


def _steps_per_s(case_folder: Path, folder: Path) -> float:
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for path in (*case_folder.glob("*.in"), case_folder / "liner.stl"):
        shutil.copyfile(path, folder / path.name)
    done = subprocess.run(
        [find_engine(), "-in", "single_ball.in"],
        cwd=folder,
        env=engine_environment(),
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        errors="replace",
    )
    loop, cause = loop_timing(done.stdout), error_line(done.stdout + done.stderr)
    if loop is None or cause:
        raise RuntimeError(f"single_ball.in in {folder}: {cause or 'no time loop'}")
    return loop.steps / loop.loop_time
