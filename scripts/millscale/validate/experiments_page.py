"""Tables and figures of docs/results/experiments.md: `millscale validate experiments`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps, rc_context
from matplotlib.figure import Figure

from millscale.analysis.finished_campaign import Campaign, load_campaign
from millscale.engine.record import provenance
from millscale.formats import number
from millscale.report.figures.style import STYLE
from millscale.runs.untrusted import RunFolderError
from millscale.runs.writing import write_json
from millscale.study.folders import SETTINGS_FOLDER
from millscale.validate.experiments import (
    OMEGA,
    Profile,
    closed_form,
    drum_row,
    is_measured_drum,
    landing_on_liner,
    read_profile,
    releases_of,
    state_row,
    throw_row,
)

Row = dict[str, Any]
COMMAND = "millscale validate experiments DIR..."
# Impact speeds reported of mills of 5 and 10 m [m/s].
REPORTED = {"impacts-5-m": 8.0, "impacts-10-m": 12.0}
# Distance below the axis at which the surface layer of the measured drum ends: its speed there is
# half of that at the surface, and points above scatter by a third [m].
SURFACE_LAYER = 0.04
DRUM, THROWS = "experiments-drum.png", "experiments-throws.png"


def measured_profile(document: Row) -> Profile:
    """Return the measured profile."""
    stored = document["measured"]
    return Profile(np.array(stored["distance_from_axis_m"]), np.array(stored["velocity_m_s"]))


def simulated_profile(row: Row, measured: Profile) -> Profile:
    """Return the profile of a row of `drums`."""
    velocity = [math.nan if u is None else u for u in row["velocity_m_s"]]
    return Profile(measured.distance, np.array(velocity))


def tables(document: Row) -> str:
    """Return the tables of the page, in Markdown."""
    return "\n".join(
        [
            *(*drum_table(document), ""),
            *(*throw_table(document), ""),
            *(*impact_table(document), ""),
            *(*slip_table(document), ""),
        ]
    )


def settings_of(document: Row) -> list[list[Row]]:
    """Return the rows of the drum by setting and S, the seeds of one together."""
    groups: dict[tuple[str, float], list[Row]] = {}
    for row in document["drums"]:
        groups.setdefault((row["campaign"], row["S"]), []).append(row)
    return list(groups.values())


def drum_table(document: Row) -> list[str]:
    """Return the drum: a line for each setting, means over its seeds, best fit of each S first."""
    measured = measured_profile(document)
    lines = [
        "| S | balls | seeds | ends | rolling friction, balls / wall | friction, balls / wall "
        "| slip on the liner | T / M g R | rms [m/s] | rms below the surface layer [m/s] | points "
        "| change of sign [mm] | speed near the wall |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    groups = [
        (rows, [simulated_profile(x, measured) for x in rows]) for rows in settings_of(document)
    ]
    groups.sort(key=lambda pair: (-pair[0][0]["S"], mean_rms(pair[1], measured)))
    for rows, profiles in groups:
        first = rows[0]
        zeros = [1e3 * zero for x in profiles if (zero := x.zero()) is not None]
        points = [int(np.isfinite(x.velocity).sum()) for x in profiles]
        lines.append(
            f"| {first['S']:g} | {first['balls']:,} | {len(rows)} | {first['ends']} "
            f"| {first['rolling_friction_pp']:g} / {first['rolling_friction_pw']:g} "
            f"| {first['static_friction_pp']:g} / {first['static_friction_pw']:g} "
            f"| {_mean([x['liner_slip'] for x in rows if x['liner_slip'] is not None], 3)} "
            f"| {_mean([x['torque'] for x in rows], 3)} "
            f"| {_mean(_known(x.rms_from(measured) for x in profiles), 3)} "
            f"| {_mean(_known(x.rms_from(measured, SURFACE_LAYER) for x in profiles), 3)} "
            f"| {min(points)} "
            f"| {_mean(zeros, 1)} "
            f"| {_mean(_known(x.over_rigid(OMEGA) for x in profiles), 2)} |"
        )
    return lines


def mean_rms(profiles: Sequence[Profile], measured: Profile) -> float:
    """Return the mean over the seeds of the rms from the measured velocities [m/s]; infinite if no
    seed has any."""
    known = _known(x.rms_from(measured) for x in profiles)
    return float(np.mean(known)) if known else math.inf


def _known(values: Iterable[float | None]) -> list[float]:
    return [x for x in values if x is not None]


def throw_table(document: Row) -> list[str]:
    """Return the single balls: a line for each case, means over its throws."""
    lines = [
        "| campaign | liner | S | throws | left at [deg] | lands on the liner at [deg] "
        "| speed there [m/s] | without lifters [deg, m/s] |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for row in document["throws"]:
        releases = releases_of(row)
        on_liner = [landing_on_liner(x, row["path_m"]) for x in releases]
        left = [math.degrees(math.atan2(-x.position[0], x.position[2])) for x in releases]
        form = closed_form(row)
        lines.append(
            f"| {row['campaign']} | {row['state'] or '-'} | {row['S']:g} | {len(releases)} "
            f"| {_mean(left, 1)} | {_mean([math.degrees(x.angle) for x in on_liner], 1)} "
            f"| {_mean([x.speed for x in on_liner], 2)} "
            f"| {math.degrees(form.angle):.1f}, {form.speed:.2f} |"
        )
    return lines


def impact_table(document: Row) -> list[str]:
    """Return the root mean square difference of the impact speeds from those reported, by S."""
    lines = [
        "| S | "
        + " | ".join(f"{name}, reported {speed:g} m/s" for name, speed in REPORTED.items())
        + " | rms [m/s] | rms [%] |",
        "|---|" + "---|" * (len(REPORTED) + 2),
    ]
    found: dict[float, dict[str, float]] = {}
    for row in document["throws"]:
        if row["campaign"] in REPORTED and row["releases"]:
            speeds = [landing_on_liner(x, row["path_m"]).speed for x in releases_of(row)]
            found.setdefault(row["S"], {})[row["campaign"]] = float(np.mean(speeds))
    for S, speeds_of in sorted(found.items()):
        if speeds_of.keys() != REPORTED.keys():
            continue
        off = np.array([speeds_of[name] - speed for name, speed in REPORTED.items()])
        share = off / np.array(list(REPORTED.values()))
        lines.append(
            f"| {S:g} | "
            + " | ".join(f"{speeds_of[name]:.2f}" for name in REPORTED)
            + f" | {math.sqrt(np.mean(off**2)):.2f} | {100.0 * math.sqrt(np.mean(share**2)):.0f} |"
        )
    return lines


def slip_table(document: Row) -> list[str]:
    """Return the slip on the liner of every charge."""
    lines = [
        "| campaign | S | balls | slip on the liner | T / M g R | kinetic / M (omega R)^2 "
        "| steady |",
        "|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {row['campaign']} | {row['S']:g} | {row['balls']:,} | {number(row['liner_slip'], 3)} "
        f"| {row['torque']:.3f} | {row['kinetic']:.3f} | {'yes' if row['is_steady'] else 'no'} |"
        for row in [*document["charges"], *document["drums"]]
    ]
    return lines


def _mean(values: Sequence[float], digits: int) -> str:
    """Return a mean, with the standard deviation of values that differ by more than its digits."""
    text = number(float(np.mean(values)) if values else None, digits)
    spread = float(np.std(values, ddof=1)) if len(values) > 1 else 0.0
    return f"{text} ± {spread:.{digits}f}" if spread > 10.0**-digits else text


def draw(document: Row, folder: Path) -> None:
    """Draw the profiles of the drum and the paths of thrown balls."""
    if document["drums"]:
        _draw_drum(document, folder / DRUM)
    if document["throws"]:
        _draw_throws(document["throws"], folder / THROWS)


def _draw_drum(document: Row, file: Path) -> None:
    measured = measured_profile(document)
    with rc_context(STYLE):
        figure = Figure(figsize=(9.0, 3.6), layout="constrained")
        ratios = sorted({row["S"] for row in document["drums"]})
        panels = figure.subplots(1, len(ratios), sharey=True, squeeze=False)[0]
        for axes, S in zip(panels, ratios, strict=True):
            groups = [rows for rows in settings_of(document) if rows[0]["S"] == S]
            colours = colormaps["viridis"](np.linspace(0.0, 0.9, len(groups)))
            for rows, colour in zip(groups, colours, strict=True):
                label = ", ".join(
                    [
                        *(f"{rows[0][f'rolling_friction_{pair}']:g}" for pair in ("pp", "pw")),
                        f"{rows[0]['static_friction_pw']:g}",
                        *(["no ends"] if rows[0]["ends"] == "periodic" else []),
                    ]
                )
                order = np.argsort(measured.distance)
                for row in rows:
                    velocity = simulated_profile(row, measured).velocity
                    axes.plot(
                        -1e3 * measured.distance[order], velocity[order], color=colour,
                        linewidth=1.0, label=label if row is rows[0] else None,
                    )  # fmt: skip
            axes.plot(-1e3 * measured.distance, measured.velocity, "ko", ms=3, label="measured")
            axes.axhline(0.0, color="#999", linewidth=0.8)
            axes.set(xlabel="distance below the axis [mm]", title=f"S = {S:g}")
            axes.legend(
                fontsize="x-small", title="rolling: balls, wall; wall", title_fontsize="x-small"
            )
        panels[0].set(ylabel="velocity down the slope [m/s]")
        figure.savefig(file, dpi=110)


def _draw_throws(rows: Sequence[Row], file: Path) -> None:
    names = list(dict.fromkeys(row["campaign"] for row in rows))
    with rc_context(STYLE):
        figure = Figure(figsize=(9.0, 3.6), layout="constrained")
        for axes, name in zip(figure.subplots(1, len(names), squeeze=False)[0], names, strict=True):
            own = [row for row in rows if row["campaign"] == name and row["releases"]]
            colours = colormaps["viridis"](np.linspace(0.0, 0.85, max(len(own), 1)))
            turn = np.linspace(0.0, 2.0 * np.pi, 181)
            axes.plot(np.cos(turn), np.sin(turn), color="#555", linewidth=0.8)
            for row, colour in zip(own, colours, strict=True):
                first = releases_of(row)[0]
                time = np.linspace(0.0, first.time_to_radius(row["path_m"]), 60)
                place = first.position_at(time) / row["radius_m"]
                label = f"S = {row['S']:g}{', ' + row['state'] if row['state'] else ''}"
                axes.plot(place[:, 0], place[:, 2], color=colour, linewidth=1.2, label=label)
            axes.set(title=name, aspect="equal", xlabel="x / R")
            axes.legend(fontsize="x-small", loc="center")
        figure.axes[0].set(ylabel="z / R")
        figure.savefig(file, dpi=110)


def _campaigns(folders: Sequence[Path]) -> list[Campaign]:
    """Return the campaigns of runs folders; of a parameter study those of its settings."""
    found = []
    for folder in folders:
        settings = sorted((folder / SETTINGS_FOLDER).glob("*/campaign.json"))
        found += [load_campaign(x.parent) for x in settings] or [load_campaign(folder)]
    return found


def write_experiments(folders: Sequence[Path], to: Path, measured: Path) -> str:
    """Write experiments.json and its figures; return their tables.

    Charges of the drum that was measured have a profile, other charges their slip alone.

    Args:
        folders: runs folders of campaigns/experiments and of other campaigns.
        measured: file of the measured profile.

    Raises:
        RunFolderError: a folder holds no finished case, or dumps are missing.
    """
    profile = read_profile(measured)
    document: Row = {"schema": 1, **provenance(), "command": COMMAND}
    document["measured"] = {
        "distance_from_axis_m": profile.distance.tolist(),
        "velocity_m_s": profile.velocity.tolist(),
    }
    document |= {"drums": [], "charges": [], "throws": []}
    for campaign in _campaigns(folders):
        if not campaign.cases:
            raise RunFolderError(campaign.runs, "no finished case", "run its campaign first")
        for charge in campaign.charges:
            if is_measured_drum(charge.case):
                document["drums"].append(drum_row(charge, profile))
            else:
                document["charges"].append(state_row(charge))
        document["throws"] += [throw_row(ball, campaign.name) for ball in campaign.single]
    to.parent.mkdir(parents=True, exist_ok=True)
    write_json(to, document)
    draw(document, to.parent)
    return tables(document)
