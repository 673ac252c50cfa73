"""Names of the files of a runs folder; the stages of a case, what each reads and makes.

The workflow, the dry run, the status and the analysis all read this table. Each stage reads a
product of the one before it, so the stages of a case run one after the other.
"""

from __future__ import annotations

from dataclasses import dataclass

CAMPAIGN_FILE = "campaign.json"
CASES_FOLDER = "cases"
CASE_FILE = "case.json"
RESULT_FILE = "result.json"
DUMP_FOLDER = "dump"
BED_DUMP = "settled.dump"
# Beside parameters.in, of a liner that is not of trapezoidal lifters.
PROFILE_FILE = "liner_profile.csv"
# Written where the decks compute the energy budget.
LEDGER_FILES = ("impacts.csv", "ledger.csv")
# Written where the decks record the loads on the liner.
LOADS_FILES = ("lifter_loads.csv", "liner_loads.csv")
# Written where the decks record impacts.
IMPACTS_FILES = ("impact_spectra.csv",)


@dataclass(frozen=True)
class Stage:
    """One step of a case. Files are relative to the case folder.

    Attributes:
        inputs: files it reads; a stage is out of date when one of them has changed.
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
    """Return the stage of that name for a kind of case; KeyError if it has none."""
    return {stage.name: stage for stage in STAGES[kind]}[name]
