"""Steps per second of a single ball with the mesh and with the analytic wall."""

from __future__ import annotations

import shutil
import statistics
from pathlib import Path

import numpy as np
from rich.console import Console

from millscale.bench.running import engine_output, finish_campaign
from millscale.engine.deck_run import find_engine
from millscale.engine.log import loop_timing
from millscale.runs.series import Series, read_series
from millscale.runs.writing import write_text

BALL = Path(__file__).parent / "ball.toml"
CASE = "sb-cg-paper-S1.000"
KINDS = ("mesh", "analytic")
# At this angle the ball lies in the corner of groove and lifter.
LIFTED_ANGLE_RAD = 2.0
# All balls of the paper's mills fly from 2.6 to 3.57 rad (docs/results/reproduction.md).
LAST_ANGLE_RAD = 3.5
# The default, 2.5 % of the ball radius, and its half, quarter and eighth.
CHORD_ERRORS_M = (5e-4, 2.5e-4, 1.25e-4, 6.25e-5)


def ball_speedup(repeats: int, runs: Path, console: Console) -> dict:
    """Return the steps per second of both walls, in turns on one core, and their median ratio.

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


def mesh_convergence(runs: Path, console: Console) -> dict:
    """Compare the path of the ball on finer and finer meshes with that on the analytic wall.

    Distances are the largest over the samples up to LAST_ANGLE_RAD, in the first throw, that at
    its end, and that at LIFTED_ANGLE_RAD; once the ball has landed, a distance grows with every
    impact.
    """
    exact = _path(_prepare("analytic", runs / "ball-analytic", console))
    end, lifted = (
        int(np.searchsorted(exact["mill_angle_rad"], angle))
        for angle in (LAST_ANGLE_RAD, LIFTED_ANGLE_RAD)
    )
    rows = []
    for chord_error in CHORD_ERRORS_M:
        folder = runs / f"ball-mesh-{chord_error:g}"
        mesh = _path(_prepare("mesh", folder, console, chord_error))
        apart = np.hypot(mesh["x_m"] - exact["x_m"], mesh["z_m"] - exact["z_m"])
        energy = mesh["kinetic_translation_J"] - exact["kinetic_translation_J"]
        rows.append(
            {
                "chord_error_m": chord_error,
                "largest_distance_m": float(apart[:end].max()),
                "distance_on_the_lifter_m": float(apart[lifted]),
                "distance_at_the_end_m": float(apart[end - 1]),
                "kinetic_energy_at_the_end_J": float(abs(energy[end - 1])),
            }
        )
    return {"to_mill_angle_rad": float(exact["mill_angle_rad"][end - 1]), "meshes": rows}


def _path(case_folder: Path) -> Series:
    return read_series(case_folder / "series.csv", "single-ball")


def _prepare(kind: str, folder: Path, console: Console, chord_error: float | None = None) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    campaign = folder / BALL.name
    wall = f'kind = "{kind}"' + (f"\nchord_error_m = {chord_error!r}" if chord_error else "")
    write_text(campaign, BALL.read_text(encoding="utf-8").replace('kind = "analytic"', wall))
    finish_campaign(campaign, folder, [CASE], console)
    return folder / "cases" / CASE


def _steps_per_s(case_folder: Path, folder: Path) -> float:
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for path in (*case_folder.glob("*.in"), *case_folder.glob("liner.stl")):
        shutil.copyfile(path, folder / path.name)
    loop = loop_timing(engine_output([find_engine(), "-in", "single_ball.in"], folder))
    if loop is None:
        raise RuntimeError(f"single_ball.in in {folder}: no time loop")
    return loop.steps / loop.loop_time
