"""Reads a campaign file into checked values: syntax, keys, units, types and ranges."""

from __future__ import annotations

import codecs
import math
import re
import tomllib
import unicodedata
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from millscale.campaign.keys import (
    OPTIONAL,
    REQUIRED,
    REQUIRED_SECTIONS,
    SECTIONS,
    TABLES,
    Key,
    Table,
    size_range,
)
from millscale.campaign.spellings import agree, spelling_of, spellings_of
from millscale.campaign.units import AGREEMENT, split_unit
from millscale.errors import CampaignError, Mistakes, nearest
from millscale.runs.untrusted import RunFolderError, read_bytes

# A campaign is a page of text; more than this is some other file.
LARGEST_FILE_BYTES = 1 << 20
LONGEST_LIST = 10_000
# Unknown keys of a section that are looked at one by one: more are no slips.
MOST_UNKNOWN = 20
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


def checked_sections(path: Path, tree: Section, mistakes: Mistakes) -> dict[str, Any]:
    """Return the checked sections of a campaign, defaults filled in; sections left out are absent.

    A section with a mistake is absent too.

    Args:
        path: of the campaign file, for the messages.
        tree: its content, of `parse_toml`.
        mistakes: takes unknown sections and keys, wrong types and values out of range.
    """
    for name in _few(path, "", [name for name in tree if not _is_section(name)], mistakes):
        mistakes.found.append(unknown_word(path, name, "", {**SECTIONS, **tables_of("")}))
    for name in SECTIONS:
        if not isinstance(tree.get(name, {}), Mapping):
            cause, accepted = f"got {_shown(tree[name])}", f"a section, written [{name}]"
            mistakes.found.append(CampaignError(path, name, cause, accepted))
    for name in REQUIRED_SECTIONS:
        if name not in tree:
            cause = f"the section [{name}] is missing"
            mistakes.found.append(CampaignError(path, name, cause, _listed(SECTIONS)))
    read: dict[str, Any] = {}
    for name, known in SECTIONS.items():
        content = tree.get(name, {})
        if isinstance(content, Mapping) and (name in tree or name in OPTIONAL):
            with mistakes.collected():
                read[name] = read_section(path, name, content, known, tables_of(name))
    for name, table in tables_of("").items():
        with mistakes.collected():
            read[name] = read_table(path, name, table, tree.get(name, []))
    return read


def _is_section(name: str) -> bool:
    return name in SECTIONS or name in tables_of("")


def _few(path: Path, section: str, unknown: list[str], mistakes: Mistakes) -> list[str]:
    """Return the first unknown words; of the others a mistake states only the number."""
    if len(unknown) > MOST_UNKNOWN:
        cause = f"{len(unknown) - MOST_UNKNOWN:,} more unknown keys"
        accepted = "the keys of docs/reference/campaign-file.md"
        mistakes.found.append(CampaignError(path, section, cause, accepted))
    return unknown[:MOST_UNKNOWN]


def tables_of(section: str) -> dict[str, Table]:
    """Return the arrays of tables of a section, by their last word; of "", the top level's."""
    found = {}
    for name, table in TABLES.items():
        own, _, word = name.rpartition(".")
        if own == section:
            found[word] = table
    return found


def read_section(
    path: Path,
    section: str,
    content: Section,
    known: Mapping[str, Key],
    tables: Mapping[str, Table] | None = None,
) -> dict[str, Any]:
    """Return the checked values of one section, defaults filled in, in the units of the keys.

    Args:
        tables: arrays of tables inside the section; each becomes a tuple of such values.

    Raises:
        CampaignError: unknown or missing keys, wrong types, values out of range; holds all.
    """
    tables = tables or {}
    mistakes = Mistakes()
    plain = {word: value for word, value in content.items() if word not in tables}
    respelled = _respelled(path, section, plain, known, mistakes)
    values: dict[str, Any] = {}
    unknown = [word for word in plain if word not in known and not spelling_of(word, known)]
    misspelt = set()
    for word in _few(path, section, unknown, mistakes):
        mistakes.found.append(unknown_word(path, word, section, {**known, **tables}))
        misspelt.add(_nearest_key(word, known)[0])
    for name, key in known.items():
        where = f"{section}.{name}"
        with mistakes.collected():
            if name in respelled or name in misspelt:
                # A value that is not accepted, and a misspelt key, are mistakes already.
                values[name] = respelled.get(name)
            elif key.default is REQUIRED:
                raise CampaignError(path, where, "missing", f"{key.accepted()} ({key.meaning})")
            else:
                values[name] = key.default
    for name, table in tables.items():
        with mistakes.collected():
            values[name] = read_table(path, f"{section}.{name}", table, content.get(name, []))
    mistakes.raise_all()
    return values


