"""The parts of a case.json: every number a stage needs, from a planned mill and its time step."""

from __future__ import annotations

import math

from millscale import _core
from millscale.campaign import campaign as campaign_file
from millscale.campaign.campaign import Campaign, CampaignPart
from millscale.cases.law import PlannedMill, physical_liner
from millscale.cases.time_step import Step
from millscale.cases.wall_panels import chord_error, resting_height, shape_of
from millscale.errors import CampaignError
from millscale.liner.given import Given
from millscale.packing.ball_sizes import class_counts, mean_volume
from millscale.packing.charge import Room, capacity
from millscale.runs.case_file import (
    BallClass,
    Balls,
    Charge,
    Domain,
    Factors,
    Groups,
    LinerFile,
    LinerState,
    Material,
    Mill,
    Output,
    PhysicalMill,
    Times,
)
from millscale.runs.liner import liner_keys, profile_rows

# The start of a single ball, above the liner, in ball radii: it must not overlap the mesh.
START_GAP = 1e-3
# Least neighbour skin in ball radii, by contacts: the optima measured at 20 mm balls and 1e-4 s.
SKIN = {"stock": 0.75, "fast": 1.0}
# Steps that our own list lasts at least. It takes from the skin only what a ball's speed asks for
# (`core/neighbor/adaptive_skin.h`), so a longer skin costs little: docs/results/performance.md.
LIST_STEPS = 12
# A single ball has no others to list, and a long skin saves rebuilding the list of wall triangles.
SINGLE_BALL_SKIN = 10.0
# Room around the mill for the engine's box, in ball radii.
BOX_MARGIN = 2.0
THERMO_LINES = 200
# The engine counts steps in 32-bit integers in places.
MOST_STEPS = 2_000_000_000
MOST_BALLS = 10_000_000


def physical_part(campaign: Campaign) -> PhysicalMill:
    """Return the physical mill."""
    mill = campaign.mill
    return PhysicalMill(
        radius_m=mill.radius,
        ball_radius_m=campaign.ball.radius,
        gravity_m_s2=mill.gravity,
        omega_rad_s=mill.omega,
        length_m=mill.length,
        **liner_keys(physical_liner(campaign)),
    )


def mill_part(campaign: Campaign, planned: PlannedMill) -> Mill:
    """Return the scaled mill, its operating point and the numbers that follow from it."""
    mill, froude = planned.scaled.mill, planned.scaled.froude
    critical = _core.critical_speed(mill)
    return Mill(
        radius_m=planned.liner.radius,
        length_m=planned.length,
        simulated_length_m=planned.simulated_length,
        gravity_m_s2=mill.gravity,
        omega_rad_s=mill.omega,
        froude=froude,
        critical_speed_rad_s=critical,
        percent_of_critical=100.0 * mill.omega / critical,
        detach_angle_deg=(math.degrees(_core.detach_angle(froude)) if froude <= 1.0 else None),
        regime=_core.regime(froude),
        **liner_keys(planned.liner),
        phase_rad=planned.liner.phase,
        area_m2=planned.liner.area,
        profile=profile_rows(planned.liner),
        ends=campaign.mill.ends,
        end_static_friction=campaign.mill.end_static_friction,
        end_rolling_friction=campaign.mill.end_rolling_friction,
    )


def liner_file_part(campaign: Campaign) -> LinerFile | None:
    """Return the file that states the liner; None without one."""
    liner = campaign.liner
    if not isinstance(liner, Given) or not liner.file:
        return None
    return LinerFile(name=liner.file, sha256=liner.digest)


def liner_state_part(campaign: Campaign) -> LinerState | None:
    """Return the state of the liner; None in a campaign of one."""
    state = campaign.state
    return LinerState(name=state.name, hours=state.hours, tonnes=state.tonnes) if state else None


def factors_part(planned: PlannedMill) -> Factors:
    """Return the factors scaled / physical of the law."""
    base = planned.scaled.base
    return Factors(
        length=base.length,
        mass=base.mass,
        time=base.time,
        energy=_core.factor(base, 2, 1, -2),
        friction=ratio if (ratio := planned.scaled.friction_ratio) != 1.0 else None,
    )


def groups_part(campaign: Campaign, planned: PlannedMill) -> Groups:
    """Return ratios to the ball size, which no policy keeps."""
    diameter, liner = 2.0 * campaign.ball.radius, liner_keys(planned.liner)
    return Groups(
        ball_radius_over_mill_radius=0.5 * diameter / planned.liner.radius,
        lifter_height_over_ball_diameter=(
            (planned.liner.radius - liner["lifter_top_radius_m"]) / diameter
            if liner["lifters"]
            else 0.0
        ),
        groove_width_over_ball_diameter=liner["groove_width_m"] / diameter,
        length_over_ball_diameter=planned.simulated_length / diameter,
        length_over_mill_radius=(
            planned.simulated_length / planned.liner.radius
            if campaign.mill.ends != "periodic"
            else None
        ),
    )


