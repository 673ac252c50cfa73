"""`millscale wear`: the worn liner of the physical mill, for the next campaign."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import typer

from millscale.cli.options import RunsArgument, print_whole
from millscale.errors import CampaignError


def wear(
    runs: RunsArgument,
    hours: Annotated[float, typer.Option("--hours", metavar="H", help="Hours of operation [h].")],
    constant: Annotated[
        float | None,
        typer.Option("--constant", metavar="K", help="Worn volume over energy [m^3/J]."),
    ] = None,
    to: Annotated[
        Path | None, typer.Option("--to", metavar="CSV", help="File for the worn profile.")
    ] = None,
    measured: Annotated[
        Path | None,
        typer.Option(metavar="CSV", help="Profile measured after H hours, to find K by."),
    ] = None,
    law: Annotated[
        str, typer.Option(metavar="LAW", help="archard: slip work; finnie: impacts at an angle.")
    ] = "archard",
    ratio: Annotated[
        float | None,
        typer.Option("--S", metavar="S", help="Scaled mill to read; default: the smallest S."),
    ] = None,
    smoothing: Annotated[
        float | None,
        typer.Option(metavar="M", help="Smoothing of the depth [m]; default: the ball radius."),
    ] = None,
    plate: Annotated[
        float | None,
        typer.Option(metavar="M", help="Thickness between the lifters [m]; default: no limit."),
    ] = None,
) -> None:
    """Wear the liner of the physical mill by the loads of a scaled mill; write its profile.

    The campaign of DIR needs `liner_loads = true` in [multi_ball]. The next campaign takes the
    file with `[liner] profile`; its first lines state radius_m and turns. See docs/guide/wear.md.

    With --measured in place of --constant and --to it prints the constant of each law that fits a
    measured profile best, and the rms that is left. Writes no file then.

    Examples: `millscale wear runs/sag --hours 500 --constant 4e-13 --to worn.csv`,
    `millscale wear runs/sag --hours 4000 --measured measured.csv`
    """
    if measured is not None:
        if constant is not None or to is not None or plate is not None:
            cause = "with --constant, --to or --plate"
            accepted = "--measured with --hours, --S and --smoothing"
            raise CampaignError("millscale wear", "--measured", cause, accepted)
        _print_fit(runs, measured, hours, ratio, smoothing)
        return
    if constant is None or to is None:
        accepted = "--constant K and --to CSV, or --measured CSV"
        raise CampaignError("millscale wear", "--constant, --to", "missing", accepted)
    from millscale.analysis.wear.rate import LAWS
    from millscale.analysis.wear.worn_liner import WearWish, worn_liner_of
    from millscale.runs.writing import write_text

    if law not in LAWS:
        raise CampaignError("millscale wear", "--law", f'got "{law}"', " or ".join(LAWS))
    wish = WearWish(law, hours, constant, ratio, smoothing, plate)
    found = worn_liner_of(runs, wish)
    worn, first = found.worn, found.charges[0]
    about = f"{law}, k = {constant:g} m^3/J, {hours:g} h, of {first.id}"
    write_text(to, worn.text(about))
    for warning in found.warnings:
        typer.echo(f"warning: {warning}", err=True)
    typer.echo(f"{to}: {about}")
    typer.echo(f"  deepest wear {1e3 * worn.deepest:.3g} mm")
    typer.echo(f"  lifter height {1e3 * found.height:.4g} -> {1e3 * worn.height:.4g} mm")
    if math.isfinite(worn.leading_angle):
        typer.echo(f"  leading face {math.degrees(worn.leading_angle):.1f} deg from the radius")
    typer.echo(f"  for the next campaign: radius_m = {worn.radius:.9g} in [mill], and in [liner]")
    typer.echo(f'  profile = "{to.name}", turns = "counter-clockwise"')


def _print_fit(
    runs: Path, measured: Path, hours: float, ratio: float | None, smoothing: float | None
) -> None:
    """Print the laws of wear beside a measured profile."""
    from rich.table import Table

    from millscale.analysis.wear.measured_profile import fit_laws

    found = fit_laws(runs, measured, hours, ratio, smoothing)
    table = Table(title=f"{measured} after {hours:g} h, by {found.charges[0].id}")
    for name in ("law", "constant [m^3/J]", "height [mm]", "face [deg]", "rms [mm]"):
        table.add_column(name, justify="left" if name == "law" else "right")
    table.add_row("measured", "", f"{1e3 * found.height:.1f}", "", "")
    table.add_row("no wear", "0", "", "", f"{1e3 * found.unworn_rms:.1f}")
    for one in found.laws:
        worn = one.worn
        shape = (f"{1e3 * worn.height:.1f}", f"{math.degrees(worn.leading_angle):.1f}")
        table.add_row(one.law, f"{one.constant:.3g}", *shape, f"{1e3 * one.rms:.1f}")
    print_whole(table)
    typer.echo("rms: of the heights above the plate over a pitch")
