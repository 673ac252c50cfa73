"""The similarity law and the liner, taken from `_core`, applied to the mills of a campaign."""

from __future__ import annotations

import math
from dataclasses import dataclass

from millscale import _core
from millscale.campaign.campaign import Campaign, CampaignPart, Material
from millscale.campaign.keys import FRICTION_MATCHED, POLICIES, SCHEMES
from millscale.errors import CampaignError
from millscale.liner.sector import ROUNDING


@dataclass(frozen=True)
class PlannedMill:
    """A scaled mill of a part, before times and charge.

    Attributes:
        part: the campaign part it belongs to.
        index: position of its S in the list of the part.
        scheme, policy, S, time_factor: request to the law; time_factor 0 but for scheme froude.
        friction_exponent: the same; 1 but for scaled mills of policy friction-matched.
        scaled: _core.ScaledMill, the operating point and the factors.
        liner: _core.Profile of the scaled mill.
        length: length of the scaled mill along the axis [m].
        simulated_length: periodic length simulated, shorter if a slice is taken [m].
        youngs_modulus: of balls and wall in this mill [Pa].
    """

    part: CampaignPart
    index: int
    scheme: str
    policy: str
    S: float
    time_factor: float
    friction_exponent: float
    scaled: _core.ScaledMill
    liner: _core.Profile
    length: float
    simulated_length: float
    youngs_modulus: float

    def modulus_of(self, material: Material, campaign: Campaign) -> float:
        """Return Young's modulus of a material of the campaign in this mill [Pa]."""
        if material.youngs_modulus == campaign.material.youngs_modulus:
            return self.youngs_modulus
        return self.youngs_modulus * material.youngs_modulus / campaign.material.youngs_modulus

    @property
    def velocity_factor(self) -> float:
        """Velocity, scaled / physical."""
        return _core.factor(self.scaled.base, 1, 0, -1)


def physical_mill(campaign: Campaign) -> _core.OperatingPoint:
    """Return the operating point of the physical mill."""
    mill = campaign.mill
    return _core.OperatingPoint(mill.radius, campaign.ball.radius, mill.gravity, mill.omega)


def physical_liner(campaign: Campaign) -> _core.Profile:
    """Return the liner of the physical mill.

    Raises:
        CampaignError: no such liner exists.
    """
    try:
        return campaign.liner.profile(campaign.mill.radius)
    except ValueError as cause:
        raise CampaignError(campaign.file, "liner", f"impossible liner: {cause}") from None


def scaled_liner(campaign: Campaign, policy: str, S: float) -> _core.Profile:
    """Return the liner of a scaled mill.

    Raises:
        CampaignError: the physical mill has no liner.
        ValueError: nothing is left of a lifter or groove.
    """
    physical = physical_liner(campaign)
    if policy == "offset-liner":
        return physical.offset_scaled(S, campaign.ball.radius)
    return physical.scaled(S)


def planned_mills(campaign: Campaign, part: CampaignPart) -> list[PlannedMill]:
    """Return the scaled mills of a campaign part by policy, scheme and S.

    At S = 1 every policy is the physical mill itself: it is kept once per scheme, under `paper` (or
    the first policy asked for), and is the reference of all of them.
    """
    policies = sorted(part.policies, key=POLICIES.index)
    ordered = sorted((S, index) for index, S in enumerate(part.ratios))
    mills = []
    for policy in policies:
        for scheme in sorted(part.schemes, key=SCHEMES.index):
            for S, index in ordered:
                if S > 1.0 or policy == policies[0]:
                    mills.append(_planned(campaign, part, scheme, policy, index))
    return mills


def _planned(
    campaign: Campaign, part: CampaignPart, scheme: str, policy: str, index: int
) -> PlannedMill:
    S = part.ratios[index]
    time_factor = _time_factor(campaign, S) if scheme == "froude" else 0.0
    is_matched = policy == FRICTION_MATCHED and S > 1.0
    exponent = {"friction_exponent": campaign.friction_exponent} if is_matched else {}
    try:
        scaled = _core.scale(
            physical_mill(campaign),
            S,
            scheme,
            policy,
            time_factor,
            campaign.mill.allow_centrifuging,
            **exponent,
        )
        liner = scaled_liner(campaign, policy, S)
    except CampaignError:
        raise
    except ValueError as cause:
        key = f"scaling (scheme {scheme}, policy {policy}, S = {S:g})"
        raise CampaignError(campaign.file, key, str(cause)) from None
    liner = _of_radius(campaign, policy, S, liner, scaled.mill.radius)
    length = campaign.mill.length / S
    piece = part.charge.slice_length if part.charge else None
    _check_length(campaign, S, piece or length)
    matched = campaign.stiffness == "overlap-matched"
    stiffness_factor = _core.factor(scaled.base, 2, 0, -2) if matched else 1.0
    return PlannedMill(
        part=part,
        index=index,
        scheme=scheme,
        policy=policy,
        S=S,
        time_factor=time_factor,
        friction_exponent=exponent.get("friction_exponent", 1.0),
        scaled=scaled,
        liner=liner,
        length=length,
        simulated_length=min(piece or length, length),
        youngs_modulus=campaign.material.youngs_modulus * stiffness_factor,
    )


def _of_radius(
    campaign: Campaign, policy: str, S: float, liner: _core.Profile, radius: float
) -> _core.Profile:
    """Return a liner with the radius of the scaled mill, as the engine needs it.

    An offset moves a corner, and an arc that is not around the axis, by more than the ball's
    radius. A liner that is off by a thousandth is scaled; more is refused.
    """
    off = abs(liner.radius / radius - 1.0)
    if 1e-9 < off <= ROUNDING:
        return liner.scaled(liner.radius / radius)
    if off > ROUNDING:
        raise CampaignError(
            campaign.file,
            "scaling.policies",
            f"got {policy}: at S = {S:g} the liner has a radius of {liner.radius:.9g} m and the "
            f"mill of {radius:.9g} m, because it is farthest from the axis at a corner",
            "other policies, or a liner that is farthest from the axis along an arc",
        )
    return liner


def _time_factor(campaign: Campaign, S: float) -> float:
    if campaign.time_exponent is not None:
        return math.pow(S, campaign.time_exponent)
    assert campaign.time_factor is not None  # as the reader of campaign files has checked
    return campaign.time_factor


def _check_length(campaign: Campaign, S: float, length: float) -> None:
    """Refuse a simulated length in which a ball would touch its periodic image."""
    largest = campaign.ball.largest
    if length < 2.0 * largest:
        raise CampaignError(
            campaign.file,
            "mill.length_m",
            f"{length:.4g} m at S = {S:g} is shorter than a ball of {2.0 * largest:g} m",
            "a length, slice or S that leaves at least one ball diameter",
        )
