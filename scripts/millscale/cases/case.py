"""The cases of a campaign: one scaled mill each, every number of it resolved."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from msgspec import structs

from millscale.campaign.campaign import Campaign
from millscale.cases import sections as parts
from millscale.cases.cost import wall_time
from millscale.cases.deck_terms import deck_part, statements_of, terms_of
from millscale.cases.feasible import check_model
from millscale.cases.law import Model, models_of
from millscale.cases.modelled import statements
from millscale.cases.output_size import check_budget, output_bytes
from millscale.cases.time_step import Step, steps_of
from millscale.cases.wall_panels import wall_part
from millscale.engine.code_version import installed_version
from millscale.errors import CampaignError
from millscale.runs.case_digest import case_digest
from millscale.runs.case_file import SCHEMA, Case, Predicted

SHORT_KIND = {"single-ball": "sb", "multi-ball": "mb"}
SHORT_SCHEME = {"constant-gravity": "cg", "constant-speed": "cs", "froude": "fr"}
_NOT_PREDICTED = Predicted(particle_steps=0, ranks=1, wall_time_s=0.0, output_bytes=0)


def cases_of(campaign: Campaign) -> list[Case]:
    """Return the cases of a campaign: by study, policy, scheme, S and seed.

    Raises:
        CampaignError: a model is impossible, a case would write more than the campaign's budget, or
            two cases would have the same id.
    """
    cases = []
    for study in campaign.studies:
        models = models_of(campaign, study)
        for model, step in zip(models, steps_of(campaign, models), strict=True):
            cases += _cases(campaign, model, step)
    for case in cases:
        check_budget(campaign.file, case, campaign.output_budget)
    seen: set[str] = set()
    for case in cases:
        if case.id in seen:
            cause = f"two cases are called {case.id}: S is told apart by three decimals"
            raise CampaignError(campaign.file, "scaling.S", cause, "S that differ by 0.001 or more")
        seen.add(case.id)
    return cases


def case_id(model: Model, seed: int) -> str:
    """Return the name of a case, `mb-cg-paper-S2.600`, with the seed if there are several."""
    kind = SHORT_KIND[model.study.kind]
    name = f"{kind}-{SHORT_SCHEME[model.scheme]}-{model.policy}-S{model.S:.3f}"
    several = model.study.charge is not None and len(model.study.charge.seeds) > 1
    return f"{name}-seed{seed}" if several else name


def _cases(campaign: Campaign, model: Model, step: Step) -> list[Case]:
    """Return the cases of a model, which differ in the seed alone.

    Raises:
        CampaignError: the model is impossible.
    """
    study = model.study
    try:
        case = _case(campaign, model, step)
    except ArithmeticError as cause:
        raise _beyond_arithmetic(campaign, model, str(cause)) from None
    beyond = next(
        (key for key, number in numbers(case.document) if not math.isfinite(number)), None
    )
    if beyond:
        raise _beyond_arithmetic(campaign, model, f"{beyond} is not finite")
    seeds = study.charge.seeds_at(model.S) if study.charge else (0,)
    return [_seeded(case, model, seed) for seed in seeds]


def _beyond_arithmetic(campaign: Campaign, model: Model, cause: str) -> CampaignError:
    return CampaignError(
        campaign.file,
        model.study.kind.replace("-", "_"),
        f"numbers beyond floating point at S = {model.S:g}, scheme {model.scheme}: {cause}",
        "numbers of a mill; check units and powers of ten",
    )


def _seeded(case: Case, model: Model, seed: int) -> Case:
    own = structs.replace(case, id=case_id(model, seed), seed=seed)
    return structs.replace(own, digest=case_digest(own.document))


def _case(campaign: Campaign, model: Model, step: Step) -> Case:
    """Return the case of a model without its id, seed and digest."""
    study = model.study
    time = parts.time_part(campaign, model, step)
    warned = check_model(campaign, model, step.limits)
    ball = parts.ball_part(campaign, model)
    terms = terms_of(campaign, model)
    given = study.charge
    case = Case(
        schema=SCHEMA,
        id="",
        campaign=campaign.name,
        kind=study.kind,
        scheme=model.scheme,
        policy=model.policy,
        S=model.S,
        time_factor=model.time_factor,
        allow_centrifuging=campaign.mill.allow_centrifuging,
        seed=0,
        physical=parts.physical_part(campaign),
        mill=parts.mill_part(model),
        factors=parts.factors_part(model),
        predicted_energy_ratio=model.scaled.predicted_energy_ratio,
        centre_path_energy_ratio=model.scaled.centre_path_energy_ratio,
        groups=parts.groups_part(campaign, model),
        ball=ball,
        material=parts.material_part(campaign, model),
        time=time,
        charge=parts.charge_part(campaign, model, given, ball, time) if given else None,
        wall=wall_part(campaign, model),
        deck=deck_part(terms, campaign, study),
        domain=parts.domain_part(campaign, model),
        output=parts.output_part(study, model, time),
        warnings=(*campaign.warnings, *step.warnings, *warned),
        model=statements(campaign, model, statements_of(terms)),
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
