"""`millscale validate`: how far the simulation can be trusted, measured."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from millscale.cli.options import (
    CaseArgument,
    CasesArgument,
    RunsArguments,
    RunsOption,
    check_at_least,
)

validate = typer.Typer(
    no_args_is_help=True,
    rich_markup_mode="markdown",
    help="""
Measure the errors of the simulation itself: time step, energy, torque, sampling.

These commands run the engine for minutes to hours and write the files of docs/results and the pages
made of them.
""",
)

Docs = Annotated[
    Path, typer.Option(metavar="DIR", help="Folder that gets results/*.json and *.md.")
]


Scheme = Annotated[
    str | None, typer.Option(metavar="NAME", help="Scheme of the scaled mills, if there are two.")
]
Policy = Annotated[
    str | None, typer.Option(metavar="NAME", help="Policy of the scaled mills, if there are two.")
]


Every = Annotated[
    bool,
    typer.Option(
        "--all", help="Use charges as well that are not steady or out of the law's range."
    ),
]


@validate.command("hard-cases")
def hard_cases(
    docs: Docs = Path("docs"),
    only: Annotated[
        str,
        typer.Option(metavar="TEXT", help="Cases whose name contains this; keeps other results."),
    ] = "",
    backend: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="Contact backend, such as default or stock; repeatable; keeps other results.",
        ),
    ] = None,
) -> None:
    """Find the largest stable time step of mills that are hard to integrate.

    Each case runs at rising fractions of the Rayleigh time. Writes results/hard-cases.json and
    results/hard-cases.md. All cases take some hours.

    Example: `millscale validate hard-cases --only 'Fr 0.9' --backend default`
    """
    from millscale.validate.hard_cases import write_hard_cases

    write_hard_cases(docs, only, tuple(backend or ()))


@validate.command()
def energy(
    folder: CaseArgument,
    to: Annotated[Path, typer.Option(metavar="JSON", help="File for the results.")] = Path(
        "docs/results/ledger.json"
    ),
    angle: Annotated[
        float | None, typer.Option(metavar="RAD", help="Rotation [rad]; default: the case's.")
    ] = None,
    only: Annotated[
        str,
        typer.Option(metavar="NAME", help="One contact setting; keeps the results of the other."),
    ] = "",
) -> None:
    """Measure how well the energy budget of a settled multi-ball case closes.

    Writes the terms of the last revolution [J] and their residual, and a figure beside the file.

    Example: `millscale validate energy runs/quick/cases/mb-cg-paper-S2.600 --angle 7`
    """
    from millscale.validate.energy_budget import write_energy_budget

    write_energy_budget(folder, to, angle, only)


@validate.command("time-step")
def time_step(
    study: Annotated[
        Path, typer.Argument(metavar="DIR", help="Runs folder of campaigns/study-S2.6.toml.")
    ],
    docs: Docs = Path("docs"),
) -> None:
    """Measure what the time step changes in a collision, a bed at rest and a mill.

    The mill comes from a finished study; collisions and beds are run here. Writes
    results/time-step.json, its figure and results/time-step.md.

    Example: `millscale validate time-step runs/study-S2.6`
    """
    from millscale.validate.time_step import write_time_step

    write_time_step(study, docs)


@validate.command()
def torque(runs: RunsArguments, docs: Docs = Path("docs")) -> None:
    """Compare the drive torque with the weight and angular momentum of the charge.

    Takes every finished multi-ball case of the campaigns. Writes results/torque.json and torque.md.

    Example: `millscale validate torque runs/slices runs/slices-half-step`
    """
    from millscale.validate.torque import write_torque

    write_torque(runs, docs)


@validate.command()
def sampling(
    cases: CasesArgument,
    to: Annotated[Path, typer.Option(metavar="JSON", help="File for the results.")] = Path(
        "docs/results/sampling.json"
    ),
    steps: Annotated[int, typer.Option(metavar="N", help="Steps that each case continues.")] = 3000,
    halved: Annotated[
        bool, typer.Option("--halved", help="Also run each case with half of its time step.")
    ] = False,
) -> None:
    """Measure what rows of series.csv miss between their steps, from a row at every step.

    Example: `millscale validate sampling runs/slices/cases/mb-cg-paper-S2.600 --halved`
    """
    from millscale.validate.sampling import write_sampling

    check_at_least("validate sampling", "--steps", steps, 2)
    write_sampling(cases, to, steps, halved)


@validate.command()
def mixing(
    runs: RunsArguments,
    to: Annotated[Path, typer.Option(metavar="JSON", help="File for the results.")] = Path(
        "docs/results/mixing.json"
    ),
) -> None:
    """Measure how fast the balls of the rising and the falling side mix, by Lacey's index.

    Takes the dumps of every finished multi-ball case of the campaigns. Writes a figure beside the
    file; prints Markdown tables.

    Example: `millscale validate mixing runs/slices runs/friction-matched`
    """
    from millscale.validate.mixing import write_mixing

    typer.echo(write_mixing(runs, to))


@validate.command()
def experiments(
    runs: RunsArguments,
    to: Annotated[Path, typer.Option(metavar="JSON", help="File for the results.")] = Path(
        "docs/results/experiments.json"
    ),
    measured: Annotated[
        Path, typer.Option(metavar="CSV", help="Measured velocities of the drum.")
    ] = Path("campaigns/experiments/drum-240-mm.csv"),
) -> None:
    """Compare runs with published measurements: a drum, impact speeds, worn lifters.

    Takes the finished cases of campaigns/experiments; of other campaigns the slip on the liner.
    Writes figures beside the file; prints Markdown tables.

    Example: `millscale validate experiments runs/drum-240-mm runs/impacts-5-m`
    """
    from millscale.validate.experiments_page import write_experiments

    typer.echo(write_experiments(runs, to, measured))


@validate.command()
def fidelity(
    study: Annotated[
        Path, typer.Argument(metavar="DIR", help="Runs folder of campaigns/study-fidelity.toml.")
    ],
    to: Annotated[Path, typer.Option(metavar="JSON", help="File for the results.")] = Path(
        "docs/results/fidelity.json"
    ),
) -> None:
    """Measure whether runs of one seed at two time steps or in two precisions are correlated.

    Control variates need this correlation. Also extrapolates in the step, and in the slice length
    by slice-length.json beside the file. Writes a figure beside the file; prints Markdown tables.

    Example: `millscale validate fidelity runs/study-fidelity`
    """
    from millscale.validate.fidelity import write_fidelity

    typer.echo(write_fidelity(study, to))


@validate.command("friction-matched")
def friction_matched(
    runs: RunsArguments,
    to: Annotated[Path, typer.Option(metavar="JSON", help="File for the results.")],
    every: Every = False,
) -> None:
    """Compare the scaled mills of the policies paper and friction-matched with S = 1.

    Takes the physical mills of which the folders hold S = 1 and scaled mills of both policies. The
    slice of S = 1 serves both schemes. Prints Markdown tables, and draws a figure beside JSON.

    Example: `millscale validate friction-matched runs/slices runs/matched --to friction.json`
    """
    from millscale.validate.friction_matched import write_friction_matched

    typer.echo(write_friction_matched(runs, to, every))


@validate.command()
def prediction(
    runs: RunsArguments,
    to: Annotated[Path, typer.Option(metavar="JSON", help="File for the results.")],
    every: Every = False,
) -> None:
    """Measure how many intervals of predictions hold what S = 1 has, and what predictions cost.

    Predicts each physical mill from pairs of its scaled mills, without S = 1. Prints Markdown
    tables, and draws two figures beside JSON: speed against error, errors over half widths.

    Example: `millscale validate prediction runs/slices --to coverage.json`
    """
    from millscale.validate.coverage import write_coverage

    typer.echo(write_coverage(runs, to, every))


@validate.command()
def definitions(
    runs: RunsArguments, scheme: Scheme = None, policy: Policy = None, docs: Docs = Path("docs")
) -> None:
    """Compare definitions of toe, shoulder, throw angle and flight by how they extrapolate.

    Takes finished charges of S = 1 and of two scaled mills or more. Writes
    results/observable-definitions.json and its figure.

    Example: `millscale validate definitions runs/slices`
    """
    from millscale.validate.definitions import write_definitions

    write_definitions(runs, docs, scheme, policy)


@validate.command()
def averaging(runs: RunsArguments, docs: Docs = Path("docs")) -> None:
    """Measure how far charges turn until they are steady, and what longer runs give beside seeds.

    Takes every finished charge of the campaigns; one of them must be steady for 15 rad. Writes
    results/averaging.json and its figure.

    Example: `millscale validate averaging runs/slices runs/long`
    """
    from millscale.validate.averaging import write_averaging

    write_averaging(runs, docs)


@validate.command("flowing-layer")
def flowing_layer(runs: RunsArguments, docs: Docs = Path("docs")) -> None:
    """Measure depth, inertial number and friction of the layer that flows down the bed.

    Takes every finished charge of the campaigns, of one scheme. Writes results/flowing-layer.json
    and its figure.

    Example: `millscale validate flowing-layer runs/slices runs/friction-matched`
    """
    from millscale.validate.flowing_layer import write_flowing_layer

    write_flowing_layer(runs, docs)


@validate.command("impact-collapse")
def impact_collapse(runs: RunsArguments, docs: Docs = Path("docs")) -> None:
    """Compare the impact spectra of several S, decade by decade, with the spread over the seeds.

    Takes the finished charges with spectra, of one physical mill, scheme and policy. Writes
    results/impact-collapse.json, its figure and results/impact-collapse.md.

    Example: `millscale validate impact-collapse runs/impact-collapse`
    """
    from millscale.validate.impact_collapse import write_impact_collapse

    typer.echo(write_impact_collapse(runs, docs))


@validate.command("liner-variants")
def liner_variants(
    runs: RunsOption,
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="Campaign file of a single ball.")
    ] = Path("campaigns/paper-single-ball.toml"),
) -> None:
    """Run the single ball with the lifter read in other ways and from other start phases.

    The paper states neither the face angle of the lifter nor the phase at the start. Runs S = 1 and
    2.6 for both readings and four phases a quarter of a pitch apart; prints a Markdown table.

    Example: `millscale validate liner-variants --runs runs/liner-variants`
    """
    from millscale.cli.options import console_of
    from millscale.validate.liner_variants import compare_variants

    typer.echo(compare_variants(file, runs, console_of(stderr=True)))
