"""Writes the content of a campaign file as TOML."""

from __future__ import annotations

import json
from typing import Any

# Sections by name, each with its keys.
Tree = dict[str, Any]


def toml_text(tree: Tree) -> str:
    """A campaign of sections of plain values and lists as TOML."""
    sections = []
    for name, content in tree.items():
        lines = [f"{key} = {_value(value)}" for key, value in content.items()]
        sections.append("\n".join([f"[{name}]", *lines]))
    return "\n\n".join(sections) + "\n"


def _value(value: Any) -> str:
    """JSON writes numbers, lists and printable text as TOML does."""
    return json.dumps(value, ensure_ascii=False)
