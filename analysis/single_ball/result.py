"""result.json of a single-ball case."""

from __future__ import annotations

import math
from dataclasses import asdict

import numpy as np

from millscale.analysis.paper import numbers as paper
from millscale.analysis.result_file import (
    PaperAngles,
    RegionBounds,
    SingleBallResult,
    ThrowEnergy,
    Thrown,
)
from millscale.analysis.single_ball import energy, events
from millscale.runs.case_file import Case
from millscale.runs.series import Series


def ball_of(case: Case) -> energy.Ball:
    """Return the ball and the mill's operating point of a case."""
    return energy.Ball(case.ball.mass_kg, case.mill.gravity_m_s2, case.mill.omega_rad_s)


def single_ball_result(case: Case, series: Series) -> SingleBallResult:
    """Return throws, regions and energy changes of a single ball.

    Angles from the vertical are in degrees, mill angles in rad. The first throw is the paper's;
    means and standard deviations (n - 1) are over all cycles.
    """
    throws = events.throws(series)
    first = throws[0] if throws else None
    offs = [throw.liner_off.angle for throw in throws if throw.liner_off]
    ball = ball_of(case)
    return SingleBallResult(
        problem=None if throws else _why_no_throw(series),
        cycles=len(throws),
        throws=tuple(_thrown(throw) for throw in throws),
        **_angles("detach_angle", [throw.flight.angle for throw in throws]),
        **_angles("liner_off_angle", offs),
        regions=first and _regions(series, first, ball.omega, case.mill.radius_m),
        throw_energy=first and _throw_energy(series, first.flight, ball),
        paper_angles=first and _at_paper_angles(case, series),
        unseen_events=events.unseen_events(series),
        rotation_angle_rad=float(series["mill_angle_rad"][-1]),
    )


def flight_of(throw: Thrown) -> events.Flight:
    """Return the flight of a throw, without its samples."""
    return events.Flight(
        mill_angle=throw.mill_angle_rad,
        angle=math.radians(throw.angle_deg),
        lifter=throw.lifter,
        position=np.array(throw.position_m),
        velocity=np.array(throw.velocity_m_s),
        rows=np.empty(0, int),
        finished=throw.finished,
        mill_angle_end=throw.mill_angle_end_rad,
    )


def _regions(series: Series, throw: events.Throw, omega: float, radius: float) -> RegionBounds:
    found = events.regions(series, throw, omega, radius)
    return RegionBounds(**{f"{name}_rad": angle for name, angle in asdict(found).items()})


def _throw_energy(series: Series, flight: events.Flight, ball: energy.Ball) -> ThrowEnergy:
    begin, window = flight.mill_angle, min(flight.length, paper.longest_window())
    sampled = energy.change_from_release(series, flight, ball, window)
    kinetic, potential = energy.deviation_from_parabola(series, flight, ball)
    return ThrowEnergy(
        begin_rad=begin,
        window_rad=window,
        change_J=energy.change_on_parabola(flight, ball, begin, begin + window),
        kinetic_sampled_J=sampled.kinetic,
        potential_sampled_J=sampled.potential,
        off_parabola_kinetic_J=kinetic,
        off_parabola_potential_J=potential,
    )


def _at_paper_angles(case: Case, series: Series) -> PaperAngles | None:
    """Return the energy change between the mill angles of Table 8 or 9; None of another mill than
    the paper's, and of a series that does not reach them."""
    reported = paper.reported_throw(case.scheme) if paper.is_papers_mill(case) else None
    if reported is None or reported.end > series["mill_angle_rad"][-1]:
        return None
    seen = events.flights(series)
    change = energy.sampled_change(series, reported.begin, reported.end, seen)
    return PaperAngles(change.begin, change.end, change.kinetic, change.potential, change.in_flight)


def _why_no_throw(series: Series) -> str:
    seen = len(events.flights(series))
    lifted = len(events.lift_rows(series))
    return (
        f"no throw: {seen} confirmed flights in {series['mill_angle_rad'][-1]:.2f} rad, lifted "
        f"above the axis {lifted} times; rotate longer, or the mill is too slow or too smooth "
        "to lift the ball"
    )


def _thrown(throw: events.Throw) -> Thrown:
    flight, off = throw.flight, throw.liner_off
    return Thrown(
        mill_angle_rad=flight.mill_angle,
        angle_deg=math.degrees(flight.angle),
        lifter=flight.lifter,
        position_m=tuple(flight.position.tolist()),
        velocity_m_s=tuple(flight.velocity.tolist()),
        flight_length_rad=flight.length,
        finished=flight.finished,
        liner_off_mill_angle_rad=off.mill_angle if off else None,
        liner_off_angle_deg=math.degrees(off.angle) if off else None,
    )


def _angles(name: str, radians: list[float]) -> dict[str, float | None]:
    """Return first, mean and standard deviation of angles, in degrees."""
    degrees = np.degrees(radians)
    return {
        f"{name}_deg": float(degrees[0]) if degrees.size else None,
        f"{name}_mean_deg": float(degrees.mean()) if degrees.size else None,
        f"{name}_std_deg": float(degrees.std(ddof=1)) if degrees.size > 1 else None,
    }
