"""Speed against error over the settings of a study: rows, front, recommendations.

Reads study.json of a runs folder, made by `millscale study`, and the cases it names.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from millscale.analysis.charge.comparison import measure_pairs
from millscale.analysis.charge.errors import deviation
from millscale.analysis.charge.scaled_mills import Charge
from millscale.runs.case_folder import (
    SCHEMA,
    RunFolderError,
    finished_or_reason,
    read_json,
)
from millscale.runs.untrusted import is_id, understood
from millscale.study import pareto
from millscale.study.errors import (
    Distances,
    SettingModel,
    compared_pairs,
    errors_of,
    models_of,
    reference_for,
)

Row = dict[str, Any]
STUDY = "study.json"
MADE_BY = "millscale study FILE --runs DIR"
SHORT_SCHEME = {"constant-gravity": "cg", "constant-speed": "cs", "froude": "fr"}


def study_results(runs: Path) -> Row:
    """What a study found: name, about, reference, default, rows, recommendations, time_to_solution,
    missing, problems; keys and units: docs/reference/files.md.

    Raises:
        RunFolderError: no study, or no finished case of its reference.
    """
    runs = Path(runs)
    about = read_json(runs / STUDY, MADE_BY)
    with understood(runs / STUDY, f"make it with: {MADE_BY}"):
        charges, missing = study_charges(runs, about)
        models = models_of(charges)
        try:
            references = [reference_for(model, models, about["reference"]) for model in models]
            if not models:
                raise ValueError("none of its cases is finished")
        except ValueError as error:
            raise RunFolderError(runs, str(error), f"run them with: {MADE_BY}") from None
        measured = measure_pairs(charges, compared_pairs(models, references))
        rows = _rows(about, models, references, Distances(models, measured))
        problems = {"/".join(key): said for key, said in measured.problems.items() if said}
    return {
        "name": about["name"],
        "about": about["about"],
        "reference": about["reference"],
        "default": about["default"],
        "rows": rows,
        "recommendations": pareto.recommendations(rows),
        "time_to_solution": pareto.time_to_solution(rows),
        "missing": missing,
        "problems": problems,
        "hardware": _hardware(charges),
    }


def study_charges(runs: Path, about: Row) -> tuple[list[Charge], dict[str, str]]:
    """The finished cases, each with its setting for a campaign, and why others are not."""
    charges, missing = [], {}
    for setting in about["settings"]:
        if not is_id(setting["name"]):
            cause = f"got {setting['name']!r:.60}, not the name of a setting"
            raise RunFolderError(runs / STUDY, cause, f"make it with: {MADE_BY}")
        for entry in setting["cases"]:
            folder, name = runs / entry["folder"], f"{setting['name']}/{entry['id']}"
            found = finished_or_reason(folder)
            if isinstance(found, str):
                missing[name] = found
            elif entry.get("identity", found.case.identity) != found.case.identity:
                missing[name] = f"case.json: not that of the study's setting; {MADE_BY} makes it"
            else:
                charges.append(Charge(setting["name"], found))
    return charges, missing


def _rows(
    about: Row,
    models: Sequence[SettingModel],
    references: Sequence[SettingModel],
    distances: Distances,
) -> list[Row]:
    told = {setting["name"]: setting["about"] for setting in about["settings"]}
    by_processor = all(_processor_time(c) is not None for m in models for c in m.seeds)
    rows = []
    for model, reference in zip(models, references, strict=True):
        alone = sum(other.setting == model.setting for other in models) == 1
        rows.append(
            {
                "setting": model.setting,
                "label": _label(model, alone),
                "about": told[model.setting],
                "is_reference": model is reference,
                "is_default": model.setting == about["default"],
                "reference": _label(reference, alone=False),
                **_knobs(model),
                **_times(model, by_processor),
                "errors": errors_of(model, reference, distances),
            }
        )
    known = pareto.known_errors(rows)
    for row in rows:
        row["worst"] = None if row["is_reference"] else pareto.worst_of(row["errors"], known)
    fronts = {name: pareto.front(rows, name) for name in (*known, pareto.WORST)}
    for row in rows:
        row["on_front_of"] = [name for name, best in fronts.items() if row in best]
        row["on_front"] = pareto.WORST in row["on_front_of"]
    return rows


def _label(model: SettingModel, alone: bool) -> str:
    """The setting; with scheme and S if it has several models."""
    if alone:
        return model.setting
    case = model.first.case
    policy = "" if case["policy"] == "paper" else f" {case['policy']}"
    scheme = SHORT_SCHEME.get(case["scheme"], case["scheme"])
    return f"{model.setting} {scheme}{policy} S {case['S']:.4g}"


def _knobs(model: SettingModel) -> Row:
    """What a row is of; `engine` is stock where contacts of balls and wall are the engine's own."""
    case = model.first.case
    stock = case["deck"]["surface"] == "default" and case["wall"]["kind"] == "mesh"
    return {
        **{key: case[key] for key in ("scheme", "policy", "S")},
        "stiffness": model.first.stiffness,
        "balls": case["ball"]["count"],
        "step_s": case["time"]["step_s"],
        "engine": "stock" if stock else "millscale",
        "contacts": case["deck"]["surface"],
        "damping": case["deck"].get("tangential_damping"),
        "wall": case["wall"]["kind"],
        "length_m": case["mill"]["simulated_length_m"],
        "rotation_angle_rad": model.first.result["rotation_angle_rad"],
        "seeds": len(model.seeds),
        "ranks": model.first.timing["ranks"],
    }


