"""Files that are damaged or made to do harm are refused in one line, at once."""

import os
import re
import socket
import time
from dataclasses import dataclass, field

import pytest

from millscale.runs.untrusted import (
    RunFolderError,
    as_record,
    open_regular,
    read_json,
    read_object,
    read_tail,
    read_text,
)

WITHIN_S = 2.0


def socket_at(path):
    with socket.socket(socket.AF_UNIX) as end:
        end.bind(str(path))


IRREGULAR = {
    "not a regular file": os.mkfifo,
    "cannot be read: not a regular file": lambda path: path.mkdir(),
    "a regular file": socket_at,
    "is a link": lambda path: path.symlink_to("/etc/hostname"),
    "cannot be read: is a link": lambda path: path.symlink_to("/dev/zero"),
}


@pytest.mark.parametrize("cause", IRREGULAR)
@pytest.mark.parametrize("read", [read_json, lambda path, remedy: read_text(path, 99, remedy)])
def test_what_is_no_regular_file_is_refused_at_once(tmp_path, cause, read):
    IRREGULAR[cause](path := tmp_path / "case.json")
    begin = time.monotonic()
    with pytest.raises(RunFolderError, match=f"case.json: .*{cause}; copy it") as refused:
        read(path, "copy it")
    assert time.monotonic() - begin < WITHIN_S
    assert "\n" not in str(refused.value)


def test_a_device_is_refused():
    with pytest.raises(OSError, match="not a regular file"):
        open_regular("/dev/zero")


def test_a_link_that_a_person_named_is_followed(tmp_path):
    (tmp_path / "a").write_text("x")
    (tmp_path / "b").symlink_to("a")
    assert read_text(tmp_path / "b", 9, "", follow=True) == "x"


def test_a_file_is_read_up_to_a_size(tmp_path):
    path = tmp_path / "a"
    path.write_text("12345")
    assert read_text(path, 5, "") == "12345"
    with pytest.raises(RunFolderError, match="larger than 4 bytes"):
        read_text(path, 4, "")
    with path.open("wb") as file:
        file.truncate(1 << 40)
    with pytest.raises(RunFolderError, match="larger than"):
        read_json(path, "")
    assert read_tail(path, 3) == "\0\0\0"


@pytest.mark.parametrize(
    ("text", "cause"),
    [
        ("[" * 200_000, "nested too deep"),
        ("[" * 21 + "]" * 21, "nested too deep"),
        ('{"a":' * 200_000, "nested too deep"),
        ("NaN", "NaN is not a finite number"),
        ("[-Infinity]", "-Infinity is not a finite number"),
        ("1e400", "1e400 is not finite"),
        ("-1e400", "-1e400 is not finite"),
        ("1" + "0" * 400, "a whole number of 401 digits"),
        ("1" * 10_000, "a whole number of 10000 digits"),
        ('{"a": 1', "cut short"),
        ("", "not valid JSON"),
        ("\ufeff{}", "not valid JSON"),
        (b"\xff\xfe{", "not UTF-8 text, damaged at byte 0"),
    ],
)
def test_json_that_is_none_is_refused(tmp_path, text, cause):
    path = tmp_path / "a.json"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(RunFolderError, match=re.escape(cause)) as refused:
        read_json(path, "")
    assert len(str(refused.value)) < 300


def test_json_within_the_bounds_is_read(tmp_path):
    path = tmp_path / "a.json"
    text = '{"a": [1e308, -7, 18446744073709551615, "ü", [[[[]]]]]}'
    path.write_text(text, encoding="utf-8")
    assert read_object(path, "") == {"a": [1e308, -7, 2**64 - 1, "ü", [[[[]]]]]}
    path.write_text("[" * 20 + "]" * 20)
    with pytest.raises(RunFolderError, match="not a JSON object"):
        read_object(path, "")


def test_an_error_holds_nothing_that_a_terminal_obeys(tmp_path):
    error = RunFolderError(tmp_path / "a\x1b[2Jb", "c\r\nd\x07", "e")
    assert str(error).endswith("a [2Jb: c d; e")


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
    assert as_record(Outer, content) == expected
    assert isinstance(as_record(Outer, content).inner.cost, float)


@pytest.mark.parametrize(
    ("change", "cause"),
    [
        ({"name": 3}, "name: got 3, accepted: str"),
        ({"name": None}, "name: got None"),
        ({"inner": {"step": "x"}}, "step: got 'x', accepted: int"),
        ({"inner": {"step": True}}, "step: got True, accepted: int"),
        ({"inner": {"step": 1.5}}, "step: got 1.5"),
        ({"inner": {}}, "step is missing"),
        ({"inner": []}, "accepted: an object"),
        ({"many": {}}, "many: got"),
        ({"many": [1]}, "accepted: an object"),
        ({"digests": {"x": 1}}, "digests: got 1, accepted: str"),
        ({"flag": 1}, "flag: got 1, accepted: bool"),
        ({"more": 1}, "unknown key 'more'"),
    ],
)
def test_a_record_of_other_types_is_refused(change, cause):
    with pytest.raises(ValueError, match=re.escape(cause)):
        as_record(Outer, {"name": "a", "inner": {"step": 3}} | change)
    with pytest.raises(ValueError, match="accepted: an object"):
        as_record(Outer, [])