def read_table(path: Path, name: str, table: Table, entries: Any) -> tuple[dict[str, Any], ...]:
    """Return the checked entries of an array of tables; the first is called `name[1]`.

    Raises:
        CampaignError: not such an array, or mistakes in its entries; holds all.
    """
    written = f"[[{name}]]"
    if not isinstance(entries, list) or not all(isinstance(one, Mapping) for one in entries):
        cause = f"{table.meaning}: got {_shown(entries)}"
        raise CampaignError(path, name, cause, f"tables, each written {written}")
    if len(entries) > table.most:
        cause = f"{table.meaning}: got {len(entries)}"
        raise CampaignError(path, name, cause, f"at most {table.most} {written}")
    mistakes, read = Mistakes(), []
    for number, entry in enumerate(entries, 1):
        with mistakes.collected():
            read.append(read_section(path, f"{name}[{number}]", entry, table.keys))
    mistakes.raise_all()
    return tuple(read)


def campaign_tree(path: Path) -> dict[str, Any]:
    """Return the content of a campaign file, every value of a section under its declared key.

    Raises:
        CampaignError: not TOML, or a section with another spelling of a key holds mistakes.
    """
    return canonical_tree(path, parse_toml(path))


def canonical_tree(path: Path, tree: Section, before: str = "") -> dict[str, Any]:
    """Return sections of keys with every value under its declared key.

    Unknown sections and keys stay as they are.

    Args:
        before: what the messages put before the keys.

    Raises:
        CampaignError: a section with another spelling of a key holds mistakes.
    """
    mistakes, result = Mistakes(), dict(tree)
    for section, content in tree.items():
        where = f"{before}{section}"
        if section in TABLES:
            result[section] = _canonical_entries(path, where, TABLES[section], content, mistakes)
        elif section in SECTIONS and isinstance(content, Mapping):
            result[section] = _canonical(path, where, content, SECTIONS[section], mistakes)
            for word, table in tables_of(section).items():
                if word in content:
                    entries = _canonical_entries(
                        path, f"{where}.{word}", table, content[word], mistakes
                    )
                    result[section][word] = entries
    mistakes.raise_all()
    return result


def _canonical_entries(
    path: Path, where: str, table: Table, entries: Any, mistakes: Mistakes
) -> Any:
    if not isinstance(entries, list):
        return entries
    return [
        _canonical(path, f"{where}[{number}]", entry, table.keys, mistakes)
        if isinstance(entry, Mapping)
        else entry
        for number, entry in enumerate(entries, 1)
    ]


def _canonical(
    path: Path, where: str, content: Section, known: Mapping[str, Key], mistakes: Mistakes
) -> dict[str, Any]:
    spelled = {word: to for word in content if (to := spelling_of(word, known))}
    kept = {word: value for word, value in content.items() if word not in spelled}
    if spelled:
        values = _respelled(path, where, content, known, mistakes)
        for name in (spelling.canonical for spelling in spelled.values()):
            kept[name] = list(values[name]) if isinstance(values[name], tuple) else values[name]
    return kept


def _respelled(
    path: Path, section: str, content: Section, known: Mapping[str, Key], mistakes: Mistakes
) -> dict[str, Any]:
    """Return the accepted values under their declared keys; None where a value is a mistake."""
    values: dict[str, Any] = {}
    first: dict[str, str] = {}
    # The declared key comes first: another spelling must agree with it.
    for word in sorted(content, key=lambda word: word not in known):
        spelling = spelling_of(word, known)
        if word not in known and spelling is None:
            continue
        name = spelling.canonical if spelling else word
        value = None
        with mistakes.collected():
            key = spelling.key if spelling else known[word]
            value = read_value(path, f"{section}.{word}", key, content[word])
            value = spelling.to_canonical(value) if spelling else value
            if values.get(name) is not None and not agree(values[name], value):
                one, other = first[name], f"{name} = {_short(values[name])}"
                if one != name:
                    other = f"{one} = {_shown(content[one])} is {other}"
                raise CampaignError(
                    path,
                    f"{section}.{word}",
                    f"contradicts {one}: {word} = {_shown(content[word])} is {name} = "
                    f"{_short(value)}, {other}",
                    f"one of the two, or values that agree within {AGREEMENT:.1%}",
                )
        values.setdefault(name, value)
        first.setdefault(name, word)
    return values