def _times(model: SettingModel, by_processor: bool) -> Row:
    """Means over the seeds, settling included. `time_s` is that of the processors, which a shared
    machine lengthens less, if every case of the study tells it; else the wall time."""
    wall = [_time_of(charge, "wall_time_s") for charge in model.seeds]
    processor = [_processor_time(charge) for charge in model.seeds]
    times = processor if by_processor else wall
    return {
        "wall_time_s": float(np.mean(wall)),
        "processor_time_s": None if None in processor else float(np.mean(processor)),
        "time_is": "processor" if by_processor else "wall",
        "time_s": float(np.mean(times)),
        "time_spread_s": deviation(times),
    }


def _processor_time(charge: Charge) -> float | None:
    return _time_of(charge, "processor_time_s")


def _time_of(charge: Charge, key: str) -> float | None:
    """Rotation and settling; None if one of the two records does not tell it."""
    try:
        settled = read_json(charge.finished.folder / "settled.json", "millscale run")
    except RunFolderError:
        settled = {key: 0.0}
    parts = [charge.timing.get(key), settled.get(key)]
    return None if None in parts else float(sum(parts))


def _hardware(charges: Sequence[Charge]) -> list[str]:
    found = [charge.timing["hardware"] for charge in charges]
    return list(dict.fromkeys(f"{h['cpu']}, {h['available_cores']} cores" for h in found))


def published(results: Sequence[Row], provenance: Row) -> Row:
    """Content of speed-against-error.json: rows of all studies, each with its `study`, and the rest
    by study."""
    return {
        "schema": SCHEMA,
        "rows": [{"study": r["name"], **row} for r in results for row in r["rows"]],
        "studies": {
            r["name"]: {
                **{key: value for key, value in r.items() if key not in ("rows", "name")},
                "provenance": provenance,
            }
            for r in results
        },
    }


def with_study(content: Row, added: Row) -> Row:
    """speed-against-error.json with the studies of another in place of its own of the same name."""
    names = added["studies"].keys()
    kept = [row for row in content["rows"] if row["study"] not in names]
    studies = {name: s for name, s in content["studies"].items() if name not in names}
    return {**added, "rows": [*kept, *added["rows"]], "studies": studies | added["studies"]}
