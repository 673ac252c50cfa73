"""Lines of the keys of a TOML file, for the messages: the parser of Python reports none."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping

from millscale.campaign.keys import SECTIONS, TABLES
from millscale.campaign.spellings import spelling_of
from millscale.errors import CampaignError

_TOKEN = re.compile(
    "|".join(
        (
            r'"""(?:[^\\]|\\.)*?"{3,5}',
            r"'{3}.*?'{3,5}",
            r'"(?:[^"\\\n]|\\.)*"',
            r"'[^'\n]*'",
            r"#[^\n]*",
            r"[\n\[\]{}]",
            r"[^\n\[\]{}#\"']+",
            r".",
        )
    ),
    re.DOTALL,
)
_PART = re.compile(r"""\s*(?:"([^"]*)"|'([^']*)'|([\w-]+))\s*(?:\.|$)""")


def key_lines(text: str) -> dict[str, int]:
    """Return the line, from 1, of each section and key of a TOML text.

    Keys are written with dots, `mill.radius_m`; the second `[[ball.class]]` is `ball.class[2]`.
    Keys of inline tables are not among them.
    """
    lines: dict[str, int] = {}
    seen: dict[str, int] = {}
    section = ""
    for number, statement in _statements(text):
        if statement.startswith("["):
            array = statement.startswith("[[")
            section = _dotted(statement.strip("[]"))
            if array:
                seen[section] = seen.get(section, 0) + 1
                lines.setdefault(section, number)
                section = f"{section}[{seen[section]}]"
            lines.setdefault(section, number)
        else:
            key = _dotted(_before_equals(statement))
            lines.setdefault(f"{section}.{key}" if section else key, number)
    return lines


class Places:
    """Where the keys of a campaign file are, to give its mistakes their lines and spellings."""

    def __init__(self, text: str = "") -> None:
        self._text = text

    def located(self, error: CampaignError) -> CampaignError:
        """Return an error with the line of each mistake, and each key as it is spelled there."""
        if not self._text:
            return error
        lines = key_lines(self._text)

        def place(mistake: CampaignError) -> CampaignError:
            if mistake.line or not mistake.key:
                return mistake
            key, cause = mistake.key, mistake.cause
            if key not in lines and (typed := _typed(key, lines)):
                key, cause = typed, f"as {key.rpartition('.')[2]}: {cause}"
            line = next((lines[name] for name in _outward(key) if name in lines), None)
            return CampaignError(mistake.file, key, cause, mistake.accepted, line)

        return error.each(place)


def _typed(key: str, lines: Mapping[str, int]) -> str:
    """Return the key of the file that spells a declared key; empty if none does."""
    section, _, name = key.rpartition(".")
    table = TABLES.get(re.sub(r"\[\d+\]", "", section))
    known = table.keys if table else SECTIONS.get(section, {})
    for word in lines:
        inside, _, last = word.rpartition(".")
        spelling = spelling_of(last, known) if inside == section else None
        if spelling and spelling.canonical == name:
            return word
    return ""


def _outward(key: str) -> Iterator[str]:
    """Yield a key, its section, and the section around it."""
    while key:
        yield key
        key = key.rpartition(".")[0]


def _statements(text: str) -> Iterator[tuple[int, str]]:
    """Yield each header and each key with its value, without comments, and its first line."""
    number, first, depth = 1, 1, 0
    parts: list[str] = []
    for found in _TOKEN.finditer(text):
        token = found[0]
        if token in "[{":
            depth += 1
        elif token in "]}":
            depth -= 1
        if not parts and not token.isspace():
            first = number
        number += token.count("\n")
        if token == "\n" and depth <= 0:
            if statement := "".join(parts).strip():
                yield first, statement
            parts, depth = [], 0
        elif not token.startswith("#") and (parts or not token.isspace()):
            parts.append(token)
    if statement := "".join(parts).strip():
        yield first, statement


def _before_equals(statement: str) -> str:
    quoted = re.match(r"""(?:"[^"]*"|'[^']*'|[^"'=])*""", statement)
    return quoted[0] if quoted else statement


def _dotted(key: str) -> str:
    return ".".join(part[1] or part[2] or part[3] for part in _PART.finditer(key))
