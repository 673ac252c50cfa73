"""What a case models and what it leaves out, each with its reason."""

from __future__ import annotations

import math

from millscale.campaign.campaign import Campaign
from millscale.cases.law import PlannedMill, physical_mill
from millscale.cases.time_step import impact_speed
from millscale.runs.case_file import Modelled, Statement

POLICY_REASONS = {
    "paper": "the law for point masses is applied as it stands",
    "corrected": "speed or gravity follow the path of the ball's centre, R - a",
    "offset-liner": "the liner is built so that the path of the ball's centre scales",
    "friction-matched": "the law for point masses, and the friction between balls is lowered",
}
AIR_DENSITY = 1.2
# Of a sphere at Reynolds numbers of 1e3 to 2e5: balls of 1 to 300 mm at 10 m/s.
DRAG_COEFFICIENT = 0.47


def statements(campaign: Campaign, planned: PlannedMill, of_decks: Modelled) -> Modelled:
    """Return what a case models and what it leaves out.

    Args:
        of_decks: the statements about the terms that depend on the scene, from `deck_terms`.
    """
    return Modelled(
        inside=(*_modelled(campaign, planned), *of_decks.inside),
        outside=(*_left_out(campaign, planned), *of_decks.outside),
    )


def _say(what: str, reason: str) -> Statement:
    return Statement(what=what, reason=reason)


def _modelled(campaign: Campaign, planned: PlannedMill) -> list[Statement]:
    said = [
        _say(
            "Hertz-Mindlin contacts with damping",
            "normal force of Hertz, tangential spring and dashpots; docs/theory/contact-law.md",
        ),
        _say(
            "lifters as rigid rotating surfaces",
            "they throw the balls; moved exactly about the axis",
        ),
        _wall(campaign),
        _ends(campaign),
        _say(
            "wall with the elastic constants of the balls",
            "assumption: a campaign gives moduli of the balls alone",
        ),
    ]
    if planned.part.kind == "multi-ball":
        said.append(_say("settling before rotation", "the bed at rest is the initial state"))
        said.append(_contacts(campaign))
        if planned.simulated_length == planned.length and campaign.mill.ends == "periodic":
            reason = "no slice asked for; the error of a shorter piece is not known beforehand"
            said.append(_say("the whole length of the mill", reason))
        if campaign.ball.classes:
            said.append(_classes(campaign))
        if campaign.ball.radius_std > 0.0:
            said.append(_say("normal distribution of ball radii", "given by the campaign"))
    if planned.part.speed_changes:
        said.append(_speed(planned))
    if planned.scaled.friction_ratio != 1.0:
        k = planned.friction_exponent
        said.append(
            _say(
                "sliding friction between balls divided by S" + (f"^{k:g}" if k != 1.0 else ""),
                "the inertial number of the flowing layer grows as S, and its friction with it",
            )
        )
    if campaign.stiffness == "overlap-matched":
        said.append(
            _say(
                "Young's modulus scaled with velocity squared",
                "keeps overlap / ball radius, hence the contact law's groups",
            )
        )
    return said


def _classes(campaign: Campaign) -> Statement:
    ball = campaign.ball
    sizes = ", ".join(f"{2e3 * one.radius:.4g} mm ({one.share:.3g})" for one in ball.classes)
    return _say(
        f"balls of {len(ball.classes)} classes, shares by number: {sizes}",
        f"a of the similarity law is their mean by mass, {1e3 * ball.radius:.4g} mm",
    )


def _ends(campaign: Campaign) -> Statement:
    if campaign.mill.ends == "periodic":
        return _say("periodic ends", "a piece of a long mill")
    motion = {"turning": "turn with the mill", "resting": "stand still"}[campaign.mill.ends]
    return _say(f"flat end walls that {motion}", "asked for")


def _speed(planned: PlannedMill) -> Statement:
    """Return the start-up ramp and the changes of the speed."""
    words = []
    for begin, over, ratio in planned.part.speed_changes:
        what = "from rest" if begin == 0.0 else f"from {begin / math.tau:.3g} turns on"
        how = f"over {over / math.tau:.3g} turns" if over else "at once"
        words.append(f"{what} to {100.0 * ratio:.4g} % of the speed {how}")
    reason = "stated in the mill's angle, so that scaled mills change speed at similar times"
    return _say("speed against mill angle: " + "; ".join(words), reason)


def _contacts(campaign: Campaign) -> Statement:
    if campaign.contacts.backend == "stock":
        return _say("contacts between balls evaluated by stock LIGGGHTS", "asked for")
    damping = ""
    if campaign.contacts.damping == "bounded":
        damping = "; tangential damping bounded by what a step can take, for longer steps"
    precision = ", in mixed precision" if campaign.contacts.precision == "mixed" else ""
    return _say(
        f"contacts between balls evaluated by our kernels{precision}",
        f"the same law in less time{damping}",
    )


def _wall(campaign: Campaign) -> Statement:
    if campaign.wall.kind == "mesh":
        return _say("liner as a triangle mesh", "asked for; arcs within the chord error")
    return _say("liner as exact arcs and lines", "no mesh to turn and search at every step")


def _left_out(campaign: Campaign, planned: PlannedMill) -> list[Statement]:
    said = [
        _say("ore, powder and slurry", "balls alone are simulated"),
        _say("air drag", _drag(campaign)),
        _say("breakage and wear", "balls and liner keep their shape over a few turns"),
        *(
            [_say("end walls", "periodic along the axis")]
            if campaign.mill.ends == "periodic"
            else []
        ),
        _say("motion and bending of the mill", "rigid mill at a prescribed speed"),
    ]
    if planned.S > 1.0:
        said.append(
            _say(
                "scaling of the ball radius",
                f"the method keeps the balls, so a / R grows by S; policy {planned.policy}: "
                + POLICY_REASONS[planned.policy],
            )
        )
    if planned.simulated_length < planned.length:
        said.append(_say("the rest of the mill's length", _slice(campaign, planned)))
    if planned.part.kind == "single-ball":
        said.append(_say("other balls", "one ball alone, to test the law of detachment and flight"))
    elif campaign.ball.radius_std == 0.0 and not campaign.ball.classes:
        said.append(_say("spread of ball radii", "radius_std_m is 0"))
    return said


def _slice(campaign: Campaign, planned: PlannedMill) -> str:
    diameters = planned.simulated_length / (2.0 * campaign.ball.radius)
    if campaign.mill.ends != "periodic":
        return f"asked for: {diameters:.3g} ball diameters between the ends stand for it"
    return f"asked for: a periodic slice of {diameters:.3g} ball diameters stands for it"


def _drag(campaign: Campaign) -> str:
    """Return the drag of a ball over its weight at the speed of impact in the physical mill."""
    ball = campaign.ball
    speed = impact_speed(physical_mill(campaign))
    drag = 0.5 * AIR_DENSITY * speed**2 * DRAG_COEFFICIENT * math.pi * ball.radius**2
    weight = 4.0 / 3.0 * math.pi * ball.radius**3 * ball.density * campaign.mill.gravity
    return f"{drag / weight:.1%} of a ball's weight at its fastest, {speed:.2g} m/s, physical mill"
