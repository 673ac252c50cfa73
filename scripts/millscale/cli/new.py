"""`millscale new`: write a commented campaign file from questions or options."""

from __future__ import annotations

import sys
from dataclasses import fields, replace
from pathlib import Path
from typing import Annotated, Any

import typer

from millscale.errors import CampaignError
from millscale.formats import counted, duration

_QUESTIONS = {
    "diameter_m": "Diameter inside the liner [m]",
    "length_m": "Length [m]",
    "percent_of_critical": "Speed [% of critical]",
    "filling_percent": "Filling, bed over mill volume [%]",
    "ball_diameter_mm": "Ball diameter [mm]",
    "density_kg_m3": "Ball density [kg/m^3]",
    "lifters": "Number of lifters, 0 for a plain drum",
    "lifter_height_mm": "Lifter height [mm]",
    "lifter_width_mm": "Width of a lifter top [mm]",
    "face_angle_deg": "Angle of a lifter's faces from its centre line [deg]",
}
_LINER = ("lifter_height_mm", "lifter_width_mm", "face_angle_deg")


def _number(name: str) -> Any:
    return typer.Option(metavar="X", help=f"{_QUESTIONS[name]}.", show_default=False)


def new(
    context: typer.Context,
    file: Annotated[Path, typer.Argument(metavar="FILE", help="Campaign file to write.")],
    diameter_m: Annotated[float | None, _number("diameter_m")] = None,
    length_m: Annotated[float | None, _number("length_m")] = None,
    percent_of_critical: Annotated[float | None, _number("percent_of_critical")] = None,
    filling_percent: Annotated[float | None, _number("filling_percent")] = None,
    ball_diameter_mm: Annotated[float | None, _number("ball_diameter_mm")] = None,
    density_kg_m3: Annotated[float | None, _number("density_kg_m3")] = None,
    lifters: Annotated[int | None, _number("lifters")] = None,
    lifter_height_mm: Annotated[float | None, _number("lifter_height_mm")] = None,
    lifter_width_mm: Annotated[float | None, _number("lifter_width_mm")] = None,
    face_angle_deg: Annotated[float | None, _number("face_angle_deg")] = None,
) -> None:
    """Write a commented campaign file of a mill, ready for `millscale plan`.

    Asks for what a drawing states. With an option, or without a terminal, nothing is asked and
    usual values stand for the others. An existing file is never overwritten.

    Example: `millscale new my-mill.toml --diameter-m 5.5 --ball-diameter-mm 60 --lifters 36`
    """
    from millscale.cases.cost import wall_time
    from millscale.cases.new_campaign import NewMill, checked_text, suggested

    given = {name: context.params[name] for name in _QUESTIONS}
    if file.exists():
        raise CampaignError("millscale new", str(file), "exists already", "a new file")
    asks = sys.stdin.isatty() and not any(value is not None for value in given.values())
    mill = NewMill()
    for field in fields(NewMill):
        value, name = given[field.name], field.name
        usual = suggested(name, mill)
        if asks and (mill.lifters or name not in _LINER):
            value = typer.prompt(_QUESTIONS[name], default=f"{usual:g}", type=type(usual))
        changed: dict[str, Any] = {name: usual if value is None else value}
        mill = replace(mill, **changed)
    text, cases = checked_text(file, mill)
    try:
        with file.open("x", encoding="utf-8") as written:
            written.write(text)
    except FileExistsError:
        raise CampaignError("millscale new", str(file), "exists already", "a new file") from None
    total = duration(sum(wall_time(case, 1) for case in cases))
    typer.echo(f"{file}: {counted(len(cases), 'case')}, about {total}; next: millscale plan {file}")
