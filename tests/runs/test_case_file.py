"""case.json: accepted and refused content; the same campaign makes the same file."""

import json
from pathlib import Path

import pytest

from millscale.campaign.build import load_campaign
from millscale.cases.case import cases_of
from millscale.runs.case_digest import INFORMING, case_digest
from millscale.runs.case_file import REMEDY, case_of, is_outdated, load_case
from millscale.runs.untrusted import RunFolderError
from small_campaign import CHARGE, SINGLE_BALLS, TEXT
from synthetic_case import case_document, typed

# Of the version before the types (commit 1e464a8), with glibc's functions on x86-64: runs folders
# of that version must stay valid.
DIGESTS = {
    SINGLE_BALLS[0]: "6ee1787dfc5144aa5e0265ea371f37ff8625cd64f088295599a24d4028cd3f15",
    SINGLE_BALLS[1]: "f897f7c74a4cfb1ecc44cfe79a7dd606024942b0962e5d8a359c8c897e9ed1f1",
    CHARGE: "c5e67806cc3b82fe853788b1f005b8e71118923467f90582358d2ad68df2bcce",
}
MAY_BE_ABSENT = {
    *("charge", "ball.start_m", "wall.curvature_deg"),
    *(
        "deck.wall_damping",
        "deck.precision",
        "deck.ledger",
        "deck.liner_loads",
        "time.speed_changes",
    ),
}


@pytest.fixture
def cases(tmp_path):
    (tmp_path / "small.toml").write_text(TEXT)
    return cases_of(load_campaign(tmp_path / "small.toml"))


def leaves(document, above=""):
    for key, value in document.items():
        yield f"{above}{key}"
        if isinstance(value, dict) and above == "":
            yield from leaves(value, f"{key}.")


def without(document, path):
    copy = json.loads(json.dumps(document))
    *above, key = path.split(".")
    part = copy
    for name in above:
        part = part[name]
    del part[key]
    return copy


def refusal(document):
    with pytest.raises(RunFolderError) as refused:
        case_of(Path("case.json"), document)
    assert str(refused.value).startswith("case.json: ") and str(refused.value).endswith(REMEDY)
    return refused.value.cause


def test_the_same_campaign_has_the_digests_of_an_earlier_version(tmp_path):
    # That version began at full speed.
    sudden = TEXT.replace("[multi_ball]\n", "[multi_ball]\nramp_turns = 0\n")
    (tmp_path / "small.toml").write_text(sudden)
    cases = cases_of(load_campaign(tmp_path / "small.toml"))
    assert {case.id: case.digest for case in cases} == DIGESTS


def test_a_file_that_was_read_is_written_again_byte_by_byte(cases, tmp_path):
    for case in cases:
        (tmp_path / "case.json").write_text(case.text())
        assert load_case(tmp_path) == case
        assert load_case(tmp_path).text() == case.text()


def test_every_key_but_a_few_must_be_there(cases):
    for case in cases:
        for path in leaves(case.document):
            # The keys of `versions` are names of programs.
            if path in MAY_BE_ABSENT or path.startswith("versions."):
                case_of(Path("case.json"), without(case.document, path))
            else:
                assert refusal(without(case.document, path)) == f"{path} is missing"


@pytest.mark.parametrize(
    ("path", "value", "cause"),
    [
        ("S", 0, "S: got 0, accepted: a finite number > 0"),
        ("S", 1e301, "S: got 1e+301, accepted: a finite number > 0"),
        ("S", "2", "S: got '2', accepted: a finite number > 0"),
        ("schema", 2, "schema: got 2, accepted: 1"),
        ("kind", "two-ball", "kind: got 'two-ball', accepted: multi-ball, single-ball"),
        ("id", "../x", "id: got '../x', accepted: such as sb-cg-paper-S1.000"),
        ("id", "a\n", r"id: got 'a\n', accepted: such as sb-cg-paper-S1.000"),
        ("digest", "0", "digest: got '0', accepted: a SHA-256"),
        ("allow_centrifuging", 1, "allow_centrifuging: got 1, accepted: true or false"),
        ("seed", 10**10, "seed: got 10000000000, accepted: a whole number >= 0, <= 1e+09"),
        ("mill", [], "mill: got [], accepted: an object"),
        ("mill.lifters", True, "mill.lifters: got True, accepted: a whole number >= 0, <= 10000"),
        ("ball.count", 0, "ball.count: got 0, accepted: a whole number >= 1, <= 1e+09"),
        ("ball.start_m", [1, 2], "ball.start_m: got [1, 2], accepted: a list of 3"),
        ("time.steps", 1.5, "time.steps: got 1.5, accepted: a whole number >= 1, <= 1e+15"),
        ("deck.pair", "none\nshell", r"deck.pair: got 'none\nshell', accepted: a plain word"),
        ("deck.shell", "a", "unknown key 'deck.shell'"),
        ("wall.kind", "mesh", "wall.curvature_deg is missing, of a mesh"),
        ("wall.kind", "x" * 99, f"wall.kind: got '{'x' * 56}..., accepted: analytic, mesh"),
        ("versions", {"a": 1}, "versions[...]: Expected `str`, got `int`"),
    ],
)
def test_a_value_that_is_not_accepted_is_named(path, value, cause):
    document = case_document("single-ball", "constant-gravity", "paper", 2.0)
    *above, key = path.split(".")
    part = document
    for name in above:
        part = part[name]
    part[key] = value
    assert refusal(document) == cause


def test_a_whole_number_may_stand_for_a_real_one():
    document = case_document("single-ball", "constant-gravity", "paper", 2.0)
    assert isinstance(typed(document | {"S": 2}).S, float)


def test_the_digest_of_a_case_that_was_read_is_that_of_the_content():
    document = case_document("single-ball", "constant-gravity", "paper", 2.0)
    edited = document | {"seed": 7, "later": "a key of another version"}
    case = typed(edited)
    assert case.digest == case_digest(edited) != typed(document).digest
    assert is_outdated({"digests": {case.id: typed(document).digest}}, case)
    assert not is_outdated({"digests": {case.id: case.digest}}, case)


def test_keys_that_inform_and_names_do_not_decide_the_identity():
    document = case_document("single-ball", "constant-gravity", "paper", 2.0)
    named = document | {"id": "other", "campaign": "other", "warnings": ["x"]}
    assert typed(named).identity == typed(document).identity
    assert typed(named).digest != typed(document).digest
    assert "warnings" in INFORMING
    assert typed(document | {"S": 2.1}).identity != typed(document).identity


def test_a_default_that_a_campaign_states_does_not_change_the_identity_once_it_is_read(tmp_path):
    file = tmp_path / "small.toml"
    file.write_text(TEXT + '\n[model]\nprecision = "double"\n')
    made = next(case for case in cases_of(load_campaign(file)) if case.id == CHARGE)
    assert made.identity == typed(json.loads(made.text())).identity
