"""Time step, precision and slice length as fidelities: `millscale validate fidelity`.

The runs are those of campaigns/study-fidelity.toml: several seeds, each at two steps and in two
precisions. A control variate needs runs of one seed that are correlated. Extrapolation in the step
or in the slice length needs a bias that exceeds the noise.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from millscale.analysis.charge.result import charge_scales
from millscale.analysis.charge.steady import Window, lifter_pitch
from millscale.analysis.finished import Charge
from millscale.analysis.means import mean_known
from millscale.analysis.shapes.shape import snapshots_at, unit_length, wanted_angles
from millscale.engine.record import provenance
from millscale.formats import number
from millscale.report.figures.style import STYLE
from millscale.runs.case_folder import read_json
from millscale.runs.dumps import read_dump
from millscale.runs.untrusted import RunFolderError, read_object
from millscale.runs.writing import write_json
from millscale.study.results import MADE_BY, STUDY, study_charges
from millscale.validate.correlation import (
    Correlation,
    correlation,
    cost_at_equal_variance,
    least_correlation,
    pooled_correlation,
    richardson,
    variance_left,
)

Row = dict[str, Any]
COMMAND = "millscale validate fidelity DIR --to JSON"
OBSERVABLES = {
    "power": "power / M g R ω",
    "minus_centre_x": "-x_c / R",
    "kinetic": "kinetic energy / M ω²R²",
    "toe": "toe [rad]",
}
# Lifter pitches of a window, whose means are correlated: about 1 rad of the paper's mill.
PITCHES = 4
# Windows from the start that count as spin-up.
SPIN_UP = 2
ORDERS = (1.0, 2.0)
SLICES = "slice-length.json"


@dataclass(frozen=True)
class Fidelity:
    """Finished runs of one step and precision, by seed."""

    name: str
    charges: Mapping[int, Charge]

    @property
    def first(self) -> Charge:
        return next(iter(self.charges.values()))

    @property
    def step(self) -> float:
        """Return the time step [s]."""
        return self.first.case.time.step_s

    @property
    def precision(self) -> str:
        return self.first.case.deck.precision

    @property
    def steady_from(self) -> float:
        """Return the mill angle from which all of its runs are steady [rad]."""
        return max(charge.steady_from for charge in self.charges.values())

    @property
    def cost(self) -> float:
        """Return the processor time of a rotation [s], in the mean over the seeds; the wall time
        where it was not recorded."""
        timings = [charge.timing for charge in self.charges.values()]
        return float(np.mean([x.processor_time_s or x.wall_time_s for x in timings]))

    @cached_property
    def windows(self) -> dict[str, np.ndarray]:
        """Return the mean of each observable over each window, (seeds, windows) float by name."""
        found = [window_means(charge) for charge in self.charges.values()]
        fewest = min(len(means["power"]) for means in found)
        return {name: np.array([means[name][:fewest] for means in found]) for name in OBSERVABLES}


def window_edges(charge: Charge) -> np.ndarray:
    """Return the mill angles between whole windows from the start, (n + 1,) float [rad]."""
    width = PITCHES * lifter_pitch(charge.case.mill.lifters)
    return width * np.arange(int(charge.series["mill_angle_rad"][-1] / width + 1e-9) + 1)


def window_means(charge: Charge) -> dict[str, np.ndarray]:
    """Return the dimensionless means of each window of a run, (n,) float by observable."""
    series, edges = charge.series, window_edges(charge)
    angle, scales = series["mill_angle_rad"], charge_scales(charge.case, series)
    window = Window(float(edges[0]), float(edges[-1]), edges)
    work = np.interp(edges, angle, series["drive_work_J"])
    return {
        "power": np.diff(work) / np.diff(edges) / scales.torque,
        "minus_centre_x": -window.pitch_means(angle, series["centre_x_m"]) / scales.length,
        "kinetic": window.pitch_means(angle, series["kinetic_translation_J"]) / scales.energy,
        "toe": window.pitch_means(angle, series["toe_angle_rad"]),
    }


def fidelities_of(runs: Path) -> list[Fidelity]:
    """Return the settings of a study that have two finished seeds or more.

    Raises:
        RunFolderError: no study, or no two such settings share two seeds.
    """
    about = read_json(runs / STUDY, MADE_BY)
    charges, _ = study_charges(runs, about)
    settings: dict[str, dict[int, Charge]] = {}
    for charge in charges:
        settings.setdefault(charge.campaign, {})[charge.seed] = charge
    several = [Fidelity(name, seeds) for name, seeds in settings.items() if len(seeds) > 1]
    if not pairs_of(several):
        cause = "no two settings share two finished seeds"
        raise RunFolderError(runs, cause, f"run them with: {MADE_BY}")
    return several


def pairs_of(fidelities: Sequence[Fidelity]) -> list[tuple[Fidelity, Fidelity]]:
    """Return every two settings, each with the seeds that both have; of two seeds or more."""
    found = []
    for pair in combinations(fidelities, 2):
        common = sorted(pair[0].charges.keys() & pair[1].charges.keys())
        if len(common) > 1:
            first, second = (Fidelity(x.name, {i: x.charges[i] for i in common}) for x in pair)
            found.append((first, second))
    return found


def steady_windows(fidelities: Sequence[Fidelity]) -> slice:
    """Return the windows in which every run is steady.

    Raises:
        RunFolderError: there is none.
    """
    begin = max(fidelity.steady_from for fidelity in fidelities)
    first = fidelities[0].first
    edges = window_edges(first)
    # 1e-9: a window may begin with the steady part, but for rounding.
    steady = slice(int(np.searchsorted(edges, begin - 1e-9)), len(edges) - 1)
    if steady.start >= steady.stop:
        cause = f"steady from {begin:.3g} rad on: no window of {PITCHES} pitches is left"
        raise RunFolderError(first.folder, cause, "turn the mill further")
    return steady


def compare(first: Fidelity, second: Fidelity, steady: slice) -> Row:
    """Return the correlation of two settings in each observable, and what it gains."""
    costs = sorted((first.cost, second.cost))
    ratio = costs[0] / costs[1]
    observables = {}
    for name in OBSERVABLES:
        a, b = first.windows[name], second.windows[name]
        in_steady = correlation(a[:, steady], b[:, steady])
        of_means = correlation(*(x[:, steady].mean(axis=1, keepdims=True) for x in (a, b)))
        observables[name] = {
            "spin_up": asdict(correlation(a[:, :SPIN_UP], b[:, :SPIN_UP])),
            "steady": asdict(in_steady) | _gain(in_steady, ratio),
            "steady_means": asdict(of_means),
            "by_window": [
                pooled_correlation(x[:, None], y[:, None]) for x, y in zip(a.T, b.T, strict=True)
            ],
        }
    return {
        "first": first.name,
        "second": second.name,
        "seeds": list(first.charges),
        "cost_ratio": ratio,
        "least_correlation": least_correlation(ratio),
        "observables": observables,
        "distance": distances(first, second),
    }


def _gain(found: Correlation, ratio: float) -> Row:
    """Return what a control variate would leave; None without a correlation."""
    if found.value is None:
        return {"variance_left": None, "cost_at_equal_variance": None}
    return {
        "variance_left": variance_left(found.value),
        "cost_at_equal_variance": cost_at_equal_variance(found.value, ratio),
    }


def distances(first: Fidelity, second: Fidelity) -> list[Row]:
    """Return how far a ball of one run is from the same ball of the other, at each dump: root mean
    square over balls and seeds in the cross-section, over R - a. `unrelated`: the same of pairs of
    different balls."""
    generator = np.random.default_rng(1)
    squares: dict[float, list[tuple[float, float]]] = {}
    for seed, charge in first.charges.items():
        angles = [0.0, *wanted_angles(charge.result.rotation_angle_rad)]
        unit = unit_length(charge.case)
        at = [snapshots_at(x.folder, angles) for x in (charge, second.charges[seed])]
        for angle in at[0].keys() & at[1].keys():
            ours, theirs = (read_dump(of[angle].path).positions[:, [0, 2]] / unit for of in at)
            pairs = ours - theirs, ours - generator.permutation(theirs)
            same, unrelated = (float(np.mean(np.sum(x * x, axis=1))) for x in pairs)
            squares.setdefault(angle, []).append((same, unrelated))
    return [
        {"mill_angle_rad": angle, "same": math.sqrt(same), "unrelated": math.sqrt(unrelated)}
        for angle, (same, unrelated) in (
            (angle, np.mean(squares[angle], axis=0).tolist()) for angle in sorted(squares)
        )
    ]


def means_of(fidelity: Fidelity, steady: slice) -> dict[str, Row]:
    """Return mean, deviation of a seed and standard error of the steady means by observable."""
    found = {}
    for name, values in fidelity.windows.items():
        of_seeds = values[:, steady].mean(axis=1)
        scatter = float(of_seeds.std(ddof=1))
        found[name] = {
            "mean": float(of_seeds.mean()),
            "deviation": scatter,
            "error": scatter / math.sqrt(len(of_seeds)),
        }
    return found


def step_bias(fidelities: Sequence[Fidelity], steady: slice) -> dict[str, Row]:
    """Return by observable what the larger step changes, and the extrapolation to a step of 0.

    All precisions count as runs of their step. Their seeds count as independent, which the
    correlations have to confirm.
    """
    steps = sorted({fidelity.step for fidelity in fidelities})
    if len(steps) != 2:
        return {}
    found = {}
    for name in OBSERVABLES:
        fine, coarse = (
            _mean_and_error(
                np.concatenate(
                    [x.windows[name][:, steady].mean(axis=1) for x in fidelities if x.step == step]
                )
            )
            for step in steps
        )
        difference = coarse[0] - fine[0]
        error = math.hypot(coarse[1], fine[1])
        found[name] = {
            "steps_s": steps,
            "fine": {"mean": fine[0], "error": fine[1]},
            "coarse": {"mean": coarse[0], "error": coarse[1]},
            "bias": difference,
            "error": error,
            "richardson": [
                asdict(richardson(fine, coarse, steps[1] / steps[0], order)) for order in ORDERS
            ],
        }
    return found


def _mean_and_error(values: np.ndarray) -> tuple[float, float]:
    return float(values.mean()), float(values.std(ddof=1) / math.sqrt(len(values)))


def slice_lengths(measured: Row) -> dict[str, list[Row]]:
    """Return by quantity the error of each slice against the whole length, and of extrapolations
    in 1 / length, from slice-length.json."""
    found: dict[str, list[Row]] = {}
    for name, lengths in measured["slices"]["quantities"].items():
        known = {
            float(key.split()[0]): _mean_and_error(np.array(of["of_seeds"]))
            for key, of in lengths.items()
            if key.endswith("diameters")
        }
        whole = _mean_and_error(np.array(lengths[measured["slices"]["reference"]]["of_seeds"]))
        rows = found.setdefault(name, [])
        for diameters, mean in sorted(known.items()):
            rows.append({"from": [diameters], **_against(mean, whole)})
        for short, long in combinations(sorted(known), 2):
            limit = richardson(known[long], known[short], long / short, 1.0)
            against = _against((limit.value, limit.error), whole)
            rows.append({"from": [short, long], **against})
    return found


def _against(mean: tuple[float, float], whole: tuple[float, float]) -> Row:
    return {
        "error": (mean[0] - whole[0]) / abs(whole[0]),
        "standard_error": math.hypot(mean[1], whole[1]) / abs(whole[0]),
    }


def tables(document: Row) -> str:
    """Return correlations, biases and slices as Markdown tables."""
    lines = [
        "| runs | observable | r, spin-up | 95 % interval | r, steady | 95 % interval | chance "
        "| variance left | r needed |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for pair in document["pairs"]:
        for name, found in pair["observables"].items():
            spin_up, steady = found["spin_up"], found["steady"]
            lines.append(
                f"| {pair['first']}, {pair['second']} | {OBSERVABLES[name]} "
                f"| {_range(spin_up)} | {_range(steady)} "
                f"| {number(steady['chance'], 2)} | {number(steady['variance_left'], 2)} "
                f"| {number(pair['least_correlation'], 3)} |"
            )
    lines += [
        "",
        "| observable | smaller step | larger step | bias [%] | Richardson, order 1 [%] "
        "| order 2 [%] |",
        "|---|---|---|---|---|---|",
    ]
    for name, found in document["step"].items():
        base = abs(found["fine"]["mean"])
        limits = [
            f"{100.0 * (x['value'] - found['fine']['mean']) / base:+.2f} "
            f"± {100.0 * x['error'] / base:.2f}"
            for x in found["richardson"]
        ]
        lines.append(
            f"| {OBSERVABLES[name]} | {found['fine']['mean']:.4f} ± {found['fine']['error']:.4f} "
            f"| {found['coarse']['mean']:.4f} ± {found['coarse']['error']:.4f} "
            f"| {100.0 * found['bias'] / base:+.2f} ± {100.0 * found['error'] / base:.2f} "
            f"| {' | '.join(limits)} |"
        )
    if document["slice_length"]:
        lines += ["", "| quantity | from slices of [diameters] | error [%] |", "|---|---|---|"]
    for name, rows in document["slice_length"].items():
        lines += [
            f"| {name} | {' and '.join(f'{x:g}' for x in row['from'])} "
            f"| {100.0 * row['error']:+.2f} ± {100.0 * row['standard_error']:.2f} |"
            for row in rows
        ]
    return "\n".join(lines)


def _range(found: Row) -> str:
    """Return two cells of a table: a correlation and its interval."""
    ends = f"{number(found['low'], 2)} to {number(found['high'], 2)}"
    return f"{number(found['value'], 2)} | {ends}"


def draw(document: Row, file: Path) -> Figure:
    """Draw correlation by window and distance of the same ball against mill angle.

    Args:
        file: picture to write.
    """
    with rc_context(STYLE):
        figure = Figure(figsize=(9.5, 3.8), layout="constrained")
        left, right = figure.subplots(1, 2)
        for place, pair in enumerate(document["pairs"]):
            label = f"{pair['first']}, {pair['second']}"
            columns = [found["by_window"] for found in pair["observables"].values()]
            mean = [mean_known(of_window) for of_window in zip(*columns, strict=True)]
            width = document["window_rad"]
            middle = width * (np.arange(len(columns[0])) + 0.5)
            left.plot(middle, mean, "o-", color=f"C{place}", markersize=3,
                      label=label)  # fmt: skip
            at = [row["mill_angle_rad"] for row in pair["distance"]]
            right.plot(at, [row["same"] for row in pair["distance"]], color=f"C{place}")
        unrelated = document["pairs"][0]["distance"]
        right.plot(
            [row["mill_angle_rad"] for row in unrelated],
            [row["unrelated"] for row in unrelated],
            "k--",
            label="two different balls",
        )
        left.axhline(0.0, color="#999", linewidth=0.8)
        left.axvline(document["steady_from_rad"], color="#999", linewidth=0.8, linestyle=":")
        left.set(xlabel="mill angle [rad]", ylabel="r over seeds, mean of observables",
                 ylim=(-1.0, 1.05))  # fmt: skip
        right.set(xlabel="mill angle [rad]", ylabel="distance of the same ball over R - a",
                  ylim=(0.0, None))  # fmt: skip
        right.legend()
        figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3)
        figure.savefig(file, dpi=150)
    return figure


def write_fidelity(runs: Path, file: Path) -> str:
    """Write fidelity.json and a figure beside it; return its tables.

    Slices come from slice-length.json beside the file, if it is there.

    Args:
        runs: runs folder of campaigns/study-fidelity.toml.

    Raises:
        RunFolderError: not the folder of a finished study.
    """
    fidelities = fidelities_of(runs)
    steady = steady_windows(fidelities)
    first = fidelities[0].first
    edges = window_edges(first)
    slices = file.parent / SLICES
    measured = read_object(slices, "millscale bench --scene slices") if slices.exists() else None
    document = {
        "schema": 1,
        **(provenance() | {"command": COMMAND}),
        "S": first.S,
        "balls": first.balls,
        "window_rad": float(edges[1]),
        "steady_from_rad": float(edges[steady.start]),
        "to_rad": float(edges[steady.stop]),
        "settings": [
            {
                "setting": fidelity.name,
                "seeds": sorted(fidelity.charges),
                "step_s": fidelity.step,
                "precision": fidelity.precision,
                "time_s": fidelity.cost,
                "means": means_of(fidelity, steady),
            }
            for fidelity in fidelities
        ],
        "pairs": [compare(a, b, steady) for a, b in pairs_of(fidelities)],
        "step": step_bias(fidelities, steady),
        "slice_length": slice_lengths(measured) if measured else {},
    }
    file.parent.mkdir(parents=True, exist_ok=True)
    write_json(file, document)
    draw(document, file.with_suffix(".png"))
    return tables(document)
