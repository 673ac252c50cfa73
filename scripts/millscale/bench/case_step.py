"""A step of a case from the state of a scene: bare, or with all that a campaign adds."""

from __future__ import annotations

from pathlib import Path

from msgspec import structs

from millscale.bench.state import State
from millscale.campaign.contacts import Precision
from millscale.cases.decks import copy_decks
from millscale.cases.parameters import parameters
from millscale.runs.layout import DUMP_FOLDER
from millscale.runs.writing import write_text

DECK = "case_step.in"


def write_case_step(
    step: str, precision: Precision, state: State, steps: tuple[int, int], folder: Path
) -> str:
    """Write the decks of a step into a folder; return the name of the deck to run.

    Args:
        step: bare or campaign.
        steps: to warm up, and to time.
    """
    copy_decks(("mill.in",), folder)
    (folder / DUMP_FOLDER).mkdir(exist_ok=True)
    mill = state.case.mill
    turned = structs.replace(mill, phase_rad=mill.phase_rad + state.mill_angle)
    values = parameters(structs.replace(state.case, mill=turned)) | {
        "state": str(state.data),
        "step": step,
        "precision": precision,
        "warm_steps": steps[0],
        "steps": steps[1],
        # The cross-section is averaged in the second half of these steps, as of a rotation.
        "rotation_steps": sum(steps),
        "rotation_angle": sum(steps) * state.case.time.step_s * mill.omega_rad_s,
    }
    lines = [f"variable {name} string {value}\n" for name, value in values.items()]
    write_text(folder / "case_values.in", "".join(lines))
    return DECK
