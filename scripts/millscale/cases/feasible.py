"""Checks that find what the engine would refuse or run wrongly, before anything is written."""

from __future__ import annotations

import math

from millscale.campaign.campaign import Campaign
from millscale.campaign.parts import settling_time
from millscale.cases.law import PlannedMill, scaled_liner
from millscale.cases.time_step import Limits
from millscale.errors import CampaignError, Mistakes
from millscale.formats import rounded_up
from millscale.packing.bed import LARGEST_OVERLAP

# Mean overlap of the bed at rest over the ball radius. The largest is five to six times the mean
# (docs/theory/contact-law.md), so at a twentieth some contacts exceed the range of Hertz' law
# (`LARGEST_OVERLAP`).
SOFT = 0.05
# Thinner slices [ball diameters] are warned of: at 2 energy and centre of mass are off by 3 %, at 4
# by less than half a percent (docs/results/slice-length.json).
THIN_SLICE = 4.0
# Mill rotation after which a charge has come to a steady state [rad]: the centre of mass of the
# paper's charge overshoots and swings until 6.5 to 7 rad (docs/theory/charge.md).
START_UP = 7.0
# The least rotation whose means are of a steady charge [rad]: 8 are too few, 12 are enough there.
LEAST_ROTATION = 10.5


def check_mill(campaign: Campaign, planned: PlannedMill, limits: Limits) -> list[str]:
    """Return the warnings about a planned mill, in words.

    Raises:
        CampaignError: its balls do not fit the grooves, are too soft, or have no time to fall;
            holds all of it.
    """
    mistakes, warnings = Mistakes(), []
    with mistakes.collected():
        warnings += _grooves(campaign, planned)
    if planned.part.kind == "multi-ball":
        with mistakes.collected():
            _check_settling(campaign, planned)
    with mistakes.collected():
        warnings += _softness(campaign, planned, limits)
    mistakes.raise_all()
    return [
        *warnings,
        *_thin(campaign, planned),
        *_short(planned),
        *_ends(campaign, planned),
        *_law_radius(campaign, planned),
    ]


def _grooves(campaign: Campaign, planned: PlannedMill) -> list[str]:
    """Refuse balls that are too wide for the grooves; with a mesh wall, warn of them."""
    liner = planned.liner
    diameter = 2.0 * _largest_radius(campaign, planned)
    width = liner.narrowest_width
    if diameter < width:
        return []
    if campaign.wall.kind == "mesh":
        return [
            f"balls of {diameter:g} m are too wide for the grooves, {width:.4g} m, at S = "
            f"{planned.S:g}: they lie on the lifters"
        ]
    most = _largest_scale(campaign, planned, diameter)
    raise CampaignError(
        campaign.file,
        "scaling.S",
        f"got {planned.S:g}, policy {planned.policy}: balls of {diameter:g} m do not fit the "
        f"grooves, {width:.4g} m wide where they are narrowest",
        f"S <= {most:g}, or smaller balls" if most else "smaller balls or wider grooves",
    )


def _largest_scale(campaign: Campaign, planned: PlannedMill, diameter: float) -> float:
    """Return the largest S at which balls fit the grooves, to three decimals; 0 if none does."""

    def fits(S: float) -> bool:
        try:
            return diameter < scaled_liner(campaign, planned.policy, S).narrowest_width
        except ValueError:
            return False

    low, high = 1.0, planned.S
    if not fits(low):
        return 0.0
    while high - low > 1e-6 * low:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if fits(middle) else (low, middle)
    return max(1.0, math.floor(1e3 * low) / 1e3)


def _softness(campaign: Campaign, planned: PlannedMill, limits: Limits) -> list[str]:
    """Return the overlaps at rest and in the fastest impact, over the ball radius."""
    radius = limits.radius
    at_rest = limits.overlap / radius
    stiffer = rounded_up(campaign.material.youngs_modulus * (at_rest / SOFT) ** 1.5)
    said = (
        f"at rest balls overlap by {at_rest:.3g} of their radius on average, at S = {planned.S:g}"
    )
    if at_rest > LARGEST_OVERLAP:
        raise CampaignError(
            campaign.file,
            "material.youngs_modulus_pa",
            f"got {campaign.material.youngs_modulus:.4g}: {said}: 1.06 (rho g R / E)^(2/3)",
            f">= {stiffer:g}, which makes it {SOFT}",
        )
    if at_rest > SOFT:
        return [
            f"{said}, the deepest by five times as much: too soft for Hertz contacts; a "
            f"youngs_modulus_pa of {stiffer:g} makes it {SOFT}"
        ]
    # Duration of a Hertz impact is 2.94 times its overlap over its speed.
    impact = limits.collision * limits.impact_speed / 2.94 / radius
    if impact > LARGEST_OVERLAP:
        # The overlap of a Hertz impact goes as E^(-2/5).
        stiffer = rounded_up(campaign.material.youngs_modulus * (impact / LARGEST_OVERLAP) ** 2.5)
        return [
            f"impacts at {limits.impact_speed:.3g} m/s overlap by {impact:.2g} of the ball radius: "
            f"too soft for Hertz contacts above {LARGEST_OVERLAP}, which a youngs_modulus_pa of "
            f"{stiffer:g} avoids"
        ]
    return []


