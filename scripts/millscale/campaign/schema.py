"""JSON schema of a campaign file, for editors that complete and check TOML."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from millscale.campaign.keys import (
    KINDS,
    REQUIRED,
    REQUIRED_SECTIONS,
    SECTIONS,
    TABLES,
    Key,
    Table,
)
from millscale.campaign.reader import tables_of
from millscale.campaign.spellings import spellings_of

Schema = dict[str, Any]
_TYPES = {"number": "number", "integer": "integer", "flag": "boolean", "text": "string"}


def schema_text() -> str:
    """Return the schema as JSON."""
    return json.dumps(campaign_schema(), indent=1, ensure_ascii=False) + "\n"


def campaign_schema() -> Schema:
    """Return the schema of a campaign file.

    It has keys, types, ranges and words. Other units are patterns, whose ranges are left to
    `millscale plan`, as are contradictions between keys.
    """
    properties = {
        name: _section(keys, tables_of(name)) | {"title": f"[{name}]"}
        for name, keys in SECTIONS.items()
    }
    properties |= {name: _array(TABLES[name]) for name in tables_of("")}
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "Campaign of millscale",
        "description": "A physical mill, the scaled mills to make of it, and what to simulate",
        "type": "object",
        "properties": properties,
        "required": list(REQUIRED_SECTIONS),
        "anyOf": [{"required": [kind]} for kind in KINDS],
        "additionalProperties": False,
    }


def _section(keys: Mapping[str, Key], tables: Mapping[str, Table]) -> Schema:
    patterns: Schema = {}
    needed = []
    for name, key in keys.items():
        others = spellings_of(name, key)
        if others:
            patterns["^(" + "|".join(others) + ")$"] = _value(key, name)
        if key.default is REQUIRED:
            needed.append({"anyOf": [{"required": [word]} for word in (name, *others)]})
    section: Schema = {
        "type": "object",
        "properties": {name: _value(key) for name, key in keys.items()}
        | {name: _array(table) for name, table in tables.items()},
        "additionalProperties": False,
    }
    if patterns:
        section["patternProperties"] = patterns
    if needed:
        section["allOf"] = needed
    return section


def _array(table: Table) -> Schema:
    return {
        "description": table.meaning,
        "type": "array",
        "maxItems": table.most,
        "items": _section(table.keys, {}),
    }


def _value(key: Key, in_unit_of: str = "") -> Schema:
    """Return the schema of a key, or with `in_unit_of` of its other spellings."""
    one = _one(key, bool(in_unit_of))
    value: Schema = dict(one)
    if key.many:
        value = {"anyOf": [one, {"type": "array", "items": one}]}
    if in_unit_of:
        return value | {"description": f"{in_unit_of} in another unit: {key.meaning}"}
    value["description"] = key.meaning
    if key.default is not None and key.default is not REQUIRED:
        value["default"] = list(key.default) if isinstance(key.default, tuple) else key.default
    return value


def _one(key: Key, in_another_unit: bool) -> Schema:
    if key.type == "text" and key.choices:
        return {"enum": list(key.choices)}
    one: Schema = {"type": _TYPES[key.type]}
    bounds = {"exclusiveMinimum": key.above, "minimum": key.least, "maximum": key.most}
    for word, bound in bounds.items():
        # Zero is zero in every unit.
        if bound is not None and (not in_another_unit or bound == 0.0):
            one[word] = bound
    return {"anyOf": [one, {"enum": list(key.choices)}]} if key.choices else one
