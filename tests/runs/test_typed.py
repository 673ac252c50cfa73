"""Typed values from JSON: what is accepted, and errors that name the key."""

import json
import re
from dataclasses import dataclass, field

import msgspec
import pytest

from millscale.runs.typed import as_typed, read_typed
from millscale.runs.untrusted import RunFolderError


@dataclass(frozen=True)
class Inner:
    step: int
    cost: float = 0.0


@dataclass(frozen=True)
class Outer:
    name: str
    inner: Inner
    many: tuple[Inner, ...] = ()
    digests: dict[str, str] = field(default_factory=dict)
    flag: bool = False


def test_a_record_has_the_types_of_its_fields():
    content = {
        "name": "a",
        "inner": {"step": 3, "cost": 1},
        "many": [{"step": 4}],
        "digests": {"x": "y"},
        "flag": True,
    }
    expected = Outer("a", Inner(3, 1.0), (Inner(4),), {"x": "y"}, True)
    assert as_typed(Outer, content) == expected
    assert isinstance(as_typed(Outer, content).inner.cost, float)


@pytest.mark.parametrize(
    ("change", "cause"),
    [
        ({"name": 3}, "name: got 3, accepted: text"),
        ({"name": None}, "name: got None"),
        ({"inner": {"step": "x"}}, "inner.step: got 'x', accepted: a whole number"),
        ({"inner": {"step": True}}, "inner.step: got True, accepted: a whole number"),
        ({"inner": {"step": 1.5}}, "inner.step: got 1.5, accepted"),
        ({"inner": {}}, "inner.step is missing"),
        ({"inner": []}, "inner: got [], accepted: an object"),
        ({"many": {}}, "many: got {}, accepted: a list"),
        ({"many": [1]}, "many[0]: got 1, accepted: an object"),
        ({"digests": {"x": 1}}, "digests[...]: Expected `str`, got `int`"),
        ({"flag": 1}, "flag: got 1, accepted: true or false"),
    ],
)
def test_a_record_of_other_types_is_refused(change, cause):
    with pytest.raises(ValueError, match=re.escape(cause)):
        as_typed(Outer, {"name": "a", "inner": {"step": 3}} | change)
    with pytest.raises(ValueError, match="accepted: an object"):
        as_typed(Outer, [])


class Strict(msgspec.Struct, forbid_unknown_fields=True):
    length: float | None


@pytest.mark.parametrize(
    ("content", "cause"),
    [
        ({"length": "x" * 99}, f"length: got '{'x' * 56}..., accepted: a finite number"),
        ({"length": 1.0, "more": 1}, "unknown key 'more'"),
        ({}, "length is missing"),
        ([], "got [], accepted: an object"),
    ],
)
def test_a_file_of_other_types_is_refused_with_its_name(tmp_path, content, cause):
    (path := tmp_path / "x.json").write_text(json.dumps(content))
    with pytest.raises(RunFolderError) as refused:
        read_typed(path, Strict, "make it again")
    assert refused.value.cause == cause and str(refused.value).endswith("; make it again")


def test_a_missing_key_is_not_null(tmp_path):
    (tmp_path / "x.json").write_text('{"length": null}')
    assert read_typed(tmp_path / "x.json", Strict, "").length is None
