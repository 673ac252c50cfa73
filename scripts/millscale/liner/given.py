"""The liner that a campaign states by a file, rows of lifters or a preset."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from millscale import _core
from millscale.errors import CampaignError
from millscale.liner.csv_table import read_csv
from millscale.liner.dxf_drawing import read_dxf
from millscale.liner.lengths import LENGTHS
from millscale.liner.lifter_rows import LifterRow, rows_outline, step_outline, wave_outline
from millscale.liner.outline import Outline, flattened
from millscale.liner.sector import COUNTER, Placing, profile_of
from millscale.liner.shell import read_shell
from millscale.liner.simplify import reached_error, simplified
from millscale.runs.digests import digest_of

PRESETS = ("plain", "rail", "wave", "step", "ship-lap")
TABLES, DRAWINGS, SHELLS = (".csv", ".txt", ".dat"), (".dxf",), (".stl",)


@dataclass(frozen=True)
class Source:
    """A file with an outline, and what the campaign states about it.

    Attributes:
        path: of the file.
        unit: of its numbers; None: as the file states.
        layer: of a drawing; None: all.
        centre: of the mill in the file [m].
        tolerance: points are replaced by lines and arcs within this; None: not at all [m].
        turns: direction of rotation in the file; None: not stated.
        lifters: number around the mill; None: not stated.
    """

    path: Path
    unit: str | None = None
    layer: str | None = None
    centre: tuple[float, float] = (0.0, 0.0)
    tolerance: float | None = None
    turns: str | None = None
    lifters: int | None = None


@dataclass(frozen=True)
class Given:
    """A liner of the physical mill.

    Attributes:
        shape: its cross-section.
        warnings: in words.
        file: name of its file; empty without one.
        digest: of the file, SHA-256; empty without one.
    """

    shape: _core.Profile
    warnings: tuple[str, ...] = ()
    file: str = ""
    digest: str = ""

    def profile(self, radius: float) -> _core.Profile:
        """Return the liner; it is made for the radius of the mill already."""
        return self.shape


def liner_from_file(source: Source, radius: float, phase: float) -> Given:
    """Return the liner of a file.

    Args:
        radius: R of the mill [m].
        phase: angle of groove 0 from the bottom at rest [rad].

    Raises:
        CampaignError: states the place in the file.
    """
    outline, notes = _read(source, radius)
    outline = replace(outline, points=outline.points - np.array(source.centre))
    placing = Placing(radius, phase, source.turns, source.lifters)
    if source.tolerance is not None:
        placing = replace(placing, tolerance=source.tolerance)
        outline, note = _fitted(outline, source.tolerance)
        notes += note
    profile, more = profile_of(outline, placing)
    return Given(profile, notes + more, source.path.name, digest_of(source.path))


def _read(source: Source, radius: float) -> tuple[Outline, tuple[str, ...]]:
    ending = source.path.suffix.lower()
    if ending in DRAWINGS:
        return read_dxf(source.path, source.layer, source.unit)
    if source.layer is not None:
        cause = f'liner.layer is "{source.layer}", and the file has no layers'
        raise CampaignError(source.path, "", cause, "a .dxf drawing, or no such key")
    if ending in SHELLS:
        return read_shell(source.path, source.unit, radius)
    if ending not in TABLES:
        accepted = ", ".join((*TABLES, *DRAWINGS, *SHELLS))
        cause = f'a file that ends in "{source.path.suffix}"'
        raise CampaignError(source.path, "", cause, accepted)
    outline = read_csv(source.path)
    if source.unit is not None and LENGTHS[source.unit] != outline.unit:
        stated = next(name for name, metres in LENGTHS.items() if metres == outline.unit)
        cause = f"its header states {stated}, liner.unit is {source.unit}"
        raise CampaignError(source.path, outline.names[0], cause, "one of the two")
    return outline, ()


def _fitted(outline: Outline, tolerance: float) -> tuple[Outline, tuple[str, ...]]:
    """Return the outline with lines and arcs in place of its points, and the reached error."""
    measured, _ = flattened(outline, 0.01 * tolerance)
    names = outline.names if len(measured) == len(outline.points) else ()
    lines = replace(
        outline,
        points=measured,
        bulges=np.zeros(len(measured)),
        names=names or tuple(f"point {i + 1}" for i in range(len(measured))),
    )
    found = simplified(lines, tolerance)
    error = reached_error(lines, found)
    note = (
        f"liner: {len(measured)} points are {found.pieces} lines and arcs, none farther than "
        f"{error:.3g} m (tolerance {tolerance:g} m)"
    )
    if found.pieces > 0.2 * len(measured) > 4:
        note += "; so many pieces mean a tolerance below the noise of the points"
    return found, (note,)


def liner_of_rows(
    file: Path, radius: float, rows: tuple[LifterRow, ...], lifters: int, phase: float
) -> Given:
    """Return the liner of lifters that repeat in the order of the rows around the mill.

    Raises:
        CampaignError: rows that do not fit.
    """
    if lifters % len(rows):
        raise CampaignError(
            file,
            "liner.lifters",
            f"got {lifters} with {len(rows)} rows, which repeat in order around the mill",
            f"a multiple of {len(rows)}",
        )
    outline = rows_outline(file, radius, rows, lifters)
    return Given(_placed(outline, radius, phase))


@dataclass(frozen=True)
class Preset:
    """A family of liners by few numbers.

    Attributes:
        family: one of PRESETS.
        lifters: lifters, waves or steps around the mill; 0 of a plain liner.
        height: of a lifter, wave or step [m].
        top_width: of the lifters of rail and ship-lap [m].
        leading_angle, trailing_angle: of the faces from the lifter's centre line [rad].
        edge_radius: of rail, step and ship-lap [m].
    """

    family: str
    lifters: int
    height: float = 0.0
    top_width: float = 0.0
    leading_angle: float = 0.0
    trailing_angle: float = 0.0
    edge_radius: float = 0.0


def liner_of_preset(file: Path, radius: float, preset: Preset, phase: float) -> Given:
    """Return the liner of a family.

    Raises:
        CampaignError: numbers that make no such liner.
    """
    if preset.family == "plain":
        return Given(_core.Lifters(radius, 0.0, 0.0, 0.0, 0, phase))
    if preset.height >= radius:
        cause = f"got {preset.height:g} in a mill of {radius:g} m"
        raise CampaignError(file, "liner.lifter_height_m", cause, f"< {radius:g}")
    if preset.family == "wave":
        outline = wave_outline(file, radius, preset.height, preset.lifters)
    elif preset.family == "step":
        outline = step_outline(
            file, radius, preset.height, preset.leading_angle, preset.edge_radius, preset.lifters
        )
    else:
        row = LifterRow(
            preset.height,
            preset.top_width,
            preset.leading_angle,
            preset.trailing_angle,
            preset.edge_radius,
        )
        outline = rows_outline(file, radius, (row,), preset.lifters)
    return Given(_placed(outline, radius, phase))


def _placed(outline: Outline, radius: float, phase: float) -> _core.Profile:
    """Return the profile of an outline made in the direction of rotation."""
    profile, _ = profile_of(outline, Placing(radius, phase, COUNTER))
    return profile


# Default angles of the presets, from the lifter's centre line [rad].
ANGLES = {
    "rail": (0.0, 0.0),
    "step": (0.0, 0.0),
    "ship-lap": (math.radians(20.0), math.radians(70.0)),
}