def ball_part(campaign: Campaign, planned: PlannedMill) -> Balls:
    """Return the balls; their mass is the mean of their distribution."""
    single = planned.part.kind == "single-ball"
    ball = campaign.ball
    volume = 4.0 / 3.0 * math.pi * ball.radius**3 if single else mean_volume(ball)
    count = ball_count(campaign, planned)
    start = start_position(planned, ball.radius, chord_error(campaign, planned)) if single else None
    return Balls(
        radius_m=ball.radius,
        density_kg_m3=ball.density,
        mass_kg=ball.density * volume,
        radius_std_m=0.0 if single else ball.radius_std,
        truncation=ball.truncation,
        count=count,
        start_m=start,
        classes=() if single else _classes(campaign, planned, count),
    )


def _classes(campaign: Campaign, planned: PlannedMill, count: int) -> tuple[BallClass, ...]:
    """Return the classes of a charge.

    Raises:
        CampaignError: a class has no ball.
    """
    ball = campaign.ball
    if not ball.classes:
        return ()
    counts = class_counts(ball, count)
    if 0 in counts:
        k = counts.index(0)
        raise CampaignError(
            campaign.file,
            "multi_ball",
            f"{count} balls at S = {planned.S:g} have none of radius {ball.classes[k].radius:g} m, "
            f"a share of {ball.classes[k].share:.3g} by number",
            "a longer slice, or fewer classes",
        )
    return tuple(
        BallClass(
            radius_m=one.radius,
            density_kg_m3=one.density,
            count=n,
            material=material_part(campaign, planned, one.material) if one.material else None,
        )
        for one, n in zip(ball.classes, counts, strict=True)
    )


def start_position(
    planned: PlannedMill, ball_radius: float, error: float
) -> tuple[float, float, float]:
    """Return the centre (x, y, z) [m] of a ball at rest under the axis, at half the length.

    It lies on whatever panel is at the bottom: of the groove, or with another phase of a lifter.
    """
    z = resting_height(shape_of(planned.liner), error, ball_radius * (1.0 + START_GAP))
    return 0.0, 0.5 * planned.simulated_length, z


def ball_count(campaign: Campaign, planned: PlannedMill) -> int:
    """Return the balls in the simulated length."""
    charge = planned.part.charge
    if charge is None:
        return 1
    if charge.counts is not None:
        count = charge.counts[planned.index] * planned.simulated_length / planned.length
    else:
        assert charge.filling is not None  # as the reader of campaign files has checked
        volume = charge.filling * planned.liner.area * planned.simulated_length
        count = volume * (1.0 - charge.porosity) / mean_volume(campaign.ball)
    room = Room(
        planned.liner,
        planned.simulated_length,
        chord_error(campaign, planned),
        closed=campaign.mill.ends != "periodic",
    )
    places = capacity(room, campaign.ball)
    if not 0.5 <= count <= min(places, MOST_BALLS):
        raise CampaignError(
            campaign.file,
            "multi_ball.count" if charge.counts else "multi_ball.filling",
            f"makes {count:.0f} balls at S = {planned.S:g}",
            f"1 to {min(places, MOST_BALLS):,} balls, the most an initial packing holds",
        )
    return round(count)


def material_part(
    campaign: Campaign, planned: PlannedMill, own: campaign_file.Material | None = None
) -> Material:
    """Return the elastic constants of this mill and coefficients of the contact law.

    Args:
        own: of a class of balls; None: of the campaign.
    """
    material = own or campaign.material
    modulus = planned.modulus_of(material, campaign)
    return Material(
        youngs_modulus_pa=modulus,
        shear_modulus_pa=modulus / (2.0 * (1.0 + material.poisson_ratio)),
        poisson_ratio=material.poisson_ratio,
        restitution_pp=material.restitution_pp,
        restitution_pw=material.restitution_pw,
        static_friction_pp=material.static_friction_pp * planned.scaled.friction_ratio,
        static_friction_pw=material.static_friction_pw,
        rolling_friction_pp=material.rolling_friction_pp,
        rolling_friction_pw=material.rolling_friction_pw,
        stiffness=campaign.stiffness,
    )


