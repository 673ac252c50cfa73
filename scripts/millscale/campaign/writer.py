"""Writes the content of a campaign file as TOML."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

# Sections by name, each with its keys; arrays of tables are lists of such.
Tree = dict[str, Any]


def toml_text(tree: Tree) -> str:
    """Return a campaign of sections of plain values, lists and arrays of tables as TOML."""
    blocks = []
    for name, content in tree.items():
        if _is_table_array(content):
            blocks += [_block(f"[[{name}]]", entry) for entry in content]
            continue
        arrays = {key: value for key, value in content.items() if _is_table_array(value)}
        plain = {key: value for key, value in content.items() if key not in arrays}
        blocks.append(_block(f"[{name}]", plain))
        for key, entries in arrays.items():
            blocks += [_block(f"[[{name}.{key}]]", entry) for entry in entries]
    return "\n\n".join(blocks) + "\n"


def _is_table_array(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and isinstance(value[0], Mapping)


def _block(header: str, content: Mapping[str, Any]) -> str:
    # JSON writes numbers, lists and printable text as TOML does.
    lines = [f"{key} = {json.dumps(value, ensure_ascii=False)}" for key, value in content.items()]
    return "\n".join([header, *lines])
