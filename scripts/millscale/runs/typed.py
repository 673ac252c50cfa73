"""Reads JSON files into typed values, checked by msgspec; an error names the key."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from millscale.runs.untrusted import MOST_JSON, RunFolderError, read_json

T = TypeVar("T")
_SHOWN = 60
_MISSING = re.compile(r"Object missing required field `(.*)`", re.S)
_UNKNOWN = re.compile(r"Object contains unknown field `(.*)`", re.S)
_STEP = re.compile(r"[^.\[\]]+")


def read_typed(path: Path, kind: type[T], remedy: str, most: int = MOST_JSON) -> T:
    """Return the content of a JSON file as a struct or dataclass.

    Args:
        remedy: what to do about a file that is refused.
        most: largest size accepted [bytes].

    Raises:
        RunFolderError: missing, not a regular file, damaged, or not of this type.
    """
    content = read_json(path, remedy, most)
    try:
        return as_typed(kind, content)
    except ValueError as error:
        raise RunFolderError(path, str(error), remedy) from None


def as_typed(kind: type[T], content: Any) -> T:
    """Return parsed JSON as a struct or dataclass. A whole number may stand for a real one.

    Raises:
        ValueError: names the first key that is not accepted, its value, and what is accepted.
    """
    try:
        return msgspec.convert(content, kind)
    except msgspec.ValidationError as error:
        raise ValueError(_cause(str(error), kind, content)) from None


def _cause(message: str, kind: type, content: Any) -> str:
    text, _, place = message.rpartition(" - at `$")
    text, place = (text, place.rstrip("`").lstrip(".")) if text else (message, "")
    if missing := _MISSING.fullmatch(text):
        return f"{_joined(place, missing[1])} is missing"
    if unknown := _UNKNOWN.fullmatch(text):
        return f"unknown key {_joined(place, unknown[1])!r:.{_SHOWN}}"
    accepted = text
    try:
        accepted, content = _described(kind, place), _value(content, place)
    except (LookupError, TypeError, ValueError):
        # An element of a list or an object whose keys are data: the message says what it is.
        return f"{place}: {text}" if place else text
    where = f"{place}: " if place else ""
    return f"{where}got {shown(content)}, accepted: {accepted}"


def _joined(place: str, name: str) -> str:
    return f"{place}.{name}".lstrip(".")


def _steps(place: str) -> list[str]:
    if "..." in place:
        raise ValueError(place)
    return _STEP.findall(place)


def _value(content: Any, place: str) -> Any:
    for step in _steps(place):
        content = content[int(step)] if isinstance(content, list) else content[step]
    return content


def _described(kind: type, place: str) -> str:
    """Return in words what a key accepts."""
    from msgspec import inspect

    found = inspect.type_info(kind)
    for step in _steps(place):
        if isinstance(found, inspect.StructType | inspect.DataclassType):
            found = next(x.type for x in found.fields if x.encode_name == step)
        elif isinstance(found, inspect.TupleType):
            found = found.item_types[int(step)]
        elif isinstance(found, inspect.VarTupleType | inspect.ListType):
            found = found.item_type
        else:
            raise ValueError(step)
        found = _without_null(found)
    return _words(found)


def _without_null(found: Any) -> Any:
    from msgspec import inspect

    if isinstance(found, inspect.UnionType):
        some = [x for x in found.types if not isinstance(x, inspect.NoneType)]
        return some[0] if len(some) == 1 else found
    return found


def _words(found: Any) -> str:
    from msgspec import inspect

    if isinstance(found, inspect.Metadata):
        return str((found.extra_json_schema or {}).get("description") or _words(found.type))
    if isinstance(found, inspect.LiteralType):
        return ", ".join(map(str, found.values))
    if isinstance(found, inspect.TupleType):
        return f"a list of {len(found.item_types)}"
    words: dict[type, str] = {
        inspect.FloatType: "a finite number",
        inspect.IntType: "a whole number",
        inspect.BoolType: "true or false",
        inspect.StrType: "text",
        inspect.DictType: "an object",
        inspect.StructType: "an object",
        inspect.DataclassType: "an object",
    }
    limits = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
    given = {sign: getattr(found, name, None) for name, sign in limits.items()}
    kind = words.get(type(found), "a list")
    return kind + "".join(f" {sign} {x:g}," for sign, x in given.items() if x is not None)[:-1]


def shown(value: Any) -> str:
    """Return a value as an error message shows it, shortened."""
    text = repr(value)
    return text if len(text) <= _SHOWN else f"{text[: _SHOWN - 3]}..."
