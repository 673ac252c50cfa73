"""Single-ball cases of a campaign against each other and against the law's prediction."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from scipy.stats import linregress

from millscale.analysis.paper import numbers as paper
from millscale.analysis.single_ball import energy
from millscale.analysis.single_ball.result import ball_of, flight_of
from millscale.analysis.single_ball.windows import Window, common_windows
from millscale.runs.case_folder import FinishedCase, is_physical

Row = dict[str, Any]
POLICIES = ("paper", "corrected", "offset-liner")
# Energies are compared between mill angles common to all models, from each model's own throw, and
# between the paper's mill angles: prefixes of the keys.
MEASURES = ("", "from_throw_", "paper_angles_")
_ANGLES = ("detach_angle_", "liner_off_angle_")
_ENERGY_KEYS = (
    *("throw_rad", "energy_begin_rad", "energy_end_rad", "energy_change_J"),
    *("from_throw_window_rad", "from_throw_energy_change_J"),
    *("off_parabola", "energy_imbalance"),
)
T = TypeVar("T")
Key = tuple[str, str, float]


def single_ball_rows(cases: list[FinishedCase]) -> list[Row]:
    """A row for each case, by scheme, policy and S; keys and units: docs/reference/files.md.

    Energies are changes on the parabola of the first throw. Ratios are to S = 1 of the same scheme
    and policy, or of another policy: all policies are the same mill there.
    """
    windows = common_windows(cases)
    rows = [_row(case, windows.get(case.case["scheme"])) for case in sorted(cases, key=place)]
    for row in rows:
        _compare(row, _reference(row, rows))
    return rows


def ratio_key(measure: str) -> str:
    """Key of the energy ratio of a measure."""
    return f"{measure}ratio" if measure else "energy_ratio"


def place(case: FinishedCase) -> tuple:
    """Place of a case in tables: by scheme, policy and S."""
    document = case.case
    return document["scheme"], POLICIES.index(document["policy"]), document["S"], case.id


def policy_models(entries: list[T], key: Callable[[T], Key]) -> dict[tuple[str, str], list[T]]:
    """Models of each scheme and policy. At S = 1 all policies are the same mill: a policy without
    such a model borrows another's.

    Args:
        entries: in the order of `place`.
        key: scheme, policy and S of an entry.
    """
    groups: dict[tuple[str, str], list[T]] = {}
    for entry in entries:
        groups.setdefault(key(entry)[:2], []).append(entry)
    for (scheme, _), group in groups.items():
        if not any(is_physical(key(entry)[2]) for entry in group):
            same = (e for e in entries if key(e)[0] == scheme and is_physical(key(e)[2]))
            group[:0] = list(same)[:1]
    return groups


def row_key(row: Row) -> Key:
    """Scheme, policy and S of a row."""
    return row["scheme"], row["policy"], row["S"]


def case_key(case: FinishedCase) -> Key:
    """Scheme, policy and S of a case."""
    return case.case["scheme"], case.case["policy"], case.case["S"]


def regressions(rows: list[Row]) -> list[Row]:
    """Ratio against prediction for each scheme and policy: regression line, worst deviation over
    S > 1, spread of the detach angles (largest minus smallest)."""
    groups = policy_models(rows, row_key)
    return [_regression(scheme, policy, group) for (scheme, policy), group in groups.items()]


def regression_line(predicted: list[float], ratio: list[float]) -> dict[str, float | None]:
    """Least-squares line and Pearson correlation; None below three points, where any line fits."""
    if len(set(predicted)) < 3:
        return {"slope": None, "intercept": None, "correlation": None}
    line = linregress(predicted, ratio)
    return {
        "slope": float(line.slope),
        "intercept": float(line.intercept),
        "correlation": float(line.rvalue),
    }


def _row(case: FinishedCase, window: Window | None) -> Row:
    document, result = case.case, case.result
    mill, fixed = document["mill"], result["paper_angles"]
    row = {
        **{key: document[key] for key in ("id", "scheme", "policy", "S")},
        **{key: mill[key] for key in ("radius_m", "gravity_m_s2", "omega_rad_s", "froude")},
        **{key: value for key, value in result.items() if key.startswith(_ANGLES)},
        "point_mass_detach_angle_deg": mill["detach_angle_deg"],
        "cycles": result["cycles"],
        "problem": result["problem"],
        **_energy(case, window),
        "paper_angles_energy_change_J": abs(fixed["kinetic_J"]) if fixed else None,
        "paper_angles_in_flight": fixed["in_flight"] if fixed else None,
        "predicted_ratio": document["predicted_energy_ratio"],
        "centre_path_ratio": document["centre_path_energy_ratio"],
        "wall_time_s": case.timing["wall_time_s"],
    }
    of_paper = paper.is_papers_mill(document)
    reported = paper.reported_energy(row["scheme"], row["S"]) if of_paper else None
    row["paper_energy_change_J"] = reported.change if reported else None
    row["paper_energy_ratio"] = reported.ratio if reported else None
    return row


def _energy(case: FinishedCase, window: Window | None) -> Row:
    """Energy changes between the common mill angles and from the case's own throw; over the
    latter, how far the samples are off the parabola, and the sum of what kinetic energy gains and
    potential energy loses."""
    if not case.result["throws"]:
        return dict.fromkeys(_ENERGY_KEYS)
    throw, sampled = case.result["throws"][0], case.result["throw_energy"]
    flight, ball = flight_of(throw), ball_of(case.case)
    begin = throw["mill_angle_rad"]
    common = energy.change_on_parabola(flight, ball, window.begin, window.end)
    own = energy.change_on_parabola(flight, ball, begin, begin + window.from_throw)
    off = max(sampled["off_parabola_kinetic_J"], sampled["off_parabola_potential_J"])
    imbalance = abs(sampled["kinetic_sampled_J"] + sampled["potential_sampled_J"])
    values = (
        *(begin, window.begin, window.end),
        abs(common) if window.end > window.begin else None,
        *(window.from_throw, abs(own)),
        *((off / abs(own), imbalance / abs(own)) if own else (None, None)),
    )
    return dict(zip(_ENERGY_KEYS, values, strict=True))


def _reference(row: Row, rows: list[Row]) -> Row | None:
    physical = [r for r in rows if r["scheme"] == row["scheme"] and is_physical(r["S"])]
    same_policy = [r for r in physical if r["policy"] == row["policy"]]
    return next(iter(same_policy + physical), None)


def _compare(row: Row, reference: Row | None) -> None:
    row["reference"] = reference["id"] if reference else None
    for name in MEASURES:
        change = f"{name}energy_change_J"
        known = reference is not None and row[change] is not None and reference[change]
        row[ratio_key(name)] = row[change] / reference[change] if known else None
        row[f"{name}relative_error"] = _relative(row[ratio_key(name)], row["predicted_ratio"])
    row["relative_error_to_centre_path"] = _relative(row["energy_ratio"], row["centre_path_ratio"])


def _relative(ratio: float | None, predicted: float) -> float | None:
    return None if ratio is None else ratio / predicted - 1.0


def _regression(scheme: str, policy: str, rows: list[Row]) -> Row:
    fit = {"scheme": scheme, "policy": policy, "models": len(rows)}
    for name in MEASURES:
        ratio, error = ratio_key(name), f"{name}relative_error"
        compared = [row for row in rows if row[ratio] is not None]
        scaled = [row for row in compared if not is_physical(row["S"])]
        worst = max(scaled, key=lambda row: abs(row[error]), default=None)
        predicted = [row["predicted_ratio"] for row in compared]
        line = regression_line(predicted, [row[ratio] for row in compared])
        fit |= {f"{name}{key}": value for key, value in line.items()}
        fit[f"{name}worst_relative_error"] = worst[error] if worst else None
        fit[f"{name}worst_case"] = worst["id"] if worst else None
    return fit | {
        "detach_angle_spread_deg": _spread(rows, "detach_angle_deg"),
        "liner_off_angle_spread_deg": _spread(rows, "liner_off_angle_deg"),
        "paper_angles_models_in_flight": sum(bool(row["paper_angles_in_flight"]) for row in rows),
    }


def _spread(rows: list[Row], key: str) -> float | None:
    values = [row[key] for row in rows if row[key] is not None]
    return max(values) - min(values) if len(values) > 1 else None
