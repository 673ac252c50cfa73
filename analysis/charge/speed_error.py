"""Speed against error: one row for each model, over its seeds."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from millscale.analysis.charge.errors import FLOW_ERRORS, SHAPE_ERRORS, deviation, mean_known

Row = dict[str, Any]
COLUMNS = (
    ("campaign", "campaign", "{}", 1.0),
    ("scheme", "scheme", "{}", 1.0),
    ("stiffness", "E", "{}", 1.0),
    ("S", "S", "{:.3f}", 1.0),
    ("balls", "balls", "{:,}", 1.0),
    ("seeds", "seeds", "{}", 1.0),
    ("wall_time_s", "wall time [s]", "{:.0f}", 1.0),
    ("processor_time_s", "processor time [s]", "{:.0f}", 1.0),
    ("speed_up", "speed-up", "{:.1f}", 1.0),
    ("contour_error_mean", "contour, mean [%]", "{:.2f}", 100.0),
    ("contour_error_max", "contour, largest [%]", "{:.1f}", 100.0),
    ("curtain_iou_upper", "curtains, upper ends", "{:.2f}", 1.0),
    ("curtain_iou_lower", "curtains, lower ends", "{:.2f}", 1.0),
    ("massflow_rms", "flow, RMS [% of total]", "{:.3f}", 100.0),
    ("massflow_correlation", "flow, correlation", "{:.3f}", 1.0),
    ("power_error", "power [%]", "{:+.2f}", 100.0),
)
MODEL_KEYS = ("campaign", "scheme", "policy", "stiffness", "S")
ERRORS = (*SHAPE_ERRORS, *FLOW_ERRORS, "power_error")


def model_rows(rows: Sequence[Row]) -> list[Row]:
    """A row for each model: means over its seeds, with their standard deviations.

    Contours and curtains are those of the second half of the rotation (`mean_over_angles`), not of
    one moment.

    Args:
        rows: of `charge_comparison.compare_charges`.

    Returns:
        Rows with MODEL_KEYS; seeds; is_reference; balls, ranks, wall_time_s, speed_up,
        processor_time_s (or None); each of ERRORS, None for a reference; spread, the standard
        deviation of each over the seeds, None for one seed; noise, each between two seeds of the
        model, or of the model that lends its seeds (`noise_of`).
    """
    groups: dict[tuple, list[Row]] = {}
    for row in rows:
        groups.setdefault(tuple(row[key] for key in MODEL_KEYS), []).append(row)
    return [_model_row(group) for group in groups.values()]


def _model_row(seeds: list[Row]) -> Row:
    first = seeds[0]
    values = {name: [_error(row, name) for row in seeds] for name in ERRORS}
    return {
        **{key: first[key] for key in (*MODEL_KEYS, "balls", "ranks", "reference", "reference_S")},
        "seeds": len(seeds),
        "is_reference": any(row["is_reference"] for row in seeds),
        "wall_time_s": mean_known(row["wall_time_s"] for row in seeds),
        "processor_time_s": mean_known(row["processor_time_s"] for row in seeds),
        "speed_up": mean_known(row["speed_up"] for row in seeds),
        **{name: mean_known(known) for name, known in values.items()},
        "spread": {name: deviation(known) for name, known in values.items()},
        "noise": {name: _noise(first, name) for name in ERRORS},
        "noise_of": first["between_seeds_of"],
    }


def _error(row: Row, name: str) -> float | None:
    if name in SHAPE_ERRORS:
        return (row["mean_over_angles"] or {}).get(name)
    return row[name]


def _noise(row: Row, name: str) -> float | None:
    return _error(row["between_seeds"], name) if row["between_seeds"] else None


def markdown(models: Sequence[Row]) -> str:
    """Models as a Markdown table: mean over seeds, ± their standard deviation, and in brackets the
    same between two seeds."""
    lines = [
        "| " + " | ".join(title for _, title, _, _ in COLUMNS) + " |",
        "|---" * len(COLUMNS) + "|",
    ]
    for row in models:
        lines.append("| " + " | ".join(_cell(row, *column) for column in COLUMNS) + " |")
    return "\n".join(lines)


def _cell(row: Row, name: str, _title: str, form: str, factor: float) -> str:
    if row[name] is None:
        return "–"
    text = form.format(row[name] if factor == 1.0 else factor * row[name])
    plain = form.replace("+", "")
    if row["spread"].get(name) is not None:
        text += " ± " + plain.format(factor * row["spread"][name])
    if row["noise"].get(name) is not None:
        text += " (" + plain.format(factor * row["noise"][name]) + ")"
    return text
