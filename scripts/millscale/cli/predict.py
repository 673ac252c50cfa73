"""`millscale predict`: the physical mill from its scaled mills."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

from millscale.cli.options import Json, RunsArguments, console_of
from millscale.errors import PredictionError


def predict(
    runs: RunsArguments,
    scheme: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Scheme of the scaled mills to use, if there are two."),
    ] = None,
    policy: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="Policy of the scaled mills to use, if there are two."),
    ] = None,
    level: Annotated[
        float, typer.Option(metavar="P", help="Probability of the intervals, such as 0.95.")
    ] = 0.95,
    check: Annotated[
        bool,
        typer.Option("--check", help="Leave the runs of S = 1 out, and compare with them."),
    ] = False,
    to: Annotated[
        Path | None, typer.Option(metavar="JSON", help="Also write the prediction to this file.")
    ] = None,
    errors_to: Annotated[
        Path | None,
        typer.Option(
            "--errors", metavar="JSON", help="Also add the errors of the scaled mills to this file."
        ),
    ] = None,
    field_to: Annotated[
        Path | None,
        typer.Option("--field", metavar="CSV", help="Also write the map of the solid fraction."),
    ] = None,
    as_json: Json = False,
) -> None:
    """Predict power, shape and energies of the physical mill from its finished scaled mills.

    Needs steady charges at two values of S or more, filled alike. Solid fraction, curtains, throw
    angle and impacts also need two seeds of one S. Each observable is extrapolated to S = 1 with an
    interval that includes the unknown exponent of its error. See docs/theory/prediction.md.

    Examples: `millscale predict runs/slices`,
    `millscale predict runs/slices --check --to prediction.json`
    """
    from millscale.engine.record import provenance
    from millscale.prediction.error_model import learn, write_model
    from millscale.prediction.predict import predict as predict_mill
    from millscale.prediction.table import (
        checks_table,
        impact_tables,
        prediction_table,
    )
    from millscale.runs.writing import write_json, write_text

    prediction = predict_mill(runs, scheme, policy, level, check)
    content = provenance() | prediction.document()
    if to:
        write_json(to, content)
    if field_to:
        if prediction.field is None:
            raise PredictionError(f"--field {field_to}: {prediction.field_refused}")
        write_text(field_to, prediction.field.csv())
    if errors_to:
        write_model(errors_to, learn(prediction, provenance()))
    if as_json:
        typer.echo(json.dumps(content, indent=1))
        return
    console = console_of()
    console.print(prediction_table(prediction))
    for table in impact_tables(prediction):
        console.print(table)
    console.print(checks_table(prediction))
    for line in prediction.notes():
        console.print(line, highlight=False, markup=False)
