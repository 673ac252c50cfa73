"""What enters the decks follows from the scene, and is said."""

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
    """The part `deck` but for the damping at the wall, which is a matter of the wall's kind."""
    return {name: value for name, value in case.document["deck"].items() if name != "wall_damping"}


def said(case, side):
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
def test_the_wall_damps_as_the_balls_do_where_it_is_ours(tmp_path, changes, word):
    assert of_kind(tmp_path, "multi-ball", **changes).deck.wall_damping == word
    # A single ball is damped as it is, and its cases stay what they were.
    assert of_kind(tmp_path, "single-ball", **changes).deck.wall_damping is None


def test_an_account_of_the_energy_is_in_the_decks_for_the_asking(tmp_path):
    asked = of_kind(tmp_path, "multi-ball", multi_ball__ledger=True)
    assert terms(asked) == EVERYTHING | {"ledger": "on"}
    # Asked not to, or not asked: the case is what it was before there was an account.
    plain = of_kind(tmp_path, "multi-ball", multi_ball__ledger=False)
    assert terms(plain) == EVERYTHING
    assert plain.digest == of_kind(tmp_path, "multi-ball").digest != asked.digest
    rows = plain.time.steps // plain.output.sample_steps
    assert asked.predicted.output_bytes - plain.predicted.output_bytes > 500 * rows


def test_contacts_are_evaluated_by_stock_liggghts_for_the_asking(tmp_path):
    case = of_kind(tmp_path, "multi-ball", model__contacts="stock")
    assert terms(case) == EVERYTHING | {"surface": "default", "tangential_damping": "on"}
    assert "contacts between balls evaluated by stock LIGGGHTS" in said(case, "in")


def test_mixed_precision_is_said(tmp_path):
    case = of_kind(tmp_path, "multi-ball", model__precision="mixed")
    assert terms(case) == EVERYTHING | {"precision": "mixed"}
    assert "contacts between balls evaluated by our kernels, in mixed precision" in said(case, "in")


def test_a_single_ball_has_no_pair_style_and_no_dumps(tmp_path):
    case = of_kind(tmp_path, "single-ball")
    assert terms(case) == EVERYTHING | {"pair": "none", "dumps": "off"}
    out = said(case, "out")
    assert (
        "no other to touch"
        in out["contacts between balls: pair style, neighbour list, ghost balls"]
    )
    assert "dumps of all balls" in out


@pytest.mark.parametrize("pair", ["pp", "pw"])
@pytest.mark.parametrize("wall", ["mesh", "analytic"])
def test_a_coefficient_of_zero_takes_its_term_out_where_it_is_zero(tmp_path, pair, wall):
    changes = {f"material__rolling_friction_{pair}": 0.0, f"material__static_friction_{pair}": 0.0}
    case = of_kind(tmp_path, "multi-ball", wall__kind=wall, **changes)
    # fix wall/mill has no other tangential model, and says so.
    stays = pair == "pw" and wall == "analytic"
    assert terms(case) == EVERYTHING | {
        f"rolling_model_{pair}": "off",
        f"tangential_model_{pair}": "history" if stays else "no_history",
    }
    reasons = {**said(case, "in"), **said(case, "out")}.values()
    assert any(f"rolling_friction_{pair} is 0" in reason for reason in reasons)
    assert any(f"static_friction_{pair} is 0" in reason for reason in reasons)


@pytest.mark.parametrize("kind", ["single-ball", "multi-ball"])
def test_whatever_is_forced_is_in_and_says_so(tmp_path, kind):
    changes = {**NO_FRICTION, "wall__kind": "mesh"}
    bare = terms(of_kind(tmp_path, kind, **changes))
    assert all(bare[name] != EVERYTHING[name] for name in EVERYTHING if name[-2:] in ("pp", "pw"))
    full = of_kind(tmp_path, kind, model__force=list(FORCIBLE), **changes)
    assert terms(full) == EVERYTHING
    forced = [reason for reason in said(full, "in").values() if "[model] force" in reason]
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


def test_nothing_is_said_of_balls_that_do_not_meet(tmp_path):
    case = of_kind(tmp_path, "single-ball", **NO_FRICTION)
    assert not any("between balls," in what for side in ("in", "out") for what in said(case, side))