def parse_toml(path: Path) -> dict[str, Any]:
    """Return the content of a TOML file of a page or so, UTF-8 with or without a byte order mark.

    Raises:
        CampaignError: unreadable, too large, or not TOML.
    """
    return parse_text(path, read_text(path))


def read_text(path: Path) -> str:
    """Return the text of a campaign file.

    Raises:
        CampaignError: unreadable, too large, or not UTF-8.
    """
    try:
        # A person may name a link.
        content = read_bytes(path, LARGEST_FILE_BYTES, "", follow=True)
    except RunFolderError as error:
        raise CampaignError(path, "", error.cause, "a TOML file of a page or so") from None
    return _text(path, content)


def parse_text(path: Path, text: str) -> dict[str, Any]:
    """Return the content of a TOML text.

    Raises:
        CampaignError: not TOML, with the line; the parser stops at the first mistake.
    """
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

    def error(cause: str, accepted: str) -> CampaignError:
        return CampaignError(path, "", f"not TOML: {cause}", accepted, number or None)

    if found := _DECIMAL_COMMA.match(line):
        said = f"{found[1]} {_place(text, start + found.start(1))}, with a decimal comma"
        return error(said, f"a decimal point, {found[1].replace(',', '.')}")
    for column, character in enumerate(line):
        plain = _TYPED_FOR.get(character) or unicodedata.normalize("NFKC", character)
        if character.isascii() or not plain.isascii():
            continue
        name = unicodedata.name(character, f"character {ord(character):#x}").lower()
        return error(f"{name} {_place(text, start + column)}", _SAID_OF.get(plain, plain))
    return error(cause, "TOML 1.0, toml.io/en/v1.0.0")


def _place(text: str, index: int) -> str:
    """Return the line and column of a character of a text, as the parser counts them."""
    before = text[:index]
    return f"(at line {before.count(chr(10)) + 1}, column {index - before.rfind(chr(10))})"


def unknown_word(path: Path, word: str, section: str, known: Mapping[str, object]) -> CampaignError:
    """Return the error of an unknown section or key, naming the nearest known one and its units."""
    where = f"{section}.{word}" if section else word
    near, spelling = _nearest_key(word, known)
    if near and split_unit(word)[0] == split_unit(spelling)[0] != word:
        spelled = _spelled(near, known)
        if word.lower() not in spelled:
            cause = f"wrong unit '{split_unit(word)[1][1:]}', nearest is {near}"
            return CampaignError(path, where, cause, ", ".join(spelled))
    cause = "unknown key" if section else "unknown section"
    cause += f", nearest is {spelling}" if near else ""
    return CampaignError(path, where, cause, _listed(known))


def _nearest_key(word: str, known: Mapping[str, object]) -> tuple[str, str]:
    """Return the known key that a word is most like, and which spelling of it; empty if none."""
    quantity, unit = split_unit(word)
    keys = {name: name for name in known}
    for name in known:
        for spelling in _spelled(name, known):
            keys.setdefault(spelling, name)
    same = [one for one in keys if unit and split_unit(one)[0] == quantity]
    if word.lower() in keys:
        same = [word.lower()]
    spelling = same[0] if same else nearest(word, keys)
    return keys.get(spelling, ""), spelling


def _spelled(name: str, known: Mapping[str, object]) -> list[str]:
    """Return every spelling of a key, the declared one first; a section has its name alone."""
    key = known[name]
    return [name, *(spellings_of(name, key) if isinstance(key, Key) else ())]


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
        smallest, largest = size_range(where)
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


def _short(value: Any) -> str:
    """Return a value of a key, or several, with numbers to six digits."""
    if isinstance(value, tuple):
        return _shown([float(f"{one:.6g}") if isinstance(one, float) else one for one in value])
    return f"{value:.6g}" if isinstance(value, float) else _shown(value)


def _listed(known: Mapping[str, object]) -> str:
    return ", ".join(sorted(known, key=str.lower))
