"""The table of case.json in docs/reference/files.md has the keys and types of the code."""

import re
from pathlib import Path

import msgspec
from msgspec import inspect

from millscale.runs.case_file import Case

FILES = Path(__file__).parents[2] / "docs" / "reference" / "files.md"
WORDS = {
    inspect.FloatType: "float",
    inspect.IntType: "int",
    inspect.StrType: "text",
    inspect.BoolType: "bool",
    inspect.DictType: "object",
}


def keys_of_the_code(kind=Case, above=""):
    """Yield each key of case.json by its path, and its type as the page writes it."""
    for field in inspect.type_info(kind).fields:
        name = f"{above}{field.encode_name}"
        if isinstance(plain(field.type), inspect.StructType):
            yield from keys_of_the_code(plain(field.type).cls, f"{name}.")
        else:
            yield name, word(field)


def plain(found):
    """Return a type without its limits, and without the null of a key that may be absent."""
    if isinstance(found, inspect.Metadata):
        return plain(found.type)
    if isinstance(found, inspect.UnionType):
        return plain(next(x for x in found.types if not isinstance(x, inspect.NoneType)))
    return found


def word(field):
    found = plain(field.type)
    if isinstance(found, inspect.LiteralType):
        return "text" if isinstance(found.values[0], str) else "int"
    if isinstance(found, inspect.TupleType):
        return f"list of {len(found.item_types)} floats"
    if isinstance(found, inspect.VarTupleType):
        item = plain(found.item_type)
        if isinstance(item, inspect.StructType):
            return f"list of {{{', '.join(x.encode_name for x in item.fields)}}}"
        return "list of " + WORDS.get(type(item), "lists")
    null = isinstance(field.type, inspect.UnionType) and field.default is msgspec.NODEFAULT
    return WORDS.get(type(found), "object") + (" or null" if null else "")


def keys_of_the_page(text):
    """Yield each key of the table, and its type; empty where the page omits it."""
    table = text.split("\n## case.json\n")[1].split("\n## ")[0]
    section = ""
    for line in re.findall(r"^\| (.*) \|$", table, re.M)[1:]:
        key, kind, *_ = (cell.strip() for cell in line.split("|"))
        if named := re.match(r"\*\*(\w+)\*\*", key):
            section = named[1]
        names = re.findall(r"\.(\w+)", key) or ([] if named else re.split(r", ", key))
        above = f"{section}." if "." in key else ""
        kinds = re.split(r", (?![^{]*})", kind)
        kinds = kinds * len(names) if len(kinds) == 1 else kinds
        yield from zip((f"{above}{name}" for name in names), kinds, strict=True)


def test_the_page_has_every_key_of_the_code_with_its_type():
    code = dict(keys_of_the_code())
    page = list(keys_of_the_page(FILES.read_text(encoding="utf-8")))
    assert len(dict(page)) == len(page)
    assert sorted(dict(page)) == sorted(code)
    assert {name: code[name] for name, kind in page if kind} == {k: v for k, v in page if v}
