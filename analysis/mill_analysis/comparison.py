"""Single-ball cases of a campaign against each other and against the law's prediction."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from typing import Any

from scipy.stats import linregress

from mill_analysis import energy, paper
from mill_analysis.run_folder import FinishedCase
from mill_analysis.single_ball import ball_of, flight_of

Row = dict[str, Any]
POLICIES = ("paper", "corrected", "offset-liner")
_ANGLES = ("detach_angle_", "liner_off_angle_")


@dataclass(frozen=True)
class Window:
    """Mill rotation from the throw over which the cases of a scheme are compared.

    Attributes:
        length: [rad].
        limited_by: id of the case whose flight is shorter than the paper's window, or None.
    """

    length: float
    limited_by: str | None


def common_windows(cases: list[FinishedCase]) -> dict[str, Window]:
    """One window for each scheme: the paper's, or the shortest flight of the scheme's throws."""
    windows = {}
    for case in _thrown(cases):
        scheme, length = case.case["scheme"], case.result["throws"][0]["flight_length_rad"]
        now = windows.get(scheme, Window(paper.longest_window(), None))
        windows[scheme] = Window(length, case.id) if length < now.length else now
    return windows


def single_ball_rows(cases: list[FinishedCase]) -> list[Row]:
    """A row for each case, by scheme, policy and S; keys and units: docs/files.md.

    Energies are changes over the scheme's common window, exact on the parabola of the first throw.
    Ratios are to S = 1 of the same scheme and policy, or of another policy: all are the same there.
    """
    windows = common_windows(cases)
    rows = [_row(case, windows.get(case.case["scheme"])) for case in sorted(cases, key=place)]
    for row in rows:
        _compare(row, _reference(row, rows))
    return rows


def place(case: FinishedCase) -> tuple:
    """Place of a case in tables: by scheme, policy and S."""
    document = case.case
    return document["scheme"], POLICIES.index(document["policy"]), document["S"], case.id


def regressions(rows: list[Row]) -> list[Row]:
    """Ratio against prediction for each scheme and policy: regression line, worst deviation over
    S > 1, spread of the detach angles (largest minus smallest)."""
    return [
        _regression(scheme, policy, list(group))
        for (scheme, policy), group in groupby(rows, key=lambda r: (r["scheme"], r["policy"]))
    ]


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


def _thrown(cases: list[FinishedCase]) -> list[FinishedCase]:
    return [case for case in cases if case.result["throws"]]


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
        "energy_window_rad": window.length if window else None,
        **_energy(case, window),
        "paper_angles_energy_change_J": abs(fixed["kinetic_J"]) if fixed else None,
        "paper_angles_in_flight": fixed["in_flight"] if fixed else None,
        "predicted_ratio": document["predicted_energy_ratio"],
        "centre_path_ratio": document["centre_path_energy_ratio"],
        "wall_time_s": case.timing["wall_time_s"],
    }
    reported = paper.reported_energy(row["scheme"], row["S"])
    row["paper_energy_change_J"] = reported.change if reported else None
    row["paper_energy_ratio"] = reported.ratio if reported else None
    return row


def _energy(case: FinishedCase, window: Window | None) -> Row:
    """Energy change over the window; over that change, how far the samples of the flight are off
    the parabola, and what is missing for kinetic and potential energy to balance."""
    if not case.result["throws"]:
        keys = ("energy_begin_rad", "energy_change_J", "off_parabola", "energy_imbalance")
        return dict.fromkeys(keys)
    throw, sampled = case.result["throws"][0], case.result["throw_energy"]
    change = abs(energy.change_on_parabola(flight_of(throw), ball_of(case.case), window.length))
    off = max(sampled["off_parabola_kinetic_J"], sampled["off_parabola_potential_J"])
    imbalance = abs(sampled["kinetic_sampled_J"] + sampled["potential_sampled_J"])
    return {
        "energy_begin_rad": throw["mill_angle_rad"],
        "energy_change_J": change,
        "off_parabola": off / change if change else None,
        "energy_imbalance": imbalance / change if change else None,
    }


def _reference(row: Row, rows: list[Row]) -> Row | None:
    physical = [r for r in rows if r["scheme"] == row["scheme"] and abs(r["S"] - 1.0) < 1e-9]
    same_policy = [r for r in physical if r["policy"] == row["policy"]]
    return next(iter(same_policy + physical), None)


def _compare(row: Row, reference: Row | None) -> None:
    ratio = _ratio(row, reference, "energy_change_J")
    row["reference"] = reference["id"] if reference else None
    row["energy_ratio"] = ratio
    row["relative_error"] = _relative(ratio, row["predicted_ratio"])
    row["relative_error_to_centre_path"] = _relative(ratio, row["centre_path_ratio"])
    fixed = _ratio(row, reference, "paper_angles_energy_change_J")
    row["paper_angles_ratio"] = fixed
    row["paper_angles_relative_error"] = _relative(fixed, row["predicted_ratio"])


def _ratio(row: Row, reference: Row | None, key: str) -> float | None:
    if reference is None or row[key] is None or not reference[key]:
        return None
    return row[key] / reference[key]


def _relative(ratio: float | None, predicted: float) -> float | None:
    return None if ratio is None else ratio / predicted - 1.0


def _regression(scheme: str, policy: str, rows: list[Row]) -> Row:
    compared = [row for row in rows if row["energy_ratio"] is not None]
    scaled = [row for row in compared if row["id"] != row["reference"] and row["S"] > 1.0]
    worst = max(scaled, key=lambda row: abs(row["relative_error"]), default=None)
    predicted = [row["predicted_ratio"] for row in compared]
    at_paper_angles = [row for row in compared if row["paper_angles_in_flight"]]
    return {
        "scheme": scheme,
        "policy": policy,
        "models": len(rows),
        **regression_line(predicted, [row["energy_ratio"] for row in compared]),
        "worst_relative_error": worst["relative_error"] if worst else None,
        "worst_case": worst["id"] if worst else None,
        "detach_angle_spread_deg": _spread(rows, "detach_angle_deg"),
        "liner_off_angle_spread_deg": _spread(rows, "liner_off_angle_deg"),
        "paper_angles_models_in_flight": len(at_paper_angles),
        "paper_angles_correlation": regression_line(
            [row["predicted_ratio"] for row in at_paper_angles],
            [row["paper_angles_ratio"] for row in at_paper_angles],
        )["correlation"],
        "paper_angles_worst_relative_error": max(
            (row["paper_angles_relative_error"] for row in at_paper_angles), key=abs, default=None
        ),
    }


def _spread(rows: list[Row], key: str) -> float | None:
    values = [row[key] for row in rows if row[key] is not None]
    return max(values) - min(values) if len(values) > 1 else None
