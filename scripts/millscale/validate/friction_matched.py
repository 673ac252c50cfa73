"""Friction-matched scaled mills beside those of the paper: `millscale validate friction-matched`.

The friction between balls divided by S is to make up for the inertial number, which grows as S
(docs/theory/similarity-law.md). Each row sets the errors of the two policies side by side, of the
same S and scheme, or of the same pair of S extrapolated.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from typing import Any

from millscale.analysis.finished import Charge
from millscale.engine.record import provenance
from millscale.errors import PredictionError
from millscale.formats import NONE, number
from millscale.prediction.error_model import EXPONENT
from millscale.prediction.extrapolation import scale_function
from millscale.prediction.predict import Prediction, predict_charges
from millscale.runs.writing import write_json
from millscale.validate.differences import (
    CHANCES,
    Comparison,
    Deviations,
    Error,
    comparisons,
    deviations,
    error_of,
)
from millscale.validate.friction_matched_figure import draw_errors
from millscale.validate.mills import Mill, Scaling, load_mills

COMMAND = "millscale validate friction-matched DIR... --to FILE"
PAPER, MATCHED = "paper", "friction-matched"
BySeeds = dict[float, tuple[Charge, ...]]


@dataclass(frozen=True)
class Row:
    """One observable of one mill by both policies.

    Attributes:
        ratios: S of the scaled mills: one, or those of an extrapolation.
    """

    mill: str
    scheme: str
    ratios: tuple[float, ...]
    observable: str
    label: str
    unit: str
    paper: Error | None
    matched: Error | None

    @property
    def only_chance(self) -> bool:
        """Return whether both errors may be chance: their ratio then shows nothing."""
        return all(
            error is not None and error.may_be_chance for error in (self.paper, self.matched)
        )

    @property
    def ratio(self) -> float | None:
        """Return the error with matched friction over the paper's; None if both may be chance."""
        if self.paper is None or self.matched is None or self.only_chance:
            return None
        return abs(self.matched.value / self.paper.value) if self.paper.value else None

    def document(self) -> dict[str, Any]:
        """Return it as JSON types."""
        return asdict(self) | {"ratio": self.ratio, "only_chance": self.only_chance}


@dataclass(frozen=True)
class Medians:
    """Medians of the ratio of the errors over rows.

    Attributes:
        of: what the rows share, such as S = 2.6.
        rows, chance: with a ratio, and without one because both errors may be chance.
    """

    of: str
    ratio: float | None
    rows: int
    chance: int


def compare_policies(folders: Sequence[Path], every: bool) -> dict[str, Any]:
    """Return the errors of both policies in all mills of runs folders, as JSON types.

    Raises:
        PredictionError: no mill has both policies and S = 1.
    """
    mills, excluded = load_mills(folders, every)
    rows = [row for mill in mills for row in rows_of(mill)]
    if not rows:
        raise PredictionError(f"no mill has scaled mills of both {PAPER} and {MATCHED} at equal S")
    return {
        "schema": 1,
        **provenance(),
        "command": COMMAND + (" --all" if every else ""),
        "chances": CHANCES,
        "mills": [{"name": mill.name, "description": mill.description} for mill in mills],
        "rows": [row.document() for row in rows],
        "medians": [asdict(x) for x in medians(rows)],
        "excluded": excluded,
    }


def rows_of(mill: Mill) -> Iterator[Row]:
    """Yield a row for each scheme, S or pair of S, and observable that both policies have."""
    compared = comparisons(mill)
    for scheme in sorted({scaling.scheme for scaling in mill.scaled}):
        both = [mill.scaled.get(Scaling(scheme, policy), {}) for policy in (PAPER, MATCHED)]
        common = sorted(both[0].keys() & both[1].keys())
        noise = {x.name: deviations(x, mill, scheme) for x in compared}
        for S in common:
            for one in compared:
                errors = (_alone(one, by_S[S], mill, noise[one.name]) for by_S in both)
                yield _row(mill, scheme, (S,), one, *errors)
        for pair in itertools.combinations(common, 2):
            found = [_extrapolated(mill, by_S, pair) for by_S in both]
            for one in compared:
                errors = (
                    _after(one, prediction, by_S, pair, mill, noise[one.name])
                    for prediction, by_S in zip(found, both, strict=True)
                )
                row = _row(mill, scheme, pair, one, *errors)
                if row.paper or row.matched:
                    yield row


def _row(
    mill: Mill,
    scheme: str,
    ratios: tuple[float, ...],
    one: Comparison,
    paper: Error | None,
    matched: Error | None,
) -> Row:
    return Row(mill.name, scheme, ratios, one.name, one.label, one.unit, paper, matched)


def _alone(
    one: Comparison, seeds: Sequence[Charge], mill: Mill, deviation: Deviations
) -> Error | None:
    difference = one.mean(seeds)
    if difference is None:
        return None
    return error_of(one, difference, [(1.0, seeds)], mill, deviation)


