"""Terms of the decks that a scene needs, each with the reason.

The switches go through case.json into parameters.in; the plan and case.json say the same in words.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from millscale.campaign.campaign import Campaign, CampaignPart
from millscale.campaign.contacts import DAMPINGS
from millscale.cases.law import PlannedMill
from millscale.runs.case_file import Deck, Modelled, Statement

BETWEEN = {"pp": "between balls", "pw": "of ball and wall"}


@dataclass(frozen=True)
class Term:
    """A part of the decks that some scenes do without.

    Attributes:
        name: word of config_keys.FORCIBLE; every term of a name is forced together.
        what: the term in words.
        inside: whether the deck has it.
        reason: why it is in, or why it is out.
        switch: variable of the decks.
        values: of the variable, out and in.
    """

    name: str
    what: str
    inside: bool
    reason: str
    switch: str
    values: tuple[str, str]


def terms_of(campaign: Campaign, planned: PlannedMill) -> list[Term]:
    """Return the terms of a planned mill's decks that depend on the scene."""
    single = planned.part.kind == "single-ball"
    pair = Term(
        "pair",
        "contacts between balls: pair style, neighbour list, ghost balls",
        not single,
        "a single ball has no other to touch" if single else "balls touch each other",
        "pair",
        ("none", "gran"),
    )
    dumps = Term(
        "dumps",
        "dumps of all balls",
        not single,
        "series.csv holds the whole path" if single else "for the report's pictures and contours",
        "dumps",
        ("off", "on"),
    )
    friction = [
        *(_rolling(campaign, of) for of in BETWEEN),
        *(_history(campaign, of) for of in BETWEEN),
    ]
    return [_forced(term, campaign.force) for term in (pair, *friction, dumps)]


def deck_part(terms: list[Term], campaign: Campaign, part: CampaignPart) -> Deck:
    """Return the part `deck` of a case.json: the switches and the contact options.

    Keys that a case does not need are left out, so that cases made before they existed keep their
    digest.
    """
    contacts = campaign.contacts
    # A ball that is alone takes a step that the dashpot of its one contact allows as it is.
    wall = contacts.damping if campaign.wall.kind == "analytic" else "plain"
    switches: dict[str, Any] = {term.switch: term.values[term.inside] for term in terms}
    return Deck(
        **switches,
        surface=contacts.surface,
        tangential_damping=contacts.tangential_damping,
        wall_damping=DAMPINGS[wall] if part.kind == "multi-ball" else None,
        precision=contacts.precision,
        ledger="on" if part.ledger else "off",
        liner_loads="on" if part.liner_loads else "off",
        impacts="on" if part.impacts else "off",
    )


def statements_of(terms: list[Term]) -> Modelled:
    """Return the terms in words. Ball-ball terms are omitted if the case has one ball."""
    alone = not next(term.inside for term in terms if term.name == "pair")
    said = [term for term in terms if not (alone and term.switch.endswith("_pp"))]
    statements = [(term.inside, Statement(what=term.what, reason=term.reason)) for term in said]
    return Modelled(
        inside=tuple(x for inside, x in statements if inside),
        outside=tuple(x for inside, x in statements if not inside),
    )


def _largest(campaign: Campaign, name: str) -> float:
    """Return the largest coefficient of a name, of any class of balls or end wall."""
    materials = [campaign.material, *(one.material for one in campaign.ball.classes)]
    found = [getattr(material, name) for material in materials if material]
    if name.endswith("_pw"):
        found.append(getattr(campaign.mill, f"end_{name.removesuffix('_pw')}") or 0.0)
    return float(max(found))


def _rolling(campaign: Campaign, pair: str) -> Term:
    coefficient = _largest(campaign, f"rolling_friction_{pair}")
    return Term(
        "rolling",
        f"rolling friction {BETWEEN[pair]}, a directional constant torque (cdt)",
        coefficient > 0.0,
        f"rolling_friction_{pair} is {coefficient:g}",
        f"rolling_model_{pair}",
        ("off", "cdt"),
    )


def _history(campaign: Campaign, pair: str) -> Term:
    """Return the term of the tangential model; the engine has both models precompiled."""
    coefficient = _largest(campaign, f"static_friction_{pair}")
    needed, reason = coefficient > 0.0, "no slip until mu F_n; sets lift and detachment"
    if not needed:
        reason = f"static_friction_{pair} is 0: no tangential force to remember"
        if pair == "pw" and campaign.wall.kind == "analytic":
            needed, reason = True, f"{reason}; fix wall/mill keeps its memory, which adds no force"
    return Term(
        "history",
        f"tangential spring {BETWEEN[pair]} with memory, up to Coulomb's limit",
        needed,
        reason,
        f"tangential_model_{pair}",
        ("no_history", "history"),
    )


def _forced(term: Term, force: tuple[str, ...]) -> Term:
    if term.inside or term.name not in force:
        return term
    return replace(term, inside=True, reason=f"asked for in [model] force, though {term.reason}")
