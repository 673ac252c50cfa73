"""Speed against error over the settings of a parameter study: rows, front, recommendations.

Reads study.json of a runs folder, made by `millscale study`, and the cases it names.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from millscale.analysis.charge.measured import measure
from millscale.analysis.charge.scaled_mills import ScaledMill, scaled_mills
from millscale.analysis.finished import SETTLED, Charge, damage
from millscale.analysis.means import deviation
from millscale.runs.case_folder import SCHEMA, finished_or_reason, read_json
from millscale.runs.untrusted import RunFolderError, is_id, understood
from millscale.study import pareto
from millscale.study.errors import Distances, compared_pairs, errors_of, reference_for
from millscale.study.pareto import AgainstStock, Recommendation, SettingRow

STUDY = "study.json"
MADE_BY = "millscale study FILE --runs DIR"
SHORT_SCHEME = {"constant-gravity": "cg", "constant-speed": "cs", "froude": "fr"}
Document = dict[str, Any]


@dataclass(frozen=True)
class StudyResults:
    """What a parameter study found; keys and units: docs/reference/files.md.

    Attributes:
        missing: why a case is not among the rows, by setting/id.
        problems: dumps that could not be read, by setting/id.
        hardware: machines that the cases ran on.
    """

    name: str
    about: str
    reference: str
    default: str | None
    rows: list[SettingRow]
    recommendations: list[Recommendation]
    time_to_solution: list[AgainstStock]
    missing: dict[str, str]
    problems: dict[str, list[str]]
    hardware: list[str]

    def document(self) -> Document:
        """Return its content of speed-against-error.json, without name and rows."""
        content = asdict(self)
        return {key: value for key, value in content.items() if key not in ("name", "rows")}


def study_results(runs: Path) -> StudyResults:
    """Return the results of the parameter study of a runs folder.

    Raises:
        RunFolderError: no study, or no finished case of its reference.
    """
    runs = Path(runs)
    about = read_json(runs / STUDY, MADE_BY)
    with understood(runs / STUDY, f"make it with: {MADE_BY}"):
        charges, missing = study_charges(runs, about)
        mills = scaled_mills(charges)
        try:
            references = [reference_for(mill, mills, about["reference"]) for mill in mills]
            if not mills:
                raise ValueError("none of its cases is finished")
        except ValueError as error:
            raise RunFolderError(runs, str(error), f"run them with: {MADE_BY}") from None
        measured = measure(charges, compared_pairs(mills, references))
        rows = _with_fronts(_rows(about, references, Distances(mills, measured)))
        return StudyResults(
            **{key: about[key] for key in ("name", "about", "reference", "default")},
            rows=rows,
            recommendations=pareto.recommendations(rows),
            time_to_solution=pareto.time_to_solution(rows),
            missing=missing,
            problems={
                "/".join(charge.key): [str(problem) for problem in problems]
                for charge, problems in measured.problems.items()
                if problems
            },
            hardware=list(dict.fromkeys(str(charge.timing.hardware) for charge in charges)),
        )


def study_charges(runs: Path, about: Document) -> tuple[list[Charge], dict[str, str]]:
    """Return the finished cases, each with its setting for a campaign, and why others are not.

    Args:
        about: content of study.json.
    """
    charges, missing = [], {}
    for setting in about["settings"]:
        if not is_id(setting["name"]):
            cause = f"got {setting['name']!r:.60}, not the name of a setting"
            raise RunFolderError(runs / STUDY, cause, f"make it with: {MADE_BY}")
        for entry in setting["cases"]:
            found = _charge_or_reason(runs / entry["folder"], setting["name"], entry)
            if isinstance(found, str):
                missing[f"{setting['name']}/{entry['id']}"] = found
            else:
                charges.append(found)
    return charges, missing


def _charge_or_reason(folder: Path, setting: str, entry: Document) -> Charge | str:
    """Return a finished case of a setting, or why it cannot be used.

    Args:
        entry: of the case in study.json.
    """
    found = finished_or_reason(folder)
    if isinstance(found, str):
        return found
    identity = found.case.identity
    if entry.get("identity", identity) != identity:
        return f"case.json: not that of the study's setting; {MADE_BY} makes it"
    charge = Charge(found, setting)
    return damage(charge) or charge


def _rows(
    about: Document, references: Sequence[ScaledMill], distances: Distances
) -> list[SettingRow]:
    """Return a row for each mill, without its worst error and its fronts."""
    mills = distances.mills
    texts = {setting["name"]: setting["about"] for setting in about["settings"]}
    by_processor = all(_time(x, "processor_time_s") is not None for m in mills for x in m.seeds)
    return [
        SettingRow(
            setting=mill.name.campaign,
            label=_label(mill, alone=_is_alone(mill, mills)),
            about=texts[mill.name.campaign],
            is_reference=mill is reference,
            is_default=mill.name.campaign == about["default"],
            reference=_label(reference, alone=False),
            **_setting(mill),
            **_times(mill, by_processor),
            errors=errors_of(mill, reference, distances),
        )
        for mill, reference in zip(mills, references, strict=True)
    ]


def _with_fronts(rows: list[SettingRow]) -> list[SettingRow]:
    """Return the rows with their worst errors and the fronts they are on."""
    known = pareto.known_errors(rows)
    rows = [
        row if row.is_reference else replace(row, worst=pareto.worst_of(row.errors, known))
        for row in rows
    ]
    fronts = {name: pareto.front(rows, name) for name in (*known, pareto.WORST)}
    return [
        replace(row, on_front_of=tuple(n for n, best in fronts.items() if row in best))
        for row in rows
    ]


def _is_alone(mill: ScaledMill, mills: Sequence[ScaledMill]) -> bool:
    return sum(other.name.campaign == mill.name.campaign for other in mills) == 1


def _label(mill: ScaledMill, alone: bool) -> str:
    """Return the setting; with scheme and S if it has several mills."""
    name = mill.name
    if alone:
        return name.campaign
    policy = "" if name.policy == "paper" else f" {name.policy}"
    scheme = SHORT_SCHEME.get(name.scheme, name.scheme)
    return f"{name.campaign} {scheme}{policy} S {name.S:.4g}"


def _setting(mill: ScaledMill) -> Document:
    """Return the fields of a row that come from the case."""
    case = mill.first.case
    stock = case.deck.surface == "default" and case.wall.kind == "mesh"
    return {
        **{key: getattr(mill.name, key) for key in ("scheme", "policy", "S", "stiffness")},
        "balls": case.ball.count,
        "step_s": case.time.step_s,
        "engine": "stock" if stock else "millscale",
        "contacts": case.deck.surface,
        "damping": case.deck.tangential_damping,
        "wall": case.wall.kind,
        "length_m": case.mill.simulated_length_m,
        "rotation_angle_rad": mill.first.result.rotation_angle_rad,
        "seeds": len(mill.seeds),
        "ranks": mill.first.timing.ranks,
    }


def _times(mill: ScaledMill, by_processor: bool) -> Document:
    """Return means over the seeds, settling included.

    Args:
        by_processor: every case of the study has its processor time, which a shared machine
            lengthens less than the wall time.
    """
    wall = [_time(charge, "wall_time_s") for charge in mill.seeds]
    processor = [_time(charge, "processor_time_s") for charge in mill.seeds]
    times = processor if by_processor else wall
    return {
        "wall_time_s": float(np.mean(wall)),
        "processor_time_s": None if None in processor else float(np.mean(processor)),
        "time_is": "processor" if by_processor else "wall",
        "time_s": float(np.mean(times)),
        "time_spread_s": deviation(times),
    }


def _time(charge: Charge, key: str) -> float | None:
    """Return a time of rotation and settling [s]; None if one of the two records lacks it."""
    parts = [getattr(charge.timing, key)]
    if (charge.folder / SETTLED).exists():
        parts.append(getattr(charge.settled, key))
    return None if None in parts else float(sum(parts))


def published(results: Sequence[StudyResults], provenance: Document) -> Document:
    """Return the content of speed-against-error.json: rows of all studies, each with its `study`,
    and the rest by study."""
    return {
        "schema": SCHEMA,
        "rows": [{"study": r.name, **row.document()} for r in results for row in r.rows],
        "studies": {r.name: r.document() | {"provenance": provenance} for r in results},
    }


def with_study(content: Document, added: Document) -> Document:
    """Return speed-against-error.json with the studies of another file, which replace its own.

    Other keys of the file, such as `withdrawn`, stay.
    """
    names = added["studies"].keys()
    kept = [row for row in content["rows"] if row["study"] not in names]
    studies = {name: s for name, s in content["studies"].items() if name not in names}
    return {
        **content,
        **added,
        "rows": [*kept, *added["rows"]],
        "studies": studies | added["studies"],
    }
