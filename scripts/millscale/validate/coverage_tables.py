"""Predictions of each mill and their coverage as Markdown tables."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from statistics import median
from typing import Any

from millscale.formats import NONE, counted, number

Json = Mapping[str, Any]


def markdown(content: Json) -> str:
    """Return the predictions of each mill, and the coverage over all.

    Args:
        content: of `coverage.try_predictions`.
    """
    lines = [
        "size of the error, in brackets the half width; medians over predictions of equal runs"
    ]
    for mill in content["mills"]:
        trials = [trial for trial in content["trials"] if trial["mill"] == mill["name"]]
        title = f"**{mill['name']}** ({mill['description']})"
        cost = f"S = 1 took {mill['cost_s']:.0f} s of processor time"
        lines += ["", f"{title}; {cost}", "", *_trials_table(trials, mill)]
    lines += ["", *_coverage_table(content["coverage"])]
    lines += [f"not used: {name}: {why}" for name, why in content["excluded"].items()]
    return "\n".join(lines)


def runs_text(runs: Sequence[tuple[float, int]]) -> str:
    """Return S = 1.696 (1 seed), 2.6 (3 seeds)."""
    return "S = " + ", ".join(f"{S:.4g} ({counted(seeds, 'seed')})" for S, seeds in runs)


def _trials_table(trials: Sequence[Json], mill: Json) -> Iterator[str]:
    yield (
        "| scheme, policy | runs | cost / S = 1 | cost / whole mill | inside | refused | power [%] "
        "| contour [% of R - a] | mass in the box [% of mean] |"
    )
    yield "|---" * 9 + "|"
    groups: dict[tuple[str, str, str], list[Json]] = {}
    for trial in trials:
        key = trial["scheme"], trial["policy"], runs_text(trial["runs"])
        groups.setdefault(key, []).append(trial)
    for (scheme, policy, runs), group in groups.items():
        rows = [row for trial in group for row in trial["intervals"]]
        known = [row for row in rows if row["is_inside"] is not None]
        cost = median(trial["cost_s"] for trial in group) / mill["cost_s"]
        inside = sum(row["is_inside"] for row in known)
        curves = (_of_curves(group, name) for name in ("contour", "mass_in_box"))
        yield (
            f"| {scheme}, {policy} | {runs} | {cost:.2f} | {cost * mill['length_share']:.3f} "
            f"| {inside} of {len(known)} | {len(rows) - len(known)} "
            f"| {_of_power(known)} | {' | '.join(curves)} |"
        )


def _of_power(known: Sequence[Json]) -> str:
    rows = [row for row in known if row["observable"] == "power"]
    return _error_and_width(
        [
            tuple(100.0 * abs(row[key] / row["truth"]) for key in ("error", "half_width"))
            for row in rows
        ]
    )


def _of_curves(trials: Sequence[Json], name: str) -> str:
    curves = [trial[name] for trial in trials if trial[name]]
    return _error_and_width([(curve["error"], curve["half_width"]) for curve in curves])


def _error_and_width(pairs: Sequence[Sequence[float]]) -> str:
    if not pairs:
        return NONE
    error, width = (median(column) for column in zip(*pairs, strict=True))
    return f"{error:.2f} ({width:.2f})"


def _coverage_table(rows: Sequence[Json]) -> Iterator[str]:
    yield (
        "| intervals of | inside | share [%] | 95 % of the share | refused "
        "| misses by chance of S = 1 | half width / error | gain in cost | cost / S = 1 |"
    )
    yield "|---" * 9 + "|"
    for row in rows:
        share = f"{100.0 * row['inside'] / row['intervals']:.0f}" if row["intervals"] else NONE
        yield (
            f"| {row['of']} | {row['inside']} of {row['intervals']} | {share} "
            f"| {100.0 * row['lower']:.0f} to {100.0 * row['upper']:.0f} | {row['refused']} "
            f"| {row['within_chance']} | {number(row['half_width_over_error'], 1)} "
            f"| {number(row['gain'], 2)} | {row['cost_share']:.2f} |"
        )
