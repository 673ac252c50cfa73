"""The stages of a case: what each reads and makes. A stage is done when its products are there.

The workflow, the dry run and the status all read this table. Each stage reads a product of the one
before it, so the stages of a case run one after the other.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

CAMPAIGN_FILE = "campaign.json"
CASES_FOLDER = "cases"
CASE_FILE = "case.json"
RESULT_FILE = "result.json"
DUMP_FOLDER = "dump"


@dataclass(frozen=True)
class Stage:
    """One step of a case. Files are relative to the case folder.

    Attributes:
        inputs: files it reads; it is out of date when one of them is newer than a product.
        products: files it makes, the one that completes it last.
        deck: the deck the engine runs, empty if the stage needs no engine.
    """

    name: str
    inputs: tuple[str, ...]
    products: tuple[str, ...]
    deck: str = ""


_RESULT = Stage("result", (CASE_FILE, "series.csv", "timing.json"), (RESULT_FILE,))

STAGES: dict[str, tuple[Stage, ...]] = {
    "single-ball": (
        Stage("mesh", (CASE_FILE,), ("liner.stl", "mesh.json")),
        Stage("deck", (CASE_FILE, "mesh.json"), ("single_ball.in", "parameters.in")),
        Stage(
            "rotate",
            ("parameters.in", "single_ball.in", "liner.stl"),
            ("series.csv", "timing.json"),
            deck="single_ball.in",
        ),
        _RESULT,
    ),
    "multi-ball": (
        Stage("mesh", (CASE_FILE,), ("liner.stl", "liner.vtp", "mesh.json")),
        Stage("charge", (CASE_FILE, "mesh.json"), ("charge.data",)),
        Stage("deck", (CASE_FILE, "charge.data"), ("settle.in", "mill.in", "parameters.in")),
        Stage(
            "settle",
            ("parameters.in", "settle.in", "liner.stl", "charge.data"),
            ("settled.restart", "settled.json"),
            deck="settle.in",
        ),
        Stage(
            "rotate",
            ("parameters.in", "mill.in", "liner.stl", "settled.restart"),
            ("series.csv", "timing.json"),
            deck="mill.in",
        ),
        _RESULT,
    ),
}


def stage_of(kind: str, name: str) -> Stage:
    """The stage of that name for a kind of case; KeyError if it has none."""
    return {stage.name: stage for stage in STAGES[kind]}[name]


def unfinished(folder: Path, kind: str, case_changed: bool = False) -> list[tuple[Stage, str]]:
    """The stages that have to run, in order, each with the reason.

    Args:
        folder: the case folder; need not exist.
        case_changed: take case.json as newer than every product.
    """
    remade = {CASE_FILE} if case_changed else set()
    waiting = []
    for stage in STAGES[kind]:
        reason = _reason(folder, stage, remade)
        if reason:
            waiting.append((stage, reason))
            remade.update(stage.products)
    return waiting


def _reason(folder: Path, stage: Stage, remade: set[str]) -> str:
    """Why a stage has to run, empty if it is up to date."""
    for product in stage.products:
        if not (folder / product).exists():
            return f"no {product}"
    for name in stage.inputs:
        if name in remade:
            return f"new {name}"
    oldest = min(stage.products, key=lambda product: _modified(folder / product))
    for name in stage.inputs:
        if _modified(folder / name) > _modified(folder / oldest):
            return f"{name} is newer than {oldest}"
    return ""


def _modified(path: Path) -> int:
    """Time of the last change [ns]; that of a missing file is later than any."""
    try:
        return path.stat().st_mtime_ns
    except FileNotFoundError:
        return 2**63
