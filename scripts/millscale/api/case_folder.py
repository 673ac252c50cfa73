"""A finished case: its series, dumps, shapes, power, errors and 3-D view."""

from __future__ import annotations

from functools import cached_property
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from millscale.analysis.charge.energy_budget import read_ledger
from millscale.analysis.charge.measured import measure
from millscale.analysis.charge.pair import check_whole
from millscale.analysis.charge.physical_mill import physical_power
from millscale.analysis.finished import Charge, SingleBall
from millscale.analysis.result_file import ChargeResult, SingleBallResult
from millscale.analysis.shapes.cross_section import liner_outline
from millscale.analysis.shapes.occupancy import read_occupancy
from millscale.analysis.shapes.shape import SAME_ANGLE, Shape, shape_of, unit_length
from millscale.analysis.shapes.snapshots import (
    Snapshot,
    first_dump,
    snapshots_of,
    starts_on_rising_side,
)
from millscale.api.curtain_profiles import CurtainProfiles
from millscale.api.frames import SCALAR_ERRORS, error_unit, frame
from millscale.runs.case_file import Case
from millscale.runs.dumps import read_dump
from millscale.runs.untrusted import RunFolderError

if TYPE_CHECKING:
    import pyvista as pv

OVER = "R - a"


class CaseFolder:
    """A finished case of a runs folder, such as `ms.open("runs/quick")["mb-cg-paper-S2.600"]`.

    Lengths of shapes are over R - a, mill radius less ball radius, so that similar mills coincide.
    Methods with `angle` take the mill angle of a dump [rad]; None stands for the last dump.

    Attributes:
        finished: the case as `millscale.analysis` reads it.
    """

    def __init__(self, finished: SingleBall | Charge) -> None:
        self.finished = finished
        self._shapes: dict[Path, Shape] = {}

    @property
    def id(self) -> str:
        """Name of the case folder."""
        return self.finished.id

    @property
    def folder(self) -> Path:
        """The case folder."""
        return self.finished.folder

    @property
    def case(self) -> Case:
        """The content of case.json, typed; SI units."""
        return self.finished.case

    @property
    def result(self) -> SingleBallResult | ChargeResult:
        """The content of result.json, typed; units: docs/reference/files.md."""
        return self.finished.result

    @property
    def S(self) -> float:
        """Radius of the physical mill over that of this mill."""
        return self.case.S

    @cached_property
    def series(self) -> pd.DataFrame:
        """The rows of series.csv, SI units.

        >>> case.series["drive_power_W"].shape == (len(case.series),)
        True
        >>> case.series.attrs["units"]["drive_torque_Nm"]
        'N m'
        """
        return frame(self.finished.series)

    @property
    def ledger(self) -> pd.DataFrame:
        """The rows of ledger.csv, the energy budget against mill angle, SI units.

        Raises:
            RunFolderError: the campaign did not ask for it (`ledger = true`).
        """
        return frame(read_ledger(self._charge("energy budget").folder))

    @cached_property
    def _snapshots(self) -> list[Snapshot]:
        return snapshots_of(self._charge("dumps").folder)

    @property
    def angles(self) -> np.ndarray:
        """Mill angles of the dumps, (n,) float [rad]."""
        return np.array([snapshot.mill_angle for snapshot in self._snapshots])

    def dump(self, angle: float | None = None) -> pd.DataFrame:
        """Return the balls of a dump: position, velocity, radius and state, SI units.

        A row for each ball, by its id. `attrs` holds mill_angle_rad and step.

        >>> balls = case.dump(angle=1.0)
        >>> len(balls) == case.case.ball.count
        True
        """
        snapshot = self._snapshot(angle)
        dump = read_dump(snapshot.path)
        units = {**dict.fromkeys(("x", "y", "z", "radius"), "m")}
        units |= dict.fromkeys(("vx", "vy", "vz"), "m/s")
        about = {"mill_angle_rad": snapshot.mill_angle, "step": dump.step}
        made = frame(dump.columns, "id", units, **about)
        return made.set_index(made.index.astype(int))

    def shape(self, angle: float | None = None) -> Shape:
        """Return the shape of the charge in a dump: contour, curtains, toe and shoulder."""
        charge, snapshot = self._charge("shape"), self._snapshot(angle)
        if snapshot.path not in self._shapes:
            self._shapes[snapshot.path] = shape_of(read_dump(snapshot.path), snapshot, charge.case)
        return self._shapes[snapshot.path]

    def contour(self, angle: float | None = None) -> pd.DataFrame:
        """Return the free surface of the bed (docs/theory/charge-shape.md).

        Columns: line (int, a surface may have several), x and z over R - a. `attrs` holds
        mill_angle_rad, bulk_fraction and R - a as length_m.

        >>> list(case.contour(angle=1.0).columns)
        ['line', 'x', 'z']
        """
        shape = self.shape(angle)
        lines = shape.contour.lines
        points = np.vstack([np.empty((0, 2)), *lines])
        line = np.repeat(np.arange(len(lines)), [len(x) for x in lines])
        made = self._outline(points, shape.mill_angle)
        made.insert(0, "line", line)
        made.attrs["bulk_fraction"] = shape.contour.bulk_fraction
        return made

    def liner(self, angle: float = 0.0) -> pd.DataFrame:
        """Return the cross-section of the liner turned by a mill angle [rad]: x and z over R - a.

        >>> list(case.liner(angle=1.0).columns)
        ['x', 'z']
        """
        return self._outline(liner_outline(self.case, angle) / unit_length(self.case), angle)

    def curtains(self, angle: float | None = None) -> CurtainProfiles:
        """Return the balls in flight by the lifter that threw them.

        >>> case.curtains(angle=1.0).overlap(case.curtains(angle=1.0))["whole"].tolist()
        [1.0, 1.0]

        Raises:
            RunFolderError: the dumps or the mill have no curtains.
        """
        shape = self.shape(angle)
        if shape.curtains is None:
            raise RunFolderError(self.folder, f"no curtains: {shape.problem}", "see case.contour")
        return CurtainProfiles(self.id, shape.mill_angle, shape.curtains)

    @property
    def occupancy(self) -> pd.DataFrame:
        """The mean solid fraction of the cross-section, a row for each ring, a column for each
        sector.

        The index is the middle of a ring over R - a, the columns are the middles of the sectors
        from the vertical [rad].
        """
        cells, fraction = read_occupancy(self._charge("occupancy").folder)
        radii, angles = (0.5 * (x[1:] + x[:-1]) for x in (cells.radii, cells.angles))
        made = pd.DataFrame(
            fraction,
            index=pd.Index(radii, name="radius"),
            columns=pd.Index(angles, name="angle_rad"),
        )
        made.attrs = {"units": {"radius": OVER, "angle_rad": "rad", "solid_fraction": "-"}}
        return made

    def power(self, physical: bool = True) -> float:
        """Return the mean power of the drive over the steady window [kW].

        Args:
            physical: of the physical mill with its whole charge: its M g R omega times the
                dimensionless power of this mill, without an interval (see `ms.predict`). False: of
                this scaled mill, or of the slice that was simulated.

        >>> case.power() > case.power(physical=False)
        True
        """
        charge = self._charge("power of a charge")
        return 1e-3 * (physical_power(charge) if physical else charge.result.mean["power_W"])

    def errors(self, against: CaseFolder) -> pd.Series:
        """Return the errors of this multi-ball case against another one, by name.

        Those of dumps are means over the steady mill angles that both have. `attrs["units"]` holds
        their units; overlaps and correlations are 1 for equal charges.

        >>> float(case.errors(against=case)["power_error"])
        0.0
        """
        ours, theirs = self._charge("errors"), against._charge("errors")
        measured = measure([ours, theirs], [(ours, theirs)])
        check_whole(measured)
        found = measured.errors[ours, theirs]
        values = {error.name: found.steady(error.name) for error in SCALAR_ERRORS}
        made = pd.Series(values, name=f"{self.id} against {against.id}", dtype=float)
        made.attrs["units"] = {error.name: error_unit(error) for error in SCALAR_ERRORS}
        return made

    def mesh(self, angle: float | None = None) -> pv.MultiBlock:
        """Return balls and liner for pyvista [m]: the blocks `balls` (points) and `liner`
        (triangles).

        Point data of the balls, SI units: radius, velocity (n, 3), speed, `rising`, 1 for balls
        that started on the rising side, state, last_lifter, ... (docs/guide/export.md).
        `case.mesh(6.0).save("charge.vtm")` writes files for ParaView.

        >>> case.mesh(angle=1.0)["balls"].n_points == case.case.ball.count
        True
        """
        # The drawing library takes a second to load.
        import pyvista as pv

        from millscale.exports.geometry import ball_points, turned_liner
        from millscale.runs.case_folder import LINER

        snapshot = self._snapshot(angle)
        dump = read_dump(snapshot.path)
        balls = ball_points(dump, starts_on_rising_side(dump, first_dump(self.folder)))
        liner = turned_liner(self.folder / LINER, snapshot.mill_angle)
        return pv.MultiBlock({"balls": balls, "liner": liner})

    def view(self, angle: float | None = None, colour: str = "speed") -> pv.Plotter:
        """Return the charge and the liner in 3-D; `.show()` draws them, in a notebook too.

        Args:
            colour: point data of `mesh` that colours the balls, such as speed [m/s] or rising.
        """
        from millscale.report.charge_view import charge_view

        return charge_view(self.mesh(angle), colour)

    def _charge(self, what: str) -> Charge:
        if isinstance(self.finished, Charge):
            return self.finished
        raise RunFolderError(
            self.folder, f"a single ball, which has no {what}", "take a multi-ball case, mb-..."
        )

    def _snapshot(self, angle: float | None) -> Snapshot:
        if angle is None:
            return self._snapshots[-1]
        near = min(self._snapshots, key=lambda x: abs(x.mill_angle - angle))
        if abs(near.mill_angle - angle) > SAME_ANGLE:
            raise RunFolderError(
                self.folder / "dump",
                f"no dump at {angle:g} rad, nearest is {near.mill_angle:.4g} rad",
                "take a mill angle of case.angles",
            )
        return near

    def _outline(self, points: np.ndarray, angle: float) -> pd.DataFrame:
        x, z = points.T
        about = {"mill_angle_rad": float(angle), "length_m": unit_length(self.case)}
        return frame({"x": x, "z": z}, None, {"x": OVER, "z": OVER}, **about)

    @property
    def _title(self) -> str:
        case = self.case
        balls = "a single ball" if case.kind == "single-ball" else f"{case.ball.count:,} balls"
        return f"{self.id}: {balls}, S = {case.S:.4g}, {case.scheme}, {case.policy}"

    def _facts(self) -> list[tuple[str, str]]:
        mill = self.case.mill
        facts = [
            ("mill", f"radius {mill.radius_m:.4g} m, length {mill.simulated_length_m:.4g} m"),
            (
                "speed",
                f"{mill.omega_rad_s:.4g} rad/s, {mill.percent_of_critical:.3g} % of critical",
            ),
        ]
        if isinstance(self.finished, Charge):
            result = self.finished.result
            steady = "steady" if result.steady.is_steady else "; ".join(result.steady.reasons)
            facts += [("power of the physical mill", f"{self.power():.4g} kW"), ("state", steady)]
        else:
            angle = self.finished.result.detach_angle_deg
            flies = "no throw" if angle is None else f"{angle:.2f} deg from the vertical"
            facts.append(("free flight begins", flies))
        return facts

    def __repr__(self) -> str:
        return f"<{self._title}>"

    def _repr_html_(self) -> str:
        rows = "".join(
            f"<tr><td>{escape(name)}</td><td>{escape(text)}</td></tr>"
            for name, text in self._facts()
        )
        return f"<table><caption>{escape(self._title)}</caption>{rows}</table>"
