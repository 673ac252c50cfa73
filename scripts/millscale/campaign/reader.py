"""Reads a campaign file into checked values: syntax, keys, types and ranges, one key at a time."""

from __future__ import annotations

import codecs
import math
import re
import tomllib
import unicodedata
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from millscale.campaign.keys import REQUIRED, REQUIRED_SECTIONS, SECTIONS, SIZES, Key
from millscale.campaign.units import split_unit
from millscale.errors import CampaignError, nearest
from millscale.runs.untrusted import RunFolderError, read_bytes

# A campaign is a page of text; more than this is some other file.
LARGEST_FILE_BYTES = 1 << 20
LONGEST_LIST = 10_000
SHOWN_CHARACTERS = 60
_SAVE_AS = "UTF-8: save the file anew with the encoding UTF-8 (in PowerShell: -Encoding utf8)"
# What word processors, web pages and input methods put in place of the characters of a keyboard
# and has no compatible form of its own (NFKC); and such characters that need a word.
_TYPED_FOR = dict.fromkeys("\u2212\u2010\u2011\u2012\u2013\u2014\u2015", "-")
_TYPED_FOR |= dict.fromkeys("\u201c\u201d\u201e\u201f\u00ab\u00bb", '"')
_TYPED_FOR |= dict.fromkeys("\u2018\u2019\u201a\u201b\u2039\u203a", "'")
_TYPED_FOR |= dict.fromkeys("\u200b\u200c\u200d\u2060\ufeff\u00ad", " ") | {"\u00d7": "*"}
_SAID_OF = {" ": "a plain space, or nothing", "-": "a hyphen-minus, -"}
# The parser takes a time that grows with the square of the parts: minutes for a file of 1 MiB.
_LONG_KEY = re.compile(
    r"""(?:\.[ \t]*+(?:"[^"\n]{0,512}+"|'[^'\n]{0,512}+'|[\w-]{1,512}+)[ \t]*+){20}"""
)
_DECIMAL_COMMA = re.compile(
    r"\s*\w+\s*=\s*([+-]?\d{1,40},\d{1,40}(?:[eE][+-]?\d{1,40})?)\s*(?:#.*)?$"
)

Section = Mapping[str, Any]


def checked_sections(path: Path, tree: Section) -> dict[str, Section]:
    """Return the checked sections of a campaign, defaults filled in; sections left out are absent.

    Args:
        path: of the campaign file, for the messages.
        tree: its content, of `parse_toml`.

    Raises:
        CampaignError: unknown section or key, wrong type, value out of range.
    """
    for name, content in tree.items():
        if name not in SECTIONS:
            raise unknown_word(path, name, "", SECTIONS)
        if not isinstance(content, dict):
            raise CampaignError(
                path, name, f"got {_shown(content)}", f"a section, written [{name}]"
            )
    for name in REQUIRED_SECTIONS:
        if name not in tree:
            raise CampaignError(path, name, f"the section [{name}] is missing", _listed(SECTIONS))
    optional = {"campaign", "liner", "scaling", "wall", "model", "run"}
    names = [name for name in SECTIONS if name in tree or name in optional]
    for name in names:
        _refuse_unknown(path, name, tree.get(name, {}), SECTIONS[name])
    return {name: _read_keys(path, name, tree.get(name, {}), SECTIONS[name]) for name in names}


def read_section(
    path: Path, section: str, content: Section, known: Mapping[str, Key]
) -> dict[str, Any]:
    """Return the checked values of one section, defaults filled in.

    Raises:
        CampaignError: unknown or missing key, wrong type, value out of range.
    """
    _refuse_unknown(path, section, content, known)
    return _read_keys(path, section, content, known)


def parse_toml(path: Path) -> dict[str, Any]:
    """Return the content of a TOML file of a page or so, UTF-8 with or without a byte order mark.

    Raises:
        CampaignError: unreadable, too large, or not TOML.
    """
    try:
        # A person may name a link.
        content = read_bytes(path, LARGEST_FILE_BYTES, "", follow=True)
    except RunFolderError as error:
        raise CampaignError(path, "", error.cause, "a TOML file of a page or so") from None
    text = _text(path, content)
    if found := _LONG_KEY.search(text):
        cause = f"a key of over 20 parts {_place(text, found.start())}"
        raise CampaignError(path, "", cause, "[section] and key = value")
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as cause:
        raise _not_toml(path, text, str(cause)) from None


def _text(path: Path, content: bytes) -> str:
    wide = content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)) or b"\0" in content
    if wide:
        cause = "not UTF-8 text: UTF-16 or binary, it holds bytes of 0"
        raise CampaignError(path, "", cause, _SAVE_AS)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        before = content[: error.start].decode("utf-8", errors="replace")
        where = _place(before, len(before))
        cause = f"not UTF-8 text: byte 0x{content[error.start]:02x} {where}"
        raise CampaignError(path, "", cause, _SAVE_AS) from None


