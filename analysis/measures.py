"""Measured quantities of charges and single balls: one row for each.

A row says how a quantity is read, how two charges are compared in it, and how it is shown. Rows of
results.json, seed spreads, tables, figures, comparisons of groups and parameter studies iterate
over these rows. To add a quantity, compute it in a result or a shape, and add its row here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

from millscale.analysis.finished import Charge
from millscale.analysis.shapes.comparison import curve_distances
from millscale.analysis.shapes.curtain import curtain_overlaps
from millscale.analysis.shapes.mass_flow import FRAMES, compare_flow, flow_of
from millscale.analysis.shapes.mixing import index_after
from millscale.analysis.shapes.shape import Shape
from millscale.analysis.shapes.surface_ends import SurfaceEnds
from millscale.formats import number

# Value of an error: a number, by curtain a mapping; None where a run lacks what is compared.
Value = float | Mapping[str, Any] | None


@dataclass(frozen=True)
class Column:
    """How a number is stored and how it is shown.

    Attributes:
        name: its key in JSON.
        label: its heading, without the unit.
        unit: in which it is shown; empty for a ratio.
        factor: number shown over number stored.
        digits: decimals shown.
        signed: a positive number is shown with its sign.
        in_tables: whether tables have a column for it.
    """

    name: str
    label: str
    unit: str = ""
    factor: float = 1.0
    digits: int = 3
    signed: bool = False
    in_tables: bool = True

    @property
    def heading(self) -> str:
        return f"{self.label} [{self.unit}]" if self.unit else self.label

    def text(self, value: float | None, signed: bool | None = None) -> str:
        """Return a number as it is shown; a dash for None.

        Args:
            signed: replaces that of the column, such as for a scatter.
        """
        if value is None:
            return number(None)
        shown = number(self.factor * value, self.digits)
        plus = self.signed if signed is None else signed
        return f"+{shown}" if plus and value > 0.0 else shown

    def scatter_text(self, value: float | None) -> str:
        """Return a scatter with the decimals of the number that it stands beside."""
        return number(None) if value is None else f"{self.factor * value:.{self.digits}f}"


@dataclass(frozen=True)
class ErrorColumn(Column):
    """An error of one charge against another.

    Attributes:
        same: its value for two equal charges: 0 for distances, 1 for overlaps and correlations.
        study: its name in parameter studies; empty where they do not compare settings by it.
        about: what it is, in words.
        by_curtain: its value is a mapping by curtain, shown in a separate table.
    """

    same: float = 0.0
    study: str = ""
    about: str = ""
    by_curtain: bool = False

    def distance(self, value: float | None) -> float | None:
        """Return how far two charges are from being equal."""
        return None if value is None else abs(value - self.same)

    @property
    def distance_name(self) -> str:
        return self.name if self.same == 0.0 else f"{self.same:g} - {self.name}"


def relative(ours: float, theirs: float) -> tuple[float | None]:
    """Return a number less another, over the other."""
    return (ours / theirs - 1.0 if theirs else None,)


class Taken(Enum):
    """When a quantity is read."""

    ONCE = "from a finished charge"
    AVERAGED = "a number of each dump, averaged over the steady part of the rotation"
    AT_DUMPS = "of each dump; two charges are compared dump by dump"


@dataclass(frozen=True, kw_only=True)
class Quantity(Column):
    """One measured quantity.

    Attributes:
        read: returns it from a `Charge` if `taken` is ONCE, else from a `Shape`; None if there is
            none.
        taken: when it is read.
        compare: returns the errors of the first against the second, in the order of `errors`; of a
            number by default the relative difference.
        is_number: its value is a number, which rows hold under its name.
        of_result: it is a mean in result.json, which may have a standard error.
    """

    read: Callable[[Any], Any]
    taken: Taken = Taken.ONCE
    compare: Callable[[Any, Any], Sequence[Value]] = relative
    errors: tuple[ErrorColumn, ...] = ()
    is_number: bool = True
    of_result: bool = False

    def compared(self, ours: Any, theirs: Any) -> dict[str, Value]:
        """Return the errors of one value against another, by name; None without one of them."""
        if not self.errors or ours is None or theirs is None:
            return dict.fromkeys(error.name for error in self.errors)
        values = self.compare(ours, theirs)
        return {error.name: value for error, value in zip(self.errors, values, strict=True)}


def _mean(name: str, label: str, digits: int = 4, errors: tuple[ErrorColumn, ...] = (),
          in_tables: bool = True) -> Quantity:  # fmt: skip
    """Return a dimensionless mean of result.json."""

    def read(charge: Charge) -> float | None:
        return charge.result.dimensionless.get(name)

    return Quantity(name, label, digits=digits, read=read, errors=errors,
                    in_tables=in_tables, of_result=True)  # fmt: skip


def _end(name: str, label: str, read: Callable[[SurfaceEnds], float]) -> Quantity:
    """Return an end of the surface of the bed [rad]."""

    def of_shape(shape: Shape) -> float | None:
        return None if shape.ends is None else read(shape.ends)

    return Quantity(name, label, "deg", math.degrees(1.0), 1, taken=Taken.AVERAGED, read=of_shape)


def _mass_flow(frame: str, label: str, prefix: str, study: str) -> Quantity:
    """Return the mass in the monitoring box of a frame against mill angle, of series.csv."""
    column, shown = FRAMES[frame], bool(study)
    return Quantity(
        f"mass_flow_{frame}",
        label,
        read=lambda charge: flow_of(charge.series, column) if charge.has(column) else None,
        compare=compare_flow,
        errors=(
            ErrorColumn(f"{prefix}_rms", f"{label}, RMS", "% of total", 100.0, 3, in_tables=shown),
            ErrorColumn(
                f"{prefix}_rms_over_mean",
                f"{label}, RMS",
                "% of mean",
                100.0,
                2,
                in_tables=False,
                study=study,
                about="mass in the monitoring box: RMS difference over its mean",
            ),
            ErrorColumn(
                f"{prefix}_correlation", f"{label}, correlation", in_tables=shown, same=1.0
            ),
        ),
        is_number=False,
    )


QUANTITIES = (
    Quantity(
        "contour",
        "contour",
        taken=Taken.AT_DUMPS,
        read=lambda shape: shape.contour.lines or None,
        compare=curve_distances,
        errors=(
            ErrorColumn(
                "contour_error_mean",
                "contour, mean",
                "% of R - a",
                100.0,
                2,
                study="contour",
                about="surface contour: mean distance over R - a",
            ),
            ErrorColumn("contour_error_max", "contour, largest", "% of R - a", 100.0, 1),
        ),
        is_number=False,
    ),
    Quantity(
        "curtain",
        "curtains",
        taken=Taken.AT_DUMPS,
        read=lambda shape: shape.curtains,
        compare=curtain_overlaps,
        errors=(
            ErrorColumn("curtain_iou", "curtains", same=1.0, by_curtain=True, in_tables=False),
            ErrorColumn(
                "curtain_iou_whole",
                "curtains, overlap",
                digits=2,
                same=1.0,
                in_tables=False,
                study="curtain",
                about="curtains: 1 - intersection over union",
            ),
            ErrorColumn("curtain_iou_upper", "curtains, overlap of upper ends", digits=2, same=1.0),
            ErrorColumn("curtain_iou_lower", "curtains, overlap of lower ends", digits=2, same=1.0),
        ),
        is_number=False,
    ),
    _mass_flow("fixed", "mass in the box", "massflow", study="mass_flow"),
    _mass_flow("rotating", "mass in the rotating box", "massflow_rotating", study=""),
    _mean("kinetic", "kinetic / M ω²R²"),
    _mean("kinetic_rotation", "spin / M ω²R²", in_tables=False),
    _mean("torque", "torque / M g R"),
    _mean(
        "power",
        "power / M g R ω",
        errors=(
            ErrorColumn(
                "power_error",
                "power",
                "%",
                100.0,
                2,
                signed=True,
                study="power",
                about="mean power over M g R omega: relative",
            ),
        ),
        in_tables=False,
    ),
    _mean("centre_x", "centre x / R", 3),
    _mean("centre_z", "centre z / R", 3),
    Quantity(
        "flying_share",
        "in flight",
        "%",
        100.0,
        1,
        read=lambda charge: charge.result.mean.get("flying_share"),
        of_result=True,
    ),
    Quantity(
        "ends_power_share",
        "power of the ends",
        "% of power",
        100.0,
        1,
        read=lambda charge: charge.result.ends and charge.result.ends.power_share,
        of_result=True,
    ),
    Quantity(
        "liner_slip",
        "slip on the liner",
        "%",
        100.0,
        1,
        read=lambda charge: charge.result.liner_slip,
        of_result=True,
    ),
    _end("toe_angle_rad", "toe", lambda ends: ends.toe),
    _end("shoulder_angle_rad", "shoulder", lambda ends: ends.shoulder),
    Quantity(
        "mixing_index",
        "mixing index after a revolution",
        read=lambda charge: index_after(charge.folder, charge.case),
    ),
    Quantity(
        "solid_fraction",
        "solid fraction of the bed",
        taken=Taken.AVERAGED,
        read=lambda shape: shape.contour.bulk_fraction,
    ),
    Quantity(
        "curtain_share",
        "balls in curtains",
        "%",
        100.0,
        1,
        in_tables=False,
        taken=Taken.AVERAGED,
        read=lambda shape: shape.curtain_share,
    ),
    Quantity(
        "curtain_width",
        "width of curtains",
        "% of R - a",
        100.0,
        1,
        in_tables=False,
        taken=Taken.AVERAGED,
        read=lambda shape: shape.curtain_width,
    ),
    Quantity(
        "throw_angle_rad",
        "balls thrown at",
        "deg",
        math.degrees(1.0),
        1,
        taken=Taken.AVERAGED,
        read=lambda shape: shape.throw_angle,
        errors=(
            ErrorColumn(
                "detach_angle_error",
                "throw angle",
                "%",
                100.0,
                2,
                signed=True,
                in_tables=False,
                study="detach_angle",
                about="angle from the vertical at which balls were thrown: relative",
            ),
        ),
    ),
    Quantity(
        "landing_angle_rad",
        "thrown balls land at",
        "deg",
        math.degrees(1.0),
        1,
        taken=Taken.AVERAGED,
        read=lambda shape: shape.landing_angle,
    ),
)

NUMBERS = tuple(quantity for quantity in QUANTITIES if quantity.is_number)
ERRORS = tuple(error for quantity in QUANTITIES for error in quantity.errors)
STUDIED = {error.study: error for error in ERRORS if error.study}


@dataclass(frozen=True)
class EnergyWindow:
    """Mill angles between which the energy changes of single balls are compared.

    Attributes:
        prefix: of the keys of its numbers in results.json.
        of_paper: whether it is one of the paper's mill only.
    """

    prefix: str
    label: str
    of_paper: bool = False

    @property
    def ratio_key(self) -> str:
        return f"{self.prefix}ratio" if self.prefix else "energy_ratio"


COMMON_ANGLES = EnergyWindow("", "common mill angles")
FROM_THROW = EnergyWindow("from_throw_", "from each throw")
PAPER_ANGLES = EnergyWindow("paper_angles_", "the paper's mill angles", of_paper=True)
ENERGY_WINDOWS = (COMMON_ANGLES, FROM_THROW, PAPER_ANGLES)

# Angles from the vertical at which a single ball leaves, keys of result.json with _deg, _mean_deg
# and _std_deg.
SINGLE_BALL_ANGLES = (
    Column("liner_off_angle", "liner left", "deg", digits=2),
    Column("detach_angle", "free flight begins", "deg", digits=2),
)
