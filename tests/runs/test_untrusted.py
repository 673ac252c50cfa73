"""Damaged and malicious files are refused at once, in one line."""

import os
import re
import socket
import time

import pytest

from millscale.runs.untrusted import (
    RunFolderError,
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
def test_only_regular_files_are_read(tmp_path, cause, read):
    IRREGULAR[cause](path := tmp_path / "case.json")
    begin = time.monotonic()
    with pytest.raises(RunFolderError, match=f"case.json: .*{cause}; copy it") as refused:
        read(path, "copy it")
    assert time.monotonic() - begin < WITHIN_S
    assert "\n" not in str(refused.value)


def test_a_device_is_refused():
    with pytest.raises(OSError, match="not a regular file"):
        open_regular("/dev/zero")


def test_a_link_named_on_the_command_line_is_followed(tmp_path):
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
def test_invalid_json_is_refused(tmp_path, text, cause):
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


def test_an_error_has_no_control_characters(tmp_path):
    error = RunFolderError(tmp_path / "a\x1b[2Jb", "c\r\nd\x07", "e")
    assert str(error).endswith("a [2Jb: c d; e")