def _not_toml(path: Path, text: str, cause: str) -> CampaignError:
    """Return the error of a text that is no TOML: a slip of typing where there is one, else the
    parser's."""
    # The parser stops where it understands no more; a slip in a comment or a text is none.
    stopped = re.search(r"at line (\d+), column (\d+)", cause)
    number = int(stopped[1]) if stopped else 0
    line = text.split("\n")[number - 1] if number else ""
    start = sum(len(x) + 1 for x in text.split("\n")[: number - 1])
    if found := _DECIMAL_COMMA.match(line):
        said = f"{found[1]} {_place(text, start + found.start(1))}, with a decimal comma"
        accepted = f"a decimal point, {found[1].replace(',', '.')}"
        return CampaignError(path, "", f"not TOML: {said}", accepted)
    for column, character in enumerate(line):
        plain = _TYPED_FOR.get(character) or unicodedata.normalize("NFKC", character)
        if character.isascii() or not plain.isascii():
            continue
        name = unicodedata.name(character, f"character {ord(character):#x}").lower()
        said = f"{name} {_place(text, start + column)}"
        return CampaignError(path, "", f"not TOML: {said}", _SAID_OF.get(plain, plain))
    return CampaignError(path, "", f"not TOML: {cause}", "TOML 1.0, toml.io/en/v1.0.0")


def _place(text: str, index: int) -> str:
    """Return the line and column of a character of a text, as the parser counts them."""
    before = text[:index]
    return f"(at line {before.count(chr(10)) + 1}, column {index - before.rfind(chr(10))})"


def unknown_word(path: Path, word: str, section: str, known: Mapping[str, object]) -> CampaignError:
    """Return the error of an unknown section or key, naming the nearest known one and its unit."""
    key = f"{section}.{word}" if section else word
    quantity, unit = split_unit(word)
    siblings = [name for name in known if unit and split_unit(name)[0] == quantity]
    near = siblings[0] if siblings else nearest(word, known)
    cause = "unknown key" if section else "unknown section"
    if siblings:
        cause = f"wrong unit '{unit[1:]}'"
    return CampaignError(
        path, key, cause + (f", nearest is {near}" if near else ""), _listed(known)
    )


def _refuse_unknown(path: Path, section: str, content: Section, known: Mapping[str, Key]) -> None:
    for word in content:
        if word not in known:
            raise unknown_word(path, word, section, known)


def _read_keys(
    path: Path, section: str, content: Section, known: Mapping[str, Key]
) -> dict[str, Any]:
    values = {}
    for name, key in known.items():
        where = f"{section}.{name}"
        if name in content:
            values[name] = read_value(path, where, key, content[name])
        elif key.default is REQUIRED:
            raise CampaignError(path, where, "missing", f"{key.accepted()} ({key.meaning})")
        else:
            values[name] = key.default
    return values


def read_value(path: Path, where: str, key: Key, value: Any) -> Any:
    """Return a value of the file if the key accepts it; a tuple if the key takes a list."""
    if not key.many:
        return _read_one(path, where, key, value)
    items = value if isinstance(value, list) else [value]
    fewest = 0 if key.default == () else 1
    if not fewest <= len(items) <= LONGEST_LIST:
        raise CampaignError(
            path, where, f"a list of {len(items)} values", f"{fewest} to {LONGEST_LIST:,} values"
        )
    read = tuple(_read_one(path, where, key, item) for item in items)
    first = {item: i for i, item in reversed(list(enumerate(read)))}
    repeated = next((item for i, item in enumerate(read) if first[item] < i), None)
    # Two scaled mills may well hold the same number of balls.
    if repeated is not None and not where.endswith(".count"):
        raise CampaignError(path, where, f"{_shown(repeated)} is given twice", "different values")
    return read


def _read_one(path: Path, where: str, key: Key, value: Any) -> Any:
    """Return one value of the right type and range; numbers become float."""
    if isinstance(value, str) and value in key.choices:
        return value
    fits = {
        "number": isinstance(value, int | float) and not isinstance(value, bool),
        "integer": isinstance(value, int) and not isinstance(value, bool),
        "flag": isinstance(value, bool),
        "text": isinstance(value, str) and not key.choices and _is_line(value),
    }[key.type]
    if not fits:
        raise _refused(path, where, key, value)
    if key.type in ("number", "integer"):
        try:
            number = float(value)
        except OverflowError:
            raise _refused(path, where, key, value) from None
        if not _in_range(key, number):
            raise _refused(path, where, key, value)
        if key.type == "integer":
            return value
        smallest, largest = SIZES.get(split_unit(where)[1], SIZES[""])
        if number != 0.0 and not smallest <= abs(number) <= largest:
            cause = f"got {_shown(value)}, beyond what a mill has and arithmetic bears"
            raise CampaignError(path, where, cause, f"{smallest:g} to {largest:g}")
        return number
    return value


def _refused(path: Path, where: str, key: Key, value: Any) -> CampaignError:
    hint = ""
    if isinstance(value, str) and key.choices:
        near = nearest(value, key.choices)
        hint = f', nearest is "{near}"' if near else ""
    cause = (
        f"{key.meaning}: got {_shown(value)}{hint}" if key.meaning else f"got {_shown(value)}{hint}"
    )
    return CampaignError(path, where, cause, key.accepted())


def _in_range(key: Key, number: float) -> bool:
    return (
        math.isfinite(number)
        and (key.above is None or number > key.above)
        and (key.least is None or number >= key.least)
        and (key.most is None or number <= key.most)
    )


def _is_line(text: str) -> bool:
    return text.isprintable() and len(text) <= LONGEST_LIST


def _shown(value: Any) -> str:
    """Return a value as TOML would write it, shortened."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int) and value.bit_length() > 200:
        return f"a number of {value.bit_length()} bits"
    text = f'"{value}"' if isinstance(value, str) else repr(value)
    return text if len(text) <= SHOWN_CHARACTERS else text[: SHOWN_CHARACTERS - 3] + "..."


def _listed(known: Mapping[str, object]) -> str:
    return ", ".join(sorted(known, key=str.lower))
