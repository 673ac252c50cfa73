"""`millscale advise`: which scaled mills to run for a wanted error."""

from __future__ import annotations

import json
import re
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer

from millscale.cli.options import Campaign, Json, console_of
from millscale.errors import PredictionError

_SHARE = re.compile(r"\s*([0-9]*\.?[0-9]+(?:e-?[0-9]+)?)\s*(%?)\s*")
_TIME = re.compile(r"\s*([0-9]*\.?[0-9]+)\s*(s|min|h)\s*")
_SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0}


def share_of(text: str) -> float:
    """Return 0.02 of "2%" and of "0.02".

    Raises:
        PredictionError: states what is accepted.
    """
    found = _SHARE.fullmatch(text)
    share = float(found[1]) / (100.0 if found[2] else 1.0) if found else 0.0
    if not 1e-4 <= share <= 0.5:
        raise PredictionError(f'--error: got "{text}", accepted are 0.01% to 50%, or 0.0001 to 0.5')
    return share


def seconds_of(text: str) -> float:
    """Return 600 of "10min", "600s".

    Raises:
        PredictionError: states what is accepted.
    """
    found = _TIME.fullmatch(text)
    if not found or float(found[1]) <= 0.0:
        raise PredictionError(f'--budget: got "{text}", accepted are such as 90s, 10min, 2h')
    return float(found[1]) * _SECONDS[found[2]]


def advise(
    file: Campaign,
    error: Annotated[
        str, typer.Option(metavar="E", help="Half width of the interval wanted, such as 2%.")
    ],
    observable: Annotated[
        list[str] | None,
        typer.Option(metavar="NAMES", help="Such as power,contour,toe; repeatable."),
    ] = None,
    budget: Annotated[
        str | None, typer.Option(metavar="TIME", help="Most time on one core, such as 10min.")
    ] = None,
    learn_from: Annotated[
        list[Path] | None,
        typer.Option("--from", metavar="DIR", help="Learn the errors from these finished runs."),
    ] = None,
    to: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the campaign file of the plan.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Plan the cheapest runs that give the physical mill within an error.

    Compares two scaled mills extrapolated, a slice of the physical mill and one scaled mill alone,
    by predicted time and expected interval. Errors of angles are shares of a radian: 2% is 1.1
    degrees; those of the contour are shares of R - a. The errors are those of mills that were
    run before, unless `--from` names runs of yours.

    Example: `millscale advise campaigns/slices.toml --error 2% --observable power,contour`
    """
    from millscale.engine.record import provenance
    from millscale.prediction import error_model
    from millscale.prediction.advise import advise as advise_runs
    from millscale.prediction.predict import predict
    from millscale.prediction.table import advice_lines, advice_table
    from millscale.runs.writing import write_text

    errors = (
        (error_model.learn(predict(learn_from), provenance()),)
        if learn_from
        else error_model.built_in()
    )
    advice = advise_runs(
        file, share_of(error), errors, observable or (), seconds_of(budget) if budget else None
    )
    if to:
        if to.exists():
            raise PredictionError(f"{to} exists: name another file, or remove it")
        write_text(to, advice.text)
    if as_json:
        typer.echo(json.dumps(asdict(advice), indent=1))
        return
    console = console_of()
    console.print(advice_table(advice))
    for line in advice_lines(advice, to):
        console.print(line, highlight=False)