def _extrapolated(mill: Mill, by_S: BySeeds, pair: tuple[float, ...]) -> Prediction:
    used = [charge for S in pair for charge in by_S[S]]
    return predict_charges(used, mill.physical, mill.values)


def _after(
    one: Comparison,
    prediction: Prediction,
    by_S: BySeeds,
    pair: tuple[float, ...],
    mill: Mill,
    deviation: Deviations,
) -> Error | None:
    """Return the error that an extrapolation leaves; None where it was refused."""
    difference = one.of_prediction(prediction)
    if difference is None:
        return None
    near, far = (float(scale_function(S, EXPONENT)) for S in pair)
    weights = far / (far - near), -near / (far - near)
    parts = [(weight, by_S[S]) for weight, S in zip(weights, pair, strict=True)]
    return error_of(one, difference, parts, mill, deviation)


def medians(rows: Sequence[Row]) -> list[Medians]:
    """Return medians over the observables and mills: by S, by pair of S, by mill, and of all."""
    single = [row for row in rows if len(row.ratios) == 1]
    pairs = [row for row in rows if len(row.ratios) > 1]
    found = []
    for kind, some in (("", single), ("extrapolated ", pairs)):
        if not some:
            continue
        found += _by(some, lambda row: row.ratios, kind, ratios_text)
        found += _by(some, lambda row: (row.mill, row.scheme), kind, ", ".join)
        of_mills = [x for x in _by(some, lambda row: row.mill, "", str) if x.ratio is not None]
        if of_mills:
            middle = median(x.ratio for x in of_mills if x.ratio is not None)
            found.append(Medians(f"{kind}median over mills", middle, len(of_mills), 0))
    return found


def _by(
    rows: Sequence[Row],
    key: Callable[[Row], Hashable],
    kind: str,
    name: Callable[[Any], str],
) -> list[Medians]:
    groups: dict[Hashable, list[Row]] = {}
    for row in rows:
        groups.setdefault(key(row), []).append(row)
    found = []
    for shared, group in groups.items():
        ratios = [row.ratio for row in group if row.ratio is not None]
        chance = sum(row.only_chance for row in group)
        middle = median(ratios) if ratios else None
        found.append(Medians(kind + name(shared), middle, len(ratios), chance))
    return found


def ratios_text(ratios: Iterable[float]) -> str:
    """Return S = 1.696, 2.6."""
    return f"S = {', '.join(f'{S:.4g}' for S in ratios)}"


def write_friction_matched(folders: Sequence[Path], file: Path, every: bool = False) -> str:
    """Write the errors of both policies to a file, and their figure beside it.

    Returns:
        Tables of the errors and of their medians as Markdown.
    """
    content = compare_policies(folders, every)
    write_json(file, content)
    draw_errors(content, file.with_suffix(".png"))
    return markdown(content)


def markdown(content: Mapping[str, Any]) -> str:
    """Return a table for each mill and scheme, and one of the medians."""
    lines = [
        f"errors of paper / friction-matched; ~: below {content['chances']:g} times its chance"
    ]
    for mill in content["mills"]:
        of_mill = [row for row in content["rows"] if row["mill"] == mill["name"]]
        for scheme in sorted({row["scheme"] for row in of_mill}):
            rows = [row for row in of_mill if row["scheme"] == scheme]
            title = f"**{mill['name']}, {scheme}** ({mill['description']})"
            for several in (False, True):
                some = [row for row in rows if (len(row["ratios"]) > 1) == several]
                if some:
                    kind = ", extrapolated from" if several else ""
                    lines += ["", title + kind, "", *_table(some)]
    lines += [
        "",
        "| median of the ratio of errors | ratio | rows | only chance |",
        "|---|---|---|---|",
    ]
    lines += [
        f"| {x['of']} | {number(x['ratio'], 2)} | {x['rows']} | {x['chance']} |"
        for x in content["medians"]
    ]
    lines += [f"not used: {name}: {why}" for name, why in content["excluded"].items()]
    return "\n".join(lines)


def _table(rows: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    ratios = list(dict.fromkeys(tuple(row["ratios"]) for row in rows))
    by_place = {(row["observable"], tuple(row["ratios"])): row for row in rows}
    yield f"| observable | unit | {' | '.join(map(ratios_text, ratios))} |"
    yield "|---" * (2 + len(ratios)) + "|"
    for name, label, unit in dict.fromkeys(
        (row["observable"], row["label"], row["unit"]) for row in rows
    ):
        cells = [_cell(by_place.get((name, ratio))) for ratio in ratios]
        yield f"| {label} | {unit} | {' | '.join(cells)} |"


def _cell(row: Mapping[str, Any] | None) -> str:
    if row is None:
        return NONE
    return " / ".join(_error_text(row[policy], row["unit"]) for policy in ("paper", "matched"))


def _error_text(error: Mapping[str, Any] | None, unit: str) -> str:
    if error is None:
        return NONE
    signed = "+" if unit in ("%", "deg") else ""
    chance = error["chance"]
    mark = "~" if chance is not None and abs(error["value"]) <= CHANCES * chance else ""
    return f"{mark}{error['value']:{signed}.2f}"
