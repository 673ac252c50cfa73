"""Error against time step: `millscale validate time-step`.

The scenes are a collision of two balls, a bed at rest and a mill. The rows of the mill come from a
finished study: the settings that differ from its reference only in time step and contact backend.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from millscale.engine.record import provenance
from millscale.runs.case_file import Case, load_case
from millscale.runs.case_folder import (
    CASE,
    STAGE,
    FinishedCase,
    finished_or_reason,
    read_json,
)
from millscale.runs.untrusted import RunFolderError
from millscale.runs.writing import write_json, write_text
from millscale.study.page import REPORT, RESULTS
from millscale.study.results import STUDY
from millscale.validate.cases import CASES, REST, Mill, base_campaign, mill_of
from millscale.validate.collision import collide, contact_time
from millscale.validate.deck import BACKENDS, run_case
from millscale.validate.hard_cases import SEED, step_of
from millscale.validate.scenes import balls_of
from millscale.validate.time_step_page import COMMAND, draw, page
from millscale.validate.verdict import measure

Row = dict[str, Any]
# Fractions of the Rayleigh time. A collision at the first has no error of the step.
EXACT = 0.005
LADDER = (0.05, 0.1, 0.15, 0.2, 0.3, 0.4)
BED = next(case for case in CASES if case.kind == REST and case.steps is None)
# Keys of the dimensionless means of a result.json.
MEANS = ("kinetic", "kinetic_rotation", "power", "centre_z")
ERRORS = ("contour", "curtain", "power")


def collisions(mill: Mill) -> Iterator[Row]:
    """Yield a row for each backend, kind of collision and step."""
    for backend in BACKENDS:
        for kind in ("head-on", "oblique"):
            for share in (EXACT, *LADDER):
                step = share * mill.rayleigh_time
                with tempfile.TemporaryDirectory(prefix="collision-") as folder:
                    found = collide(Path(folder) / "c", mill, backend, step, kind == "oblique")
                yield {
                    "scene": "collision",
                    "kind": kind,
                    **step_of(mill, backend, share),
                    "steps_per_contact": contact_time(mill) / step,
                    **vars(found),
                }


def beds(mill: Mill) -> Iterator[Row]:
    """Yield a row for each backend and step: a bed that should come to rest."""
    balls = balls_of(BED, mill, SEED)
    for backend in BACKENDS:
        for share in LADDER:
            step = share * mill.rayleigh_time
            with tempfile.TemporaryDirectory(prefix="bed-") as folder:
                ran = run_case(Path(folder) / "b", BED, mill, balls, backend, step)
            found = measure(BED, mill, balls, ran)
            numbers = {
                "kinetic_left": found.energy,  # over N m g a
                "spin_noise": found.spin_noise,
                "max_overlap": found.max_overlap,
            }
            yield {
                "scene": "bed",
                **step_of(mill, backend, share),
                **{key: x if np.isfinite(x) else None for key, x in numbers.items()},
                "stopped_by": found.stopped_by,
            }


def mills(study: Path) -> Iterator[Row]:
    """Yield a row for each setting that differs from the reference only in step and backend.

    Raises:
        RunFolderError: not the folder of a finished study.
    """
    about = read_json(study / STUDY, "millscale study")
    results = read_json(study / REPORT / RESULTS, "millscale study")
    errors = {row["setting"]: row for row in results["rows"]}
    folders = {
        setting["name"]: [study / entry["folder"] for entry in setting["cases"]]
        for setting in about["settings"]
    }
    of_reference = _finished(folders[about["reference"]])
    reference = of_reference[0].case
    base = {key: _mean(of_reference, key) for key in MEANS}
    for name, places in folders.items():
        begun = [place for place in places if (place / CASE).exists()]
        if not begun:
            continue
        case = load_case(begun[0])
        backend = backend_of(case)
        if backend is None or _mill_of(case) != _mill_of(reference):
            continue
        cases, time = _finished(places), case.time
        if not cases and all(_stopped(place) is None for place in begun):
            continue
        row = {
            "scene": "mill",
            "setting": name,
            "path": backend,
            "dt": time.step_s,
            "dt_over_rayleigh": time.rayleigh_fraction,
            "dt_over_damping_limit": time.limit_fraction,
            "steps_per_contact": time.steps_per_contact,
            "seeds": len(cases),
            "stopped_by": [cause for cause in map(_stopped, begun) if cause],
            "is_reference": name == about["reference"],
        }
        yield row | (_of_seeds(cases, base, errors[name]) if cases and name in errors else {})


def _of_seeds(cases: Sequence[FinishedCase], base: Row, of_study: Row) -> Row:
    """Return the part of a row that needs finished seeds of a setting."""
    return {
        **{key: _compared(cases, key, base[key]) for key in MEANS},
        "errors": {key: of_study["errors"][key] for key in ERRORS},
        "max_overlap": max(one.result["largest_overlap_over_radius"] for one in cases),
        "time_s": of_study["time_s"],
    }


def _finished(places: Sequence[Path]) -> list[FinishedCase]:
    found = [finished_or_reason(place) for place in places]
    return [case for case in found if not isinstance(case, str)]


def _stopped(place: Path) -> str | None:
    """Return why the rotation of a case failed; None if it did not."""
    try:
        record = read_json(place / STAGE, "millscale study")
    except RunFolderError:
        return None
    return record["cause"] if record.get("state") == "failed" else None


def backend_of(case: Case) -> str | None:
    """Return the backend of a case; None for another combination of contacts and wall."""
    deck, wall = case.deck, case.wall.kind
    if deck.surface == "default":
        return "stock" if wall == "mesh" else None
    if wall != "analytic":
        return None
    if deck.tangential_damping != "bounded":
        return "plain"
    return "mixed" if deck.precision == "mixed" else "default"


def _mill_of(case: Case) -> tuple[Any, ...]:
    """Return what must agree for two cases to differ in step and contact backend alone."""
    return case.material, case.ball, case.mill, case.wall.chord_error_m


def _mean(cases, key: str) -> float:
    return float(np.mean([one.result["dimensionless"][key] for one in cases]))


def _compared(cases, key: str, base: float) -> Row:
    """Return mean of the seeds, and difference and range relative to the reference."""
    values = [one.result["dimensionless"][key] for one in cases]
    mean = float(np.mean(values))
    return {
        "mean": mean,
        "difference": (mean - base) / abs(base),
        "range_of_seeds": (max(values) - min(values)) / abs(base),
    }


def write_time_step(study: Path, docs: Path) -> None:
    """Write results/time-step.json, its figure and results/time-step.md into a folder.

    Args:
        study: runs folder of a finished study, such as campaigns/study-S2.6.toml.

    Raises:
        RunFolderError: not the folder of a finished study.
    """
    mill = mill_of(BED, base_campaign())
    rows = list(mills(study))
    print(f"{len(rows)} settings of the mill", flush=True)
    for found in (collisions(mill), beds(mill)):
        for row in found:
            rows.append(row)
            print(row["scene"], row["path"], f"{row['dt_over_rayleigh']:g} T_R", flush=True)
    record = provenance() | {"command": COMMAND}
    document = {"schema": 1, "restitution": mill.restitution[0], "rows": rows}
    document["provenance"] = record
    write_json(docs / "results" / "time-step.json", document)
    draw(rows, docs / "results" / "time-step.png")
    write_text(docs / "results" / "time-step.md", page(document))
