"""The cases of a campaign: one scaled mill each, every number of it resolved."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from msgspec import structs

from millscale.campaign.campaign import Campaign, CampaignPart
from millscale.cases import sections as parts
from millscale.cases.cost import wall_time
from millscale.cases.deck_terms import deck_part, statements_of, terms_of
from millscale.cases.feasible import check_mill
from millscale.cases.law import PlannedMill, planned_mills
from millscale.cases.modelled import statements
from millscale.cases.output_size import check_budget, output_bytes
from millscale.cases.time_step import Step, steps_of
from millscale.cases.wall_panels import wall_part
from millscale.engine.code_version import installed_version
from millscale.errors import CampaignError, Mistakes
from millscale.runs.case_digest import case_digest
from millscale.runs.case_file import SCHEMA, Case, Predicted

SHORT_KIND = {"single-ball": "sb", "multi-ball": "mb"}
SHORT_SCHEME = {"constant-gravity": "cg", "constant-speed": "cs", "froude": "fr"}
_NOT_PREDICTED = Predicted(particle_steps=0, ranks=1, wall_time_s=0.0, output_bytes=0)


def cases_of(campaign: Campaign) -> list[Case]:
    """Return the cases of a campaign: by part, policy, scheme, S and seed.

    Raises:
        CampaignError: a planned mill is impossible, a case would write more than the budget of the
            campaign, or two cases would have the same id; holds the mistakes of all parts.
    """
    cases, mistakes = [], Mistakes()
    for stated in campaign.in_each_state():
        for part in stated.parts:
            with mistakes.collected():
                cases += _part_cases(stated, part)
    # A mistake in one mill is mostly one in all: the first is stated.
    mistakes.found = list({mistake.key: mistake for mistake in mistakes.found[::-1]}.values())
    try:
        mistakes.raise_all()
    except CampaignError as error:
        raise campaign.places.located(error) from None
    return cases


def _part_cases(campaign: Campaign, part: CampaignPart) -> list[Case]:
    mills = planned_mills(campaign, part)
    cases, mistakes = [], Mistakes()
    for planned, step in zip(mills, steps_of(campaign, mills), strict=True):
        with mistakes.collected():
            cases += _cases(campaign, planned, step)
    mistakes.raise_all()
    for case in cases:
        check_budget(campaign.file, case, campaign.output_budget)
    seen: set[str] = set()
    for case in cases:
        if case.id in seen:
            cause = f"two cases are called {case.id}: names show three decimals of S"
            raise CampaignError(campaign.file, "scaling.S", cause, "S that differ by 0.001 or more")
        seen.add(case.id)
    return cases


def case_id(planned: PlannedMill, seed: int, state: str = "") -> str:
    """Return the name of a case, `mb-cg-paper-S2.600`, with the state of the liner and the seed if
    there are several."""
    kind = SHORT_KIND[planned.part.kind]
    name = f"{kind}-{SHORT_SCHEME[planned.scheme]}-{planned.policy}-S{planned.S:.3f}"
    name += f"-{state}" if state else ""
    several = planned.part.charge is not None and len(planned.part.charge.seeds) > 1
    return f"{name}-seed{seed}" if several else name


def _cases(campaign: Campaign, planned: PlannedMill, step: Step) -> list[Case]:
    """Return the cases of a planned mill, which differ in the seed alone.

    Raises:
        CampaignError: the planned mill is impossible.
    """
    part = planned.part
    try:
        case = _case(campaign, planned, step)
    except ArithmeticError as cause:
        raise _beyond_arithmetic(campaign, planned, str(cause)) from None
    beyond = next(
        (key for key, number in numbers(case.document) if not math.isfinite(number)), None
    )
    if beyond:
        raise _beyond_arithmetic(campaign, planned, f"{beyond} is not finite")
    seeds = part.charge.seeds_at(planned.S) if part.charge else (0,)
    state = campaign.state.name if campaign.state else ""
    return [_seeded(case, case_id(planned, seed, state), seed) for seed in seeds]


def _beyond_arithmetic(campaign: Campaign, planned: PlannedMill, cause: str) -> CampaignError:
    return CampaignError(
        campaign.file,
        planned.part.kind.replace("-", "_"),
        f"numbers beyond floating point at S = {planned.S:g}, scheme {planned.scheme}: {cause}",
        "numbers of a mill; check units and powers of ten",
    )


def _seeded(case: Case, name: str, seed: int) -> Case:
    own = structs.replace(case, id=name, seed=seed)
    return structs.replace(own, digest=case_digest(own.document))


def _case(campaign: Campaign, planned: PlannedMill, step: Step) -> Case:
    """Return the case of a planned mill without its id, seed and digest."""
    part = planned.part
    mistakes, warned = Mistakes(), []
    with mistakes.collected():
        warned = check_mill(campaign, planned, step.limits)
    with mistakes.collected():
        time = parts.time_part(campaign, planned, step)
    with mistakes.collected():
        ball = parts.ball_part(campaign, planned)
    mistakes.raise_all()
    terms = terms_of(campaign, planned)
    given = part.charge
    case = Case(
        schema=SCHEMA,
        id="",
        campaign=campaign.name,
        kind=part.kind,
        scheme=planned.scheme,
        policy=planned.policy,
        S=planned.S,
        time_factor=planned.time_factor,
        friction_exponent=k if (k := planned.friction_exponent) != 1.0 else None,
        allow_centrifuging=campaign.mill.allow_centrifuging,
        seed=0,
        physical=parts.physical_part(campaign),
        mill=parts.mill_part(campaign, planned),
        factors=parts.factors_part(planned),
        predicted_energy_ratio=planned.scaled.predicted_energy_ratio,
        centre_path_energy_ratio=planned.scaled.centre_path_energy_ratio,
        groups=parts.groups_part(campaign, planned),
        ball=ball,
        material=parts.material_part(campaign, planned),
        time=time,
        charge=parts.charge_part(campaign, planned, given, ball, time) if given else None,
        liner_file=parts.liner_file_part(campaign),
        liner_state=parts.liner_state_part(campaign),
        wall=wall_part(campaign, planned),
        deck=deck_part(terms, campaign, part),
        domain=parts.domain_part(campaign, planned, step),
        output=parts.output_part(part, planned, time),
        warnings=(*campaign.warnings, *step.warnings, *warned),
        model=statements(campaign, planned, statements_of(terms)),
        versions={"millscale": installed_version()},
        predicted=_NOT_PREDICTED,
        digest="",
    )
    return structs.replace(case, predicted=_predicted(case))


def numbers(content: Any, key: str = "") -> Iterator[tuple[str, float]]:
    """Yield every number of a document, with its path."""
    if isinstance(content, Mapping):
        for name, inner in content.items():
            yield from numbers(inner, f"{key}.{name}".lstrip("."))
    elif isinstance(content, list):
        for inner in content:
            yield from numbers(inner, key)
    elif isinstance(content, float):
        yield key, content


def _predicted(case: Case) -> Predicted:
    """Return the cost on one core; the plan and the run predict for the ranks they choose."""
    return Predicted(
        particle_steps=case.ball.count * (case.time.settle_steps + case.time.steps),
        ranks=1,
        wall_time_s=wall_time(case, 1),
        output_bytes=output_bytes(case),
    )