def time_part(campaign: Campaign, planned: PlannedMill, step: Step) -> Times:
    """Return the time step, its limits, and the times; mill angles are equal in all mills.

    `steps` and `duration_s` are those of the run that turns the mill: rest and rotation of a single
    ball, rotation of a charge, whose settling is a run of its own.
    """
    part, dt, limits = planned.part, step.value, step.limits
    single = part.kind == "single-ball"
    wait_steps = round(part.wait * planned.scaled.base.time / dt)
    rotation_steps = _rotation_steps(part, planned.scaled.mill.omega * dt)
    steps = rotation_steps + (wait_steps if single else 0)
    if wait_steps + rotation_steps > MOST_STEPS:
        raise CampaignError(
            campaign.file,
            part.kind.replace("-", "_"),
            f"makes {wait_steps + rotation_steps:.3g} time steps at S = {planned.S:g}",
            f"<= {MOST_STEPS:g}",
        )
    return Times(
        step_s=dt,
        step_choice=step.choice,
        rest_steps=wait_steps if single else 0,
        settle_steps=0 if single else wait_steps,
        rotation_steps=rotation_steps,
        start_s=wait_steps * dt,
        rotation_angle_rad=part.rotation_angle,
        duration_s=steps * dt,
        steps=steps,
        sample_angle_rad=part.sample_angle,
        rayleigh_time_s=limits.rayleigh,
        rayleigh_fraction=dt / limits.rayleigh,
        damping_limit_s=limits.damping,
        limit_fraction=dt / limits.damping,
        mean_overlap_m=limits.overlap,
        impact_speed_m_s=limits.impact_speed,
        collision_time_s=limits.collision,
        steps_per_contact=limits.collision / dt,
        speed_changes=part.speed_changes,
    )


def _rotation_steps(part: CampaignPart, turn: float) -> int:
    """Return the steps of a rotation, of `turn` [rad] each at full speed.

    That of a charge has whole intervals of dumps: the last is at the end, at the same mill angle in
    every mill.
    """
    angle = part.rotation_angle
    if part.speed_changes:
        if part.charge is not None and angle >= part.dump_angle:
            angle = round(angle / part.dump_angle) * part.dump_angle
        phase = _core.SpeedSchedule(list(part.speed_changes)).phase(angle)
        return max(1, int(_core.nearest_step(phase / turn)))
    steps = max(1, round(angle / turn))
    dump_steps = max(1, round(part.dump_angle / turn))
    if part.charge is not None and steps >= dump_steps:
        return round(angle / part.dump_angle) * dump_steps
    return steps


def output_part(part: CampaignPart, planned: PlannedMill, time: Times) -> Output:
    """Return the steps between outputs, from mill angles; the progress uses `thermo_steps`.

    Lines of the engine's log are at steps of the series, so that the two can be compared.
    """
    turn = planned.scaled.mill.omega * time.step_s
    sample_steps = max(1, round(part.sample_angle / turn))
    return Output(
        thermo_steps=sample_steps * max(1, time.steps // (THERMO_LINES * sample_steps)),
        sample_steps=sample_steps,
        dump_angle_rad=part.dump_angle,
        dump_steps=max(1, round(part.dump_angle / turn)),
        restart_angle_rad=part.restart_angle,
        restart_steps=max(1, round(part.restart_angle / turn)),
    )


def charge_part(
    campaign: Campaign, planned: PlannedMill, given: campaign_file.Charge, ball: Balls, time: Times
) -> Charge:
    """Return the charge of a multi-ball case.

    Args:
        given: the charge as the campaign file states it.
    """
    solid = (
        ball.count * mean_volume(campaign.ball) / (planned.liner.area * planned.simulated_length)
    )
    return Charge(
        filling=given.filling,
        porosity=given.porosity if given.filling is not None else None,
        solid_fraction=solid,
        slice_length_m=given.slice_length,
        settle_s=time.start_s,
    )


def domain_part(campaign: Campaign, planned: PlannedMill, step: Step) -> Domain:
    """Return the engine's box around the mill and its neighbour skin."""
    single = planned.part.kind == "single-ball"
    return Domain(
        half_box_m=planned.liner.radius + BOX_MARGIN * campaign.ball.largest,
        skin_m=SINGLE_BALL_SKIN * campaign.ball.radius
        if single
        else _skin(campaign, planned, step),
    )


def _skin(campaign: Campaign, planned: PlannedMill, step: Step) -> float:
    """Return the neighbour skin of a charge [m].

    Our own list lasts `LIST_STEPS` of the fastest balls, unless a ball would reach beyond half the
    length of the mill: then most balls would be ghosts.
    """
    ball, backend = campaign.ball, campaign.contacts.backend
    least = SKIN[backend] * ball.mean_by_number
    if backend == "stock":
        return least
    # Half the skin is the way of a ball until the next list.
    lasting = 2.0 * LIST_STEPS * step.limits.impact_speed * step.value
    longest = 0.5 * planned.simulated_length - 2.0 * ball.largest
    return max(least, float(f"{min(lasting, longest):.3g}"))
