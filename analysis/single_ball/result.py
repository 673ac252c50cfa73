"""result.json of a single-ball case."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from millscale.analysis.paper import numbers as paper
from millscale.analysis.single_ball import energy, events
from millscale.runs.series import Series


def ball_of(case: dict[str, Any]) -> energy.Ball:
    """The ball and the mill's operating point of a case."""
    mill = case["mill"]
    return energy.Ball(case["ball"]["mass_kg"], mill["gravity_m_s2"], mill["omega_rad_s"])


def single_ball_result(case: dict[str, Any], series: Series) -> dict[str, Any]:
    """Throws, regions and energy changes of a single ball; keys and units: docs/reference/files.md.

    Angles from the vertical are in degrees, mill angles in rad. The first throw is the paper's;
    means and standard deviations (n - 1) go over all cycles.
    """
    found = events.throws(series)
    return {
        "cycles": len(found),
        **_angles("detach_angle", [throw.flight.angle for throw in found]),
        **_angles("liner_off_angle", [t.liner_off.angle for t in found if t.liner_off]),
        "throws": [_throw(throw) for throw in found],
        **(_first_throw(case, series, found[0]) if found else _no_throw(series)),
        "unseen_events": events.unseen_events(series),
        "rotation_angle_rad": float(series["mill_angle_rad"][-1]),
    }


def flight_of(throw: dict[str, Any]) -> events.Flight:
    """The flight of an entry of `throws`, without its samples."""
    return events.Flight(
        mill_angle=throw["mill_angle_rad"],
        angle=math.radians(throw["angle_deg"]),
        lifter=throw["lifter"],
        position=np.array(throw["position_m"]),
        velocity=np.array(throw["velocity_m_s"]),
        rows=np.empty(0, int),
        finished=throw["finished"],
        mill_angle_end=throw["mill_angle_rad"] + throw["flight_length_rad"],
    )


def _first_throw(case: dict[str, Any], series: Series, throw: events.Throw) -> dict[str, Any]:
    ball, mill = ball_of(case), case["mill"]
    flight = throw.flight
    window = min(flight.length, paper.longest_window())
    span = (flight.mill_angle, flight.mill_angle + window)
    sampled = energy.change_from_release(series, flight, ball, window)
    kinetic, potential = energy.deviation_from_parabola(series, flight, ball)
    regions = events.regions(series, throw, ball.omega, mill["radius_m"])
    return {
        "problem": None,
        "regions": {f"{name}_rad": angle for name, angle in asdict(regions).items()},
        "throw_energy": {
            "begin_rad": flight.mill_angle,
            "window_rad": window,
            "change_J": energy.change_on_parabola(flight, ball, *span),
            "kinetic_sampled_J": sampled.kinetic,
            "potential_sampled_J": sampled.potential,
            "off_parabola_kinetic_J": kinetic,
            "off_parabola_potential_J": potential,
        },
        "paper_angles": _at_paper_angles(case, series),
    }


def _at_paper_angles(case: Mapping[str, Any], series: Series) -> dict[str, Any] | None:
    """Energy change between the mill angles of Table 8 or 9; None where it cannot be, and of any
    mill but the paper's."""
    reported = paper.reported_throw(case["scheme"]) if paper.is_papers_mill(case) else None
    if reported is None or reported.end > series["mill_angle_rad"][-1]:
        return None
    seen = events.flights(series)
    change = energy.sampled_change(series, reported.begin, reported.end, seen)
    return {
        "begin_rad": change.begin,
        "end_rad": change.end,
        "kinetic_J": change.kinetic,
        "potential_J": change.potential,
        "in_flight": change.in_flight,
    }


def _no_throw(series: Series) -> dict[str, Any]:
    seen = len(events.flights(series))
    lifted = len(events.lift_rows(series))
    return {
        "problem": (
            f"no throw: {seen} confirmed flights in {series['mill_angle_rad'][-1]:.2f} rad, lifted "
            f"above the axis {lifted} times; rotate longer, or the mill is too slow or too smooth "
            "to lift the ball"
        ),
        "regions": None,
        "throw_energy": None,
        "paper_angles": None,
    }


def _throw(throw: events.Throw) -> dict[str, Any]:
    flight, off = throw.flight, throw.liner_off
    return {
        "mill_angle_rad": flight.mill_angle,
        "angle_deg": math.degrees(flight.angle),
        "lifter": flight.lifter,
        "position_m": flight.position.tolist(),
        "velocity_m_s": flight.velocity.tolist(),
        "flight_length_rad": flight.length,
        "finished": flight.finished,
        "liner_off_mill_angle_rad": off.mill_angle if off else None,
        "liner_off_angle_deg": math.degrees(off.angle) if off else None,
    }


def _angles(name: str, radians: list[float]) -> dict[str, float | None]:
    """First, mean and standard deviation of angles, in degrees."""
    degrees = np.degrees(radians)
    return {
        f"{name}_deg": float(degrees[0]) if degrees.size else None,
        f"{name}_mean_deg": float(degrees.mean()) if degrees.size else None,
        f"{name}_std_deg": float(degrees.std(ddof=1)) if degrees.size > 1 else None,
    }
