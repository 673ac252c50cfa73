"""Comparison of an engine's log with a deck, whose lines the engine echoes there.

A line with variables is echoed again after each replacement of a variable.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping

# First words of commands; the engine's other output begins with other words.
_COMMANDS = """
angle_coeff angle_style atom_modify atom_style bond_coeff bond_style boundary box change_box
clear coarsegraining communicate compute compute_modify create_atoms create_box
delete_atoms delete_bonds dielectric dihedral_coeff dihedral_style displace displace_atoms
displace_box dump dump_modify echo fix fix_modify group hard_particles if improper_coeff
improper_style include jump kspace_modify kspace_style label lattice log mass modify_timing
multisphere neb neigh_modify neighbor newton next orphan_check pair_coeff pair_modify
pair_style pair_write partition prd print processors python quit read_data read_dump
read_restart region replicate rerun reset_timestep restart run run_style set shell
soft_particles special_bonds suffix thermo thermo_modify thermo_style timestep uncompute
undump unfix units variable velocity write_data write_dump write_restart
"""
COMMANDS = frozenset(_COMMANDS.split())
_QUOTED = re.compile(r'"([^"]*)"')
_DEFINITION = re.compile(r'variable (\w+) (?:string|index) "?([^"$#]+?)"?(?: #.*)?')
# An expression of variables is replaced by a number.
_NUMBER = r"[^\s,\"]+"


def difference(log: str, decks: Mapping[str, str], deck: str) -> str:
    """Return how a log differs from that of a deck; empty if it does not.

    Args:
        log: the engine's log.
        decks: file -> text, of the deck and of every file that it may include.
        deck: name of the deck.
    """
    lines = {name: list(_commands(text)) for name, text in decks.items()}
    repeated = [" ".join(line.split()) for line in log.splitlines()]
    there = set(repeated)
    included = {deck} | {name for name in decks if f"include {name}" in there}
    for name in decks:
        for line in lines[name] if name in included else ():
            if line not in there:
                return f"it does not repeat the line `{line:.60}` of {name}"
    known = [line for name in included for line in lines[name]]
    known += [text for line in known if line.startswith("if ") for text in _QUOTED.findall(line)]
    plain = set(known)
    forms = _Forms(known)
    for line in repeated:
        word = line.partition(" ")[0]
        if word in COMMANDS and line not in plain and not forms.fit(line):
            return f"it has the line `{line:.60}`, which is in no deck"
    return ""


def _commands(text: str) -> Iterator[str]:
    """Yield the lines of a deck as the engine reads them: joined at `&`, with single blanks."""
    joined = re.sub(r"&[ \t]*\n", "", text)
    for line in joined.splitlines():
        if line.strip():
            yield " ".join(line.split())


class _Forms:
    """Patterns of the lines that replacement of variables can produce."""

    def __init__(self, lines: Iterable[str]) -> None:
        lines = list(dict.fromkeys(lines))
        self._values: dict[str, list[str]] = {}
        for line in lines:
            if match := _DEFINITION.fullmatch(line):
                self._values.setdefault(match[1], []).append(re.escape(match[2]))
        self._patterns: dict[str, list[re.Pattern[str]]] = {}
        for line in lines:
            if "$" in line:
                pattern = re.compile(self._pattern(line))
                self._patterns.setdefault(line.partition(" ")[0], []).append(pattern)

    def fit(self, line: str) -> bool:
        return any(x.fullmatch(line) for x in self._patterns.get(line.partition(" ")[0], ()))

    def _pattern(self, line: str) -> str:
        # The engine drops a comment when it replaces a variable.
        parts = []
        for text in _pieces(line.partition(" #")[0]):
            if text.startswith("$"):
                values = self._values.get(text[2:-1], [_NUMBER])
                parts.append(f"(?:{'|'.join([*values, re.escape(text)])})")
            else:
                parts.append(re.escape(text))
        return "".join(parts)


def _pieces(line: str) -> Iterator[str]:
    """Yield the parts of a line: variables, ${NAME} and $(EXPRESSION), and the text between."""
    at = 0
    while at < len(line):
        begin = line.find("$", at)
        if begin < 0 or line[begin + 1 : begin + 2] not in ("{", "("):
            yield line[at:]
            return
        yield line[at:begin]
        end, depth = begin + 1, 0
        while end < len(line):
            depth += (line[end] in "({") - (line[end] in ")}")
            end += 1
            if depth == 0:
                break
        yield line[begin:end]
        at = end