def _check_settling(campaign: Campaign, planned: PlannedMill) -> None:
    """Refuse a settling in which a ball falls by less than its own radius."""
    radius, gravity = campaign.ball.radius, planned.scaled.mill.gravity
    to_scaled = planned.scaled.base.time
    time = planned.part.wait * to_scaled
    fall = 0.5 * gravity * time**2
    if fall >= radius:
        return
    least = math.sqrt(2.0 * radius / gravity) / to_scaled
    usual = max(least, settling_time(campaign.mill))
    raise CampaignError(
        campaign.file,
        "multi_ball.settle_s",
        f"got {planned.part.wait:g}: at S = {planned.S:g} a ball falls by {fall:.3g} m meanwhile, "
        f"{fall / radius:.2g} of its radius, so that the bed hangs in the air",
        f">= {rounded_up(least):g}; usual is {usual:.2g}",
    )


def _thin(campaign: Campaign, planned: PlannedMill) -> list[str]:
    if planned.part.kind == "single-ball":
        return []
    diameters = planned.simulated_length / (2.0 * campaign.ball.radius)
    # A slice given in diameters is rounded.
    if diameters >= THIN_SLICE * (1.0 - 1e-9):
        return []
    if planned.simulated_length == planned.length:
        if campaign.mill.ends != "periodic":
            return []
        return [
            f"the mill is {diameters:.3g} ball diameters long and has no end walls, which carry a "
            'part of so short a charge: mill.ends = "turning" adds them'
        ]
    return [
        f"a slice of {diameters:.3g} ball diameters: energy and surface are off by 3 % at 2, by "
        f"half a percent at {THIN_SLICE:g}"
    ]


def _short(planned: PlannedMill) -> list[str]:
    if planned.part.kind == "single-ball":
        return []
    part = planned.part
    late = [begin + over for begin, over, _ in part.speed_changes]
    if late and late[-1] >= part.rotation_angle:
        return [
            f"the last change of the speed ends at {late[-1]:.3g} rad, the rotation at "
            f"{part.rotation_angle:.3g} rad: means are of changing speed"
        ]
    if part.rotation_angle >= LEAST_ROTATION:
        return []
    return [
        f"rotation of {planned.part.rotation_angle:.3g} rad: a charge is not steady before some "
        f"{START_UP:g} rad; for means of the steady state give rotation_angle_rad = "
        f"{math.ceil(LEAST_ROTATION):g} or more"
    ]


# Relative difference of the speed between laws for the smallest and the largest ball.
LAW_SPREAD = 0.002


def _law_radius(campaign: Campaign, planned: PlannedMill) -> list[str]:
    """Warn where the law depends on which ball's radius it takes."""
    ball = campaign.ball
    if not ball.classes or planned.policy not in ("corrected", "offset-liner") or planned.S == 1.0:
        return []
    # Both policies follow the path R - a of a ball's centre.
    mill, S = campaign.mill, planned.S
    paths = [(mill.radius / S - a) / (mill.radius - a) for a in (ball.smallest, ball.largest)]
    spread = abs(paths[1] / paths[0] - 1.0)
    if spread <= LAW_SPREAD:
        return []
    return [
        f"policy {planned.policy} takes a = {1e3 * ball.radius:.4g} mm, the mean by mass; the path "
        f"R - a of the smallest and of the largest balls scale differently by {spread:.1%}"
    ]


def _ends(campaign: Campaign, planned: PlannedMill) -> list[str]:
    """Warn of end walls whose distance over the radius is not that of the physical mill."""
    mill, radius = campaign.mill, planned.liner.radius
    if mill.ends == "periodic":
        return []
    kept, found = mill.length / mill.radius, planned.simulated_length / radius
    if abs(found - kept) <= 1e-9 * kept:
        return []
    return [
        f"L / R = {found:.3g} between the ends at S = {planned.S:g}, of the physical mill "
        f"{kept:.3g}: the share of the end walls is not that of the physical mill"
    ]


def _largest_radius(campaign: Campaign, planned: PlannedMill) -> float:
    """Return the largest ball radius of a scaled mill [m]."""
    ball = campaign.ball
    return ball.radius if planned.part.kind == "single-ball" else ball.largest
