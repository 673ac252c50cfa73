"""Limits of the time step and the step advised from them.

The yardsticks are _core's; the numbers that turn them into advice are below, with their origin.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from millscale import _core
from millscale.campaign.campaign import Ball, Campaign, Material
from millscale.cases.law import PlannedMill
from millscale.errors import CampaignError

# Beyond this share of the Rayleigh time no DEM scheme is trusted; refused.
RAYLEIGH_REFUSED = 0.40
# Upper end of what DEM practice takes.
RAYLEIGH_ADVISED = 0.20
# Steps per collision of two balls at the speed of re-impact. A single ball lives from its rebounds:
# at 5 m/s, 30 steps realise e = 0.092 and 15 steps 0.084 instead of 0.100. In a bed, 2e-4 s (7
# steps, bounded damping) keep the energies within 1 % of those at 5e-5 s:
# docs/results/time-step.md.
STEPS_PER_CONTACT = {"single-ball": 25, "multi-ball": 8}
# Fewer than this share of them is warned of.
FEW_STEPS = 0.5
# Contacts per ball of a bed, and of a ball rolling in a groove.
COORDINATION = {"single-ball": 1.0, "multi-ball": 4.0}


@dataclass(frozen=True)
class Limits:
    """Time-step limits of one planned mill.

    Attributes:
        rayleigh: Rayleigh time [s].
        collision: duration of an impact at `impact_speed` [s].
        damping: largest linearly stable step of the damped contacts of the bed [s].
        impact_speed: of a thrown ball back on the liner [m/s].
        overlap: mean overlap the damping limit is taken at [m].
        radius: of the balls that decide [m]; of several classes the one with the shortest step.
    """

    rayleigh: float
    collision: float
    damping: float
    impact_speed: float
    overlap: float
    radius: float

    def advised(self, kind: str) -> tuple[float, str]:
        """Return the advised step [s] to two digits, rounded down, and the limit that binds."""
        n = STEPS_PER_CONTACT[kind]
        candidates = {
            f"{RAYLEIGH_ADVISED:.0%} of the Rayleigh time": RAYLEIGH_ADVISED * self.rayleigh,
            f"{n} steps per collision at {self.impact_speed:.3g} m/s": self.collision / n,
            "the damping limit": self.damping,
        }
        reason = min(candidates, key=candidates.__getitem__)
        return _round_down(candidates[reason]), reason


@dataclass(frozen=True)
class Step:
    """Time step of one mill and how it came about.

    Attributes:
        value: [s].
        choice: "given", or "advised" with the limit that binds.
        limits: of this planned mill.
        warnings: what the step risks, in words.
    """

    value: float
    choice: str
    limits: Limits
    warnings: tuple[str, ...]


def impact_speed(mill: _core.OperatingPoint) -> float:
    """Return the speed [m/s] at which a ball thrown from the path R - a reaches it again.

    V sqrt(1 + 8 sin^2 phi) with V = omega (R - a) and cos phi = omega^2 (R - a) / g; a
    centrifuging mill throws nothing, its balls run at V. Point contact, no friction; derived in
    the theory notes.
    """
    path = mill.radius - mill.ball_radius
    cosine = min(1.0, mill.omega**2 * path / mill.gravity)
    return mill.omega * path * math.sqrt(1.0 + 8.0 * (1.0 - cosine**2))


def fastest_point(planned: PlannedMill) -> _core.OperatingPoint:
    """Return the operating point of a planned mill at its largest speed."""
    mill = planned.scaled.mill
    fastest = _core.SpeedSchedule(list(planned.part.speed_changes)).fastest
    return _core.OperatingPoint(mill.radius, mill.ball_radius, mill.gravity, mill.omega * fastest)


def limits_of(campaign: Campaign, planned: PlannedMill) -> Limits:
    """Return the time-step limits of a planned mill, with its own stiffness, gravity and speed."""
    ball = campaign.ball
    if planned.part.kind == "single-ball" or not ball.classes:
        return _limits_of_kind(campaign, planned, ball, campaign.material)
    kinds = [
        _limits_of_kind(
            campaign,
            planned,
            Ball(one.radius, one.density, 0.0, ball.truncation),
            one.material or campaign.material,
        )
        for one in ball.classes
    ]
    # Each limit is that of the class whose step it limits most.
    binding = min(kinds, key=lambda limits: limits.advised(planned.part.kind)[0])
    return replace(
        binding,
        rayleigh=min(limits.rayleigh for limits in kinds),
        collision=min(limits.collision for limits in kinds),
        damping=min(limits.damping for limits in kinds),
    )


def _limits_of_kind(
    campaign: Campaign, planned: PlannedMill, ball: Ball, material_of: Material
) -> Limits:
    """Return the time-step limits of balls of one material."""
    mill = planned.scaled.mill
    modulus = planned.modulus_of(material_of, campaign)
    material = _core.Material(modulus, material_of.poisson_ratio, ball.density)
    single = planned.part.kind == "single-ball"
    depth = ball.radius if single else mill.radius
    overlap = ball.radius * _core.bed_overlap(material, mill.gravity, depth)
    restitution = material_of.restitution_pw if single else material_of.restitution_pp
    speed = impact_speed(fastest_point(planned))
    # The smallest ball has the shortest times.
    smallest = ball.radius if single else ball.smallest
    return Limits(
        rayleigh=_core.rayleigh_time(material, smallest),
        collision=_core.hertz_collision_time(material, smallest, speed),
        damping=_core.damping_time_step_limit(
            material,
            smallest,
            restitution,
            overlap,
            coordination=COORDINATION[planned.part.kind],
            # A single ball is in contact with the wall only, whose damping is not bounded.
            bounded=not single and campaign.contacts.damping == "bounded",
        ),
        impact_speed=speed,
        overlap=overlap,
        radius=ball.radius,
    )


def steps_of(campaign: Campaign, mills: list[PlannedMill]) -> list[Step]:
    """Return time steps of the mills of one part, in their order.

    With fixed stiffness every mill takes the same step; with overlap-matched stiffness contact
    times scale with 1 / velocity factor, and the step with them.

    Raises:
        CampaignError: a step beyond `RAYLEIGH_REFUSED` of the Rayleigh time.
    """
    matched = campaign.stiffness == "overlap-matched"
    stretch = [1.0 / planned.velocity_factor if matched else 1.0 for planned in mills]
    limits = [limits_of(campaign, planned) for planned in mills]
    part = mills[0].part
    if part.step is not None:
        physical, choice = part.step, "given"
    else:
        advice = [
            (step / factor, reason)
            for (step, reason), factor in zip(
                (limit.advised(part.kind) for limit in limits), stretch, strict=True
            )
        ]
        physical, reason = min(advice)
        choice = f"advised: {reason}"
    if campaign.ball.classes and part.kind == "multi-ball":
        choice += f"; balls of {2e3 * limits[0].radius:g} mm decide"
    return [
        _step(campaign, planned, physical * factor, choice, limit)
        for planned, factor, limit in zip(mills, stretch, limits, strict=True)
    ]


def _step(
    campaign: Campaign, planned: PlannedMill, value: float, choice: str, limits: Limits
) -> Step:
    if value > RAYLEIGH_REFUSED * limits.rayleigh:
        raise CampaignError(
            campaign.file,
            f"{planned.part.kind.replace('-', '_')}.step_s",
            f"got {value:.3g} s = {value / limits.rayleigh:.0%} of the Rayleigh time "
            f"{limits.rayleigh:.3g} s at S = {planned.S:g}",
            f'<= {RAYLEIGH_REFUSED * limits.rayleigh:.3g} or "advised" '
            f"({limits.advised(planned.part.kind)[0]:g} s)",
        )
    warnings = []
    if value > limits.damping:
        warnings.append(
            f"step {value:.3g} s is {value / limits.damping:.2f} times the damping limit "
            f"{limits.damping:.3g} s: expect spin noise and a wrong dissipation"
        )
    per_contact = limits.collision / value
    if per_contact < FEW_STEPS * STEPS_PER_CONTACT[planned.part.kind]:
        warnings.append(
            f"only {per_contact:.1f} steps per collision at {limits.impact_speed:.3g} m/s"
        )
    return Step(value, choice, limits, tuple(warnings))


def _round_down(value: float) -> float:
    digits = math.floor(math.log10(value)) - 1
    return float(f"{math.floor(value / 10.0**digits + 1e-9)}e{digits}")
