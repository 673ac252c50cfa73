"""The terms of the decks follow from the scene and are reported."""

import pytest

from millscale.campaign.keys import FORCIBLE
from paper_campaign import MULTI_BALL, cases

NO_FRICTION = {
    f"material__{kind}_friction_{pair}": 0.0
    for kind in ("static", "rolling")
    for pair in ("pp", "pw")
}
EVERYTHING = {
    "pair": "gran",
    "dumps": "on",
    "tangential_model_pp": "history",
    "tangential_model_pw": "history",
    "rolling_model_pp": "cdt",
    "rolling_model_pw": "cdt",
    "surface": "fast",
    "tangential_damping": "bounded",
}


def of_kind(folder, kind, **changes):
    return next(case for case in cases(folder, **MULTI_BALL, **changes) if case.kind == kind)


def terms(case):
    """Return the part `deck` without the damping at the wall, which depends on the wall's kind."""
    return {name: value for name, value in case.document["deck"].items() if name != "wall_damping"}


def listed(case, side):
    statements = {"in": case.model.inside, "out": case.model.outside}[side]
    return {entry.what: entry.reason for entry in statements}


def test_a_charge_with_friction_has_every_term(tmp_path):
    assert terms(of_kind(tmp_path, "multi-ball")) == EVERYTHING


@pytest.mark.parametrize(
    ("changes", "word"),
    [
        ({}, "bounded"),
        ({"model__tangential_damping": "plain"}, "on"),
        ({"model__contacts": "stock"}, "on"),
        ({"wall__kind": "mesh"}, "on"),
    ],
)
def test_the_analytic_wall_damps_as_the_balls_do(tmp_path, changes, word):
    assert of_kind(tmp_path, "multi-ball", **changes).deck.wall_damping == word
    # The damping of a single ball is unchanged, so that the digests of its cases stay valid.
    assert of_kind(tmp_path, "single-ball", **changes).deck.wall_damping is None


def test_decks_have_an_energy_budget_on_request(tmp_path):
    asked = of_kind(tmp_path, "multi-ball", multi_ball__ledger=True)
    assert terms(asked) == EVERYTHING | {"ledger": "on"}
    # With `ledger = false` or without the key, the case has no trace of an energy budget.
    plain = of_kind(tmp_path, "multi-ball", multi_ball__ledger=False)
    assert terms(plain) == EVERYTHING
    assert plain.digest == of_kind(tmp_path, "multi-ball").digest != asked.digest
    rows = plain.time.steps // plain.output.sample_steps
    assert asked.predicted.output_bytes - plain.predicted.output_bytes > 500 * rows


def test_decks_record_impacts_on_request(tmp_path):
    asked = of_kind(tmp_path, "multi-ball", multi_ball__impacts=True)
    assert terms(asked) == EVERYTHING | {"impacts": "on"}
    plain = of_kind(tmp_path, "multi-ball", multi_ball__impacts=False)
    assert plain.digest == of_kind(tmp_path, "multi-ball").digest != asked.digest
    assert asked.predicted.output_bytes > plain.predicted.output_bytes


def test_the_contact_backend_is_stock_liggghts_on_request(tmp_path):
    case = of_kind(tmp_path, "multi-ball", model__contacts="stock")
    assert terms(case) == EVERYTHING | {"surface": "default", "tangential_damping": "on"}
    assert "contacts between balls evaluated by stock LIGGGHTS" in listed(case, "in")


def test_mixed_precision_is_stated(tmp_path):
    case = of_kind(tmp_path, "multi-ball", model__precision="mixed")
    assert terms(case) == EVERYTHING | {"precision": "mixed"}
    assert "contacts between balls evaluated by our kernels, in mixed precision" in listed(
        case, "in"
    )


def test_a_single_ball_has_no_pair_style_and_no_dumps(tmp_path):
    case = of_kind(tmp_path, "single-ball")
    assert terms(case) == EVERYTHING | {"pair": "none", "dumps": "off"}
    out = listed(case, "out")
    assert (
        "no other to touch"
        in out["contacts between balls: pair style, neighbour list, ghost balls"]
    )
    assert "dumps of all balls" in out


@pytest.mark.parametrize("pair", ["pp", "pw"])
@pytest.mark.parametrize("wall", ["mesh", "analytic"])
def test_a_coefficient_of_zero_omits_its_term_where_it_is_zero(tmp_path, pair, wall):
    changes = {f"material__rolling_friction_{pair}": 0.0, f"material__static_friction_{pair}": 0.0}
    case = of_kind(tmp_path, "multi-ball", wall__kind=wall, **changes)
    # fix wall/mill has no other tangential model, and the case reports it.
    stays = pair == "pw" and wall == "analytic"
    assert terms(case) == EVERYTHING | {
        f"rolling_model_{pair}": "off",
        f"tangential_model_{pair}": "history" if stays else "no_history",
    }
    reasons = {**listed(case, "in"), **listed(case, "out")}.values()
    assert any(f"rolling_friction_{pair} is 0" in reason for reason in reasons)
    assert any(f"static_friction_{pair} is 0" in reason for reason in reasons)


@pytest.mark.parametrize("kind", ["single-ball", "multi-ball"])
def test_a_forced_term_is_in_the_deck_and_is_reported(tmp_path, kind):
    changes = {**NO_FRICTION, "wall__kind": "mesh"}
    bare = terms(of_kind(tmp_path, kind, **changes))
    assert all(bare[name] != EVERYTHING[name] for name in EVERYTHING if name[-2:] in ("pp", "pw"))
    full = of_kind(tmp_path, kind, model__force=list(FORCIBLE), **changes)
    assert terms(full) == EVERYTHING
    forced = [reason for reason in listed(full, "in").values() if "[model] force" in reason]
    assert len(forced) == sum(bare[name] != EVERYTHING[name] for name in EVERYTHING)
    assert terms(of_kind(tmp_path, kind, model__force=["rolling"], **changes)) == bare | {
        "rolling_model_pp": "cdt",
        "rolling_model_pw": "cdt",
    }


def test_forcing_a_term_makes_another_case(tmp_path):
    plain, forced = (
        of_kind(tmp_path, "single-ball", **change) for change in ({}, {"model__force": ["pair"]})
    )
    assert plain.digest != forced.digest


def test_ball_ball_terms_are_omitted_if_the_case_has_one_ball(tmp_path):
    case = of_kind(tmp_path, "single-ball", **NO_FRICTION)
    assert not any(
        "between balls," in what for side in ("in", "out") for what in listed(case, side)
    )
